//! The motion estimator on simulated drives, where every step is known: how far off, how sure of it, and whether it says so
//! where the road tells nothing. `fingerpost-papers/tests/motion.rs` holds it against the papers' flow.
//!
//! `cargo test -p fingerpost --test motion_accuracy -- --nocapture` prints the figures.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::simulated::{
    BINS, camera, drive, error, is_measured_in_other_views, motions, recorded, simulator, turns, view,
};
use fingerpost::attitude::{AttitudeObservation, ObservedAngle};
use fingerpost::ground_view::GroundPicture;
use fingerpost::motion::{DirectMotion, DirectMotionConfig, MotionDoubt, MotionEstimator, MotionOutput};
use fingerpost_map::{OsmData, RoadGraph};
use fingerpost_sim::{Conditions, RandomRouteOptions, SimConfig, Simulator, random_drive, random_route};
use nalgebra::Isometry2;

fn direct() -> DirectMotion {
    DirectMotion::new(&DirectMotionConfig::default())
}

#[test]
fn direct_alignment_is_honest_about_its_accuracy() {
    for drive in turns() {
        let name = drive.name;
        let found = motions(&drive, &mut direct());
        // Normalised errors squared: 1 a degree of freedom on average when the covariances are right.
        let normalised = found.iter().zip(&drive.steps).map(|(found, step)| {
            let error = error(found, step);
            error.dot(&(found.covariance.try_inverse().unwrap() * error)) / 3.0
        });
        let consistency = normalised.sum::<f64>() / found.len() as f64;
        println!("{name:<9} direct  normalised error squared {consistency:.2}");
        assert!(consistency < 3.0, "{name}: {consistency} times the variance that is promised");
        let believed = found.iter().filter(|motion| motion.quality > 0.3).count();
        assert!(10 * believed > 9 * found.len(), "{name}: {believed} of {} believed", found.len());
    }
}

/// After sunset the vignette and the low beam are stronger than the road's grain, and stay with the camera.
#[test]
fn a_pattern_that_stays_with_the_camera_does_not_hold_the_vehicle_back() {
    let config = SimConfig { seed: 21, conditions: Conditions::DUSK, start_m: 60.0, ..SimConfig::default() };
    let drive = drive("dusk", &config, 60);
    let forward_m = |steps: &mut dyn Iterator<Item = f64>| steps.sum::<f64>();
    let driven_m = forward_m(&mut drive.steps.iter().map(|step| step.translation.x));
    let found = motions(&drive, &mut direct());
    let found_m = forward_m(&mut found.iter().map(|found| found.previous_from_current.translation.x));
    println!("dusk: {found_m:.2} m found of {driven_m:.2} m");
    assert!((found_m / driven_m - 1.0).abs() < 0.04, "{found_m} m of {driven_m} m");
}

/// On a wet road the mirrored sky and trees are stronger than the grain, and move little while the road goes by.
#[test]
fn what_a_wet_road_mirrors_does_not_hold_the_vehicle_back() {
    let seed = 6014;
    let town = include_bytes!("../../../fingerpost-sim/assets/town.osm");
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(town).unwrap()).unwrap();
    let route = random_route(&graph, seed, &RandomRouteOptions::default()).unwrap();
    let config = random_drive(seed, &Conditions::WET);
    let simulator = Simulator::new(&graph, &route, &camera(), &config).unwrap();
    let drive = recorded("wet", &simulator, 45);
    let driven_m: f64 = drive.steps.iter().map(|step| step.translation.x).sum();
    let found = motions(&drive, &mut direct());
    let found_m: f64 = found.iter().map(|found| found.previous_from_current.translation.x).sum();
    println!("wet: {found_m:.2} m found of {driven_m:.2} m");
    assert!((found_m / driven_m - 1.0).abs() < 0.05, "{found_m} m of {driven_m} m");
}

#[test]
fn a_standing_vehicle_does_not_move_and_a_creeping_one_does() {
    let (simulator, view) = (simulator(&SimConfig { start_m: 30.0, ..SimConfig::default() }), view());
    let mut estimator = direct();
    let mut picture = GroundPicture::new(view.grid().columns(), view.grid().rows(), BINS);
    let frame = simulator.frame(0).picture;
    for i in 0..8_u64 {
        // The camera's noise, two grey levels either way, differs from frame to frame.
        let mut noisy = frame.clone();
        let mut state = i + 1;
        for value in noisy.as_mut_slice() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let noise = ((state >> 60) % 5) as i16 - 2;
            *value = (i16::from(*value) + noise).clamp(0, 255) as u8;
        }
        view.render(&noisy, &mut picture).unwrap();
        let found = estimator.estimate(&view, &picture, &AttitudeObservation::default()).unwrap();
        assert_eq!(found.is_some(), i > 0, "frame {i}");
        if let Some((MotionOutput { motion, .. }, _)) = found {
            assert_eq!(motion.previous_from_current, Isometry2::identity(), "frame {i}");
            assert!(motion.quality > 0.5 && motion.covariance.symmetric_eigenvalues().min() > 0.0);
        }
    }
    // A metre a second, a thousand times a second: a millimetre a frame is less than one frame tells.
    let creeping = SimConfig { fps: 1000.0, cruise_speed_mps: 1.0, start_m: 30.0, ..SimConfig::default() };
    let drive = drive("creeping", &creeping, 40);
    let crept: f64 = drive.steps.iter().map(|step| step.translation.x).sum();
    let found: f64 =
        motions(&drive, &mut direct()).iter().map(|m| m.previous_from_current.translation.x).sum();
    // A swing of the camera by a thousandth of a degree looks the same, so a fifth may be missing.
    assert!(crept > 0.03 && (found - crept).abs() < 0.008, "{found} m of {crept} m");
}

/// A slow vehicle before a fast camera moves less in a frame than what is taken for standing where the camera travels.
#[test]
fn a_slow_vehicle_before_a_fast_camera_moves() {
    let slow = SimConfig { fps: 60.0, cruise_speed_mps: 1.0, start_m: 30.0, ..SimConfig::default() };
    let drive = drive("slow", &slow, 60);
    let driven_m: f64 = drive.steps.iter().map(|step| step.translation.x).sum();
    let found = motions(&drive, &mut direct());
    let found_m: f64 = found.iter().map(|found| found.previous_from_current.translation.x).sum();
    let travels = drive.attitudes.iter().filter(|attitude| attitude.pitch.is_some()).count();
    println!("slow: {found_m:.3} m found of {driven_m:.3} m, seen to travel in {travels} frames");
    assert!((found_m / driven_m - 1.0).abs() < 0.05, "{found_m} m of {driven_m} m");
    assert!(found[5..].iter().all(|found| found.quality > 0.3));
}

/// A road smoothed away by a video's compression stays where it is in the picture; trees and signs beside it do not.
#[test]
fn a_camera_that_is_seen_to_travel_does_not_stand() {
    let (simulator, view) = (simulator(&SimConfig { start_m: 30.0, ..SimConfig::default() }), view());
    let mut picture = GroundPicture::new(view.grid().columns(), view.grid().rows(), BINS);
    view.render(&simulator.frame(0).picture, &mut picture).unwrap();
    let ahead = ObservedAngle { angle_rad: 0.0, variance_rad2: 1e-5 };
    let travels = AttitudeObservation { pitch: Some(ahead), ..AttitudeObservation::default() };
    let mut estimator = direct();
    let (mut qualities, mut doubts) = (Vec::new(), Vec::new());
    for attitude in [travels; 5].into_iter().chain([AttitudeObservation::default(); 5]) {
        let found = estimator.estimate(&view, &picture, &attitude).unwrap();
        qualities.extend(found.map(|(output, _)| output.motion.quality));
        doubts.extend(found.map(|(output, _)| output.doubt));
    }
    assert!(doubts[1..4].iter().all(|doubt| *doubt == Some(MotionDoubt::ViewStandsStill)), "{doubts:?}");
    assert!(doubts[7..].iter().all(Option::is_none), "{doubts:?}");
    assert!(qualities[1..4].iter().all(|&quality| quality < 0.05), "{qualities:?}");
    assert!(
        qualities[7..].iter().all(|&quality| quality > 0.5),
        "a vehicle that has stopped stands: {qualities:?}"
    );
}

#[test]
fn a_road_that_tells_nothing_is_not_believed() {
    let view = view();
    let mut picture = GroundPicture::new(view.grid().columns(), view.grid().rows(), BINS);
    let mut estimator = direct();
    let mut state = 1_u64;
    let mut sigma_m = 0.0;
    for i in 0..6 {
        // Noise alone, different in each frame.
        for value in picture.grey.as_mut_slice() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            *value = 110 + ((state >> 61) % 5) as u8;
        }
        let found = estimator.estimate(&view, &picture, &AttitudeObservation::default()).unwrap();
        assert_eq!(found.is_some(), i > 0, "frame {i}");
        if let Some((MotionOutput { motion, .. }, _)) = found {
            assert!(motion.quality < 0.2, "frame {i}: quality {}", motion.quality);
            let now_m = motion.covariance[(0, 0)].sqrt();
            assert!(now_m > 0.5 && now_m >= sigma_m, "frame {i}: {now_m} m after {sigma_m} m");
            sigma_m = now_m;
        }
    }
    for grey in [0, 90, 255] {
        picture.grey.as_mut_slice().fill(grey);
        let (MotionOutput { motion, .. }, _) =
            estimator.estimate(&view, &picture, &AttitudeObservation::default()).unwrap().unwrap();
        assert!(motion.quality < 0.2, "grey {grey}: quality {}", motion.quality);
    }
}

#[test]
fn another_ground_view_starts_anew() {
    assert_eq!(is_measured_in_other_views(&mut direct()), [false, true, false, true]);
}

#[test]
fn a_frame_needs_no_new_memory() {
    let (drive, view) = (drive("clear", &SimConfig { start_m: 30.0, ..SimConfig::default() }, 10), view());
    let mut estimator = direct();
    for (i, picture) in drive.pictures.iter().enumerate() {
        let used = allocation_counter::measure(|| {
            assert!(estimator.estimate(&view, picture, &AttitudeObservation::default()).is_ok())
        });
        assert!(i < 2 || used.count_total == 0, "frame {i}: {used:?}");
    }
}

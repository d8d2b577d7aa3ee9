//! The papers' motion beside the method's on simulated drives, where every step is known.
//!
//! `cargo test -p fingerpost-papers --test motion -- --nocapture` prints the table.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "../../fingerpost/tests/simulated/mod.rs"]
mod simulated;

use fingerpost::attitude::{AttitudeObservation, ObservedAngle};
use fingerpost::motion::{
    DirectMotion, DirectMotionConfig, FarnebackMotionConfig, FlowModel, Motion, MotionEstimator, MotionMethod,
};
use fingerpost::{Config, Pipeline};
use fingerpost_papers::FarnebackMotion;
use fingerpost_sim::SimConfig;
use nalgebra::Vector3;
use simulated::{camera, is_measured_in_other_views, motions, rms, simulator, turns, view};

fn farneback(model: FlowModel) -> FarnebackMotion {
    FarnebackMotion::new(&FarnebackMotionConfig { model, ..FarnebackMotionConfig::default() }).unwrap()
}

#[test]
fn direct_alignment_is_more_accurate_than_flow() {
    println!("{:<9} {:<7} {:>9} {:>9} {:>9}", "drive", "method", "fwd cm", "left cm", "yaw mrad");
    for drive in turns() {
        let name = drive.name;
        let errors = |method: &str, estimator: &mut dyn MotionEstimator| {
            let rms = rms(&drive, &motions(&drive, estimator));
            let shown = rms.component_mul(&Vector3::new(100.0, 100.0, 1000.0));
            println!("{name:<9} {method:<7} {:>9.2} {:>9.2} {:>9.2}", shown.x, shown.y, shown.z);
            rms
        };
        let direct = errors("direct", &mut DirectMotion::new(&DirectMotionConfig::default()));
        let mean = errors("mean", &mut farneback(FlowModel::Mean));
        let rigid = errors("rigid", &mut farneback(FlowModel::Rigid));
        assert!(
            (0..3).all(|axis| direct[axis] < 0.5 * mean[axis]),
            "{name}: half of what the mean flow errs"
        );
        assert!(
            name == "rough" || (0..3).all(|axis| direct[axis] < rigid[axis]),
            "{name}: better than the rigid fit to the flow"
        );
    }
}

#[test]
fn another_ground_view_starts_anew() {
    let measured = is_measured_in_other_views(&mut farneback(FlowModel::Rigid));
    assert_eq!(measured, [false, true, false, true]);
}

/// A road smoothed away by a video's compression stays where it is in the picture; trees and signs beside it do not.
#[test]
fn flow_that_stands_while_the_camera_travels_is_no_motion() {
    let (simulator, view) = (simulator(&SimConfig { start_m: 30.0, ..SimConfig::default() }), view());
    let mut picture = view.black_picture();
    view.render(&simulator.frame(0).picture, &mut picture).unwrap();
    let ahead = ObservedAngle { angle_rad: 0.0, variance_rad2: 1e-5 };
    let travels = AttitudeObservation { pitch: Some(ahead), ..AttitudeObservation::default() };
    let mut estimator = farneback(FlowModel::Mean);
    let mut found = Vec::new();
    for attitude in [travels; 5].into_iter().chain([AttitudeObservation::default(); 5]) {
        let motion = estimator.estimate(&view, &picture, &attitude).unwrap();
        found.extend(motion.map(|(output, _)| output.motion));
    }
    assert!(found[1..4].iter().all(|motion| *motion == Motion::unknown()), "{found:?}");
    assert!(
        found[7..].iter().all(|motion| motion.quality > 0.5),
        "a vehicle that has stopped stands: {found:?}"
    );
}

#[test]
fn flow_that_is_asked_for_and_not_given_is_refused_with_what_to_do() {
    let mut config = Config::default();
    config.motion.estimator = MotionMethod::Farneback;
    let refused = Pipeline::new(&config, &camera(), None, None).err().unwrap().to_string();
    for words in ["motion.estimator = \"farneback\"", "fingerpost_papers::parts", "\"direct\""] {
        assert!(refused.contains(words), "{refused}");
    }
    let parts = fingerpost_papers::parts(&config).unwrap();
    assert!(Pipeline::with_parts(&config, &camera(), None, None, parts).is_ok());
}

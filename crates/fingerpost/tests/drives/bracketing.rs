//! Bracketing (paper 1, section VI; paper 2, section 7.2): of a feature that is not where a spoilt motion puts it, and in
//! place of flow.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use std::f64::consts::FRAC_PI_2;

use crate::painted::{Junction, Place, World, camera_of_width, route};
use fingerpost::ground_view::GroundView;
use fingerpost::matching::Matcher;
use fingerpost::motion::{Motion, MotionMethod};
use fingerpost::road_surface::{Perspective, RoadInput, RoadSurface};
use fingerpost::track::{
    Decision, FeatureTracker, Moved, ShownSurface, State, TrackEvidence, TrackOutput, Tracker, TrackerSetting,
};
use fingerpost::vehicle::Traffic;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_map::FeatureKind;
use nalgebra::{Isometry2, Matrix3, Vector2};

const WIDTH_M: f64 = 5.5;
const STEP_M: f64 = 0.6;
const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];
const T_JUNCTION: Junction<'_> =
    Junction { kind: FeatureKind::Junction, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };

fn world() -> World {
    World::new(&[(SOUTH, WIDTH_M), (EAST, WIDTH_M), (WEST, WIDTH_M)])
}

/// The painted roads meet at sharp corners and have one lane.
fn config() -> Config {
    let mut config = crate::painted::config();
    config.track.alignment.kerb_radius_m = 0.0;
    config.vehicle.traffic = Traffic::Centre;
    config
}

/// A vehicle on its way north, so many metres before the node.
fn map_from_vehicle(before_m: f64) -> Isometry2<f64> {
    Isometry2::new(Vector2::new(0.0, -before_m), FRAC_PI_2)
}

/// The frame in which the motion is spoilt: what decided it, and by how much the place was off before and after.
#[derive(Debug)]
struct Spoilt {
    decision: Decision,
    predicted_off_m: f64,
    off_m: f64,
}

/// Drives towards the junction with the true motion, but for one frame 12 m before it whose motion is off by `spoilt_m`.
fn drive_spoilt(spoilt_m: f64) -> Spoilt {
    let (config, camera, world) = (config(), camera_of_width(400), world());
    let view =
        GroundView::new(&config.ground_view, config.road_surface.backprojection.bins(), &camera).unwrap();
    let setting = TrackerSetting {
        track: &config.track,
        masks: &config.feature_mask,
        driving_line: &config.driving_line,
        vehicle: &config.vehicle,
        progress: &config.route_progress,
        grid: view.grid(),
        nearest_seen_m: view.nearest_seen_m(),
        viewpoint: view.viewpoint(),
        row_rad: view.row_rad(),
    };
    let (route, _) = route(&T_JUNCTION);
    let mut tracker = Tracker::new(setting, Some(&route), Some(35.0)).unwrap();
    let mut detector = config.road_surface.detector().unwrap();
    let mut matcher = Matcher::new(&config.matching, view.grid());
    let (mut ground, mut surface) = (view.black_picture(), RoadSurface::default());
    let (mut output, mut evidence) = (TrackOutput::default(), TrackEvidence::default());
    for i in 0.. {
        let before_m = 25.0 - STEP_M * f64::from(i);
        let is_spoilt = before_m < 12.0;
        let forward_m = if is_spoilt { STEP_M + spoilt_m } else { STEP_M };
        let motion = (i > 0).then_some(Motion {
            previous_from_current: Isometry2::translation(forward_m, 0.0),
            covariance: Matrix3::identity() * 1e-4,
            quality: 1.0,
        });
        let frame = world.picture(&camera, &map_from_vehicle(before_m));
        view.render(&frame, &mut ground).unwrap();
        let validity = view.validity();
        let input = RoadInput {
            picture: &ground,
            validity,
            sample: config.road_surface.sample_region(&view),
            perspective: Perspective::Ground { view: &view, frame: &frame },
            motion: motion.as_ref(),
            height: None,
        };
        detector.detect(input, &mut surface).unwrap();
        let laid = matcher.laid_with(&surface, (&ground.grey, validity)).unwrap();
        let shown = ShownSurface { surface: &surface, seen: validity, laid };
        let moved = Moved { motion: motion.as_ref(), ..Moved::default() };
        tracker.step(moved, shown, None, &mut output, &mut evidence).unwrap();
        if is_spoilt {
            let off_m =
                |pose: &Isometry2<f64>| (pose.translation.vector - Vector2::new(before_m, 0.0)).norm();
            let followed = output.followed.as_ref().expect("it is followed");
            return Spoilt {
                decision: evidence.decision.clone(),
                predicted_off_m: evidence.predicted.as_ref().map_or(f64::NAN, off_m),
                off_m: off_m(&followed.vehicle_from_feature),
            };
        }
    }
    unreachable!("the drive comes to the junction")
}

#[test]
fn a_feature_that_is_not_where_a_spoilt_motion_puts_it_is_found_by_bracketing() {
    for spoilt_m in [2.5, -2.5, 4.0, -4.0] {
        let spoilt = drive_spoilt(spoilt_m);
        assert_eq!(spoilt.decision, Decision::FoundByBracketing, "{spoilt_m} m: {spoilt:?}");
        assert!(spoilt.predicted_off_m > 2.0 && spoilt.off_m < 0.4, "{spoilt_m} m: {spoilt:?}");
    }
}

#[test]
fn a_motion_that_is_right_needs_no_bracketing() {
    let spoilt = drive_spoilt(0.0);
    assert_eq!(spoilt.decision, Decision::Confirmed);
    assert!(spoilt.off_m < 0.3, "{spoilt:?}");
}

/// Brackets its way to the junction, `step_m` metres a frame, with nothing that measures the motion.
#[test]
fn a_feature_is_followed_by_bracketing_in_place_of_flow() {
    let (camera, world) = (camera_of_width(400), world());
    let (route, _) = route(&T_JUNCTION);
    let mut config = config();
    config.motion.estimator = MotionMethod::Bracketing;
    for step_m in [0.4, 0.7, 1.1] {
        let mut pipeline = Pipeline::new(&config, &camera, Some(&route), Some(35.0)).unwrap();
        let (mut detected_m, mut arrived, mut step_off_m) = (None, false, f64::INFINITY);
        let frames = ((25.0 - 3.0) / step_m) as usize;
        for i in 0..frames {
            let before_m = 25.0 - step_m * i as f64;
            let frame = world.picture(&camera, &map_from_vehicle(before_m));
            let (output, _) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
            let Some(followed) = &output.track.followed else { continue };
            detected_m.get_or_insert(before_m);
            let off = followed.vehicle_from_feature.translation.vector - Vector2::new(before_m, 0.0);
            assert!(off.norm() < 0.5, "{step_m} m a frame, {before_m} m before: {off}, {}", output.why);
            arrived |= output.track.state == State::Arrived;
            step_off_m = output.motion.unwrap().previous_from_current.translation.x - step_m;
        }
        assert!(detected_m.is_some_and(|m| m > 9.0) && arrived, "{step_m} m: {detected_m:?}, {arrived}");
        assert!(step_off_m.abs() < 0.1, "{step_m} m a frame is off by {step_off_m}");
    }
}

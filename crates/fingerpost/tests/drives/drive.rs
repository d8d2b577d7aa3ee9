//! The whole method on painted drives: every place is known, so every number is checked.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, World, camera, route};
use fingerpost::track::State;
use fingerpost::vehicle::Traffic;
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_map::FeatureKind;
use nalgebra::{Isometry2, Point2, Vector2};

const WIDTH_M: f64 = 5.5;

struct Drive {
    outputs: Vec<FrameOutput>,
    vehicle_from_node: Vec<Point2<f64>>,
}

/// Drives straight north towards a node at the origin, from `from_m` before it, `left_m` left of the road's middle.
fn drive(world: &World, junction: &Junction<'_>, config: &Config, left_m: f64, step_m: f64) -> Drive {
    let camera = camera();
    let (route, _) = route(junction);
    let mut pipeline = Pipeline::new(config, &camera, Some(&route), None).unwrap();
    let mut result = Drive { outputs: Vec::new(), vehicle_from_node: Vec::new() };
    let frames = ((28.0 - 5.0) / step_m) as usize;
    for i in 0..frames {
        let y = -28.0 + step_m * i as f64;
        let map_from_vehicle = Isometry2::new(Vector2::new(-left_m, y), std::f64::consts::FRAC_PI_2);
        let frame = world.picture(&camera, &map_from_vehicle);
        let (output, _) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
        result.outputs.push(output.clone());
        result.vehicle_from_node.push(map_from_vehicle.inverse() * Point2::origin());
    }
    result
}

/// The painted roads meet at sharp corners.
fn keeping(traffic: Traffic) -> Config {
    let mut config = crate::painted::config();
    config.track.kerb_radius_m = 0.0;
    config.vehicle.traffic = traffic;
    config
}

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const NORTH: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];

fn check_found(drive: &Drive) {
    let first =
        drive.outputs.iter().position(|o| o.track.state == State::Tracking).expect("the junction is found");
    let distance = drive.vehicle_from_node[first].x;
    assert!(distance > 13.0, "found only {distance} m ahead");
    let mut arrived = false;
    for (output, truth) in drive.outputs.iter().zip(&drive.vehicle_from_node).skip(first) {
        let Some(followed) = &output.track.followed else { continue };
        let error = followed.vehicle_from_feature.translation.vector - truth.coords;
        assert!(error.norm() < 0.35, "{truth}: off by {error}, {}", output.why);
        arrived |= output.track.state == State::Arrived;
    }
    assert!(arrived, "the curve's start reached the bottom of the view");
}

/// A T-junction that is left by `exit`, with the other arm aside.
fn check_t_junction(exit: &[Place], side: &[Place], traffic: Traffic, left_m: f64) {
    let world = World::new(&[(SOUTH, WIDTH_M), (EAST, WIDTH_M), (WEST, WIDTH_M)]);
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit, sides: &[side], width_m: WIDTH_M };
    check_found(&drive(&world, &junction, &keeping(traffic), left_m, 0.6));
}

#[test]
fn a_t_junction_to_the_right_is_found_followed_and_arrived_at() {
    check_t_junction(EAST, WEST, Traffic::Centre, 0.0);
}

#[test]
fn a_vehicle_that_cannot_turn_as_tightly_as_its_line_is_told_so() {
    let world = World::new(&[(SOUTH, WIDTH_M), (EAST, WIDTH_M), (WEST, WIDTH_M)]);
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    for (turning_radius_m, is_said) in [(9.0, false), (25.0, true)] {
        let mut config = keeping(Traffic::Centre);
        config.vehicle.turning_radius_m = turning_radius_m;
        let drive = drive(&world, &junction, &config, 0.0, 0.6);
        let followed = drive.outputs.iter().filter(|output| output.track.followed.is_some());
        let said = followed.map(|output| output.why.contains("the vehicle at no less than 25.00 m"));
        let said: Vec<bool> = said.collect();
        assert!(!said.is_empty() && said.iter().all(|said| *said == is_said), "{turning_radius_m}: {said:?}");
    }
}

#[test]
fn the_side_of_the_road_does_not_matter() {
    check_t_junction(WEST, EAST, Traffic::Right, -1.3);
}

#[test]
fn a_side_road_is_found_on_its_own_side_alone() {
    let to_the_left = World::new(&[(SOUTH, WIDTH_M), (NORTH, WIDTH_M), (WEST, WIDTH_M)]);
    let left = Junction {
        kind: FeatureKind::SideRoad,
        approach: SOUTH,
        exit: NORTH,
        sides: &[WEST],
        width_m: WIDTH_M,
    };
    let right = Junction {
        sides: &[EAST],
        ..Junction { kind: FeatureKind::SideRoad, approach: SOUTH, exit: NORTH, sides: &[], width_m: WIDTH_M }
    };
    check_found(&drive(&to_the_left, &left, &keeping(Traffic::Centre), 0.0, 0.6));
    let mirrored = drive(&to_the_left, &right, &keeping(Traffic::Centre), 0.0, 0.6);
    assert!(
        mirrored.outputs.iter().all(|o| o.track.followed.is_none()),
        "a road on the left is none on the right"
    );
}

#[test]
fn a_straight_road_is_no_feature() {
    let world = World::new(&[(SOUTH, WIDTH_M), (NORTH, WIDTH_M)]);
    let junction = Junction {
        kind: FeatureKind::Junction,
        approach: SOUTH,
        exit: EAST,
        sides: &[WEST],
        width_m: WIDTH_M,
    };
    let drive = drive(&world, &junction, &keeping(Traffic::Centre), 0.0, 0.6);
    assert!(drive.outputs.iter().all(|o| o.track.followed.is_none()));
    assert!(drive.outputs.iter().all(|o| o.track.state == State::Searching));
}

#[test]
fn a_paved_area_is_no_junction() {
    // As wide as all that is seen: road under every mask.
    let world = World::new(&[(SOUTH, 90.0), (NORTH, 90.0)]);
    let junction = Junction {
        kind: FeatureKind::Junction,
        approach: SOUTH,
        exit: EAST,
        sides: &[WEST],
        width_m: WIDTH_M,
    };
    let drive = drive(&world, &junction, &keeping(Traffic::Centre), 0.0, 0.6);
    let looked_for =
        |o: &&FrameOutput| o.why.contains("at none of 33 places in view does the ground look like it");
    assert!(drive.outputs.iter().filter(looked_for).count() > 30);
    assert!(drive.outputs.iter().all(|o| o.track.followed.is_none()));
}

#[test]
fn ego_motion_is_the_motion_and_a_standing_vehicle_does_not_move() {
    let world = World::new(&[(SOUTH, WIDTH_M), (NORTH, WIDTH_M)]);
    let camera = camera();
    for (step_m, yaw_step) in [(0.0, 0.0), (0.4, 0.0), (1.2, 0.0), (0.5, 0.04), (0.5, -0.04)] {
        let mut pipeline = Pipeline::new(&crate::painted::config(), &camera, None, None).unwrap();
        let mut map_from_vehicle = Isometry2::new(Vector2::new(0.0, -20.0), std::f64::consts::FRAC_PI_2);
        let step = Isometry2::new(Vector2::new(step_m, 0.0), yaw_step);
        for i in 0..5 {
            let mut frame = world.picture(&camera, &map_from_vehicle);
            // A sensor's noise never repeats; a picture that does is no standing vehicle's.
            frame.as_mut_slice().iter_mut().skip(i).step_by(7).for_each(|level| *level ^= 1);
            let (output, _) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
            if i > 0 {
                let motion = output.motion.unwrap();
                let moved = motion.previous_from_current;
                assert!(
                    (moved.translation.vector - step.translation.vector).norm() < 0.02 + 0.02 * step_m,
                    "{moved} for {step}"
                );
                assert!((moved.rotation.angle() - yaw_step).abs() < 0.004, "{moved} for {step}");
                assert!(motion.quality > 0.5, "quality {}", motion.quality);
            }
            map_from_vehicle *= step;
        }
    }
}

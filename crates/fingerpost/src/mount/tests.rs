use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

use super::*;
use crate::attitude::{AttitudeObservation, ObservedAngle};
use crate::motion::Motion;

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const AHEAD_M: f64 = 1.5;

fn straight() -> Motion {
    Motion {
        previous_from_current: Isometry2::translation(1.0, 0.0),
        covariance: Matrix3::identity() * 1e-4,
        quality: 1.0,
    }
}

fn seen(angle_deg: f64, sigma_deg: f64) -> Option<ObservedAngle> {
    Some(ObservedAngle { angle_rad: angle_deg * DEGREE, variance_rad2: (sigma_deg * DEGREE).powi(2) })
}

/// Pitch, yaw and roll with a noise that repeats.
fn angles(frame: usize, [pitch, yaw, roll]: [f64; 3]) -> AttitudeObservation {
    let noise = 0.2 * ((frame * 7 % 11) as f64 / 5.0 - 1.0);
    AttitudeObservation {
        pitch: seen(pitch + noise, 0.2),
        yaw: seen(yaw - noise, 0.2),
        roll: seen(roll + noise, 0.5),
        ..Default::default()
    }
}

fn drive(filter: &mut MountFilter, frames: usize, truth_deg: [f64; 3]) -> MountEstimate {
    (0..frames).map(|frame| filter.observe(&angles(frame, truth_deg), &straight())).last().unwrap()
}

#[test]
fn the_camera_is_turned_by_the_mount_and_the_suspension_together() {
    let mount = MountEstimate {
        pitch_rad: 0.01,
        roll_rad: -0.02,
        suspension_pitch_rad: 0.005,
        sigma_rad: [0.003, 0.5, 0.02, 0.004],
        ..MountEstimate::default()
    };
    let CameraAttitude { turn, sigma_rad } = mount.attitude();
    let is = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value}, not {expected}");
    is(turn.pitch_rad, 0.015);
    is(turn.roll_rad, -0.02);
    is(sigma_rad[0], 0.005);
    is(sigma_rad[1], 0.02);
}

#[test]
fn the_mount_is_found_and_becomes_valid() {
    let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
    assert_eq!(drive(&mut filter, 5, [0.8, -0.3, 0.2]).state, MountState::NotYetValid);
    let estimate = drive(&mut filter, 60, [0.8, -0.3, 0.2]);
    assert_eq!((estimate.state, estimate.fault), (MountState::Valid, None));
    for (found, truth) in
        [estimate.pitch_rad, estimate.yaw_rad, estimate.roll_rad].into_iter().zip([0.8, -0.3, 0.2])
    {
        assert!((found / DEGREE - truth).abs() < 0.15, "{estimate:?}");
    }
    assert!(estimate.sigma_rad.iter().all(|&sigma| sigma > 0.0), "never certain");
}

#[test]
fn braking_moves_the_suspension_and_not_the_mount() {
    let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
    let before = drive(&mut filter, 200, [0.5, 0.0, 0.0]);
    let dip = AttitudeObservation { pitch_change: seen(0.6, 0.05), ..angles(5, [1.1, 0.0, 0.0]) };
    let braking = filter.observe(&dip, &straight());
    assert!((braking.pitch_rad - before.pitch_rad).abs() < 0.1 * DEGREE, "{braking:?}");
    assert!((braking.suspension_pitch_rad / DEGREE - 0.6).abs() < 0.15, "{braking:?}");
}

#[test]
fn a_turned_camera_is_noticed_and_found_again() {
    for (turned, angle) in [
        ([3.5, 0.0, 0.0], MountAngle::Pitch),
        ([0.5, -3.0, 0.0], MountAngle::Yaw),
        ([0.5, 0.0, 3.0], MountAngle::Roll),
    ] {
        let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
        assert_eq!(drive(&mut filter, 100, [0.5, 0.0, 0.0]).fault, None);
        let noticed = (0..50).find_map(|frame| filter.observe(&angles(frame, turned), &straight()).fault);
        let fault = noticed.unwrap();
        assert_eq!(fault.angle, angle);
        assert!((fault.by_rad.abs() / DEGREE - 3.0).abs() < 0.4, "{fault:?}");
        let again = drive(&mut filter, 60, turned);
        assert_eq!((again.state, again.fault), (MountState::Valid, None));
        assert!((again.pitch_rad / DEGREE - turned[0]).abs() < 0.2, "{again:?}");
        assert!((again.yaw_rad / DEGREE - turned[1]).abs() < 0.2, "{again:?}");
    }
}

#[test]
fn a_jump_of_the_roll_is_noticed_without_a_view_of_the_roll() {
    let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
    let without = |frame| AttitudeObservation { roll: None, ..angles(frame, [0.5, 0.0, 0.0]) };
    for frame in 0..100 {
        assert_eq!(filter.observe(&without(frame), &straight()).fault, None);
    }
    let jump = AttitudeObservation { roll_change: seen(3.0, 0.1), ..without(0) };
    let noticed = (0..50)
        .map(|frame| if frame == 0 { jump } else { without(frame) })
        .find_map(|observation| filter.observe(&observation, &straight()).fault);
    assert_eq!(noticed.unwrap().angle, MountAngle::Roll);
}

#[test]
fn bumps_and_outliers_are_no_fault() {
    let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
    drive(&mut filter, 100, [0.5, 0.0, 0.0]);
    for frame in 0..200 {
        let bump = if frame % 4 == 0 { 4.0 } else { 0.0 };
        let bumpy = AttitudeObservation {
            roll_change: seen(if frame % 2 == 0 { 2.0 } else { -2.0 }, 0.1),
            ..angles(frame, [0.5 + bump, bump, -bump])
        };
        let estimate = filter.observe(&bumpy, &straight());
        assert_eq!(estimate.fault, None, "frame {frame}");
        assert!((estimate.pitch_rad / DEGREE - 0.5).abs() < 0.2, "{estimate:?}");
    }
}

#[test]
fn a_small_lasting_change_is_followed() {
    let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
    drive(&mut filter, 100, [0.5, 0.0, 0.0]);
    let loaded = drive(&mut filter, 500, [-0.7, 0.0, 0.0]);
    assert_eq!(loaded.fault, None);
    assert!((loaded.pitch_rad / DEGREE + 0.7).abs() < 0.25, "{loaded:?}");
}

#[test]
fn a_calibration_that_cannot_be_true_is_named_and_a_possible_one_is_not() {
    for fifth in -100..=100_i32 {
        let off_deg = f64::from(fifth) * 0.2;
        for (truth, angle) in
            [([off_deg, 0.0, 0.0], MountAngle::Pitch), ([0.0, off_deg, 0.0], MountAngle::Yaw)]
        {
            let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
            let early = drive(&mut filter, 5, truth);
            assert_eq!(early.contradiction, None, "not before it is known");
            let estimate = drive(&mut filter, 200, truth);
            assert_eq!(estimate.state, MountState::Valid, "{off_deg}");
            match estimate.contradiction {
                Some(found) => {
                    assert!(off_deg.abs() > 4.5, "{off_deg}: {found:?}");
                    assert_eq!(found.angle, angle);
                    assert!((found.by_rad / DEGREE - off_deg).abs() < 0.3, "{off_deg}: {found:?}");
                    assert!(found.by_rad.abs() > found.most_rad);
                }
                None => assert!(off_deg.abs() < 5.5, "{off_deg}: {estimate:?}"),
            }
        }
    }
}

/// The camera sweeps round a circle of 25 m at 5 m/s and 30 frames a second: it moves 3.3 degrees to the inside all the time.
#[test]
fn a_long_bend_turns_no_camera() {
    for (left, yaw_deg) in [(1.0_f64, 0.0), (-1.0, 0.0), (1.0, 0.6)] {
        let (step_m, turn_rad) = (5.0 / 30.0, left * 5.0 / 30.0 / 25.0);
        let chord_m = Vector2::new(libm::cos(0.5 * turn_rad), libm::sin(0.5 * turn_rad)) * step_m;
        let previous_from_current = Isometry2::new(chord_m, turn_rad);
        let camera = Point2::new(AHEAD_M, 0.0);
        let moved_m = previous_from_current.rotation.inverse() * (previous_from_current * camera - camera);
        let bend = Motion { previous_from_current, ..straight() };
        let mut filter = MountFilter::new(&MountConfig::default(), AHEAD_M);
        drive(&mut filter, 60, [0.5, yaw_deg, 0.0]);
        for frame in 0..150 {
            let inwards_deg = libm::atan2(moved_m.y, moved_m.x) / DEGREE;
            let estimate = filter.observe(&angles(frame, [0.5, yaw_deg - inwards_deg, 0.0]), &bend);
            assert_eq!(estimate.fault, None, "{left}, frame {frame}");
            assert!((estimate.yaw_rad / DEGREE - yaw_deg).abs() < 0.2, "{left}, frame {frame}: {estimate:?}");
        }
    }
}

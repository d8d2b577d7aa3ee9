//! Each controller drives a bicycle model along lines and circles whose place is known.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

mod bicycle;

use fingerpost_control::{ControllerName, DEFAULT_RULES, Situation, Steersman, VehicleLimits, arc, lay};
use nalgebra::Point2;

use bicycle::Bicycle;

fn steersman(name: ControllerName, limits: VehicleLimits) -> Steersman {
    Steersman::new(name, limits, DEFAULT_RULES).unwrap()
}

/// A situation on a path that is surely there.
fn on(path: &[fingerpost_control::PathPoint], speed_mps: f64, steer_rad: f64) -> Situation<'_> {
    Situation {
        path,
        speed_mps,
        steer_rad,
        lateral_sigma_m: 0.05,
        room_m: 1.0,
        present: 1.0,
        seen_ahead_m: 20.0,
        turn_ahead: None,
    }
}

#[test]
fn a_path_to_the_left_is_steered_to_the_left() {
    for name in ControllerName::ALL {
        for side in [1.0, -1.0] {
            let mut path = Vec::new();
            let mut steer = |left_m, heading_rad, curvature_per_m| {
                arc(left_m, heading_rad, curvature_per_m, [20.0, 0.5], &mut path);
                let mut steersman = steersman(name, VehicleLimits::default());
                let command = steersman.steer(&on(&path, 5.0, 0.0), None).unwrap();
                (command.steer_rad * side, steersman.evidence().offset_m * side)
            };
            let (beside, offset_m) = steer(side, 0.0, 0.0);
            assert!(beside > 0.05 && offset_m < -0.9, "{name:?}: the vehicle is right of a line to the left");
            assert!(steer(0.0, 0.2 * side, 0.0).0 > 0.05, "{name:?}: towards its direction");
            assert!(steer(0.0, 0.0, 0.1 * side).0 > 0.1, "{name:?}: round its bend");
            assert!(steer(0.0, 0.0, 0.0).0.abs() < 1e-9, "{name:?}: straight on");
        }
    }
}

/// A drive along points.
struct Drive<'a> {
    name: ControllerName,
    limits: VehicleLimits,
    points: &'a [Point2<f64>],
    curvature_per_m: &'a [f64],
}

impl Drive<'_> {
    /// The largest distance from the points between two times, metres, and the largest steering angle, radians.
    fn worst(&self, start: Bicycle, counted_s: std::ops::Range<f64>) -> (f64, f64) {
        const DT_S: f64 = 0.05;
        let (mut steersman, mut vehicle, mut path) = (steersman(self.name, self.limits), start, Vec::new());
        let (mut worst_m, mut most_rad, mut asked_rad) = (0.0_f64, 0.0_f64, start.steer_rad);
        for step in 0..(counted_s.end / DT_S) as usize {
            let in_vehicle: Vec<_> =
                self.points.iter().map(|place| vehicle.pose().inverse() * place).collect();
            let nearest = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
            let first = in_vehicle.iter().map(|p| p.coords.norm()).enumerate().min_by(nearest).unwrap().0;
            let ahead = first.saturating_sub(4)..(first + 60).min(in_vehicle.len());
            if ahead.len() < 8 {
                break;
            }
            lay(&in_vehicle[ahead.clone()], &self.curvature_per_m[ahead], &mut path);
            let command = steersman.steer(&on(&path, vehicle.speed_mps, asked_rad), Some(DT_S)).unwrap();
            asked_rad = command.steer_rad;
            most_rad = most_rad.max(asked_rad.abs());
            vehicle.step(&self.limits, command, DT_S);
            if step as f64 * DT_S >= counted_s.start {
                worst_m = worst_m.max(steersman.evidence().offset_m.abs());
            }
        }
        (worst_m, most_rad)
    }
}

#[test]
fn a_straight_line_is_come_back_to() {
    let points: Vec<_> = (-10..500).map(|i| Point2::new(0.5 * f64::from(i), 0.0)).collect();
    let straight = vec![0.0; points.len()];
    for name in ControllerName::ALL {
        for (left_m, heading_rad) in [(1.5, 0.0), (-1.5, 0.0), (0.0, 0.3), (1.0, 0.3), (-1.0, -0.3)] {
            let start = Bicycle { left_m, heading_rad, speed_mps: 6.0, ..Bicycle::default() };
            let drive =
                Drive { name, limits: VehicleLimits::default(), points: &points, curvature_per_m: &straight };
            let off_m = drive.worst(start, 15.0..30.0).0;
            assert!(off_m < 0.05, "{name:?} from {left_m} m, {heading_rad} rad: {off_m} m off");
        }
    }
}

#[test]
fn a_circle_is_followed() {
    for (radius_m, side) in [(6.0, 1.0), (6.0, -1.0), (12.0, 1.0), (25.0, -1.0), (100.0, 1.0)] {
        let points: Vec<_> = (0..)
            .map(|i| 0.25 * f64::from(i) / radius_m)
            .take_while(|angle| *angle < 12.0)
            .map(|angle| Point2::new(radius_m * libm::sin(angle), side * radius_m * (1.0 - libm::cos(angle))))
            .collect();
        // Only the first turn of it, so that the nearest point is not one of another.
        let turns = points.len().min((6.0 * radius_m / 0.25) as usize);
        let curvature_per_m = vec![side / radius_m; turns];
        for name in ControllerName::ALL {
            let steer_rad = VehicleLimits::default().steer_rad(side / radius_m);
            let start = Bicycle { speed_mps: 3.0, steer_rad, ..Bicycle::default() };
            let time_s = 4.0 * radius_m / (2.0 * radius_m).sqrt().min(8.0);
            let limits = VehicleLimits::default();
            let drive = Drive { name, limits, points: &points[..turns], curvature_per_m: &curvature_per_m };
            let off_m = drive.worst(start, 0.5 * time_s..time_s).0;
            assert!(off_m < 0.12, "{name:?} on {radius_m} m: {off_m} m off");
        }
    }
}

#[test]
fn corners_of_the_vehicle_s_turning_circle_are_driven() {
    for radius_m in [6.0, 9.0, 12.0, 25.0] {
        for side in [1.0, -1.0] {
            const STEP_M: f64 = 0.25;
            let limits = VehicleLimits { turning_radius_m: radius_m, ..VehicleLimits::default() };
            let quarter_m = 0.5 * std::f64::consts::PI * radius_m;
            let (points, curvature_per_m): (Vec<_>, Vec<_>) = (0..)
                .map(|i| STEP_M * f64::from(i))
                .take_while(|along_m| *along_m < 40.0 + quarter_m)
                .map(|along_m| {
                    let turned = ((along_m - 20.0) / radius_m).clamp(0.0, 0.5 * std::f64::consts::PI);
                    let (before_m, behind_m) = (along_m.min(20.0), (along_m - 20.0 - quarter_m).max(0.0));
                    let place = Point2::new(
                        before_m + radius_m * libm::sin(turned),
                        side * (radius_m * (1.0 - libm::cos(turned)) + behind_m),
                    );
                    let turns = (20.0..=20.0 + quarter_m).contains(&along_m);
                    (place, if turns { side / radius_m } else { 0.0 })
                })
                .unzip();
            for name in ControllerName::ALL {
                let start = Bicycle { speed_mps: 3.0, ..Bicycle::default() };
                let drive = Drive { name, limits, points: &points, curvature_per_m: &curvature_per_m };
                let (off_m, most_rad) = drive.worst(start, 0.0..30.0);
                assert!(off_m < 0.45, "{name:?} round {radius_m} m to {side}: {off_m} m off");
                assert!(
                    most_rad <= limits.steer_max_rad() + 1e-9,
                    "{name:?} round {radius_m} m: {most_rad} rad"
                );
            }
        }
    }
}

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

/// Drives along points for `time_s` and gives the largest distance from them after half of that.
fn drive(
    name: ControllerName,
    limits: VehicleLimits,
    points: &[Point2<f64>],
    curvature_per_m: &[f64],
    start: Bicycle,
    time_s: f64,
) -> f64 {
    const DT_S: f64 = 0.05;
    let (mut steersman, mut vehicle, mut path) = (steersman(name, limits), start, Vec::new());
    let (mut worst_m, mut asked_rad) = (0.0_f64, start.steer_rad);
    for step in 0..(time_s / DT_S) as usize {
        let in_vehicle: Vec<_> = points.iter().map(|place| vehicle.pose().inverse() * place).collect();
        let nearest = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
        let first = in_vehicle.iter().map(|p| p.coords.norm()).enumerate().min_by(nearest).unwrap().0;
        let ahead = first.saturating_sub(4)..(first + 60).min(points.len());
        lay(&in_vehicle[ahead.clone()], &curvature_per_m[ahead], &mut path);
        let command = steersman.steer(&on(&path, vehicle.speed_mps, asked_rad), Some(DT_S)).unwrap();
        asked_rad = command.steer_rad;
        vehicle.step(&limits, command, DT_S);
        if step as f64 * DT_S > 0.5 * time_s {
            worst_m = worst_m.max(steersman.evidence().offset_m.abs());
        }
    }
    worst_m
}

#[test]
fn a_straight_line_is_come_back_to() {
    let points: Vec<_> = (-10..500).map(|i| Point2::new(0.5 * f64::from(i), 0.0)).collect();
    let straight = vec![0.0; points.len()];
    for name in ControllerName::ALL {
        for (left_m, heading_rad) in [(1.5, 0.0), (-1.5, 0.0), (0.0, 0.3), (1.0, 0.3), (-1.0, -0.3)] {
            let start = Bicycle { left_m, heading_rad, speed_mps: 6.0, ..Bicycle::default() };
            let off_m = drive(name, VehicleLimits::default(), &points, &straight, start, 30.0);
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
            .map(|angle| Point2::new(radius_m * angle.sin(), side * radius_m * (1.0 - angle.cos())))
            .collect();
        // Only the first turn of it, so that the nearest point is not one of another.
        let turns = points.len().min((6.0 * radius_m / 0.25) as usize);
        let curvature_per_m = vec![side / radius_m; turns];
        for name in ControllerName::ALL {
            let steer_rad = VehicleLimits::default().steer_rad(side / radius_m);
            let start = Bicycle { speed_mps: 3.0, steer_rad, ..Bicycle::default() };
            let time_s = 4.0 * radius_m / (2.0 * radius_m).sqrt().min(8.0);
            let off_m =
                drive(name, VehicleLimits::default(), &points[..turns], &curvature_per_m, start, time_s);
            assert!(off_m < 0.12, "{name:?} on {radius_m} m: {off_m} m off");
        }
    }
}

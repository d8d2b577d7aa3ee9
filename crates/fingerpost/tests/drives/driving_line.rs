//! The driving line by known places: turning circle, side of the road, curvature's sign.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, route};
use fingerpost::driving_line::{CornerSetting, DrivingLine, DrivingLineConfig};
use fingerpost::feature_model::FeatureModel;
use fingerpost::vehicle::{Traffic, VehicleConfig};
use fingerpost_map::{FeatureKind, TangentPlane};
use nalgebra::{Point2, Vector2};

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];

fn line(exit: &[Place], vehicle: &VehicleConfig) -> DrivingLine {
    line_round(exit, vehicle, 6.0, 4.0)
}

fn line_round(exit: &[Place], vehicle: &VehicleConfig, width_m: f64, kerb_m: f64) -> DrivingLine {
    let junction = Junction { kind: FeatureKind::Junction, approach: SOUTH, exit, sides: &[], width_m };
    let (route, _) = route(&junction);
    let model = FeatureModel::new(&route.features[0], &TangentPlane::new(route.line[0].at)).unwrap();
    let corner = CornerSetting { kerb_radius_m: kerb_m, ..CornerSetting::default() };
    DrivingLine::new(&DrivingLineConfig::default(), vehicle, &model, &corner).unwrap().unwrap()
}

fn centred(turning_radius_m: f64) -> VehicleConfig {
    VehicleConfig { traffic: Traffic::Centre, turning_radius_m, ..VehicleConfig::default() }
}

#[test]
fn the_line_goes_round_the_kerb_in_its_lane() {
    // Roads of 6 m whose kerbs have 4 m: from the inner edge a lane's middle is 1.5 or 4.5 m away, the road's 3 m.
    let (east, west): (&[Place], &[Place]) = (&[(0.0, 0.0), (60.0, 0.0)], &[(0.0, 0.0), (-60.0, 0.0)]);
    for (exit, traffic, to_edge_m) in [
        (east, Traffic::Right, 1.5),
        (west, Traffic::Right, 4.5),
        (west, Traffic::Left, 1.5),
        (east, Traffic::Centre, 3.0),
    ] {
        for kerb_m in [1.0, 4.0, 10.0] {
            let vehicle = VehicleConfig { traffic, turning_radius_m: 2.0, ..VehicleConfig::default() };
            let line = line_round(exit, &vehicle, 6.0, kerb_m);
            let side = exit[1].0.signum();
            // Inside of the turn, in the feature frame: behind the node, to the right of a way that leads east.
            let kerb_centre = Point2::new(-3.0 - kerb_m, -side * (3.0 + kerb_m));
            for i in 0..=10 {
                let at = line.curve.at(0.1 * f64::from(i) * line.curve.length_m()).0;
                let from_kerb_m = (at - kerb_centre).norm() - kerb_m;
                assert!((from_kerb_m - to_edge_m).abs() < 0.02, "{traffic:?} {kerb_m}: {from_kerb_m}");
            }
        }
    }
}

#[test]
fn the_turning_circle_widens_the_line_where_there_is_room() {
    for radius in [4.0, 5.0, 7.0] {
        let line = line(&[(0.0, 0.0), (60.0, 0.0)], &centred(radius));
        assert!(line.within_turning_circle());
        assert!((line.tightest_radius_m - 7.0).abs() < 1e-3, "the kerb is wider: {}", line.tightest_radius_m);
        assert!(line.start().y.abs() < 1e-3 && (line.end() - Point2::new(0.0, -7.0)).norm() < 1e-3);
    }
}

#[test]
fn a_road_of_two_lanes_a_side_is_driven_along_its_edge() {
    let line = line_round(&[(0.0, 0.0), (60.0, 0.0)], &VehicleConfig::default(), 14.0, 4.0);
    assert!((line.start().y + 5.25).abs() < 1e-3, "the right one of two lanes of 3.5 m: {}", line.start());
    assert!((line.end().x + 5.25).abs() < 1e-3, "{}", line.end());
}

#[test]
fn a_wide_vehicle_gets_a_rounder_curve_and_not_a_longer_one() {
    for radius in [9.0, 11.0] {
        let line = line(&[(0.0, 0.0), (60.0, 0.0)], &centred(radius));
        assert!(line.within_turning_circle(), "{} for {radius}", line.tightest_radius_m);
        assert!(-line.start().x <= 12.0, "{}", line.start());
    }
    // No line on the road is as wide as that: the body's inner side, 1 m from its middle, touches the kerb of 4 m on an arc of
    // (3 sqrt(2) + 4 (sqrt(2) - 1) - 1) / (sqrt(2) - 1) m.
    let line = line(&[(0.0, 0.0), (60.0, 0.0)], &centred(25.0));
    assert!(!line.within_turning_circle() && (line.tightest_radius_m - 11.828).abs() < 0.01);
}

#[test]
fn the_line_stays_on_the_road_in_sharp_turns() {
    // A car of a turning circle of 5 m, on roads of 6 m whose corners are rounded with 4 m.
    for turn_deg in [60.0_f64, 90.0, 110.0, 120.0, 130.0] {
        for side in [1.0, -1.0] {
            let (sine, cosine) = libm::sincos(turn_deg.to_radians());
            let exit = [(0.0, 0.0), (60.0 * side * sine, 60.0 * cosine)];
            let line = line(&exit, &VehicleConfig::default());
            let is_driven = line.within_turning_circle() || turn_deg > 120.0;
            assert!(is_driven, "{turn_deg}: {}", line.tightest_radius_m);
            // Inside the turn both roads' edges are this far from the middle of the corner, and the kerb cuts it off.
            let (half, inward) = (0.5 * turn_deg.to_radians(), -side);
            let apex = line.curve.at(0.5 * line.curve.length_m()).0;
            let bisector = Vector2::new(-libm::sin(half), inward * libm::cos(half));
            let kerb_m = 3.0 / libm::cos(half) + 4.0 * (1.0 / libm::cos(half) - 1.0);
            let apex_m = apex.coords.dot(&bisector);
            assert!(apex_m < kerb_m - 0.5, "{turn_deg} {side}: {apex_m} of {kerb_m}");
        }
    }
}

#[test]
fn too_sharp_a_turn_says_so() {
    let line = line(&[(0.0, 0.0), (6.0, -60.0)], &centred(6.0));
    assert!(!line.within_turning_circle() && line.tightest_radius_m < 6.0);
}

#[test]
fn curvature_is_positive_to_the_left_and_zero_straight_on() {
    let tightest = |line: &DrivingLine| {
        line.curvature_per_m.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
    };
    // Three metres from the inner edge, whose kerb has 4 m.
    let [left, right] =
        [-60.0, 60.0].map(|east_m| tightest(&line(&[(0.0, 0.0), (east_m, 0.0)], &centred(5.0))));
    assert!((left - 1.0 / 7.0).abs() < 1e-4 && (right + 1.0 / 7.0).abs() < 1e-4, "{left} {right}");
    assert!(tightest(&line(&[(0.0, 0.0), (0.0, 60.0)], &centred(5.0))).abs() < 1e-6, "straight on");
}

#[test]
fn points_and_curvature_describe_one_smooth_curve() {
    let line = line(&[(0.0, 0.0), (60.0, 0.0)], &VehicleConfig::default());
    assert_eq!(line.points.len(), line.curvature_per_m.len());
    for points in line.points.windows(2) {
        let step = (points[1] - points[0]).norm();
        assert!((0.2..0.7).contains(&step), "points {step} m apart");
    }
    let turned: f64 = line
        .points
        .windows(3)
        .map(|p| {
            let (a, b) = (p[1] - p[0], p[2] - p[1]);
            libm::atan2(a.perp(&b), a.dot(&b))
        })
        .sum();
    assert!((turned + std::f64::consts::FRAC_PI_2).abs() < 0.01, "a right angle to the right: {turned}");
}

#[test]
fn traffic_keeps_to_its_side() {
    let north: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
    let side = |traffic| line(north, &VehicleConfig { traffic, ..VehicleConfig::default() }).start().y;
    assert!((side(Traffic::Right) + 1.5).abs() < 1e-6, "a quarter of 6 m to the right");
    assert!((side(Traffic::Left) - 1.5).abs() < 1e-6);
    assert!(side(Traffic::Centre).abs() < 1e-6);
    // Turning right in right-hand traffic cuts the corner closer than turning left.
    let right = line(&[(0.0, 0.0), (60.0, 0.0)], &VehicleConfig::default());
    assert!((right.end().x + 1.5).abs() < 1e-3, "the exit's own side: south of its middle");
}

#[test]
fn a_road_that_bends_beside_its_node_is_no_tight_corner() {
    // A road of Vaduz at a side road: 6 m before the node it turns by 13 degrees.
    let approach: &[Place] = &[(0.0, 0.0), (-6.0, -0.6), (-40.4, -12.2), (-81.1, -35.0)];
    let junction = Junction {
        kind: FeatureKind::SideRoad,
        approach,
        exit: &[(0.0, 0.0), (44.5, 4.1), (81.8, 7.1)],
        sides: &[&[(0.0, 0.0), (10.4, -41.1)]],
        width_m: 6.0,
    };
    let (route, _) = route(&junction);
    let model = FeatureModel::new(&route.features[0], &TangentPlane::new(route.line[0].at)).unwrap();
    for traffic in [Traffic::Left, Traffic::Right, Traffic::Centre] {
        let vehicle = VehicleConfig { traffic, ..VehicleConfig::default() };
        let line =
            DrivingLine::new(&DrivingLineConfig::default(), &vehicle, &model, &CornerSetting::default());
        let line = line.unwrap().unwrap();
        assert!(line.tightest_radius_m > 15.0, "{} m", line.tightest_radius_m);
    }
}

#[test]
fn arms_that_bend_beside_the_node_have_an_arc_all_the_same() {
    // A turn in Vaduz: the approach turns twice within 10 m of the node, the exit once after 11 m.
    let junction = Junction {
        kind: FeatureKind::Junction,
        approach: &[(0.0, 0.0), (-1.0, 3.6), (-5.4, 8.5), (-11.3, 12.8), (-38.8, 31.9)],
        exit: &[(0.0, 0.0), (10.9, -3.3), (9.6, -9.5), (14.1, -20.1), (28.0, -46.5)],
        sides: &[&[(0.0, 0.0), (-16.3, -10.2), (-49.4, -29.0)]],
        width_m: 5.5,
    };
    let (route, _) = route(&junction);
    let model = FeatureModel::new(&route.features[0], &TangentPlane::new(route.line[0].at)).unwrap();
    let config = DrivingLineConfig::default();
    let line = DrivingLine::new(&config, &VehicleConfig::default(), &model, &CornerSetting::default());
    let line = line.unwrap().unwrap();
    assert!(line.within_turning_circle(), "{} m", line.tightest_radius_m);
    let [start, corner, end] = line.control;
    let legs_m = [(corner - start).norm(), (end - corner).norm()];
    assert!((legs_m[0] - legs_m[1]).abs() < 0.3 && legs_m[0] < 6.0, "{legs_m:?}");
}

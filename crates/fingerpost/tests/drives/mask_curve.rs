//! The papers' curve, by which features are found, by known places: turning circle, set-back, roundness.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, route};
use fingerpost::feature_masks::{FeatureMaskConfig, MaskCurve};
use fingerpost::feature_model::FeatureModel;
use fingerpost::vehicle::{Traffic, VehicleConfig};
use fingerpost_map::{FeatureKind, TangentPlane};
use nalgebra::Point2;

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];

fn curve(exit: &[Place], traffic: Traffic, turning_radius_m: f64) -> MaskCurve {
    let junction = Junction { kind: FeatureKind::Junction, approach: SOUTH, exit, sides: &[], width_m: 6.0 };
    let (route, _) = route(&junction);
    let model = FeatureModel::new(&route.features[0], &TangentPlane::new(route.line[0].at)).unwrap();
    let vehicle = VehicleConfig { traffic, turning_radius_m, ..VehicleConfig::default() };
    MaskCurve::new(&FeatureMaskConfig::default(), &vehicle, &model).unwrap().unwrap()
}

#[test]
fn the_set_back_gives_the_turning_circle() {
    // d = R sin(45 deg) / cos^2(45 deg) = 1.414 R for a right angle.
    for radius_m in [4.0, 5.0, 7.0] {
        let curve = curve(EAST, Traffic::Centre, radius_m);
        let setback_m = -curve.start().x;
        assert!((setback_m - 2_f64.sqrt() * radius_m).abs() < 0.26, "{setback_m} for {radius_m}");
        assert!(curve.tightest_radius_m >= radius_m);
        assert!(curve.start().y.abs() < 1e-3 && (curve.end() - Point2::new(0.0, -setback_m)).norm() < 1e-3);
    }
}

#[test]
fn a_wide_vehicle_gets_a_rounder_curve_and_not_a_longer_one() {
    for radius_m in [9.0, 11.0] {
        let curve = curve(EAST, Traffic::Centre, radius_m);
        assert!(curve.tightest_radius_m >= radius_m, "{} for {radius_m}", curve.tightest_radius_m);
        assert!(-curve.start().x <= 12.0, "{}", curve.start());
    }
    let curve = curve(EAST, Traffic::Centre, 25.0);
    assert!(curve.tightest_radius_m < 25.0 && curve.tightest_radius_m > 11.9);
}

#[test]
fn the_curve_lies_on_the_vehicles_side_of_the_road() {
    for (traffic, left_m) in [(Traffic::Left, 1.5), (Traffic::Right, -1.5), (Traffic::Centre, 0.0)] {
        let curve = curve(EAST, traffic, 5.0);
        assert!((curve.start().y - left_m).abs() < 1e-3, "{traffic:?}: {}", curve.start());
        assert!((curve.end().x - left_m).abs() < 1e-3, "{traffic:?}: {}", curve.end());
    }
}

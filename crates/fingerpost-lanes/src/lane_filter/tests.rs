//! The lane carried on by a known motion.

use fingerpost_geometry::{Distortion, Intrinsics, Mount};

use super::*;

/// A vehicle that follows a bend to the left keeps its lane beside it: 300 m, 30 m/s, ten pictures a second.
#[test]
fn a_known_motion_along_a_bend_leaves_the_lane_beside_the_vehicle() {
    let (radius_m, forward_m) = (300.0, 3.0);
    let mut filter = LaneFilter::new();
    filter.place_edge(Side::Left, 1.8, 0.05);
    filter.place_edge(Side::Right, -1.8, 0.05);
    filter.state[CURVATURE] = 1.0 / radius_m;
    for _ in 0..15 {
        let yaw_rad = Some(forward_m / radius_m);
        filter.predict(&LaneMotion {
            dt_s: Some(0.1),
            forward_m: Some(forward_m),
            yaw_rad,
            ..LaneMotion::default()
        });
    }
    assert!((filter.offset_m(Side::Left) - 1.8).abs() < 1e-9, "{}", filter.offset_m(Side::Left));
    assert!((filter.offset_m(Side::Right) + 1.8).abs() < 1e-9);
    assert!(filter.heading_rad().abs() < 1e-9);
}

/// On a straight road a turn to the left brings the right edge's course to the vehicle's right, the further the more.
#[test]
fn a_turn_on_a_straight_road_moves_the_edges_as_an_arc_does() {
    let mut filter = LaneFilter::new();
    filter.place_edge(Side::Right, -1.8, 0.05);
    filter.predict(&LaneMotion {
        dt_s: Some(0.1),
        forward_m: Some(2.0),
        yaw_rad: Some(0.1),
        ..LaneMotion::default()
    });
    // The vehicle has come 0.1 m to the left and looks 0.1 rad to the left.
    assert!((filter.offset_m(Side::Right) + 1.9).abs() < 1e-9);
    assert!((filter.heading_rad() + 0.1).abs() < 1e-9);
}

/// A country road's curvature is doubted sooner than a motorway's, a known bend's not while the vehicle stands.
#[test]
fn bends_of_slow_roads_end_sooner() {
    let doubt_per_m = |speed_mps: f64| {
        let mut filter = LaneFilter::new();
        filter.covariance[(CURVATURE, CURVATURE)] = 1e-10;
        for _ in 0..10 {
            filter.predict(&LaneMotion {
                dt_s: Some(0.1),
                forward_m: Some(0.1 * speed_mps),
                yaw_rad: Some(0.0),
                ..LaneMotion::default()
            });
        }
        filter.covariance[(CURVATURE, CURVATURE)].sqrt()
    };
    assert!((doubt_per_m(30.0) - 8e-4).abs() < 2e-5, "{}", doubt_per_m(30.0));
    assert!((doubt_per_m(20.0) - 1.8e-3).abs() < 2e-5, "{}", doubt_per_m(20.0));
    assert!(doubt_per_m(0.0) < 2e-5, "{}", doubt_per_m(0.0));
}

/// A change of the pitch that the picture shows well is the pitch's own, but for what the road's slope may change.
#[test]
fn a_pitch_that_is_seen_to_change_changes() {
    let mut filter = LaneFilter::new();
    let seen = ObservedAngle { angle_rad: 0.004, variance_rad2: 1e-8 };
    filter.predict(&LaneMotion { dt_s: Some(0.1), pitch_change: Some(seen), ..LaneMotion::default() });
    assert!((0.0026..0.004).contains(&filter.pitch_rad()), "{}", filter.pitch_rad());
    let mut blurred = LaneFilter::new();
    let unsure = ObservedAngle { variance_rad2: 1e-2, ..seen };
    blurred.predict(&LaneMotion { dt_s: Some(0.1), pitch_change: Some(unsure), ..LaneMotion::default() });
    assert!(blurred.pitch_rad().abs() < 1e-5, "{}", blurred.pitch_rad());
}

/// The camera looks 0.02 rad to the right of the way, so that a lane which the vehicle keeps seems to lead to the left.
#[test]
fn a_camera_that_looks_aside_is_learned_and_carries_no_lane_aside() {
    let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { pitch_rad: 0.05, x_m: 1.5, ..Mount::level(1.3) };
    let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
    let motion =
        LaneMotion { dt_s: Some(0.05), forward_m: Some(1.5), yaw_rad: Some(0.0), ..LaneMotion::default() };
    let mut filter = LaneFilter::new();
    for _ in 0..40 {
        filter.predict(&motion);
        let mut points = Vec::new();
        for side in Side::BOTH {
            for ahead_m in [7.0, 9.0, 12.0, 16.0, 22.0] {
                let place = Point2::new(ahead_m, 0.02 * ahead_m - 1.8 * side.outward());
                let pixel = camera.pixel_of_ground(place).unwrap();
                points.push(EdgePoint { side, pixel, sigma_px: 0.6, column_sigma_px: 0.6, weight: 0.0 });
            }
        }
        filter.update(&camera, &mut points);
    }
    let seen_m = filter.offset_m(Side::Left);
    for _ in 0..10 {
        filter.predict(&motion);
    }
    assert!((filter.offset_m(Side::Left) - seen_m).abs() < 0.02, "{} m", filter.offset_m(Side::Left));
}

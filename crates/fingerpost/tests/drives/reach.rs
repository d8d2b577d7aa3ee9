//! How far ahead a feature is tracked: as far as the ground view is asked to reach, and no farther than its distance is known.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use crate::painted::{World, camera, route_past};
use fingerpost::vehicle::Traffic;
use fingerpost::{Pipeline, Sensors};
use nalgebra::{Isometry2, Vector2};

const WIDTH_M: f64 = 6.0;
/// Where the side road leaves a road that goes north, metres.
const SIDE_M: f64 = 60.0;

/// How far ahead a side road is tracked first, by how much its place is off then, and what standard deviation is said, metres.
fn tracked_from(far_m: f64) -> Option<[f64; 3]> {
    let mut config = crate::painted::config();
    config.ground_view.far_m = far_m;
    config.track.kerb_radius_m = 0.0;
    config.vehicle.traffic = Traffic::Centre;
    let camera = camera();
    let route = route_past(&[(SIDE_M, (-40.0, 0.0))], [0.0, 120.0], WIDTH_M);
    let world =
        World::new(&[(&[(0.0, -20.0), (0.0, 140.0)], WIDTH_M), (&[(0.0, SIDE_M), (-40.0, SIDE_M)], WIDTH_M)]);
    let mut pipeline = Pipeline::new(&config, &camera, Some(&route), Some(15.0)).unwrap();
    (0..60).find_map(|i| {
        let at_m = 15.0 + 0.7 * f64::from(i);
        let map_from_vehicle = Isometry2::new(Vector2::new(0.0, at_m), std::f64::consts::FRAC_PI_2);
        let frame = world.picture(&camera, &map_from_vehicle);
        let (output, _) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
        let followed = output.track.followed.as_ref()?;
        let off = followed.vehicle_from_feature.translation.vector - Vector2::new(SIDE_M - at_m, 0.0);
        Some([SIDE_M - at_m, off.norm(), followed.covariance[(0, 0)].sqrt()])
    })
}

#[test]
fn a_view_that_reaches_farther_tracks_from_farther() {
    let [usual_m, ..] = tracked_from(20.0).unwrap();
    let [far_m, off_m, sigma_m] = tracked_from(40.0).unwrap();
    assert!(usual_m > 10.0, "{usual_m}");
    assert!(far_m > 20.0, "{far_m}");
    assert!(off_m < 3.0 * sigma_m, "{off_m} m off, {sigma_m} m said");
}

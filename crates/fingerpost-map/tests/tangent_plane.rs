//! The tangent plane against pyproj (PROJ's `cart` and `topocentric` on WGS 84) and against its own inverse.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use fingerpost_map::{LatLon, TangentPlane};
use nalgebra::Point2;
use proptest::prelude::*;

type Degrees = (f64, f64);

/// Origin, place, metres east and north of it by PROJ.
const BY_PROJ: [(Degrees, Degrees, (f64, f64)); 8] = [
    ((48.983266, 8.390918), (48.984266, 8.390918), (0.0, 111.209423)),
    ((48.983266, 8.390918), (48.983266, 8.391918), (73.196303, 0.000482)),
    ((48.983266, 8.390918), (48.993266, 8.370918), (-1463.633116, 1112.287844)),
    ((48.983266, 8.390918), (48.683266, 8.790918), (29453.616176, -33284.225173)),
    ((-33.9, 18.4), (-33.899, 18.4), (0.0, 110.920572)),
    ((-33.9, 18.4), (-34.2, 18.8), (36866.783583, -33348.611215)),
    ((71.2, -179.9), (71.21, -179.92), (-719.282227, 1115.887584)),
    ((71.2, -179.9), (70.9, -179.5), (14613.917162, -33424.058079)),
];

fn place((lat_deg, lon_deg): Degrees) -> LatLon {
    LatLon::new(lat_deg, lon_deg).unwrap()
}

#[test]
fn agrees_with_proj() {
    for (origin, there, (east_m, north_m)) in BY_PROJ {
        let p_in_map = TangentPlane::new(place(origin)).map_from_wgs84(place(there));
        let error_m = (p_in_map - Point2::new(east_m, north_m)).norm();
        assert!(error_m < 2e-6, "{origin:?} to {there:?}: {p_in_map}, {error_m} m off");
    }
}

#[test]
fn goes_over_the_date_line() {
    let plane = TangentPlane::new(place((0.0, 179.9995)));
    let east = plane.wgs84_from_map(Point2::new(111.319, 0.0));
    assert!(east.lon_deg < -179.999 && east.lon_deg > -180.0, "{east:?}");
    assert!((plane.map_from_wgs84(east) - Point2::new(111.319, 0.0)).norm() < 1e-6);
}

#[test]
fn refuses_what_is_no_place() {
    for (lat_deg, lon_deg) in [(90.1, 0.0), (0.0, 180.5), (f64::NAN, 0.0), (0.0, f64::INFINITY)] {
        assert!(LatLon::new(lat_deg, lon_deg).is_err(), "{lat_deg}, {lon_deg}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: prop::test_runner::RngSeed::Fixed(11), ..ProptestConfig::default() })]

    #[test]
    fn the_inverse_leads_back(
        lat_deg in -80.0..80.0f64,
        lon_deg in -180.0..180.0f64,
        x in -1e5..1e5f64,
        y in -1e5..1e5f64,
    ) {
        let plane = TangentPlane::new(place((lat_deg, lon_deg)));
        let p_in_map = Point2::new(x, y);
        let there = plane.wgs84_from_map(p_in_map);
        prop_assert!(LatLon::new(there.lat_deg, there.lon_deg).is_ok());
        prop_assert!((plane.map_from_wgs84(there) - p_in_map).norm() < 1e-5);
    }
}

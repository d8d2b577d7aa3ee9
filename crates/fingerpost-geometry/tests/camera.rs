//! The camera by known places: height sign, pitch sign, left and right, with and without a lens.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, Pixel};
use nalgebra::{Point2, Point3};
use proptest::prelude::*;

const INTRINSICS: Intrinsics = Intrinsics { fx: 600.0, fy: 590.0, cx: 322.0, cy: 238.0 };

fn camera(distortion: Distortion, mount: Mount) -> Camera {
    Camera::calibrated(640, 480, INTRINSICS, distortion, mount).unwrap()
}

fn lens() -> Distortion {
    Distortion::brown_conrady(&[-0.264, 0.075, -0.0003, 0.0004, -0.146]).unwrap()
}

#[test]
fn the_road_is_below_the_horizon_and_comes_closer_downwards() {
    let camera = camera(Distortion::None, Mount::level(1.5));
    let far = camera.pixel_of_ground(Point2::new(40.0, 0.0)).unwrap();
    let near = camera.pixel_of_ground(Point2::new(8.0, 0.0)).unwrap();
    assert!((far.v - (238.0 + 590.0 * 1.5 / 40.0)).abs() < 1e-9);
    assert!((near.v - (238.0 + 590.0 * 1.5 / 8.0)).abs() < 1e-9);
    assert!(camera.ground_of_pixel(Pixel::new(320.0, 200.0)).is_none(), "the sky is not on the road");
    assert!(
        camera.pixel_of_ground(Point2::new(-5.0, 0.0)).is_none(),
        "nor is the road behind in the picture"
    );
}

#[test]
fn nose_down_moves_the_road_up_the_picture() {
    let level = camera(Distortion::None, Mount::level(1.5));
    let down = camera(Distortion::None, Mount { pitch_rad: 0.05, ..Mount::level(1.5) });
    let place = Point2::new(10.0, 0.0);
    let change = level.pixel_of_ground(place).unwrap().v - down.pixel_of_ground(place).unwrap().v;
    assert!(
        (change - 590.0 * (libm::tan(libm::atan(0.15)) - libm::tan(libm::atan(0.15) - 0.05))).abs() < 1e-6
    );
}

#[test]
fn left_is_left_with_and_without_a_lens() {
    for distortion in [Distortion::None, lens()] {
        let camera = camera(distortion, Mount { pitch_rad: 0.03, x_m: 1.2, y_m: 0.2, ..Mount::level(1.6) });
        let left = camera.pixel_of_ground(Point2::new(10.0, 2.0)).unwrap();
        let right = camera.pixel_of_ground(Point2::new(10.0, -2.0)).unwrap();
        assert!(left.u < 322.0 && right.u > 322.0);
    }
}

/// Place (vehicle frame, metres) and pixel, by OpenCV 5.0.
const OPENCV_PROJECTIONS: [([f64; 3], [f64; 2]); 4] = [
    ([10.0, 2.0, 0.0], [190.93279909, 321.24927240]),
    ([15.0, -3.0, 0.0], [446.89146325, 280.48275736]),
    ([6.5, 0.4, 0.0], [289.89417322, 388.31352674]),
    ([12.0, 1.0, 2.5], [264.86724604, 165.91384754]),
];

/// Reference values: OpenCV 5.0 `projectPoints`, rotation from the same mount, the same lens.
#[test]
fn agrees_with_opencv_projection() {
    let mount = Mount { pitch_rad: 0.04, yaw_rad: -0.02, roll_rad: 0.01, x_m: 1.2, y_m: 0.2, height_m: 1.6 };
    let camera = camera(lens(), mount);
    for (place, expected) in OPENCV_PROJECTIONS {
        let pixel = camera.project(Point3::new(place[0], place[1], place[2])).unwrap();
        assert!(pixel.distance(Pixel::new(expected[0], expected[1])) < 1e-6, "{place:?}: {pixel:?}");
    }
}

#[test]
fn four_points_give_the_same_road_as_the_calibration_they_came_from() {
    let calibrated = camera(Distortion::None, Mount { pitch_rad: 0.05, y_m: 0.3, ..Mount::level(1.4) });
    let places = [(6.0, 2.0), (6.0, -2.0), (18.0, -3.0), (18.0, 3.0)].map(|(x, y)| Point2::new(x, y));
    let pixels = places.map(|place| calibrated.pixel_of_ground(place).unwrap());
    let by_points = Camera::from_points(640, 480, pixels, places).unwrap();
    let place = Point2::new(10.0, 2.0);
    let (a, b) = (calibrated.pixel_of_ground(place).unwrap(), by_points.pixel_of_ground(place).unwrap());
    assert!(a.distance(b) < 1e-6);
    assert!((by_points.ground_of_pixel(b).unwrap() - place).norm() < 1e-9);
    assert!(by_points.ground_of_pixel(Pixel::new(320.0, 100.0)).is_none(), "above the horizon");
    let mirrored = [pixels[1], pixels[0], pixels[3], pixels[2]];
    assert!(Camera::from_points(640, 480, mirrored, places).is_err());
    let in_line = [pixels[0], pixels[0], pixels[2], pixels[3]];
    assert!(Camera::from_points(640, 480, in_line, places).is_err());
}

/// The vehicle's origin then lies in the plane of the lens, where a homography scaled by its last entry breaks down.
#[test]
fn four_points_work_for_a_level_camera_above_the_origin() {
    let calibrated = camera(Distortion::None, Mount::level(1.5));
    let places = [(5.0, 1.5), (5.0, -1.5), (10.0, -2.0), (10.0, 2.0)].map(|(x, y)| Point2::new(x, y));
    let pixels = places.map(|place| calibrated.pixel_of_ground(place).unwrap());
    let by_points = Camera::from_points(640, 480, pixels, places).unwrap();
    let place = Point2::new(14.0, 3.0);
    let (a, b) = (calibrated.pixel_of_ground(place).unwrap(), by_points.pixel_of_ground(place).unwrap());
    assert!(a.distance(b) < 1e-6);
}

#[test]
fn a_picture_at_another_size_shows_the_same_places() {
    let mount = Mount { pitch_rad: 0.04, yaw_rad: 0.02, ..Mount::level(1.5) };
    let calibrated = camera(lens(), mount);
    let places = [(5.0, 1.5), (5.0, -1.5), (10.0, -2.0), (10.0, 2.0)].map(|(x, y)| Point2::new(x, y));
    let level = camera(Distortion::None, Mount::level(1.5));
    let pixels = places.map(|place| level.pixel_of_ground(place).unwrap());
    let by_points = Camera::from_points(640, 480, pixels, places).unwrap();
    for full in [calibrated, by_points] {
        for (width, height) in [(320, 240), (150, 113), (512, 384)] {
            let small = full.scaled_to(width, height).unwrap();
            assert_eq!((small.width(), small.height()), (width, height));
            let (along_u, along_v) = (width as f64 / 640.0, height as f64 / 480.0);
            for place in [(6.0, -1.0), (12.0, 2.0), (20.0, 0.0)].map(|(x, y)| Point2::new(x, y)) {
                let (seen, kept) =
                    (small.pixel_of_ground(place).unwrap(), full.pixel_of_ground(place).unwrap());
                // Edges coincide, not the centres of the corner pixels.
                assert!((seen.u + 0.5 - (kept.u + 0.5) * along_u).abs() < 1e-9, "{width} {place:?}");
                assert!((seen.v + 0.5 - (kept.v + 0.5) * along_v).abs() < 1e-9, "{width} {place:?}");
                assert!((small.ground_of_pixel(seen).unwrap() - place).norm() < 1e-3, "{width} {place:?}");
            }
        }
        assert!(full.scaled_to(15, 240).is_err());
    }
}

#[test]
fn absurd_calibrations_are_refused_by_name() {
    let refused = |width, height, intrinsics: Intrinsics| {
        Camera::calibrated(width, height, intrinsics, Distortion::None, Mount::level(1.5))
            .unwrap_err()
            .to_string()
    };
    assert!(refused(640, 480, Intrinsics { fx: f64::NAN, ..INTRINSICS }).starts_with("intrinsics.fx"));
    assert!(refused(640, 480, Intrinsics { fy: -600.0, ..INTRINSICS }).starts_with("intrinsics.fy"));
    assert!(refused(640, 480, Intrinsics { cx: 5000.0, ..INTRINSICS }).starts_with("intrinsics.cx"));
    assert!(refused(0, 480, INTRINSICS).starts_with("image.width"));
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(20), ..ProptestConfig::default() })]
    #[test]
    fn every_seen_place_comes_back(
        x in 3.0..40.0_f64, y in -8.0..8.0_f64,
        pitch in -0.05..0.2_f64, yaw in -0.1..0.1_f64, roll in -0.05..0.05_f64,
    ) {
        let mount = Mount { pitch_rad: pitch, yaw_rad: yaw, roll_rad: roll, ..Mount::level(1.5) };
        for distortion in [Distortion::None, lens()] {
            let camera = camera(distortion, mount);
            let Some(pixel) = camera.pixel_of_ground(Point2::new(x, y)) else { continue };
            let back = camera.ground_of_pixel(pixel).unwrap();
            prop_assert!((back - Point2::new(x, y)).norm() < 1e-4 * x * x);
        }
    }
}

//! `camera.toml`: what is read, what is written, what is refused.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use fingerpost_format::{CameraFileError, camera_from_toml, camera_to_toml, mount_from_toml};
use fingerpost_geometry::{Camera, Distortion, GeometryError, Intrinsics, Mount, Pixel, View};
use nalgebra::Point2;

const CALIBRATED: &str = "
[image]
width = 1280
height = 720
[intrinsics]
fx = 1157.1
fy = 1151.3
cx = 670.4
cy = 387.9
[distortion]
model = \"brown-conrady\"
coefficients = [-0.264, 0.075, -0.0003, 0.0004, -0.146]
[mount]
height_m = 1.4
pitch_deg = 2.5
yaw_deg = -1.0
roll_deg = 0.5
x_m = 1.8
y_m = 0.1
";

const POINTS: &str = "
[image]
width = 640
height = 480
[points]
image_px = [[219.5, 314.5], [419.5, 314.5], [469.5, 389.5], [169.5, 389.5]]
road_m = [[11.5, 2.0], [11.5, -2.0], [6.5, -1.5], [6.5, 1.5]]
";

fn refusal(text: &str) -> String {
    camera_from_toml(text).unwrap_err().to_string()
}

#[test]
fn every_number_arrives_in_its_place_and_unit() {
    let camera = camera_from_toml(CALIBRATED).unwrap();
    assert_eq!((camera.width(), camera.height()), (1280, 720));
    let View::Calibrated { intrinsics, distortion, mount, .. } = camera.view() else {
        panic!("a calibrated camera was expected");
    };
    assert_eq!(*intrinsics, Intrinsics { fx: 1157.1, fy: 1151.3, cx: 670.4, cy: 387.9 });
    assert_eq!(*distortion, Distortion::brown_conrady(&[-0.264, 0.075, -0.0003, 0.0004, -0.146]).unwrap());
    let expected = Mount {
        height_m: 1.4,
        pitch_rad: 2.5_f64.to_radians(),
        yaw_rad: (-1.0_f64).to_radians(),
        roll_rad: 0.5_f64.to_radians(),
        x_m: 1.8,
        y_m: 0.1,
    };
    assert_eq!(*mount, expected);
}

#[test]
fn what_is_written_reads_back_as_the_same_camera() {
    let lenses = [
        Distortion::None,
        Distortion::brown_conrady(&[-0.2, 0.05, 0.001, -0.002, 0.01, 0.1, 0.02, 0.003]).unwrap(),
        Distortion::kannala_brandt(&[0.01, -0.002, 0.0003, -0.00004]).unwrap(),
    ];
    for lens in lenses {
        let intrinsics = Intrinsics { fx: 400.25, fy: 401.0, cx: 319.5, cy: 239.75 };
        let mount = Mount { pitch_rad: 0.0625, yaw_rad: -0.03125, ..Mount::level(1.65) };
        let camera = Camera::calibrated(640, 480, intrinsics, lens, mount).unwrap();
        let again = camera_from_toml(&camera_to_toml(&camera).unwrap()).unwrap();
        assert_eq!((again.width(), again.height()), (640, 480));
        for ground in [Point2::new(5.0, -1.0), Point2::new(12.0, 3.0), Point2::new(20.0, 0.0)] {
            let (p, q) = (camera.pixel_of_ground(ground).unwrap(), again.pixel_of_ground(ground).unwrap());
            assert!((p.u - q.u).abs() < 1e-9 && (p.v - q.v).abs() < 1e-9, "{lens:?}: {p:?} {q:?}");
        }
    }
}

#[test]
fn four_points_put_known_places_at_their_pixels() {
    let camera = camera_from_toml(POINTS).unwrap();
    let pixel = camera.pixel_of_ground(Point2::new(11.5, 2.0)).unwrap();
    assert!((pixel.u - 219.5).abs() < 1e-6 && (pixel.v - 314.5).abs() < 1e-6, "{pixel:?}");
    let place = camera.ground_of_pixel(Pixel::new(469.5, 389.5)).unwrap();
    assert!((place.x - 6.5).abs() < 1e-6 && (place.y + 1.5).abs() < 1e-6, "{place:?}");
    assert!(matches!(camera_to_toml(&camera), Err(CameraFileError::Incomplete { .. })));
}

#[test]
fn a_key_that_nobody_knows_is_refused_by_its_name() {
    assert!(refusal(&CALIBRATED.replace("pitch_deg", "pitch")).contains("`pitch`"));
    assert!(refusal(&format!("{CALIBRATED}\n[lens]\nfx = 1\n")).contains("`lens`"));
    assert!(refusal(&CALIBRATED.replace("width = 1280\n", "")).contains("`width`"));
    assert!(refusal(&CALIBRATED.replace("1280", "\"wide\"")).contains("wide"));
    assert!(matches!(camera_from_toml("no calibration"), Err(CameraFileError::Parse { .. })));
}

#[test]
fn a_missing_table_is_named() {
    let (without_mount, _) = CALIBRATED.split_once("[mount]").unwrap();
    assert!(refusal(without_mount).contains("no [mount]"));
    let image = "[image]\nwidth = 640\nheight = 480\n";
    assert!(refusal(&format!("{image}[mount]\nheight_m = 1.5\n")).contains("no [intrinsics]"));
    assert!(refusal(image).contains("neither [intrinsics] nor [points]"));
    assert!(refusal(&format!("{POINTS}[mount]\nheight_m = 1.5\n")).contains("[points] beside"));
}

#[test]
fn numbers_that_cannot_be_right_are_named() {
    for (from, to, name) in [
        ("fx = 1157.1", "fx = nan", "intrinsics.fx"),
        ("fy = 1151.3", "fy = -1151.3", "intrinsics.fy"),
        ("cx = 670.4", "cx = 6704.0", "intrinsics.cx"),
        ("height_m = 1.4", "height_m = -1.4", "mount.height_m"),
        ("height_m = 1.4", "height_m = 140.0", "mount.height_m"),
        ("pitch_deg = 2.5", "pitch_deg = inf", "mount.pitch_deg"),
        ("yaw_deg = -1.0", "yaw_deg = 180.0", "mount.yaw_deg"),
        ("width = 1280", "width = 1", "image.width"),
    ] {
        let message = refusal(&CALIBRATED.replace(from, to));
        assert!(message.contains(name) && message.contains("correct it"), "{to}: {message}");
    }
    let nan = CALIBRATED.replace("-0.264", "nan");
    assert!(matches!(
        camera_from_toml(&nan),
        Err(CameraFileError::Geometry(GeometryError::OutOfRange { .. }))
    ));
}

#[test]
fn distortion_must_be_known_and_whole() {
    let message = refusal(&CALIBRATED.replace("brown-conrady", "brown"));
    assert!(message.contains("\"brown\"") && message.contains("kannala-brandt"), "{message}");
    let short = CALIBRATED.replace("[-0.264, 0.075, -0.0003, 0.0004, -0.146]", "[-0.264, 0.075, -0.0003]");
    assert!(refusal(&short).contains("4, 5 or 8 coefficients, 3 were given"));
    let fisheye = CALIBRATED.replace("brown-conrady", "kannala-brandt");
    assert!(refusal(&fisheye).contains("4 coefficients, 5 were given"));
}

#[test]
fn a_mount_alone_is_read_and_checked() {
    let mount = mount_from_toml("[mount]\nheight_m = 1.65\nyaw_deg = 3\n").unwrap();
    assert_eq!(mount, Mount { yaw_rad: 3.0_f64.to_radians(), ..Mount::level(1.65) });
    for text in ["height_m = 1.65", "[mount]\nheight_m = 0.0", "[mount]\nheight = 1.65", "[mount]"] {
        assert!(mount_from_toml(text).is_err(), "{text}");
    }
}

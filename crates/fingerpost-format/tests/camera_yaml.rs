//! ROS and OpenCV calibrations as their tools write them.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use fingerpost_format::{CameraFileError, camera_from_yaml};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, View};

const ROS: &str = "image_width: 1241
image_height: 376
camera_name: left
camera_matrix:
  rows: 3
  cols: 3
  data: [718.856, 0, 607.1928, 0, 718.856, 185.2157, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.26, 0.08, -0.0003, 0.0004, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [718.856, 0, 607.1928, 0, 0, 718.856, 185.2157, 0, 0, 0, 1, 0]
";

const OPENCV: &str = "%YAML:1.0
---
calibration_time: \"Tue 04 Mar 2025 10:11:12 AM CET\"
nframes: 17
image_width: 1280
image_height: 720
board_width: 9
square_size: 2.5000000372529030e-02
flags: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1.1571e+03, 0., 6.704e+02, 0., 1.1513e+03, 3.879e+02, 0.,
       0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.64e-01, 7.5e-02, -3.0e-04, 4.0e-04,
       -1.46e-01 ]
avg_reprojection_error: 1.1000000000000001e+00
";

fn expected(size: (usize, usize), [fx, fy, cx, cy]: [f64; 4], lens: Distortion, mount: Mount) -> Camera {
    Camera::calibrated(size.0, size.1, Intrinsics { fx, fy, cx, cy }, lens, mount).unwrap()
}

fn refusal(text: &str) -> String {
    camera_from_yaml(text, Some(Mount::level(1.5))).unwrap_err().to_string()
}

fn lens_of(text: &str) -> Distortion {
    match camera_from_yaml(text, Some(Mount::level(1.5))).unwrap().view() {
        View::Calibrated { distortion, .. } => *distortion,
        View::RoadPlane(_) => panic!("a calibrated camera was expected"),
    }
}

#[test]
fn ros_camera_info_is_read() {
    let lens = Distortion::brown_conrady(&[-0.26, 0.08, -0.0003, 0.0004, 0.0]).unwrap();
    let mount = Mount::level(1.65);
    let camera = camera_from_yaml(ROS, Some(mount)).unwrap();
    assert_eq!(camera, expected((1241, 376), [718.856, 718.856, 607.1928, 185.2157], lens, mount));
}

#[test]
fn opencv_file_storage_is_read() {
    let lens = Distortion::brown_conrady(&[-0.264, 0.075, -0.0003, 0.0004, -0.146]).unwrap();
    let mount = Mount { pitch_rad: 0.02, ..Mount::level(1.4) };
    let camera = camera_from_yaml(OPENCV, Some(mount)).unwrap();
    assert_eq!(camera, expected((1280, 720), [1157.1, 1151.3, 670.4, 387.9], lens, mount));
}

#[test]
fn other_spellings_of_opencv_samples_are_read() {
    let plain = camera_from_yaml(OPENCV, Some(Mount::level(1.4))).unwrap();
    let spellings = [
        [
            ("image_width", "image_Width"),
            ("image_height", "image_Height"),
            ("camera_matrix", "Camera_Matrix"),
            ("distortion_c", "Distortion_C"),
        ],
        [
            ("image_width: 1280", "imageSize: [ 1280, 720 ]"),
            ("image_height: 720\n", ""),
            ("camera_matrix", "cameraMatrix"),
            ("distortion_coefficients", "distCoeffs"),
        ],
        [
            ("camera_matrix", "K"),
            ("distortion_coefficients", "D"),
            ("%YAML:1.0\n---\n", ""),
            ("flags", "flags_"),
        ],
    ];
    for spelling in spellings {
        let text = spelling.iter().fold(OPENCV.to_owned(), |text, (from, to)| text.replace(from, to));
        assert_eq!(camera_from_yaml(&text, Some(Mount::level(1.4))).unwrap(), plain, "{text}");
    }
}

#[test]
fn distortion_models_are_told_apart() {
    let four = "[0.01, -0.002, 0.0003, -0.00004]";
    let fisheye = Distortion::kannala_brandt(&[0.01, -0.002, 0.0003, -0.00004]).unwrap();
    let ros_four = ROS.replace("[-0.26, 0.08, -0.0003, 0.0004, 0]", four);
    assert_eq!(lens_of(&ros_four.replace("plumb_bob", "equidistant")), fisheye);
    assert_eq!(lens_of(&ros_four), Distortion::brown_conrady(&[0.01, -0.002, 0.0003, -0.00004]).unwrap());
    let rational =
        ROS.replace("plumb_bob", "rational_polynomial").replace("0.0004, 0]", "0.0004, 0, 0.1, 0.02, 0.003]");
    assert_eq!(
        lens_of(&rational),
        Distortion::brown_conrady(&[-0.26, 0.08, -0.0003, 0.0004, 0.0, 0.1, 0.02, 0.003]).unwrap()
    );
    let opencv_fisheye =
        "imageSize: [640, 480]\nfisheye_model: 1\nK: [[300, 0, 320], [0, 300, 240], [0, 0, 1]]\n";
    assert_eq!(lens_of(&format!("{opencv_fisheye}D: {four}\n")), fisheye);
    assert_eq!(lens_of(&opencv_fisheye.replace(": 1", ": 0")), Distortion::None);
}

#[test]
fn coefficients_that_are_not_used_must_be_zero() {
    let fourteen = |last: &str| {
        ROS.replace("plumb_bob", "rational_polynomial")
            .replace("0.0004, 0]", &format!("0.0004, 0, 0.1, 0.02, 0.003, 0, 0, 0, 0, 0, {last}]"))
    };
    assert!(matches!(lens_of(&fourteen("0.0")), Distortion::BrownConrady { .. }));
    assert!(refusal(&fourteen("0.001")).contains("14 were given"));
}

#[test]
fn the_mount_is_given_or_stands_in_the_text() {
    assert!(matches!(camera_from_yaml(ROS, None), Err(CameraFileError::NoMount)));
    let with_mount = format!("{ROS}mount:\n  height_m: 1.65\n  pitch_deg: 2\n");
    let own = Mount { pitch_rad: 2.0_f64.to_radians(), ..Mount::level(1.65) };
    let given = Mount::level(0.9);
    let mount_of = |mount| match camera_from_yaml(&with_mount, mount).unwrap().view() {
        View::Calibrated { mount, .. } => *mount,
        View::RoadPlane(_) => panic!("a calibrated camera was expected"),
    };
    assert_eq!(mount_of(None), own);
    assert_eq!(mount_of(Some(given)), given);
    let misspelt = with_mount.replace("pitch_deg", "pitch_rad");
    assert!(camera_from_yaml(&misspelt, None).unwrap_err().to_string().contains("`pitch_rad`"));
    let without_height = with_mount.replace("  height_m: 1.65\n", "");
    assert!(camera_from_yaml(&without_height, None).unwrap_err().to_string().contains("`height_m`"));
    let wordy = with_mount.replace("1.65", "high");
    assert!(camera_from_yaml(&wordy, None).unwrap_err().to_string().contains("`height_m`"));
}

#[test]
fn what_cannot_be_used_is_named() {
    for (from, to, named) in [
        ("distortion_model: plumb_bob", "distortion_model: thin_prism", "\"thin_prism\""),
        ("camera_matrix", "camera", "camera_matrix, Camera_Matrix"),
        ("image_width: 1241\n", "", "image_width"),
        ("image_width: 1241", "image_width: -1241", "image.width"),
        ("image_width: 1241", "image_width: .nan", "image.width"),
        ("[718.856, 0, 607.1928, 0, 718.856, 185.2157, 0, 0, 1]", "[718.856, 0, 607.1928]", "9 numbers, 3"),
        ("[718.856, 0, 607.1928, 0, 718.856, 185", "[.nan, 0, 607.1928, 0, 718.856, 185", "intrinsics.fx"),
        ("[718.856, 0, 607.1928, 0, 718.856, 185", "[one, 0, 607.1928, 0, 718.856, 185", "`camera_matrix`"),
        ("data: [-0.26, 0.08, ", "data: [0.08, .inf, ", "inf"),
        ("data: [-0.26, 0.08, -0.0003, ", "data: [", "2 were given"),
        ("  data: [-0.26, 0.08, -0.0003, 0.0004, 0]\n", "", "`data`"),
    ] {
        let text = ROS.replacen(from, to, 1);
        assert_ne!(text, ROS, "{from}");
        let message = refusal(&text);
        assert!(message.contains(named), "{to}: {message}");
    }
    for text in ["", "- a list", "{", "a: b: c", "word"] {
        assert!(matches!(
            camera_from_yaml(text, Some(Mount::level(1.5))),
            Err(CameraFileError::Parse { .. })
        ));
    }
}

#[test]
fn texts_that_are_more_than_they_seem_are_refused() {
    let refused = |text: &str| camera_from_yaml(text, None).unwrap_err().to_string();
    for levels in 2..40 {
        // Each level stands for nine of the one before.
        let mut text = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n".to_owned();
        for level in 1..levels {
            let parts = vec![format!("*a{}", level - 1); 9].join(", ");
            text += &format!("a{level}: &a{level} [{parts}]\n");
        }
        assert!(refused(&text).contains("alias"), "{levels} levels");
    }
    for depth in [17, 100, 10_000, 500_000] {
        for text in [
            format!("K: {}{}", "[".repeat(depth), "]".repeat(depth)),
            format!("K: {}1{}", "{a: ".repeat(depth), "}".repeat(depth)),
            format!("K: {}", "[".repeat(depth)),
            "- ".repeat(depth),
        ] {
            let error = refused(&text);
            assert!(!error.is_empty() && error.len() < 300, "{depth}: {error}");
        }
    }
    assert!(refused(&"# comment\n".repeat(200_000)).contains("bytes"));
}

//! ROS and OpenCV calibrations as their tools write them.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use fingerpost_format::{CameraFileError, CameraRemark, camera_from_yaml};
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
    match camera_from_yaml(text, Some(Mount::level(1.5))).unwrap().camera.view() {
        View::Calibrated { distortion, .. } => *distortion,
        View::RoadPlane(_) => panic!("a calibrated camera was expected"),
    }
}

#[test]
fn ros_camera_info_is_read() {
    let lens = Distortion::brown_conrady(&[-0.26, 0.08, -0.0003, 0.0004, 0.0]).unwrap();
    let mount = Mount::level(1.65);
    let camera = camera_from_yaml(ROS, Some(mount)).unwrap().camera;
    assert_eq!(camera, expected((1241, 376), [718.856, 718.856, 607.1928, 185.2157], lens, mount));
}

#[test]
fn opencv_file_storage_is_read() {
    let lens = Distortion::brown_conrady(&[-0.264, 0.075, -0.0003, 0.0004, -0.146]).unwrap();
    let mount = Mount { pitch_rad: 0.02, ..Mount::level(1.4) };
    let camera = camera_from_yaml(OPENCV, Some(mount)).unwrap().camera;
    assert_eq!(camera, expected((1280, 720), [1157.1, 1151.3, 670.4, 387.9], lens, mount));
}

#[test]
fn other_spellings_of_opencv_samples_are_read() {
    let plain = camera_from_yaml(OPENCV, Some(Mount::level(1.4))).unwrap().camera;
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
        assert_eq!(camera_from_yaml(&text, Some(Mount::level(1.4))).unwrap().camera, plain, "{text}");
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
fn a_fisheye_flag_beside_a_model_says_the_same_or_is_refused() {
    let with = |model: &str, flag: &str| {
        let coefficients = if model == "none" { "[]" } else { "[0.01, -0.002, 0.0003, -0.00004]" };
        let text = ROS.replace("[-0.26, 0.08, -0.0003, 0.0004, 0]", coefficients).replace("plumb_bob", model);
        format!("fisheye_model: {flag}\n{text}")
    };
    for (model, flags) in [
        ("equidistant", ["1", "true"]),
        ("fisheye", ["1", "~"]),
        ("plumb_bob", ["0", "false"]),
        ("none", ["0", "~"]),
    ] {
        for flag in flags {
            let plain = with(model, flag).replace(&format!("fisheye_model: {flag}\n"), "");
            assert_eq!(lens_of(&with(model, flag)), lens_of(&plain), "{model} {flag}");
        }
    }
    for (model, flag) in [
        ("plumb_bob", "1"),
        ("rational_polynomial", "true"),
        ("none", "1"),
        ("equidistant", "0"),
        ("equi", "false"),
    ] {
        let said = refusal(&with(model, flag));
        assert!(
            said.contains("`fisheye_model`") && said.contains("`distortion_model`"),
            "{model} {flag}: {said}"
        );
    }
    for flag in ["0.5", "2", "-1", "yes please", "[1]", ".nan"] {
        assert!(refusal(&with("equidistant", flag)).contains("0 or 1"), "{flag}");
    }
}

#[test]
fn a_region_is_the_whole_picture_or_refused_however_it_is_written() {
    let with = |region: &str| format!("{ROS}roi: {region}\n");
    for whole in [
        "~",
        "{}",
        "{x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false}",
        "{do_rectify: true}",
    ] {
        lens_of(&with(whole));
    }
    for region in [
        "[0, 0, 640, 480]",
        "[10, 20, 300, 200]",
        "[]",
        "[[0, 0], [640, 480]]",
        "10 20 300 200",
        "5",
        "{x: 10, y: 20, w: 300, h: 200}",
        "{x_offset: 0, y_offset: 0, right: 100}",
        "{x_offset: 12}",
        "{y_offset: -12}",
        "{x_offset: .nan}",
        "{width: 300, height: 200}",
    ] {
        assert!(refusal(&with(region)).contains("`roi`"), "{region}");
    }
}

#[test]
fn a_tail_of_zeros_behind_a_models_coefficients_is_none() {
    let fisheye = ROS.replace("plumb_bob", "equidistant");
    let with = |list: &str| fisheye.replace("[-0.26, 0.08, -0.0003, 0.0004, 0]", list);
    let four = Distortion::kannala_brandt(&[0.01, -0.002, 0.0003, -0.00004]).unwrap();
    for tail in ["", ", 0", ", 0.0, 0, 0, 0"] {
        assert_eq!(lens_of(&with(&format!("[0.01, -0.002, 0.0003, -0.00004{tail}]"))), four, "{tail}");
    }
    assert!(refusal(&with("[0.01, -0.002, 0.0003, -0.00004, 0.001]")).contains("5 were given"));
}

/// OpenCV's older calibration, with its coefficients under a key.
fn older(key: &str) -> String {
    let matrix = "[[210.0, 0.0, 159.5], [0.0, 210.0, 119.5], [0.0, 0.0, 1.0]]";
    format!(
        "image_width: 320\nimage_height: 240\ncamera_matrix: {matrix}\n{key}: [-0.2, 0.05, 0.001, 0.002, 0.0]\n"
    )
}

#[test]
fn coefficients_are_read_or_refused_whatever_they_are_called() {
    let lens = Distortion::brown_conrady(&[-0.2, 0.05, 0.001, 0.002, 0.0]).unwrap();
    for key in [
        "dist_coeff",
        "dist_coeffs",
        "distCoeffs",
        "distortion_coefficients",
        "Distortion_Coefficients",
        "distortion_coeffs",
        "D",
        "d",
    ] {
        assert_eq!(lens_of(&older(key)), lens, "{key}");
    }
    for key in ["distortion", "distortion_parameters", "lens", "radial_coefs", "k1", "fisheye_params"] {
        let message = refusal(&older(key));
        assert!(message.contains(&format!("`{key}`")) && message.contains("distortion_model"), "{message}");
    }
}

#[test]
fn a_model_that_is_named_needs_its_coefficients() {
    for model in ["plumb_bob", "rational_polynomial", "equidistant", "radtan"] {
        let text =
            older("flags").replace("camera_matrix", &format!("distortion_model: {model}\ncamera_matrix"));
        assert!(refusal(&text).contains(&format!("{model:?} is named")), "{model}");
    }
    let none = older("flags").replace("camera_matrix", "distortion_model: none\ncamera_matrix");
    assert_eq!(remarks(&none), []);
    assert_eq!(lens_of(&none), Distortion::None);
}

fn remarks(text: &str) -> Vec<CameraRemark> {
    camera_from_yaml(text, Some(Mount::level(1.5))).unwrap().remarks
}

#[test]
fn what_is_taken_for_granted_is_said() {
    assert_eq!(remarks(&older("dist_coeff")), []);
    assert_eq!([remarks(ROS), remarks(OPENCV)].concat(), []);
    assert_eq!(remarks(&older("flags")), [CameraRemark::NoDistortion]);
    let keys = vec!["exposure_us".to_owned(), "gain".to_owned()];
    let text = format!("exposure_us: 10\n{}gain: 2\n", older("d"));
    assert_eq!(remarks(&text), [CameraRemark::UnknownKeys { keys }]);
    let text = format!("{0}---\n{0}---\n", older("d"));
    assert_eq!(remarks(&text), [CameraRemark::FirstDocument { count: 2 }]);
}

#[test]
fn messages_as_ros_2_prints_them_are_read() {
    let list = |values: &[f64]| values.iter().map(|value| format!("- {value:?}\n")).collect::<String>();
    let text = format!(
        "header:\n  stamp:\n    sec: 17\n    nanosec: 5\n  frame_id: camera\nheight: 240\nwidth: 320\n\
         distortion_model: plumb_bob\nd:\n{}k:\n{}r:\n{}p:\n{}binning_x: 0\nbinning_y: 0\nroi:\n  x_offset: 0\n  \
         y_offset: 0\n  height: 0\n  width: 0\n  do_rectify: false\n---\n",
        list(&[-0.2, 0.05, 0.001, 0.002, 0.0]),
        list(&[210.0, 0.0, 159.5, 0.0, 210.0, 119.5, 0.0, 0.0, 1.0]),
        list(&[1.0]),
        list(&[200.0]),
    );
    let lens = Distortion::brown_conrady(&[-0.2, 0.05, 0.001, 0.002, 0.0]).unwrap();
    let mount = Mount::level(1.5);
    let read = camera_from_yaml(&text, Some(mount)).unwrap();
    assert_eq!(read.camera, expected((320, 240), [210.0, 210.0, 159.5, 119.5], lens, mount));
    assert_eq!(read.remarks, []);
    for (from, to, key) in [
        ("binning_x: 0", "binning_x: 2", "`binning_x`"),
        ("y_offset: 0", "y_offset: 60", "`roi`"),
        ("  height: 0\n  width: 0", "  height: 120\n  width: 320", "`roi`"),
    ] {
        assert!(refusal(&text.replace(from, to)).contains(key), "{to}");
    }
}

const KALIBR: &str = "cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 0.00002]
  distortion_model: radtan
  intrinsics: [458.6, 457.3, 367.2, 248.4]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, -0.0001, -0.00003]
  distortion_model: radtan
  intrinsics: [457.5, 456.1, 379.9, 255.2]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
";

#[test]
fn of_kalibrs_chain_the_first_camera_is_used_and_the_others_are_named() {
    let (mount, size, k) = (Mount::level(1.5), (752, 480), [458.6, 457.3, 367.2, 248.4]);
    let lens = Distortion::brown_conrady(&[-0.28, 0.07, 0.0002, 0.00002]).unwrap();
    let read = camera_from_yaml(KALIBR, Some(mount)).unwrap();
    assert_eq!(read.camera, expected(size, k, lens, mount));
    let (used, others) = ("cam0".to_owned(), vec!["cam1".to_owned()]);
    assert_eq!(read.remarks, [CameraRemark::OneOfSeveral { used, others }]);
    let (alone, _) = KALIBR.split_at(KALIBR.find("cam1:").unwrap());
    assert_eq!(remarks(alone), []);
    let fisheye = Distortion::kannala_brandt(&[-0.28, 0.07, 0.0002, 0.00002]).unwrap();
    assert_eq!(lens_of(&alone.replace("radtan", "equidistant")), fisheye);
    for model in ["omni", "eucm", "ds"] {
        assert!(refusal(&alone.replace("pinhole", model)).contains(&format!("{model:?}")), "{model}");
    }
    assert!(refusal(&alone.replace("radtan", "fov")).contains("\"fov\""));
    let with_mount = format!("{KALIBR}mount:\n  height_m: 1.5\n");
    assert_eq!(camera_from_yaml(&with_mount, None).unwrap().camera, read.camera);
}

#[test]
fn keys_that_mean_the_same_must_say_the_same() {
    let twice = format!("{}D: [-0.2, 0.05, 0.001, 0.002, 0.0]\n", older("dist_coeff"));
    assert!(matches!(lens_of(&twice), Distortion::BrownConrady { .. }));
    let message = refusal(&twice.replace("D: [-0.2", "D: [-0.3"));
    assert!(message.contains("`dist_coeff` and `D`"), "{message}");
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
    let mount_of = |mount| match camera_from_yaml(&with_mount, mount).unwrap().camera.view() {
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
        ("camera_matrix", "camera", "camera_matrix, K"),
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

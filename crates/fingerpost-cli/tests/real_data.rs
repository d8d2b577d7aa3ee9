//! The program on recorded drives: the folder named by FINGERPOST_DATA. Missing data, or a missing ffmpeg, is a failure.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use fingerpost::camera_state::{CameraState, CameraWatch};
use fingerpost::ground_view::{GroundView, GroundViewConfig};
use fingerpost::road_surface::BackprojectionConfig;
use fingerpost_format::{FrameRecord, Summary, from_json_lines};
use fingerpost_geometry::{Distortion, GroundPixel, View};
use fingerpost_io::{FrameSource, SourceOptions, read_camera, read_picture};
use fingerpost_map::{ArmRole, FeatureKind, read_route};
use fingerpost_vision::picture::RgbImage;
use tempfile::TempDir;

/// The camera of KITTI odometry 00, as its calibration and the alignment of its ground views say.
const KITTI_CAMERA: &str = "[image]\nwidth = 1241\nheight = 376\n\
    [intrinsics]\nfx = 718.856\nfy = 718.856\ncx = 607.1928\ncy = 185.2157\n\
    [mount]\nheight_m = 1.65\npitch_deg = 0.8\nx_m = 1.5\n";
/// The camera of the motorway clip, as its chessboard pictures say; its mount as the lanes' width and direction say.
const MOTORWAY_CAMERA: &str = "[image]\nwidth = 1280\nheight = 720\n\
    [intrinsics]\nfx = 1157.1\nfy = 1151.3\ncx = 670.4\ncy = 387.9\n\
    [distortion]\nmodel = \"brown-conrady\"\ncoefficients = [-0.264, 0.075, -0.0003, 0.0004, -0.146]\n\
    [mount]\nheight_m = 1.3\nx_m = 1.5\n";
/// The junction that the drive turns right at.
const JUNCTION: i64 = 24546162;

fn data(name: &str) -> PathBuf {
    let path = PathBuf::from(env::var("FINGERPOST_DATA").unwrap()).join(name);
    assert!(path.exists(), "{} is missing", path.display());
    path
}

fn fingerpost(arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_fingerpost")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn frames(run: &Path) -> Vec<FrameRecord> {
    from_json_lines(&fs::read_to_string(run.join("frames.jsonl")).unwrap()).unwrap()
}

/// What `evaluate motion` says of a run against poses.
fn motion_evaluation(run: &Path, poses: &Path) -> serde_json::Value {
    let output = Command::new(env!("CARGO_BIN_EXE_fingerpost"))
        .args(["evaluate", "motion", text(run), "--kitti-poses", text(poses), "--json"])
        .output()
        .unwrap();
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Every recorded drive and still, night, snow, dusk and dust among them.
#[test]
fn no_recorded_camera_is_called_blind() {
    let drives = ["kitti/frames00", "kitti/frames06", "kitti/frames_0926", "camvid/val", "camvid/dusk"];
    let videos = ["p1_solidWhiteRight.mp4", "p5h_project_video_cut.mp4", "p5h_test_small1.mp4"];
    let stills = ["unpaved", "tusimple/image", "bdd", "udacity/test_images"];
    let videos = videos.map(|video| format!("udacity/{video}"));
    let names = drives.into_iter().chain(stills).chain(videos.iter().map(String::as_str));
    let mut least = f64::INFINITY;
    for name in names {
        let mut watch = CameraWatch::default();
        let mut count = 0;
        for frame in FrameSource::open(text(&data(name)), &SourceOptions::default()).unwrap() {
            let Ok(picture) = frame.picture else { continue };
            let evidence = watch.look_at(&picture);
            assert_eq!(evidence.state, CameraState::Clear, "{name}, frame {}: {evidence:?}", frame.index);
            least = least.min(evidence.contrast / evidence.needed_contrast);
            count += 1;
        }
        assert!(count > 3, "{name}: {count} pictures");
    }
    assert!(least > 2.0, "{least}");
}

#[test]
fn a_street_with_a_junction() {
    let folder = TempDir::new().unwrap();
    let (camera, route, run) =
        (folder.path().join("camera.toml"), folder.path().join("route.geojson"), folder.path().join("run"));
    fs::write(&camera, KITTI_CAMERA).unwrap();
    let map = data("osm/kitti_00.osm");
    let ends = ["--from", "48.98254524,8.39036610", "--to", "48.98322839,8.39103811"];
    fingerpost(&[&["route", "--map", text(&map)], &ends[..], &["--out", text(&route)]].concat());
    let planned = read_route(&fs::read_to_string(&route).unwrap()).unwrap();
    let junction = planned.features.iter().find(|feature| feature.id == JUNCTION).unwrap();
    assert_eq!((junction.kind, junction.arms.len()), (FeatureKind::Junction, 4));
    assert!((junction.turn_rad.to_degrees() + 90.0).abs() < 10.0, "right");
    assert_eq!(junction.arms.iter().filter(|arm| arm.role == ArmRole::Side).count(), 2);

    let input = data("kitti/frames00");
    let arguments =
        ["run", text(&input), "--camera", text(&camera), "--route", text(&route), "--start-m", "0"];
    fingerpost(&[&arguments[..], &["--pictures", "85-105", "--video", "--out", text(&run)]].concat());
    let records = frames(&run);
    assert_eq!(records.len(), 130);
    assert!(records.iter().all(|record| record.error.is_none() && !record.why.is_empty()));
    let summary: Summary =
        serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary.features.iter().map(|feature| feature.id).collect::<Vec<_>>(), [JUNCTION]);
    for frame in 85..=105 {
        let picture = read_picture(&run.join(format!("pictures/frame_{frame:06}.png"))).unwrap();
        assert_eq!(picture.size(), (1280, 720));
    }
    let report = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(report.contains("24546162") && report.contains("data:image/jpeg;base64,"));
    assert!(fs::metadata(run.join("annotated.mp4")).unwrap().len() > 100_000);

    let motion = motion_evaluation(&run, &data("kitti/gt_00.txt"));
    assert_eq!(motion["steps"], 129);
    assert!(motion["motion_error_pct"].as_f64().unwrap() < 3.0, "{motion}");
}

/// With the height and the intrinsics alone: the pitch, most of a degree, is found while driving.
#[test]
fn ego_motion_without_a_known_pitch() {
    let drives = [
        ("00", level_camera(1241, 376, 718.856, [607.1928, 185.2157]), 129),
        ("06", level_camera(1226, 370, 707.0912, [601.8873, 183.1104]), 50),
    ];
    for (drive, camera, steps) in drives {
        let folder = TempDir::new().unwrap();
        let (file, run) = (folder.path().join("camera.toml"), folder.path().join("run"));
        fs::write(&file, camera).unwrap();
        let input = data(&format!("kitti/frames{drive}"));
        fingerpost(&["run", text(&input), "--camera", text(&file), "--out", text(&run)]);
        let motion = motion_evaluation(&run, &data(&format!("kitti/gt_{drive}.txt")));
        assert_eq!(motion["steps"], steps);
        assert!(motion["motion_error_pct"].as_f64().unwrap() < 3.0, "{drive}: {motion}");
        assert!(motion["end_heading_error_deg"].as_f64().unwrap() < 1.5, "{drive}: {motion}");
    }
}

/// A street's camera as its calibration has it, with nothing known of the mount but the height.
fn level_camera(width: usize, height: usize, focal: f64, centre: [f64; 2]) -> String {
    let [cx, cy] = centre;
    format!(
        "[image]\nwidth = {width}\nheight = {height}\n[intrinsics]\nfx = {focal}\nfy = {focal}\ncx = {cx}\ncy = {cy}\n\
         [mount]\nheight_m = 1.65\n"
    )
}

/// Two drives of one car: its mount from either must be the same.
#[test]
fn the_mount_of_two_streets() {
    let folder = TempDir::new().unwrap();
    let mounts = [
        ("kitti/frames00", level_camera(1241, 376, 718.856, [607.1928, 185.2157])),
        ("kitti/frames06", level_camera(1226, 370, 707.0912, [601.8873, 183.1104])),
    ]
    .map(|(drive, camera)| {
        let (camera_path, out) = (folder.path().join("camera.toml"), folder.path().join("out.toml"));
        fs::write(&camera_path, camera).unwrap();
        let input = data(drive);
        fingerpost(&[
            "calibrate",
            "mount",
            text(&input),
            "--camera",
            text(&camera_path),
            "--out",
            text(&out),
        ]);
        let run = folder.path().join("run");
        fingerpost(&["run", text(&input), "--camera", text(&camera_path), "--out", text(&run)]);
        let records = frames(&run);
        let faults = records.iter().filter(|record| record.mount.as_ref().is_some_and(|m| m.fault.is_some()));
        assert_eq!(faults.count(), 0, "{drive}");
        let camera = read_camera(&out).unwrap().camera;
        match camera.view() {
            View::Calibrated { mount, .. } => Some(*mount),
            View::RoadPlane(_) => None,
        }
        .unwrap()
    });
    let [pitch_deg, yaw_deg] =
        [mounts.map(|mount| mount.pitch_rad.to_degrees()), mounts.map(|mount| mount.yaw_rad.to_degrees())];
    assert!((pitch_deg[0] - pitch_deg[1]).abs() < 0.3, "{pitch_deg:?}");
    assert!((yaw_deg[0] - yaw_deg[1]).abs() < 0.4, "{yaw_deg:?}");
    assert!(pitch_deg.iter().all(|pitch| (0.5..1.3).contains(pitch)), "nose down: {pitch_deg:?}");
}

/// The marks that ship are of these clips: they have their size and their frames.
#[test]
fn the_shipped_marks_fit_their_clips() {
    let out = TempDir::new().unwrap();
    for (clip, frames) in
        [("p1_solidWhiteRight", 221), ("p5h_project_video_cut", 76), ("p5h_test_small1", 88)]
    {
        let video = data(&format!("udacity/{clip}.mp4"));
        let marks = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/marks/{clip}.json"));
        let truth = out.path().join(clip);
        fingerpost(&["mark", text(&video), "--marks", text(&marks), "--export", text(&truth)]);
        let truth = fingerpost_io::read_truth(&truth.join("truth.jsonl")).unwrap();
        assert_eq!(truth.len(), frames, "{clip}");
        assert!((truth[frames - 1].t_s - (frames - 1) as f64 / 25.0).abs() < 1e-6, "{clip}");
    }
}

#[test]
fn a_motorway_video() {
    let folder = TempDir::new().unwrap();
    let (camera, run) = (folder.path().join("camera.toml"), folder.path().join("run"));
    fs::write(&camera, MOTORWAY_CAMERA).unwrap();
    let video = data("udacity/p5h_project_video_cut.mp4");
    let arguments = ["run", text(&video), "--camera", text(&camera), "--pictures", "5", "--out", text(&run)];
    fingerpost(&arguments);
    assert_eq!(frames(&run).len(), 76);
    assert!(run.join("pictures/frame_000005.png").exists());

    let first = FrameSource::open(text(&video), &SourceOptions::default()).unwrap().next().unwrap();
    let bins = BackprojectionConfig::default().bins();
    let view =
        GroundView::new(&GroundViewConfig::default(), bins, &read_camera(&camera).unwrap().camera).unwrap();
    let mut ground = view.black_picture();
    view.render(&first.picture.unwrap(), &mut ground).unwrap();
    let line = yellow_line(&ground.colour, &view);
    assert!(line.len() > 150, "{} rows of the ground view show the line", line.len());
    let bend_m = largest_offset_from_straight(&line);
    assert!(bend_m < 0.1, "the line at the motorway's edge bends by {bend_m} m in 12");
}

/// Places of the yellow line, vehicle frame, metres forward and left, one for each row of the ground view that shows it.
fn yellow_line(ground: &RgbImage, view: &GroundView) -> Vec<[f64; 2]> {
    let yellow =
        |[red, green, blue]: [u8; 3]| red > blue.saturating_add(60) && green > blue.saturating_add(30);
    (0..ground.height())
        .filter_map(|row| {
            let columns: Vec<f64> = (0..ground.width())
                .filter(|&column| ground.get(column, row).is_some_and(yellow))
                .map(|column| column as f64)
                .collect();
            let column = columns.iter().sum::<f64>() / columns.len() as f64;
            let p = view.grid().vehicle_from_ground(GroundPixel { column, row: row as f64 });
            // Nearer than this the picture shows the bonnet.
            (!columns.is_empty() && p.x > 7.0).then_some([p.x, p.y])
        })
        .collect()
}

/// Largest distance of the points from the straight line through them, least squares, metres.
fn largest_offset_from_straight(points: &[[f64; 2]]) -> f64 {
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64;
    let (mean_x, mean_y) = (mean(0), mean(1));
    let slope = points.iter().map(|p| (p[0] - mean_x) * (p[1] - mean_y)).sum::<f64>()
        / points.iter().map(|p| (p[0] - mean_x).powi(2)).sum::<f64>();
    points.iter().map(|p| (p[1] - mean_y - slope * (p[0] - mean_x)).abs()).fold(0.0, f64::max)
}

/// How well a detector tells the road of labelled street pictures: intersection over union at one threshold for the whole set, and at even odds.
fn road_iou(detector: &str, set: &str, labels: &str, further: &[&str]) -> [f64; 2] {
    let (images, labels) = (data(set), data(labels));
    let output = Command::new(env!("CARGO_BIN_EXE_fingerpost"))
        .args(["evaluate", "road", "--images", text(&images), "--labels", text(&labels), "--road", "3"])
        .args(["--void", "11", "--detector", detector, "--json"])
        .args(further)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let numbers: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    ["iou", "iou_at_half"].map(|key| numbers["detectors"][0][key].as_f64().unwrap())
}

#[test]
fn the_online_classifier_tells_the_road_from_the_pavement() {
    let [day, _] = road_iou("online", "camvid/val", "camvid/valannot", &[]);
    assert!(day > 0.89, "by day {day}");
    let [first_frames, _] = road_iou("online", "camvid/val", "camvid/valannot", &["--stills"]);
    assert!(first_frames > 0.88, "every frame the first {first_frames}");
    let [dusk, _] = road_iou("online", "camvid/dusk", "camvid/duskannot", &[]);
    assert!(dusk > 0.77, "at dusk {dusk}");
}

/// Network and drive together tell it better than either, at one threshold as at even odds.
#[test]
fn both_together_tell_the_road_better_than_either() {
    for (set, labels) in [("camvid/val", "camvid/valannot"), ("camvid/dusk", "camvid/duskannot")] {
        let iou = |detector| road_iou(detector, set, labels, &["--from-row", "0.33"]);
        let (together, online, network) = (iou("combined"), iou("online"), iou("network"));
        for at in [0, 1] {
            let better = online[at].max(network[at]) + 0.01;
            assert!(together[at] > better, "{set}: {together:?}, {online:?}, {network:?}");
        }
    }
}

/// The twenty photographs of a chessboard by the camera of the motorway clips. OpenCV's `findChessboardCorners` finds 17 of the
/// boards, four corners of one of them 7 to 19 pixels off, and `cornerSubPix` (half window 5) and `calibrateCamera` give the
/// lens that is compared with here, at an rms of 1.096 pixels.
#[test]
fn a_lens_from_chessboards_is_that_of_opencv() {
    let (folder, boards) = (TempDir::new().unwrap(), data("udacity/camera_cal"));
    let out = folder.path().join("camera.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_fingerpost"))
        .args(["calibrate", "chessboard", text(&boards), "--corners", "9x6", "--height-m", "1.3", "--json"])
        .args(["--out", text(&out)])
        .output()
        .unwrap();
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{messages}");
    for useless in ["calibration1.jpg", "calibration5.jpg"] {
        assert!(messages.contains(&format!("{useless}: corners are cut off")), "{messages}");
    }
    for larger in ["calibration7.jpg", "calibration15.jpg"] {
        assert!(messages.contains(&format!("{larger} has 1281 x 721 pixels and is used")), "{messages}");
    }
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["pictures_used"], 18, "{told}");
    assert!(told["rms_px"].as_f64().unwrap() <= 1.0, "{told}");
    let camera = read_camera(&out).unwrap().camera;
    let View::Calibrated { intrinsics: k, distortion, .. } = camera.view() else { panic!("{camera:?}") };
    assert!((k.fx / 1157.1 - 1.0).abs() < 0.005 && (k.fy / 1151.3 - 1.0).abs() < 0.005, "{k:?}");
    assert!((k.cx - 670.4).abs() < 4.0 && (k.cy - 387.9).abs() < 4.0, "{k:?}");
    let Distortion::BrownConrady { coefficients, .. } = distortion else { panic!("{distortion:?}") };
    assert!((coefficients[0] + 0.264).abs() < 0.03, "{coefficients:?}");
}

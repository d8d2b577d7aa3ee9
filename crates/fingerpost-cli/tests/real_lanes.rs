//! Lanes of recorded motorways against edges marked by hand (`marks/`), and of stills: the folder named by FINGERPOST_DATA.
//! Missing data, or a missing ffmpeg, is a failure.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use fingerpost_format::{FrameRecord, LanesRecord, TruthRecord, from_json_lines, to_json_line};
use serde_json::Value;
use tempfile::TempDir;

/// Camera of the four motorway stills: the means of pitch and yaw by the points in which the labelled lines meet (6.6 to 8.3
/// and -0.9 to -2.0 degrees), the height by lanes of 3.66 m (1.55 to 1.73 m); the focal length is assumed.
const TUSIMPLE_CAMERA: &str = "[image]\nwidth = 1280\nheight = 720\n\
    [intrinsics]\nfx = 1000\nfy = 1000\ncx = 639.5\ncy = 359.5\n\
    [mount]\nheight_m = 1.6\npitch_deg = 7.3\nyaw_deg = -1.3\nx_m = 1.6\n";

/// Columns of the middles of the labelled lines of each still on either side of the vehicle, in rows 400 and 600.
const TUSIMPLE_LINES: [[(f64, [f64; 2]); 2]; 4] = [
    [(400.0, [472.0, 838.0]), (600.0, [224.0, 1064.5])],
    [(400.0, [448.5, 842.0]), (600.0, [216.0, 1064.0])],
    [(400.0, [485.5, 852.5]), (600.0, [257.5, 1080.5])],
    [(400.0, [480.0, 866.0]), (600.0, [285.0, 1098.0])],
];
/// How far an inner edge lies from its line's middle at the most: half of the paint, and reflectors beside it, pixels.
const FROM_LINE_PX: f64 = 25.0;

fn data(name: &str) -> PathBuf {
    let path = PathBuf::from(env::var("FINGERPOST_DATA").unwrap()).join(name);
    assert!(path.exists(), "{} is missing", path.display());
    path
}

fn marks(name: &str) -> String {
    format!("{}/tests/marks/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// What the program prints.
fn fingerpost(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_fingerpost")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Accuracy of the lane's edges in a clip, mean over all regions and thresholds (paper 3, equation 2), percent.
fn mean_accuracy_pct(clip: &str, camera: &str) -> f64 {
    mean_accuracy_with(clip, camera, &[])
}

/// The same of a run with more options.
fn mean_accuracy_with(clip: &str, camera: &str, options: &[&str]) -> f64 {
    let folder = TempDir::new().unwrap();
    let (truth, run) = (folder.path().join("truth"), folder.path().join("run"));
    let video = data(&format!("udacity/{clip}.mp4"));
    let video = text(&video);
    fingerpost(&["mark", video, "--marks", &marks(&format!("{clip}.json")), "--export", text(&truth)]);
    let camera = marks(camera);
    fingerpost(&[&["run", video, "--camera", &camera, "--out", text(&run)], options].concat());
    let truth = truth.join("truth.jsonl");
    let printed = fingerpost(&["evaluate", "lanes", text(&run), "--truth", text(&truth), "--json"]);
    let numbers: Value = serde_json::from_str(&printed).unwrap();
    numbers["clips"][0]["mean_accuracy_pct"].as_f64().unwrap()
}

/// What the papers' settings make of paper 3 is what its own tracker makes of it with all else as by default.
#[test]
fn the_papers_settings_run_paper_3_as_well_as_its_tracker_alone() {
    let folder = TempDir::new().unwrap();
    let sections = folder.path().join("sections.toml");
    fs::write(&sections, "[lanes]\nfinder = \"sections\"\n").unwrap();
    let papers = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../papers.toml");
    let [alone, papers] = [&sections, &papers].map(|config| {
        mean_accuracy_with(
            "p1_solidWhiteRight",
            "p1_solidWhiteRight.camera.toml",
            &["--config", text(config)],
        )
    });
    assert!(alone > 75.0 && papers > alone - 2.0, "{papers} %, its tracker alone {alone} %");
}

// The aim is 98 % on each clip.

#[test]
fn a_whole_and_a_broken_white_line() {
    let accuracy_pct = mean_accuracy_pct("p1_solidWhiteRight", "p1_solidWhiteRight.camera.toml");
    assert!(accuracy_pct >= 99.5, "{accuracy_pct} %");
}

#[test]
fn a_yellow_and_a_broken_line_in_a_bend() {
    let accuracy_pct = mean_accuracy_pct("p5h_project_video_cut", "p5h.camera.toml");
    assert!(accuracy_pct >= 98.0, "{accuracy_pct} %");
}

#[test]
fn from_asphalt_onto_concrete() {
    let accuracy_pct = mean_accuracy_pct("p5h_test_small1", "p5h.camera.toml");
    assert!(accuracy_pct >= 98.0, "{accuracy_pct} %");
}

/// The lanes of pictures that have nothing to do with each other, in their order.
fn lanes_of_stills(pictures: &[PathBuf], camera: &str) -> Vec<Option<LanesRecord>> {
    let folder = TempDir::new().unwrap();
    let (stills, run) = (folder.path().join("stills"), folder.path().join("run"));
    fs::create_dir(&stills).unwrap();
    for (index, picture) in pictures.iter().enumerate() {
        let extension = picture.extension().unwrap().display();
        fs::copy(picture, stills.join(format!("{index:06}.{extension}"))).unwrap();
    }
    let camera_file = folder.path().join("camera.toml");
    fs::write(&camera_file, camera).unwrap();
    fingerpost(&["run", text(&stills), "--stills", "--camera", text(&camera_file), "--out", text(&run)]);
    let frames: Vec<FrameRecord> =
        from_json_lines(&fs::read_to_string(run.join("frames.jsonl")).unwrap()).unwrap();
    assert_eq!(frames.len(), pictures.len());
    assert!(frames.iter().all(|frame| frame.error.is_none()), "a picture could not be used");
    frames.into_iter().map(|frame| frame.lanes).collect()
}

#[test]
fn single_pictures_of_motorways() {
    let pictures: Vec<PathBuf> = (0..4).map(|n| data(&format!("tusimple/image/000{n}.png"))).collect();
    let lanes = lanes_of_stills(&pictures, TUSIMPLE_CAMERA);
    for (picture, (lane, lines)) in lanes.iter().zip(TUSIMPLE_LINES).enumerate() {
        let lane = lane.as_ref().unwrap();
        for (row, columns) in lines {
            for (edge_px, column) in [&lane.left_px, &lane.right_px].into_iter().zip(columns) {
                let near = edge_px.iter().min_by(|a, b| (a[1] - row).abs().total_cmp(&(b[1] - row).abs()));
                let near = near.unwrap_or_else(|| panic!("picture {picture} lacks an edge: {lane:?}"));
                assert!((near[1] - row).abs() < 12.0, "picture {picture}: {near:?} is not in row {row}");
                assert!(
                    (near[0] - column).abs() < FROM_LINE_PX,
                    "picture {picture}: {near:?}, line at {column}"
                );
            }
        }
    }
}

/// A faint streak of salt runs inside the lane, along a broken line that shows one clear dash.
#[test]
fn a_streak_of_salt_inside_the_lane_is_no_edge() {
    let camera = "[image]\nwidth = 1280\nheight = 720\n\
        [intrinsics]\nfx = 1000\nfy = 1000\ncx = 639.5\ncy = 359.5\n\
        [mount]\nheight_m = 1.4\npitch_deg = 3.0\nx_m = 1.6\n";
    let lanes = lanes_of_stills(&[data("bdd/caeb782d-4a20b7c4.jpg")], camera);
    let left_px = &lanes[0].as_ref().unwrap().left_px;
    // The dash's inner edge, read off the picture; the streak is 60 pixels further right.
    let near = left_px.iter().min_by(|a, b| (a[1] - 575.0).abs().total_cmp(&(b[1] - 575.0).abs())).unwrap();
    let dash_u = 418.0 - 0.77 * (near[1] - 575.0);
    assert!((near[0] - dash_u).abs() < 12.0, "{near:?} is not at {dash_u}");
}

/// Pitches that a calibration of the camera of KITTI's drives may say, degrees; its own is about 0.75.
const KITTI_PITCHES_DEG: [f64; 6] = [0.2, 0.4, 0.5, 0.75, 0.9, 1.0];
/// Frames of 130 in which a line may be claimed where there is none.
const MOST_FALSE_FRAMES: u64 = 3;

/// A street between kerbs, with tar seams and parked cars, and a turn at a junction; nothing is painted on it. A twentieth of a degree
/// decides which kerb lies where a line might.
#[test]
fn a_street_without_markings_has_no_lane_at_any_pitch_of_the_calibration() {
    let folder = TempDir::new().unwrap();
    let (camera_file, run) = (folder.path().join("camera.toml"), folder.path().join("run"));
    let frames = data("kitti/frames00");
    let unmarked: Vec<TruthRecord> =
        (0..130).map(|frame| TruthRecord { frame, ..TruthRecord::default() }).collect();
    let truth = folder.path().join("truth.jsonl");
    let lines: String = unmarked.iter().map(|record| to_json_line(record).unwrap()).collect();
    fs::write(&truth, lines).unwrap();
    for pitch_deg in KITTI_PITCHES_DEG {
        let camera = format!(
            "[image]\nwidth = 1241\nheight = 376\n\
             [intrinsics]\nfx = 718.856\nfy = 718.856\ncx = 607.1928\ncy = 185.2157\n\
             [mount]\nheight_m = 1.65\npitch_deg = {pitch_deg}\n"
        );
        fs::write(&camera_file, camera).unwrap();
        fingerpost(&["run", text(&frames), "--camera", text(&camera_file), "--out", text(&run)]);
        let printed = fingerpost(&["evaluate", "lanes", text(&run), "--truth", text(&truth), "--json"]);
        let numbers: Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(numbers["clips"][0]["unmarked_frames"], 130);
        let false_frames = numbers["clips"][0]["false_lane_frames"].as_u64().unwrap();
        assert!(false_frames <= MOST_FALSE_FRAMES, "{false_frames} frames at {pitch_deg} degrees");
    }
}

#[test]
fn dirt_roads_have_no_lane() {
    let mut small = Vec::new();
    let mut large = Vec::new();
    for entry in fs::read_dir(data("unpaved")).unwrap() {
        let path = entry.unwrap().path();
        // The names of the large pictures have seven digits, those of the small ones nine.
        let of_its_size = if path.file_stem().unwrap().len() == 7 { &mut large } else { &mut small };
        of_its_size.push(path);
    }
    assert_eq!((small.len(), large.len()), (13, 5));
    // Nothing is known of the cameras: 58 degrees wide; the horizon is seen in the middle, in the large pictures above it.
    for (mut pictures, width, height, pitch_deg) in [(small, 352, 288, 0.0), (large, 1280, 960, 3.0)] {
        pictures.sort();
        let f = 0.9 * f64::from(width);
        let (cx, cy) = (0.5 * f64::from(width - 1), 0.5 * f64::from(height - 1));
        let camera = format!(
            "[image]\nwidth = {width}\nheight = {height}\n\
             [intrinsics]\nfx = {f}\nfy = {f}\ncx = {cx}\ncy = {cy}\n\
             [mount]\nheight_m = 1.4\npitch_deg = {pitch_deg}\nx_m = 1.6\n"
        );
        for (picture, lane) in pictures.iter().zip(lanes_of_stills(&pictures, &camera)) {
            let empty = lane.as_ref().is_none_or(|lane| lane.left_px.is_empty() && lane.right_px.is_empty());
            assert!(empty, "{}: {lane:?}", picture.display());
        }
    }
}

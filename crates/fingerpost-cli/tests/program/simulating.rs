//! Simulated drives as files.

use std::fs;

use fingerpost_format::{TruthRecord, camera_from_toml, from_json_lines};
use fingerpost_geometry::{Distortion, View};
use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::program::{call_line, command};

#[test]
fn a_drive_folder_holds_all_that_a_run_needs() {
    let drive = Drive::get().path();
    let read = |name: &str| fs::read_to_string(drive.join(name)).unwrap();
    let truth: Vec<TruthRecord> = from_json_lines(&read("truth.jsonl")).unwrap();
    assert_eq!(truth.len(), FRAMES);
    assert_eq!(fs::read_dir(drive.join("frames")).unwrap().count(), FRAMES);
    assert_eq!(fs::read_dir(drive.join("road_masks")).unwrap().count(), FRAMES);
    assert_eq!(read("times.txt").lines().count(), FRAMES);
    let camera = camera_from_toml(&read("camera.toml")).unwrap();
    assert_eq!((camera.width(), camera.height()), (320, 240));
    assert!(read("route.geojson").contains("LineString"));
    let (first, last) = (&truth[0], &truth[FRAMES - 1]);
    assert_eq!(first.feature_id, Some(2));
    assert!(first.feature_forward_m > last.feature_forward_m);
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_one_thread() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let (map, route) = (drive.map(), drive.route());
    let line = format!(
        "simulate --map {} --route {} --frames 3 --size 320x240 --conditions ideal --out {}",
        map.display(),
        route.display(),
        out.path().display()
    );
    let status =
        command().args(line.split_whitespace()).env("RAYON_NUM_THREADS", "1").output().unwrap().status;
    assert!(status.success());
    for name in ["frames/000002.jpg", "road_masks/000002.png"] {
        let (one, many) = (fs::read(out.path().join(name)), fs::read(drive.path().join(name)));
        assert_eq!(one.unwrap(), many.unwrap(), "{name}");
    }
    call_line(&format!("{line} --seed 2")).done();
    let other = fs::read(out.path().join("frames/000002.jpg")).unwrap();
    assert_ne!(other, fs::read(drive.path().join("frames/000002.jpg")).unwrap());
}

#[test]
fn a_world_is_written_as_its_owner_knows_it() {
    let (out, run) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let (drive, run) = (out.path().display(), run.path().display());
    let simulate = "simulate --world --seed 8 --size 160x120 --frames 12";
    let called = call_line(&format!("{simulate} --out {drive}")).done();
    let start_m = called.stderr.split("--start-m ").nth(1).unwrap().split_whitespace().next().unwrap();
    assert!((0.0..=30.0).contains(&start_m.parse::<f64>().unwrap()), "{start_m}");
    let inputs = format!("--camera {drive}/camera.toml --route {drive}/route.geojson --start-m {start_m}");
    let more = format!("--config {drive}/can.toml --truth {drive}/truth.jsonl --out {run}");
    call_line(&format!("run {out} {inputs} {more}", out = out.path().display())).done();
    let config = fs::read_to_string(format!("{run}/config.toml")).unwrap();
    let vehicle = fs::read_to_string(out.path().join("can.toml")).unwrap();
    let turning = vehicle.lines().find(|line| line.starts_with("turning_radius_m")).unwrap();
    assert!(config.contains(turning), "{config}");
    call_line(&format!("{simulate} --conditions wet --out {drive}")).refused(2, &["--world", "--conditions"]);
}

#[test]
fn a_distorting_lens_stands_in_the_calibration() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let (map, route) = (drive.map(), drive.route());
    let line = format!("simulate --map {} --route {}", map.display(), route.display());
    call_line(&format!(
        "{line} --frames 1 --size 160x120 --lens brown-conrady --out {}",
        out.path().display()
    ))
    .done();
    let camera = fs::read_to_string(out.path().join("camera.toml")).unwrap();
    assert!(camera.contains("brown-conrady") && camera.contains("-0.25"), "{camera}");
}

#[test]
fn a_made_up_road_is_seen_through_the_lens_that_is_asked_for() {
    let out = TempDir::new().unwrap();
    let camera = |lens: &str| {
        let line = "simulate --course country --conditions lane_continuous --frames 1 --size 160x120";
        call_line(&format!("{line} {lens} --out {}", out.path().display())).done();
        camera_from_toml(&fs::read_to_string(out.path().join("camera.toml")).unwrap()).unwrap()
    };
    let [pinhole, bent] = ["", "--lens brown-conrady"].map(camera);
    let (
        View::Calibrated { intrinsics, distortion, mount, .. },
        View::Calibrated { distortion: of_pinhole, .. },
    ) = (bent.view(), pinhole.view())
    else {
        panic!("{bent:?}")
    };
    assert!(matches!((distortion, of_pinhole), (Distortion::BrownConrady { .. }, Distortion::None)));
    // The windscreen camera's: 58 degrees across, 1.3 m above the road.
    assert!((intrinsics.fx - 0.902 * 160.0).abs() < 1e-6 && (mount.height_m - 1.3).abs() < 1e-6, "{bent:?}");
}

#[test]
fn a_made_up_road_needs_no_map() {
    let out = TempDir::new().unwrap();
    let line =
        "simulate --course country --length-m 150 --driving drifting --conditions lane_continuous --fps 2";
    call_line(&format!("{line} --size 160x120 --out {}", out.path().display())).done();
    let read = |name: &str| fs::read_to_string(out.path().join(name)).unwrap();
    let truth: Vec<TruthRecord> = from_json_lines(&read("truth.jsonl")).unwrap();
    assert!(truth.iter().all(|truth| truth.lane_left_px.len() > 20 && truth.lane_right_m.len() > 20));
    assert!((15..=20).contains(&truth.len()), "{} frames of 150 m at up to 20 m/s", truth.len());
    assert_eq!(read("crossings.jsonl").lines().count(), 0, "the first drift is farther on");
    assert!(
        (camera_from_toml(&read("camera.toml")).unwrap().width(), read("route.geojson").is_empty())
            == (160, false)
    );
    assert!(read("can.log").starts_with("(0.000000) can0 1A1#"));
    for wrong in [
        "--course country --length-m 1",
        "--course country --map town.osm",
        "--length-m 50",
        "--map town.osm",
    ] {
        let line = format!("simulate {wrong} --out {}", out.path().display());
        let status = command().args(line.split_whitespace()).output().unwrap().status;
        assert_eq!(status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn the_shortest_made_up_drive_is_driven_on_every_road() {
    for seed in 1..=6 {
        for course in ["highway", "country"] {
            let out = TempDir::new().unwrap();
            let line =
                format!("simulate --course {course} --seed {seed} --length-m 2 --frames 1 --size 160x120");
            call_line(&format!("{line} --out {}", out.path().display())).done();
        }
    }
}

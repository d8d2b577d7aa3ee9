//! Runs that cannot be looked at.

use std::fs;

use fingerpost_io::write_png;
use fingerpost_vision::picture::RgbImage;
use tempfile::TempDir;

use crate::program::call_line;

/// A frame of which nothing is known.
const BARE: &str = r#"{"frame": 0, "t_s": 0, "state": "no_route", "feature": null, "motion": null, "driving_line_m": [], "centreline": null, "lanes": null, "fix": null, "stage_ms": {}, "why": ""}"#;

/// A camera of pictures of 640 x 480 pixels.
const CAMERA: &str = "[image]\nwidth = 640\nheight = 480\n\n[intrinsics]\nfx = 500.0\nfy = 500.0\ncx = 319.5\ncy = 239.5\n\n\
    [mount]\nheight_m = 1.5\npitch_deg = 0.0\n";

#[test]
fn what_is_no_run_is_refused() {
    let folder = TempDir::new().unwrap();
    let run = folder.path().display();
    let look = format!("look {run} --port 0");
    call_line(&look).refused(1, &["no run, which has a frames.jsonl", "holds no picture"]);
    for option in ["--input", "--with", "--tuned"] {
        let leave_out = format!("leave {option} out");
        call_line(&format!("{look} {option} {run}")).refused(1, &["no run", &leave_out]);
    }
    let frames = folder.path().join("frames.jsonl");
    // What a killed run left of its first frame.
    for text in ["", "{\"frame\": 0"] {
        fs::write(&frames, text).unwrap();
        call_line(&look).refused(1, &["holds no frame", "fingerpost run"]);
    }
    fs::write(&frames, format!("{BARE}\n{{\"frame\": 1}}\n")).unwrap();
    call_line(&look).refused(1, &["frames.jsonl, line 2", "t_s"]);
    fs::write(&frames, format!("{BARE}\n")).unwrap();
    fs::write(folder.path().join("summary.json"), "{").unwrap();
    call_line(&look).refused(1, &["summary.json"]);
}

#[test]
fn pictures_and_a_camera_that_are_not_the_runs_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("frames.jsonl"), format!("{BARE}\n")).unwrap();
    fs::write(
        path("summary.json"),
        r#"{"frames": 1, "picture_px": [640, 360], "fps": 1, "stage_ms": {}, "features": [], "lost_frames": 0}"#,
    )
    .unwrap();
    fs::write(path("camera.toml"), CAMERA).unwrap();
    let look = format!("look {} --port 0", folder.path().display());
    let with = |option: &str, name: &str| call_line(&format!("{look} {option} {}", path(name).display()));
    with("--input", "frames.jsonl").refused(1, &["is no folder", "run.mcap"]);
    with("--input", "nowhere").refused(1, &["nowhere"]);
    with("--camera", "camera.toml").refused(1, &["640 x 360", "640 x 480"]);
    call_line(&format!("{look} --route route.geojson --start-m 3"))
        .refused(1, &["nothing is set up", "leave --start-m out"]);
    with("--with", "nowhere").refused(1, &["nowhere"]);
    fs::create_dir(path("other")).unwrap();
    let of_another_drive = BARE.replace("\"frame\": 0", "\"frame\": 7");
    fs::write(path("other/frames.jsonl"), format!("{of_another_drive}\n")).unwrap();
    with("--with", "other").refused(1, &["no frame in common", "one drive"]);
    fs::write(path("mine.toml"), "# Tried on the hill.\n[track]\ndetect_present = 0.7\n").unwrap();
    with("--save", "mine.toml").refused(1, &["mine.toml", "may be yours"]);
    fs::write(path("config.toml"), "# Written by fingerpost\n").unwrap();
    with("--save", "config.toml").refused(1, &["config.toml"]);
    with("--tuned", "nowhere").refused(1, &["front.json"]);
}

#[test]
fn a_camera_is_saved_over_nothing_that_may_be_the_users() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("drive")).unwrap();
    write_png(&path("drive/0.png"), &RgbImage::new(640, 480)).unwrap();
    fs::write(path("camera.toml"), CAMERA).unwrap();
    fs::write(path("mine.toml"), "# measured by hand").unwrap();
    let (drive, camera) = (path("drive"), path("camera.toml"));
    let look = format!("look {} --port 0", drive.display());
    call_line(&look).refused(1, &["brings no camera.toml", "--camera", "height_m"]);
    let look = format!("{look} --camera {}", camera.display());
    let saved_as = |name: &str| call_line(&format!("{look} --save {}", path(name).display()));
    saved_as("mine.toml").refused(1, &["mine.toml", "may be yours"]);
    saved_as("camera.toml").refused(1, &["camera.toml"]);
    fs::write(path("camera.toml"), CAMERA.replace("480", "300")).unwrap();
    saved_as("new.toml").refused(1, &["640 x 480", "640 x 300"]);
    assert!(!path("new.toml").exists());
}

#[test]
fn a_route_is_saved_over_nothing_that_may_be_the_users_and_begins_on_itself() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("drive")).unwrap();
    write_png(&path("drive/0.png"), &RgbImage::new(640, 480)).unwrap();
    fs::write(path("camera.toml"), CAMERA).unwrap();
    fs::write(path("route.geojson"), fingerpost_sim::TOWN_ROUTE).unwrap();
    fs::write(path("mine.geojson"), "{\"type\": \"FeatureCollection\", \"features\": []}").unwrap();
    let [drive, camera, route] = ["drive", "camera.toml", "route.geojson"].map(path);
    let (drive, camera, route) = (drive.display(), camera.display(), route.display());
    let look = format!("look {drive} --port 0 --camera {camera} --save {}", path("new.toml").display());
    let with = |options: &str| call_line(&format!("{look} --route {route} {options}"));
    for (name, word) in [("mine.geojson", "may be yours"), ("route.geojson", "route.geojson")] {
        with(&format!("--save-route {}", path(name).display())).refused(1, &[name, word]);
    }
    with(&format!("--save-route {}", path("new.toml").display())).refused(1, &["new.toml", "name two files"]);
    let new = path("new.geojson");
    with(&format!("--save-route {} --start-m 1e5", new.display()))
        .refused(1, &["--start-m 100000", "1028 m"]);
    call_line(&format!("{look} --map {route}")).refused(2, &["--route"]);
    assert!(!new.exists() && !path("new.toml").exists());
}

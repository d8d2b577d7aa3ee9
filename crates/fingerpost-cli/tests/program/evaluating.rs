//! A finished run against truth.

use std::fs;

use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, frames, summary};

#[test]
fn evaluation_gives_the_numbers_of_the_summary() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let truth = drive.truth();
    let truth = truth.display();
    call_line(&format!("{} --truth {truth}", drive.run_line(&drive.path(), out.path()))).done();
    let run = out.path().display();
    let of_run = serde_json::to_value(summary(out.path()).truth.unwrap()).unwrap();
    let printed = call_line(&format!("evaluate junctions {run} --truth {truth} --json")).done().stdout;
    let printed: serde_json::Value = serde_json::from_str(&printed).unwrap();
    for (key, value) in of_run.as_object().unwrap() {
        assert_eq!(&printed[key], value, "{key}");
    }
    let printed = call_line(&format!("evaluate motion {run} --truth {truth} --json")).done().stdout;
    let printed: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(printed["motion_error_pct"], of_run["motion_error_pct"]);
    assert!(printed["end_heading_error_deg"].as_f64().unwrap() < 20.0);
}

#[test]
fn a_truth_of_another_drive_is_refused_and_the_results_are_kept() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let truth = out.path().join("short.jsonl");
    let text = fs::read_to_string(drive.truth()).unwrap();
    fs::write(&truth, text.lines().take(5).map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    let run = out.path().join("run");
    let line = drive.run_line(&drive.path(), &run);
    call_line(&format!("{line} --frames 8 --truth {}", truth.display()))
        .refused(1, &["frame 5 of the run has no truth", "5 frames, 0 to 4"]);
    assert_eq!((frames(&run).len(), summary(&run).frames), (8, 8));
    call_line(&format!("evaluate motion {} --truth {}", out.path().display(), truth.display()))
        .refused(1, &["frames.jsonl"]);
}

#[test]
fn kerbs_are_compared_on_drives_that_have_them() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    call_line(&format!("evaluate kerbs {}", drive.path().display())).refused(1, &["no kerbs", "street"]);
    let street = out.path().join("street");
    let (map, route) = (drive.map(), drive.route());
    let (map, route) = (map.display(), route.display());
    let line = "--frames 3 --size 320x240 --conditions street --out";
    call_line(&format!("simulate --map {map} --route {route} {line} {}", street.display())).done();
    let printed = call_line(&format!("evaluate kerbs {} --json", street.display())).done().stdout;
    let printed: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert!(printed["all"]["kerbs"].as_u64().unwrap() > 10, "{printed}");
    assert_eq!(printed["drives"][0]["kerbs"], printed["all"]["kerbs"]);
}

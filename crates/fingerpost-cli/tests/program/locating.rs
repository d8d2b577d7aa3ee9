//! `locate`: motion logs in, fixes out.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use fingerpost_format::{FixLine, FixStatus, LocationSummary, from_json_lines};
use tempfile::TempDir;

use crate::program::{Called, call_line};

const TOWN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fingerpost-sim/assets/town.osm");

/// Ten seconds straight on at 10 m/s; GPS and truth stand beside the town's main road.
fn write_logs(folder: &Path) {
    let (mut motion, mut truth) =
        ("t_s,speed_mps,yaw_rate_rps\n".to_owned(), "t_s,lat,lon,heading_rad\n".to_owned());
    let mut gps = "<gpx version=\"1.1\" xmlns=\"http://www.topografix.com/GPX/1/1\"><trk><trkseg>".to_owned();
    for tenth in 0..100 {
        let t_s = 0.1 * f64::from(tenth);
        writeln!(motion, "{t_s:.1},10.0,0.0").unwrap();
        writeln!(truth, "{t_s:.1},47.21785,9.539682,1.5").unwrap();
        if tenth % 10 == 0 {
            write!(
                gps,
                "<trkpt lat=\"47.21785\" lon=\"9.539682\"><time>2024-05-01T10:00:{:02}Z</time></trkpt>",
                tenth / 10
            )
            .unwrap();
        }
    }
    gps.push_str("</trkseg></trk></gpx>");
    for (name, text) in [("motion.csv", motion), ("truth.csv", truth), ("track.gpx", gps)] {
        fs::write(folder.join(name), text).unwrap();
    }
}

fn locate(folder: &Path, more: &str, out: &str) -> Called {
    let at = folder.display();
    call_line(&format!("locate --map {TOWN} --motion {at}/motion.csv {more} --out {at}/{out} --json"))
}

#[test]
fn every_row_has_a_fix_and_the_same_log_gives_the_same_file() {
    let folder = TempDir::new().unwrap();
    write_logs(folder.path());
    let truth = format!("--truth {}/truth.csv", folder.path().display());
    let called = locate(folder.path(), &truth, "first").done();
    locate(folder.path(), "", "second").done();
    let [first, second] =
        ["first", "second"].map(|out| fs::read_to_string(folder.path().join(out).join("fix.jsonl")).unwrap());
    assert_eq!(first, second, "truth has no influence");
    let fixes: Vec<FixLine> = from_json_lines(&first).unwrap();
    assert_eq!(fixes.len(), 100);
    // A hundred metres straight on fit many roads.
    assert!(fixes.iter().all(|fix| fix.status == FixStatus::Ambiguous && fix.bound_m.is_none()));
    assert!(fixes.iter().all(|fix| fix.places.len() == 10 && fix.hypotheses >= 10));
    let summary: LocationSummary = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!((summary.rows, summary.statuses[&FixStatus::Ambiguous]), (100, 100));
    let scores = summary.truth.unwrap();
    assert!(scores.converged_m.is_none() && scores.bound_violations == 0);
    // Nothing of it is worth following.
    let read = |name: &str| fs::read_to_string(folder.path().join("first").join(name)).unwrap();
    let geojson: serde_json::Value = serde_json::from_str(&read("track.geojson")).unwrap();
    assert_eq!(geojson["features"].as_array().map(Vec::len), Some(0));
    assert!(read("track.gpx").contains("<trk>") && !read("track.gpx").contains("<trkpt"));
    assert_eq!((read("poses_kitti.txt").len(), read("poses_tum.txt").lines().count()), (0, 1));
    assert!(read("report.html").contains("Stanford diagram") && read("report.html").contains("ambiguous"));
    let without_truth = fs::read_to_string(folder.path().join("second/report.html")).unwrap();
    assert!(without_truth.contains("<svg") && !without_truth.contains("Stanford diagram"));
    // The folder is the program's own and may be written again.
    locate(folder.path(), "", "second").done();
}

#[test]
fn gps_narrows_it_down() {
    let folder = TempDir::new().unwrap();
    write_logs(folder.path());
    let called = locate(folder.path(), &format!("--gps {}/track.gpx", folder.path().display()), "out").done();
    let summary: LocationSummary = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!(summary.gps.unwrap().places, 10);
    let fixes: Vec<FixLine> =
        from_json_lines(&fs::read_to_string(folder.path().join("out/fix.jsonl")).unwrap()).unwrap();
    let distance_m = libm::hypot(fixes[20].lat - 47.21785, (fixes[20].lon - 9.539_682) * 0.68) * 111_000.0;
    assert!(distance_m < 60.0, "{distance_m}");
    assert_eq!(fixes.iter().filter(|fix| fix.gps.is_some()).count(), 10);
}

#[test]
fn logs_that_cannot_be_used_are_named_with_their_line() {
    let folder = TempDir::new().unwrap();
    write_logs(folder.path());
    let motion = folder.path().join("motion.csv");
    for (text, words) in [
        ("t_s,speed_mps\n0,1\n", ["motion.csv", "yaw_rate_rps"]),
        ("t_s,speed_mps,yaw_rate_rps\n0,1,0\n0.1,fast,0\n", ["line 3", "fast"]),
        ("t_s,speed_mps,yaw_rate_rps\n0,1,0\n0,1,0\n", ["line 3", "no later"]),
        ("t_s,speed_mps,yaw_rate_rps\n", ["motion.csv", "no line"]),
    ] {
        fs::write(&motion, text).unwrap();
        locate(folder.path(), "", "out").refused(1, &words);
        assert!(!folder.path().join("out").exists());
    }
}

/// A log that stutters: words between numbers, lines twice and late, speeds of no car, and five seconds in which nothing came. Every
/// fault is counted, and the lines that can be used have their fixes.
#[test]
fn faults_of_a_motion_log_are_counted_and_survived() {
    let folder = TempDir::new().unwrap();
    write_logs(folder.path());
    let mut motion = "t_s,speed_mps,yaw_rate_rps\n".to_owned();
    for tenth in 0..100 {
        let t_s = 0.1 * f64::from(tenth) + if tenth >= 60 { 5.0 } else { 0.0 };
        writeln!(motion, "{t_s:.1},{}.0,0.01", 5 + tenth % 3).unwrap();
        match tenth {
            10 | 20 => writeln!(motion, "{:.2},none,0.0", t_s + 0.05).unwrap(),
            30..33 => writeln!(motion, "{:.2},6.0,0.0", t_s - 1.0).unwrap(),
            40 => writeln!(motion, "{:.2},6e7,0.0", t_s + 0.05).unwrap(),
            _ => {}
        }
    }
    fs::write(folder.path().join("motion.csv"), motion).unwrap();
    let called = locate(folder.path(), "", "out").done();
    assert!(called.stderr.contains("5 lines are passed over") && called.stderr.contains("no car drives"));
    let summary: LocationSummary = serde_json::from_str(&called.stdout).unwrap();
    let faults = summary.motion;
    assert_eq!((faults.not_numbers, faults.not_later, faults.impossible, faults.gaps), (2, 3, 1, 1));
    assert!((faults.longest_gap_s - 5.1).abs() < 1e-9 && faults.longest_repeat_s == 0.0);
    let fixes: Vec<FixLine> =
        from_json_lines(&fs::read_to_string(folder.path().join("out/fix.jsonl")).unwrap()).unwrap();
    assert_eq!(fixes.len(), 100);
    let unseen: Vec<usize> = (0..100).filter(|&row| fixes[row].unseen_s.is_some()).collect();
    assert_eq!(unseen, [60]);
}

//! Runs on some of an input's frames, and on its pictures made smaller.

use std::fs;
use std::path::Path;

use fingerpost_format::{SamplingRecord, Summary};
use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::program::{Called, call_line, frames, summary};
use crate::video_stub::VideoStub;

/// A run on the drive, compared with its truth.
fn run(arguments: &str, out: &Path) -> Summary {
    let drive = Drive::get();
    let line = drive.run_line(&drive.path(), out);
    call_line(&format!("{line} --truth {} {arguments}", drive.truth().display())).done();
    summary(out)
}

fn junction_is_found(summary: &Summary, arguments: &str) {
    let truth = summary.truth.as_ref().unwrap();
    let found = (truth.features_total, truth.features_detected, truth.false_detections, truth.arrivals);
    assert_eq!(found, (1, 1, 0, 1), "{arguments}");
    assert!(truth.position_error_m.unwrap().p50 < 1.0, "{arguments}: {:?}", truth.position_error_m);
    assert!(truth.motion_error_pct.unwrap() < 5.0, "{arguments}: {:?}", truth.motion_error_pct);
}

#[test]
fn every_second_frame_keeps_its_number_and_time_and_is_held_against_its_truth() {
    for arguments in ["--every 2", "--rate 5"] {
        let out = TempDir::new().unwrap();
        let summary = run(arguments, out.path());
        let records = frames(out.path());
        assert_eq!(records.len(), FRAMES / 2, "{arguments}");
        for (record, number) in records.iter().zip((0..).step_by(2)) {
            assert_eq!(record.frame, number);
            assert!((record.t_s - 0.1 * number as f64).abs() < 1e-6);
        }
        let expected = SamplingRecord {
            picture_px: [320, 240],
            every: arguments.contains("every").then_some(2),
            rate_hz: arguments.contains("rate").then_some(5.0),
        };
        assert_eq!(summary.sampling, Some(expected));
        junction_is_found(&summary, arguments);
        let report = fs::read_to_string(out.path().join("report.html")).unwrap();
        assert!(report.contains("frames used"), "the report says so too");
    }
}

#[test]
fn smaller_pictures_show_the_same_junction_in_the_same_place() {
    let out = TempDir::new().unwrap();
    let summary = run("--width 240", out.path());
    assert_eq!(summary.picture_px, Some([320, 240]), "places in records are those of the input");
    let expected = SamplingRecord { picture_px: [240, 180], every: None, rate_hz: None };
    assert_eq!(summary.sampling, Some(expected));
    junction_is_found(&summary, "--width 240");
    assert!(frames(out.path())[3].stage_ms.contains_key("scale"));
}

#[test]
fn sampling_does_not_depend_on_threads() {
    let folder = TempDir::new().unwrap();
    let of = |threads| {
        let out = folder.path().join(format!("{threads}"));
        run(&format!("--width 200 --rate 4 --threads {threads}"), &out);
        let timeless = |mut record: fingerpost_format::FrameRecord| {
            record.stage_ms.clear();
            record
        };
        frames(&out).into_iter().map(timeless).collect::<Vec<_>>()
    };
    assert_eq!(of(1), of(4));
}

#[test]
fn a_video_is_sampled_like_pictures() {
    for (arguments, expected) in [("--every 4", [0, 4, 8, 12]), ("--rate 2", [0, 5, 10, 15])] {
        let (stub, out) = (VideoStub::new(&"cat $PICTURE\n".repeat(16)), TempDir::new().unwrap());
        let called = stub.run(out.path()).args(arguments.split(' ')).output().unwrap();
        Called::from(called).done();
        let numbers: Vec<u64> = frames(out.path()).iter().map(|record| record.frame).collect();
        assert_eq!(numbers, expected, "{arguments}");
    }
    // What is missing is missing of the frames that are used.
    let probe = r#"echo '{"streams":[{"avg_frame_rate":"10/1","nb_frames":"40"}]}'"#;
    let (stub, out) = (VideoStub::described(probe, &"cat $PICTURE\n".repeat(16)), TempDir::new().unwrap());
    let called = stub.run(out.path()).args(["--every", "4"]).output().unwrap();
    Called::from(called).refused(1, &["6 of 10 frames"]);
}

#[test]
fn choices_that_cannot_be_are_refused() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let line = drive.run_line(&drive.path(), out.path());
    call_line(&format!("{line} --width 641")).refused(1, &["--width 641", "320 pixels"]);
    call_line(&format!("{line} --width 20")).refused(2, &["--width"]);
    call_line(&format!("{line} --every 0")).refused(2, &["--every"]);
    call_line(&format!("{line} --rate nan")).refused(2, &["0.01 to 1000"]);
    call_line(&format!("{line} --rate 5 --every 2")).refused(2, &["--rate", "--every"]);
    // A picture of another size than the calibration's is named with the calibration's own size.
    let camera = out.path().join("camera.toml");
    let text = fs::read_to_string(drive.camera()).unwrap();
    fs::write(&camera, text.replace("width = 320", "width = 330")).unwrap();
    let line = format!("run {} --camera {}", drive.path().display(), camera.display());
    let to = out.path().join("run");
    call_line(&format!("{line} --width 200 --out {}", to.display())).refused(1, &["320 x 240", "330 x 240"]);
}

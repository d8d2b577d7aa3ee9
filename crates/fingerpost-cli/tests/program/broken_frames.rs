//! Frames that cannot be used, among ones that can.

use std::fs;

use fingerpost_format::TrackState;
use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, frames, summary};

#[test]
fn a_broken_frame_is_reported_and_passed_over() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let pictures = drive.pictures(12);
    let torn = pictures.path().join("000005.jpg");
    let bytes = fs::read(&torn).unwrap();
    fs::write(&torn, &bytes[..bytes.len() / 2]).unwrap();
    fs::write(pictures.path().join("000008.jpg"), "no picture").unwrap();

    let line = drive.run_line(pictures.path(), out.path());
    let called = call_line(&format!("{line} --max-broken-pct 20")).done();
    for words in ["frame 5 is passed over", "000005.jpg is damaged", "frame 8 is passed over", "000008.jpg"] {
        assert!(called.stderr.contains(words), "{words}: {}", called.stderr);
    }
    let records = frames(out.path());
    assert_eq!(records.len(), 12);
    let broken: Vec<u64> = records.iter().filter(|r| r.error.is_some()).map(|r| r.frame).collect();
    assert_eq!(broken, [5, 8]);
    assert_eq!((records[5].state, &records[5].feature), (TrackState::Searching, &None));
    assert!(records[5].error.as_ref().unwrap().contains("000005.jpg"));
    assert!(records[6].motion.unwrap().forward_m > 1.0, "two steps in one");
    assert_eq!(summary(out.path()).broken_frames, 2);
}

#[test]
fn a_later_frame_of_another_size_is_a_broken_one() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let (pictures, other) = (drive.pictures(4), TempDir::new().unwrap());
    let (map, route) = (drive.map(), drive.route());
    let line = format!("--map {} --route {}", map.display(), route.display());
    call_line(&format!("simulate {line} --frames 1 --size 64x64 --out {}", other.path().display())).done();
    fs::copy(other.path().join("frames/000000.jpg"), pictures.path().join("000002.jpg")).unwrap();

    let line = drive.run_line(pictures.path(), out.path());
    let called = call_line(&format!("{line} --max-broken-pct 25")).done();
    assert!(called.stderr.contains("64 x 64") && called.stderr.contains("320 x 240"), "{}", called.stderr);
    let broken: Vec<bool> = frames(out.path()).iter().map(|record| record.error.is_some()).collect();
    assert_eq!(broken, [false, false, true, false]);
}

#[test]
fn a_first_frame_of_another_size_ends_the_run() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let camera = folder.path().join("camera.toml");
    let text = fs::read_to_string(drive.camera()).unwrap();
    fs::write(&camera, text.replace("width = 320", "width = 400")).unwrap();
    let out = folder.path().join("run");
    let line =
        format!("run {} --camera {} --out {}", drive.path().display(), camera.display(), out.display());
    call_line(&line).refused(1, &["320 x 240", "400 x 240", "give the calibration"]);
    assert_eq!(frames(&out).len(), 0);
}

#[test]
fn a_drive_of_broken_frames_alone_fails() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let pictures = TempDir::new().unwrap();
    for index in 0..3 {
        fs::write(pictures.path().join(format!("{index}.png")), "no picture").unwrap();
    }
    call_line(&drive.run_line(pictures.path(), out.path())).refused(1, &["none of the 3 frames"]);
    assert_eq!(frames(out.path()).len(), 3);
    assert_eq!(summary(out.path()).broken_frames, 3);
}

#[test]
fn more_broken_frames_than_the_limit_end_in_an_error_with_all_results() {
    let drive = Drive::get();
    const FRAMES: usize = 20;
    for pattern in 0..6_usize {
        // Every second one, none, the last ones, one, the first ones but one, two.
        let is_broken = |frame: usize| match pattern {
            0 => frame % 2 == 1,
            1 => false,
            2 => frame >= 15,
            3 => frame == 7,
            4 => (1..15).contains(&frame),
            _ => frame == 3 || frame == 19,
        };
        let (pictures, out) = (drive.pictures(FRAMES), TempDir::new().unwrap());
        let broken: Vec<usize> = (0..FRAMES).filter(|frame| is_broken(*frame)).collect();
        for frame in &broken {
            fs::write(pictures.path().join(format!("{frame:06}.jpg")), "no picture").unwrap();
        }
        let called = call_line(&drive.run_line(pictures.path(), out.path()));
        if 10 * broken.len() > FRAMES {
            let count = format!("{} of {FRAMES} frames", broken.len());
            called.refused(1, &[&count, "more than 10 %", "--max-broken-pct"]);
        } else {
            assert_eq!(called.code, Some(0), "{}", called.stderr);
        }
        let found: Vec<usize> =
            frames(out.path()).iter().filter(|r| r.error.is_some()).map(|r| r.frame as usize).collect();
        assert_eq!(found, broken);
        let summary = summary(out.path());
        assert_eq!((summary.frames, summary.broken_frames), (FRAMES as u64, broken.len() as u64));
        assert!(!summary.interrupted && out.path().join("report.html").exists());
    }
}

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

    let called = call_line(&drive.run_line(pictures.path(), out.path())).done();
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

    let called = call_line(&drive.run_line(pictures.path(), out.path())).done();
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

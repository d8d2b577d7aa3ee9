//! Frames that cannot be used, among ones that can.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use fingerpost_format::TrackState;
use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{Called, call_line, frames, summary};
use crate::video_stub::VideoStub;

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
fn a_first_frame_of_another_size_is_refused_before_a_folder_is_made() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let camera = folder.path().join("camera.toml");
    let text = fs::read_to_string(drive.camera()).unwrap();
    fs::write(&camera, text.replace("width = 320", "width = 400")).unwrap();
    let out = folder.path().join("run");
    let line =
        format!("run {} --camera {} --out {}", drive.path().display(), camera.display(), out.display());
    call_line(&line).refused(1, &["320 x 240", "400 x 240", "give the calibration"]);
    assert!(!out.exists());
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

/// Numbers below `limit` that look drawn by lot and are the same in every run (SplitMix64).
fn lots(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |limit| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % limit
    }
}

/// Breaks a picture in a way drawn by lot; what is left of it is unreadable or of another size.
fn break_picture(path: &Path, draw: &mut impl FnMut(u64) -> u64) {
    let bytes = fs::read(path).unwrap();
    match draw(4) {
        0 => fs::write(path, "no picture").unwrap(),
        1 => fs::write(path, "").unwrap(),
        // Behind the headers, and before the last rows.
        2 => fs::write(path, &bytes[..bytes.len() / 4 + draw(bytes.len() as u64 / 2) as usize]).unwrap(),
        _ => fs::write(path, &bytes[bytes.len() / 2..]).unwrap(),
    }
}

#[test]
fn the_exit_code_follows_from_the_share_of_broken_frames() {
    let drive = Drive::get();
    const FRAMES: u64 = 20;
    let mut codes = BTreeSet::new();
    for seed in 0..16 {
        let mut draw = lots(seed);
        // Few and many, and about as many as the limit.
        let (of_hundred, limit_pct) =
            ([5, 10, 40, 90][draw(4) as usize], [0, 10, 10, 45, 100][draw(5) as usize]);
        let (pictures, out) = (drive.pictures(FRAMES as usize), TempDir::new().unwrap());
        let (mut left, mut broken) = (0, Vec::new());
        for frame in 0..FRAMES {
            let path = pictures.path().join(format!("{frame:06}.jpg"));
            if frame > 0 && draw(100) < 5 {
                // Nobody knows of a picture that was never taken.
                fs::remove_file(&path).unwrap();
                continue;
            }
            // One is whole, because a drive of none is another matter.
            if frame > 0 && draw(100) < of_hundred {
                break_picture(&path, &mut draw);
                broken.push(left);
            }
            left += 1;
        }
        let line = drive.run_line(pictures.path(), out.path());
        let called = call_line(&format!("{line} --max-broken-pct {limit_pct}"));
        if 100 * broken.len() as u64 > left * limit_pct {
            let count = format!("{} of {left} frames", broken.len());
            called.refused(1, &[&count, &format!("more than {limit_pct} %"), "--max-broken-pct"]);
        } else {
            assert_eq!(called.code, Some(0), "{seed}: {}", called.stderr);
        }
        codes.insert(called.code);
        let records = frames(out.path());
        let found: Vec<u64> = records.iter().filter(|r| r.error.is_some()).map(|r| r.frame).collect();
        assert_eq!(found, broken, "{seed}");
        let summary = summary(out.path());
        assert_eq!((summary.frames, summary.broken_frames), (left, broken.len() as u64), "{seed}");
        assert!(!summary.interrupted && out.path().join("report.html").exists());
    }
    assert_eq!(codes.len(), 2, "the lots must give good ends and bad ones: {codes:?}");
}

/// What ffmpeg says of a frame.
fn frame_line(number: u64, size: &str) -> String {
    format!(
        "echo '[Parsed_showinfo_2 @ 0x5] [info] n:{number:4} pts: 0 fmt:rgb24 sar:1/1 s:{size} i:P' >&2; cat $PICTURE"
    )
}

#[test]
fn damaged_frames_count_like_broken_ones() {
    for (seed, limit_pct) in (0..6).zip([0, 10, 30].into_iter().cycle()) {
        let (mut draw, mut play, mut damaged) = (lots(seed), Vec::new(), 0);
        for number in 0..12 {
            if draw(100) < 15 {
                // Said more than once of one frame, it is one.
                let say = "echo '[warning] drive.mp4: corrupt decoded frame in stream 0' >&2".to_owned();
                play.extend(std::iter::repeat_n(say, 1 + draw(2) as usize));
                damaged += 1;
            }
            play.push(frame_line(number, "320x240"));
        }
        let (stub, out) = (VideoStub::new(&play.join("\n")), TempDir::new().unwrap());
        let mut run = stub.run(out.path());
        let called = Called::from(run.args(["--max-broken-pct", &limit_pct.to_string()]).output().unwrap());
        let expected = i32::from(100 * damaged > 12 * limit_pct);
        assert_eq!(called.code, Some(expected), "{seed}: {}", called.stderr);
        let said = format!("{damaged} of 12 frames");
        assert_eq!(called.stderr.contains(&said), damaged > 0, "{seed}: {}", called.stderr);
        let summary = summary(out.path());
        assert_eq!((summary.frames, summary.broken_frames, summary.damaged_frames), (12, 0, damaged));
    }
}

#[test]
fn a_stream_that_changes_its_size_ends_there_with_an_error() {
    for (before, threads) in [(1, "1"), (5, "2"), (9, "1")] {
        let lines = (0..before).map(|number| frame_line(number, "320x240"));
        // The filters are set up anew and count from zero; the pictures are scaled to the first size.
        let lines = lines.chain((0..20).map(|number| frame_line(number, "640x480")));
        let play = lines.collect::<Vec<_>>().join("\n");
        let (stub, out) = (VideoStub::new(&play), TempDir::new().unwrap());
        let called = Called::from(stub.run(out.path()).args(["--threads", threads]).output().unwrap());
        let place = format!("changes at frame {before} from 320 x 240 (rgb24) to 640 x 480 (rgb24)");
        called.refused(1, &[&place, "results so far are in"]);
        let summary = summary(out.path());
        assert_eq!((summary.frames, summary.interrupted), (before, true));
        assert!(summary.input_broke_off.unwrap().contains(&place));
        assert_eq!(frames(out.path()).len() as u64, before);
    }
}

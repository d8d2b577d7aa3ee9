//! Cameras and streams, which do not wait: a stand-in for ffmpeg gives pictures faster than any run uses them.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::program::{Called, frames, summary};
use crate::video_stub::VideoStub;

/// Pictures that the stand-in gives.
const PICTURES: u64 = 400;

/// Gives the pictures as fast as it can, fifty of them for a second of the camera's clock, which does not begin at zero.
fn camera() -> VideoStub {
    let line = |number: u64| {
        let stamp_us = 7_000_000 + 20_000 * number;
        format!(
            "echo '[Parsed_showinfo_0 @ 0x5] [info] n:{number:4} pts:{stamp_us} pts_time:7 fmt:rgb24 s:320x240' >&2\ncat $PICTURE"
        )
    };
    VideoStub::new(&(0..PICTURES).map(line).collect::<Vec<_>>().join("\n"))
}

#[test]
fn a_camera_that_is_faster_than_the_method_loses_frames_that_are_counted() {
    for threads in [&["--threads", "1"][..], &[]] {
        let (stub, out) = (camera(), TempDir::new().unwrap());
        let called = stub.run_on(Path::new("rtsp://camera/1"), out.path()).args(threads).output().unwrap();
        let called = Called::from(called).done();
        let (records, summary) = (frames(out.path()), summary(out.path()));
        assert!(summary.dropped_frames > 0, "{}", called.stderr);
        assert_eq!(records.len() as u64 + summary.dropped_frames, PICTURES);
        let said = format!("{} frames of rtsp://camera/1 came faster", summary.dropped_frames);
        assert!(called.stderr.contains(&said), "{}", called.stderr);
        // The latest is used, however late the method is.
        assert_eq!(records.last().unwrap().frame, PICTURES - 1);
        assert!(records.windows(2).all(|pair| pair[0].frame < pair[1].frame));
        for record in &records {
            let taken_s = 0.02 * record.frame as f64;
            assert!((record.t_s - taken_s).abs() < 1e-6, "frame {} at {} s", record.frame, record.t_s);
        }
    }
}

#[test]
fn a_rate_given_of_what_is_under_way_is_refused() {
    for (input, live) in [("rtsp://camera/1", &[][..]), ("http://camera/mjpeg", &["--live"])] {
        let (stub, out) = (camera(), TempDir::new().unwrap());
        let mut run = stub.run_on(Path::new(input), out.path());
        let called = Called::from(run.args(["--fps", "25"]).args(live).output().unwrap());
        called.refused(1, &[input, "is under way", "--fps"]);
    }
}

#[test]
fn frames_that_nobody_wants_are_not_counted_as_lost() {
    let (stub, out) = (camera(), TempDir::new().unwrap());
    let mut run = stub.run_on(Path::new("rtsp://camera/1"), out.path());
    Called::from(run.args(["--rate", "2"]).output().unwrap()).done();
    let (records, dropped) = (frames(out.path()), summary(out.path()).dropped_frames);
    // Two a second of eight seconds.
    assert_eq!(records.len() as u64 + dropped, 16);
    assert!(records.iter().all(|record| record.frame % 25 == 0));
}

#[test]
fn a_recording_loses_nothing() {
    let (stub, out) = (camera(), TempDir::new().unwrap());
    Called::from(stub.run(out.path()).output().unwrap()).done();
    assert_eq!(frames(out.path()).len() as u64, PICTURES);
    assert_eq!(summary(out.path()).dropped_frames, 0);
    // Unless it is said to be none.
    let (stub, out) = (camera(), TempDir::new().unwrap());
    Called::from(stub.run(out.path()).arg("--live").output().unwrap()).done();
    let (records, dropped) = (frames(out.path()), summary(out.path()).dropped_frames);
    assert!(dropped > 0 && records.len() as u64 + dropped == PICTURES, "{dropped}");
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn a_cameras_password_is_in_no_message_and_no_file() {
    let is_shown = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        text.contains("s3cret") || text.contains("guard")
    };
    let refuses = r#"for word in "$@"; do echo "$word: Connection refused" >&2; done; exit 1"#;
    let answers = r#"echo '{"streams":[{"avg_frame_rate":"10/1","r_frame_rate":"10/1"}]}'"#;
    for address in [
        "rtsp://guard:s3cret@camera/1",
        "rtsp://guard:a/s3cret@camera/1",
        "rtsp://camera/1?user=guard&password=s3cret",
    ] {
        let address = Path::new(address);
        for (stub, has_report) in [
            (VideoStub::described(refuses, ""), false),
            (VideoStub::described(answers, refuses), true),
            (camera(), true),
        ] {
            let out = TempDir::new().unwrap();
            let called = Called::from(stub.run_on(address, out.path()).arg("-vv").output().unwrap());
            assert!(called.stderr.contains("rtsp://camera/1"), "{}", called.stderr);
            assert!(!is_shown(called.stderr.as_bytes()), "{}", called.stderr);
            let written = files(out.path());
            assert_eq!(written.iter().any(|path| path.ends_with("report.html")), has_report, "{written:?}");
            for path in written {
                assert!(!is_shown(&fs::read(&path).unwrap()), "{}", path.display());
            }
        }
        // The parser of the command line repeats what it refuses.
        let called = Called::from(camera().run_on(address, Path::new("out")).arg(address).output().unwrap());
        assert!(
            called.stderr.contains("rtsp://camera/1") && !is_shown(called.stderr.as_bytes()),
            "{}",
            called.stderr
        );
    }
    // Without quotes a shell makes several arguments of one.
    let split = Path::new("rtsp://guard:a/ s3cret@camera/1");
    let called = Called::from(camera().run_on(split, Path::new("out")).output().unwrap());
    assert!(called.stderr.contains("unexpected argument 'hidden'"), "{}", called.stderr);
    assert!(!is_shown(called.stderr.as_bytes()), "{}", called.stderr);
}

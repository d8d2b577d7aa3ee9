//! Runs that end before their input does.

use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{Called, command, frames, summary};
use crate::video_stub::VideoStub;

#[test]
fn a_video_that_breaks_off_leaves_a_finished_run_folder() {
    let stub = VideoStub::new("cat $PICTURE $PICTURE $PICTURE; echo 'Invalid data found' >&2; exit 1");
    for threads in ["1", "2"] {
        let out = TempDir::new().unwrap();
        let called = Called::from(stub.run(out.path()).args(["--threads", threads]).output().unwrap());
        called.refused(1, &["breaks off after 3 frames", "Invalid data found", "results so far are in"]);
        assert_eq!(frames(out.path()).len(), 3);
        let summary = summary(out.path());
        assert_eq!((summary.frames, summary.interrupted), (3, true));
    }
}

#[test]
fn a_video_that_breaks_off_near_its_end_is_a_drive() {
    let stub = VideoStub::new(
        "for i in 1 2 3 4 5 6 7 8 9 10 11 12; do cat $PICTURE; done; echo 'Invalid data found' >&2; exit 1",
    );
    let out = TempDir::new().unwrap();
    let called = Called::from(stub.run(out.path()).output().unwrap()).done();
    assert!(called.stderr.contains("breaks off after 12 frames"), "{}", called.stderr);
    let written = summary(out.path());
    assert_eq!((written.frames, written.broken_frames, written.interrupted), (12, 0, false));
    assert!(written.input_broke_off.unwrap().contains("Invalid data found"));
    let strict = Called::from(stub.run(out.path()).args(["--max-broken-pct", "7"]).output().unwrap());
    strict.refused(1, &["1 of 13 frames", "more than 7 %", "breaks off after 12 frames"]);
    assert!(summary(out.path()).interrupted);
}

#[test]
fn a_video_of_whole_frames_is_a_complete_run() {
    let stub = VideoStub::new("cat $PICTURE $PICTURE $PICTURE");
    let out = TempDir::new().unwrap();
    Called::from(stub.run(out.path()).output().unwrap()).done();
    let summary = summary(out.path());
    assert_eq!((summary.frames, summary.interrupted), (3, false));
    assert!(frames(out.path())[2].motion.unwrap().forward_m.abs() < 0.01, "no motion in, no motion out");
}

#[test]
fn an_interrupt_leaves_a_finished_run_folder() {
    let stub = VideoStub::new("while cat $PICTURE; do :; done");
    let out = TempDir::new().unwrap();
    let child = stub.run(out.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let patience = Instant::now();
    let lines = || fs::read_to_string(out.path().join("frames.jsonl")).unwrap_or_default().lines().count();
    while lines() < 5 {
        assert!(patience.elapsed() < Duration::from_secs(60), "the run does not get going");
        sleep(Duration::from_millis(20));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let called = Called::from(child.wait_with_output().unwrap());
    called.refused(1, &["interrupted after", "results so far are in"]);
    let summary = summary(out.path());
    assert!(summary.interrupted);
    assert_eq!(summary.frames, frames(out.path()).len() as u64);
}

/// Starts a command, sends it a signal once `is_begun`, and gives what came of it.
fn signalled(line: &str, signal: &str, is_begun: impl Fn() -> bool) -> Called {
    let mut child = command()
        .args(line.split_whitespace())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let patience = Instant::now();
    while !is_begun() {
        assert!(child.try_wait().unwrap().is_none(), "{line} has ended");
        assert!(patience.elapsed() < Duration::from_secs(60), "{line} does not get going");
        sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    Called::from(child.wait_with_output().unwrap())
}

#[test]
fn signals_leave_whole_what_commands_have_written_so_far() {
    let folder = TempDir::new().unwrap();
    // A KITTI sequence of the same picture a thousand times.
    let (sequence, drive) = (folder.path().join("00"), Drive::get());
    fs::create_dir_all(sequence.join("image_2")).unwrap();
    let mut times = String::new();
    for i in 0..1000 {
        symlink(drive.path().join("frames/000000.jpg"), sequence.join(format!("image_2/{i:06}.jpg")))
            .unwrap();
        times += &format!("{}\n", 0.1 * f64::from(i));
    }
    fs::write(sequence.join("times.txt"), times).unwrap();
    fs::write(sequence.join("calib.txt"), "P2: 210 0 159.5 44 0 210 119.5 0.2 0 0 1 0.003\n").unwrap();
    for (name, line) in [
        ("simulated", "simulate --course highway --size 640x480 --length-m 5000".to_owned()),
        ("converted", format!("convert kitti {}", sequence.display())),
    ] {
        for signal in ["-TERM", "-INT", "-HUP"] {
            let out = folder.path().join(name);
            let first = out.join("frames/000003.jpg");
            let _ = fs::remove_file(&first);
            let called = signalled(&format!("{line} --out {}", out.display()), signal, || first.exists());
            called.refused(1, &["interrupted after", "frames; they are in"]);
            let times = fs::read_to_string(out.join("times.txt")).unwrap().lines().count();
            let frames = fs::read_dir(out.join("frames")).unwrap().count();
            assert!(
                times == frames && (4..1000).contains(&frames),
                "{name} {signal}: {times} times of {frames}"
            );
            assert!(out.join("camera.toml").exists() && !out.join(".fingerpost.lock").exists());
        }
    }
}

#[test]
fn a_signal_before_the_first_result_ends_a_command_with_a_message() {
    let folder = TempDir::new().unwrap();
    let (pipe, drive) = (folder.path().join("pipe"), Drive::get());
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (map, camera) = (drive.map(), drive.camera());
    let (pipe, map) = (pipe.display(), map.display());
    // Each reads a pipe that nobody writes.
    for line in [
        format!("convert mcap {pipe} --height-m 1.4"),
        format!("simulate --map {map} --route {pipe}"),
        format!("run {} --camera {} --route {pipe}", drive.path().display(), camera.display()),
        format!("locate --map {map} --motion {pipe}"),
    ] {
        let out = folder.path().join("out");
        let mut child = command()
            .args(line.split_whitespace())
            .args(["--out", &out.display().to_string()])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Its thread for signals is there.
        let tasks = format!("/proc/{}/task", child.id());
        let names = || {
            let tasks = fs::read_dir(&tasks).into_iter().flatten().flatten();
            tasks.map(|task| fs::read_to_string(task.path().join("comm")).unwrap_or_default())
        };
        let patience = Instant::now();
        while !names().any(|name| name.trim() == "signals") {
            assert!(patience.elapsed() < Duration::from_secs(60), "{line}");
            assert!(child.try_wait().unwrap().is_none(), "{line} has ended");
            sleep(Duration::from_millis(5));
        }
        assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
        let called = Called::from(child.wait_with_output().unwrap());
        called.refused(1, &["interrupted before the first result; nothing was written"]);
        assert!(!out.exists(), "{line}");
    }
}

/// A limit on the size of files stops writing as a full disk does, at a place that the test chooses.
#[test]
fn a_disk_that_fills_up_keeps_the_frames_that_fit() {
    const BLOCKS_OF_512_BYTES: usize = 48;
    for threads in [1, 8] {
        let (drive, out) = (Drive::get(), TempDir::new().unwrap());
        let run = drive.run_line(&drive.path(), out.path());
        let program = env!("CARGO_BIN_EXE_fingerpost");
        let limit = format!("trap '' XFSZ; ulimit -f {BLOCKS_OF_512_BYTES}");
        let script = format!("{limit}; exec {program} {run} --threads {threads} --no-recording");
        let called = Called::from(Command::new("sh").args(["-c", &script]).output().unwrap());
        called.refused(1, &["frames.jsonl cannot be written", "results so far are in"]);
        let count = frames(out.path()).len();
        assert!((5..60).contains(&count), "{count} frames in 24 kB");
    }
}

#[test]
fn a_disk_that_fills_up_keeps_the_records_of_a_recorded_run() {
    const BLOCKS_OF_512_BYTES: usize = 900;
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let run = drive.run_line(&drive.path(), out.path());
    let program = env!("CARGO_BIN_EXE_fingerpost");
    let script = format!("trap '' XFSZ; ulimit -f {BLOCKS_OF_512_BYTES}; exec {program} {run}");
    let called = Called::from(Command::new("sh").args(["-c", &script]).output().unwrap());
    called.refused(1, &["run.mcap", "the recording cannot be written", "results so far are in"]);
    let (count, summary) = (frames(out.path()).len(), summary(out.path()));
    assert!(count > 0 && summary.interrupted && summary.frames == count as u64);
}

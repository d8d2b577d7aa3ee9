//! `run.mcap`: what viewers get of a run.

use std::collections::BTreeMap;
use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use mcap::MessageStream;
use mcap::read::Options;
use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::program::{call_line, command, frames};

#[test]
fn a_run_is_recorded_frame_by_frame() {
    let drive = Drive::get();
    let out = TempDir::new().unwrap();
    call_line(&format!("{} --map {}", drive.run_line(&drive.path(), out.path()), drive.map().display()))
        .done();
    let bytes = fs::read(out.path().join("run.mcap")).unwrap();
    let mut counts = BTreeMap::new();
    let records = frames(out.path());
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        *counts.entry(message.channel.topic.clone()).or_insert(0) += 1;
        if message.channel.topic == "/record" {
            let record: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
            let line = serde_json::to_value(&records[message.sequence as usize]).unwrap();
            assert_eq!(record, line);
        }
    }
    for topic in [
        "/camera/image",
        "/camera/calibration",
        "/camera/annotations",
        "/ground_view/image",
        "/road_surface",
        "/feature",
        "/driving_line",
        "/centreline",
        "/lanes",
        "/odometry",
        "/tf",
        "/fix",
        "/record",
    ] {
        assert_eq!(counts.get(topic), Some(&FRAMES), "{topic}");
    }
    assert_eq!(counts.get("/route"), Some(&1));
    // Searching, tracking, arrived and the camera's state at the least.
    assert!(counts["/log"] >= 4 && counts["/feature/masks"] > FRAMES / 4, "{counts:?}");
}

#[test]
fn a_recording_can_be_left_out_and_the_results_are_the_same() {
    let drive = Drive::get();
    let out = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let line = |out: &TempDir| drive.run_line(&drive.path(), out.path());
    call_line(&line(&out[0])).done();
    call_line(&format!("{} --no-recording", line(&out[1]))).done();
    assert!(out[0].path().join("run.mcap").exists() && !out[1].path().join("run.mcap").exists());
    let [with, without] = out.each_ref().map(|out| {
        let mut records = frames(out.path());
        records.iter_mut().for_each(|record| record.stage_ms.clear());
        records
    });
    assert_eq!(with, without);
}

#[test]
fn a_killed_run_leaves_a_recording_to_within_a_second() {
    let drive = Drive::get();
    for kill_after in [1, 6, 11, 18, 25, 33, 41, 52, 63, 71] {
        let out = TempDir::new().unwrap();
        let mut arguments = command();
        let line = drive.run_line(&drive.path(), out.path());
        arguments.args(line.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = arguments.spawn().unwrap();
        let patience = Instant::now();
        let written =
            || fs::read_to_string(out.path().join("frames.jsonl")).unwrap_or_default().lines().count();
        while written() < kill_after && patience.elapsed() < Duration::from_secs(60) {
            sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let records = frames(out.path());
        let last_s = records.last().unwrap().t_s;
        let bytes = fs::read(out.path().join("run.mcap")).unwrap();
        let stream = MessageStream::new_with_options(&bytes, Options::IgnoreEndMagic.into()).unwrap();
        let kept = stream.map_while(Result::ok).filter(|message| message.channel.topic == "/record").last();
        let kept_s = kept.map_or(0.0, |message| message.log_time as f64 / 1e9);
        assert!(last_s - kept_s <= 1.0, "{last_s} s were run and {kept_s} s are in the recording");
    }
}

//! `run.mcap`: what viewers get of a run.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use fingerpost_format::{FrameRecord, from_json_lines};
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
        // What is killed in the middle of a line leaves a part of it.
        let written = fs::read_to_string(out.path().join("frames.jsonl")).unwrap();
        let whole_lines = &written[..written.rfind('\n').unwrap() + 1];
        let records: Vec<FrameRecord> = from_json_lines(whole_lines).unwrap();
        let last_s = records.last().unwrap().t_s;
        let bytes = fs::read(out.path().join("run.mcap")).unwrap();
        let stream = MessageStream::new_with_options(&bytes, Options::IgnoreEndMagic.into()).unwrap();
        let kept = stream.map_while(Result::ok).filter(|message| message.channel.topic == "/record").last();
        let kept_s = kept.map_or(0.0, |message| message.log_time as f64 / 1e9);
        assert!(last_s - kept_s <= 1.0, "{last_s} s were run and {kept_s} s are in the recording");
    }
}

/// A recording's messages, each with its topic, number and times, without what the clock measured.
fn timeless_messages(recording: &Path) -> Vec<(String, u32, [u64; 2], Vec<u8>)> {
    let bytes = fs::read(recording).unwrap();
    let messages = MessageStream::new(&bytes).unwrap().map(|message| {
        let message = message.unwrap();
        let data = match message.channel.topic.as_str() {
            "/record" => {
                let mut record: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
                assert!(record.as_object_mut().unwrap().remove("stage_ms").is_some());
                serde_json::to_vec(&record).unwrap()
            }
            _ => message.data.to_vec(),
        };
        (message.channel.topic.clone(), message.sequence, [message.log_time, message.publish_time], data)
    });
    messages.collect()
}

/// A report without the rate and the chart of stage times.
fn timeless_report(report: &Path) -> String {
    let text = fs::read_to_string(report).unwrap();
    let (before, rest) = text.split_once("<dt>frames worked through a second</dt><dd>").unwrap();
    let (between, rest) = rest.split_once("aria-label=\"stage times\">").unwrap();
    let without_rate = between.split_once("</dd>").unwrap().1;
    let timeless = format!("{before}{without_rate}{}", rest.split_once("</svg>").unwrap().1);
    // The command line names the threads; no result may depend on them, which is what the comparison of all else holds.
    timeless.replace("--threads 8", "--threads 1")
}

#[test]
fn two_runs_on_the_same_input_differ_in_measured_times_alone() {
    let drive = Drive::get();
    let out = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    for (out, threads) in out.iter().zip(["1", "8"]) {
        let line = drive.run_line(&drive.path(), out.path());
        call_line(&format!("{line} --frames 12 --threads {threads}")).done();
    }
    let messages = out.each_ref().map(|out| timeless_messages(&out.path().join("run.mcap")));
    assert!(messages[0].len() > 100, "{} messages", messages[0].len());
    assert!(messages[0] == messages[1], "the recordings differ");
    let reports = out.each_ref().map(|out| timeless_report(&out.path().join("report.html")));
    assert!(reports[0].len() > 10_000 && reports[0] == reports[1], "the reports differ");
}

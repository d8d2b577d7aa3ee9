//! Lane edges of a run against marked ones.

use std::fs;
use std::path::Path;

use fingerpost_format::{
    FrameRecord, LanesRecord, Summary, ToJson, TruthRecord, TuSimpleRecord, from_json_lines, to_json_line,
};
use serde_json::Value;
use tempfile::TempDir;

use crate::program::call_line;

const BARE_FRAME: &str = r#"{"frame": 0, "t_s": 0, "state": "no_route", "feature": null, "motion": null,
    "driving_line_m": [], "centreline": null, "lanes": null, "fix": null, "stage_ms": {}, "why": ""}"#;

fn edge(u: f64) -> Vec<[f64; 2]> {
    vec![[u, 479.0], [u + 90.0, 300.0]]
}

fn write_lines<T: ToJson>(path: &Path, records: &[T]) {
    let lines: String = records.iter().map(|record| to_json_line(record).unwrap()).collect();
    fs::write(path, lines).unwrap();
}

/// A run of four frames whose left edge lies `off` pixels beside the truth, and its truth.
fn made(folder: &Path, name: &str, off: f64) -> (String, String) {
    let run = folder.join(name);
    fs::create_dir(&run).unwrap();
    let bare: FrameRecord = serde_json::from_str(BARE_FRAME).unwrap();
    let frames: Vec<FrameRecord> = (0..4)
        .map(|frame| {
            let lanes =
                LanesRecord { left_px: edge(100.0 + off), right_px: edge(500.0), ..Default::default() };
            FrameRecord { frame, lanes: Some(lanes), ..bare.clone() }
        })
        .collect();
    write_lines(&run.join("frames.jsonl"), &frames);
    let summary = Summary { frames: 4, picture_px: Some([640, 480]), ..Default::default() };
    fs::write(run.join("summary.json"), serde_json::to_string(&summary).unwrap()).unwrap();
    let truth: Vec<TruthRecord> = (0..4)
        .map(|frame| TruthRecord {
            frame,
            picture_px: Some([640, 480]),
            lane_left_px: edge(100.0),
            lane_right_px: edge(500.0),
            ..TruthRecord::default()
        })
        .collect();
    let path = folder.join(format!("{name}.jsonl"));
    write_lines(&path, &truth);
    (run.display().to_string(), path.display().to_string())
}

#[test]
fn table_json_and_surface() {
    let folder = TempDir::new().unwrap();
    let (good, good_truth) = made(folder.path(), "good", 0.5);
    let (bad, bad_truth) = made(folder.path(), "bad", 4.0);
    let plot = folder.path().join("plot.svg");
    let line = format!("evaluate lanes {good} {bad} --truth {good_truth} --truth {bad_truth}");
    let called = call_line(&format!("{line} --plot {}", plot.display())).done();
    for words in ["<= 10 px²", "100.00 %", "50.00 %", "75.00 %", "mean of 2 clips", "TuSimple"] {
        assert!(called.stdout.contains(words), "{words:?} is not in: {}", called.stdout);
    }
    let svg = fs::read_to_string(&plot).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("75.0") && svg.ends_with("</svg>"), "{svg}");

    let called = call_line(&format!("{line} --json")).done();
    let numbers: Value = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!(numbers["clips"].as_array().unwrap().len(), 2);
    assert_eq!(numbers["clips"][0]["mean_accuracy_pct"], 100.0);
    assert_eq!(numbers["clips"][1]["cells"].as_array().unwrap().len(), 12);
    // 4 px are 16 px²: below the threshold of 20 alone.
    assert_eq!(numbers["mean"]["cells"][2]["accuracy_pct"], 100.0);
    assert_eq!(numbers["mean"]["cells"][1]["accuracy_pct"], 75.0);
    assert!(called.stderr.contains("mean of 2 clips"), "{}", called.stderr);
}

#[test]
fn regions_thresholds_and_divisor_as_asked() {
    let folder = TempDir::new().unwrap();
    let (run, truth) = made(folder.path(), "run", 4.0);
    let line = format!("evaluate lanes {run} --truth {truth} --roi-rows 360,200 --thresholds 15,5");
    let accuracies = |line: &str| -> Vec<(u64, f64, f64)> {
        let numbers: Value =
            serde_json::from_str(&call_line(&format!("{line} --json")).done().stdout).unwrap();
        let cells = numbers["clips"][0]["cells"].as_array().unwrap().clone();
        let of = |cell: &Value, name: &str| cell[name].as_f64().unwrap();
        cells
            .iter()
            .map(|cell| {
                (cell["roi_rows"].as_u64().unwrap(), of(cell, "threshold_px2"), of(cell, "accuracy_pct"))
            })
            .collect()
    };
    // 16 px² over the truth's 180 rows; over 200 rows that are 14.4, over 360 half of it.
    let by_rows = [(200, 5.0, 50.0), (200, 15.0, 50.0), (360, 5.0, 50.0), (360, 15.0, 50.0)];
    assert_eq!(accuracies(&line), by_rows);
    let printed = accuracies(&format!("{line} --lpd-divisor region"));
    assert_eq!(printed, [(200, 5.0, 50.0), (200, 15.0, 100.0), (360, 5.0, 50.0), (360, 15.0, 100.0)]);
    assert!(call_line(&line).done().stdout.contains("<= 5 px²"));
    let plot = folder.path().join("plot.svg");
    call_line(&format!("evaluate lanes {run} --truth {truth} --roi-rows 100 --plot {}", plot.display()))
        .refused(1, &["--roi-rows", "surface"]);
    call_line(&format!("evaluate lanes {run} --truth {truth} --roi-rows 0")).refused(2, &["roi-rows"]);
}

#[test]
fn labels_of_the_benchmark() {
    let folder = TempDir::new().unwrap();
    let (run, _) = made(folder.path(), "run", 0.0);
    let labels = folder.path().join("labels.json");
    let lane = |u: f64| [310.0, 470.0].map(|row: f64| u + 90.0 * (479.0 - row) / 179.0).to_vec();
    let label = TuSimpleRecord {
        lanes: vec![lane(100.0), lane(500.0)],
        h_samples: vec![310.0, 470.0],
        raw_file: String::new(),
    };
    write_lines(&labels, &vec![label; 4]);
    assert_eq!(from_json_lines::<TuSimpleRecord>(&fs::read_to_string(&labels).unwrap()).unwrap().len(), 4);
    let called = call_line(&format!("evaluate lanes {run} --tusimple {} --json", labels.display())).done();
    let numbers: Value = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!(numbers["tusimple"]["accuracy"], 1.0);
    assert_eq!(numbers["tusimple"]["pictures"], 4);
}

#[test]
fn false_lanes_on_an_unmarked_road() {
    let folder = TempDir::new().unwrap();
    let (run, truth) = made(folder.path(), "run", 0.0);
    let unmarked = folder.path().join("unmarked.jsonl");
    let none: Vec<TruthRecord> =
        (0..4).map(|frame| TruthRecord { frame, ..TruthRecord::default() }).collect();
    write_lines(&unmarked, &none);
    let line = format!("evaluate lanes {run} --truth {}", unmarked.display());
    let called = call_line(&line).done();
    for words in ["no lane edges in the truth", "false lanes: 4 of 4 frames without markings, 100.00 %"] {
        assert!(called.stdout.contains(words), "{words:?} is not in: {}", called.stdout);
    }
    let called = call_line(&format!("{line} --json")).done();
    let numbers: Value = serde_json::from_str(&called.stdout).unwrap();
    let clip = &numbers["clips"][0];
    assert_eq!((&clip["false_lane_frames"], &clip["unmarked_frames"]), (&Value::from(4), &Value::from(4)));
    assert_eq!((&clip["false_lanes_pct"], &clip["mean_accuracy_pct"]), (&Value::from(100.0), &Value::Null));
    assert_eq!(numbers["mean"], Value::Null);
    let plot = folder.path().join("plot.svg");
    call_line(&format!("{line} --plot {}", plot.display())).refused(1, &["no accuracy to plot", "--plot"]);

    // Beside a marked drive the mean is that drive's.
    let line = format!("evaluate lanes {run} {run} --truth {truth} --truth {}", unmarked.display());
    let numbers: Value = serde_json::from_str(&call_line(&format!("{line} --json")).done().stdout).unwrap();
    assert_eq!(
        (&numbers["mean"]["clips"], &numbers["mean"]["mean_accuracy_pct"]),
        (&1.into(), &100.0.into())
    );
}

#[test]
fn what_does_not_match_is_refused() {
    let folder = TempDir::new().unwrap();
    let (run, truth) = made(folder.path(), "run", 0.0);
    let text = fs::read_to_string(&truth).unwrap();

    let larger = folder.path().join("larger.jsonl");
    fs::write(&larger, text.replace("[640,480]", "[1280,720]")).unwrap();
    call_line(&format!("evaluate lanes {run} --truth {}", larger.display()))
        .refused(1, &["640 x 480 pixels and the truth's 1280 x 720", "give the truth of the same pictures"]);

    let shorter = folder.path().join("shorter.jsonl");
    fs::write(&shorter, text.lines().take(3).map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    call_line(&format!("evaluate lanes {run} --truth {}", shorter.display()))
        .refused(1, &["frame 3 of the run has no truth", "the same drive"]);

    call_line(&format!("evaluate lanes {run} {run} --truth {truth}"))
        .refused(1, &["2 runs and 1 truths", "--truth once for every run"]);
    call_line(&format!("evaluate lanes {run}")).refused(2, &["--truth"]);

    fs::remove_file(Path::new(&run).join("summary.json")).unwrap();
    call_line(&format!("evaluate lanes {run} --truth {truth}")).done();
    let unsized_truth = folder.path().join("unsized.jsonl");
    fs::write(&unsized_truth, text.replace(r#""picture_px":[640,480],"#, "")).unwrap();
    let line = format!("evaluate lanes {run} --truth {}", unsized_truth.display());
    call_line(&line).refused(1, &["--picture-size"]);
    call_line(&format!("{line} --picture-size 640x480")).done();
}

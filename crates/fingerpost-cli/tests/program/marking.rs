//! Truth from marks, and the marks that ship.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use fingerpost_eval::{LaneMeasure, column_at_row, evaluate_lanes};
use fingerpost_format::{
    FrameRecord, LanesRecord, MarksFile, Side, TrackState, TruthRecord, TuSimpleRecord, from_json_lines,
    marks_from_json,
};
use fingerpost_io::{read_truth, write_png};
use fingerpost_mark::{LaneMarks, truth_of_marks};
use fingerpost_vision::picture::RgbImage;
use tempfile::TempDir;

use crate::program::call_line;

const MARKS: &str = r#"{"version": 1, "picture_px": [64, 48], "frames": 5,
    "left": [{"frame": 0, "points_px": [[10, 47], [20, 27]]}, {"frame": 4, "points_px": [[14, 47], [24, 27]]}],
    "right": [{"frame": 0, "points_px": []}, {"frame": 4, "points_px": [[50, 47], [40, 27]]}]}"#;

/// A folder of five pictures of 64 x 48 pixels, and marks of them.
fn marked(folder: &Path) -> (PathBuf, PathBuf) {
    let pictures = folder.join("pictures");
    fs::create_dir(&pictures).unwrap();
    for index in 0..5 {
        write_png(&pictures.join(format!("{index}.png")), &RgbImage::new(64, 48)).unwrap();
    }
    let marks = folder.join("marks.json");
    fs::write(&marks, MARKS).unwrap();
    (pictures, marks)
}

#[test]
fn marks_become_truth_and_labels() {
    let folder = TempDir::new().unwrap();
    let (pictures, marks) = marked(folder.path());
    let out = folder.path().join("truth");
    let line = format!(
        "mark {} --fps 20 --marks {} --export {}",
        pictures.display(),
        marks.display(),
        out.display()
    );
    call_line(&line).done();
    let truth = read_truth(&out.join("truth.jsonl")).unwrap();
    assert_eq!(truth.len(), 5);
    assert_eq!((truth[3].frame, truth[3].picture_px), (3, Some([64, 48])));
    assert!((truth[3].t_s - 0.15).abs() < 1e-12);
    assert_eq!(truth[3].lane_left_px.first(), Some(&[13.0, 47.0]));
    assert!(truth[3].lane_right_px.is_empty() && !truth[4].lane_right_px.is_empty());
    let labels = fs::read_to_string(out.join("tusimple.json")).unwrap();
    let labels: Vec<TuSimpleRecord> = from_json_lines(&labels).unwrap();
    assert_eq!((labels[3].lanes.len(), labels[4].lanes.len()), (1, 2));
    assert_eq!(labels[4].raw_file, "pictures/4.png");
    assert_eq!(labels[4].h_samples, [30.0, 40.0]);
}

#[test]
fn marks_that_do_not_fit_are_refused() {
    let folder = TempDir::new().unwrap();
    let (pictures, marks) = marked(folder.path());
    let line = format!(
        "mark {} --marks {} --export {}",
        pictures.display(),
        marks.display(),
        folder.path().display()
    );
    let refused = |from: &str, to: &str, words: &[&str]| {
        fs::write(&marks, MARKS.replace(from, to)).unwrap();
        call_line(&line).refused(1, words);
    };
    refused(
        "\"frames\": 5",
        "\"frames\": 6",
        &["6 frames of 64 x 48", "has 5 of 64 x 48", "that was marked"],
    );
    refused("[64, 48]", "[48, 64]", &["48 x 64"]);
    refused("\"version\": 1", "\"version\": 9", &["version 9"]);
    refused("{\"frame\": 0, \"points_px\": []}, ", "", &["the right edge is not marked in frames 0 to 3"]);
    refused("[20, 27]", "[20, 57]", &["frame 0 of its left edge", "near to far"]);
    assert!(!folder.path().join("truth.jsonl").exists());
    call_line(&format!("mark {} --marks {}", pictures.display(), marks.display())).refused(2, &["--export"]);

    fs::write(&marks, MARKS).unwrap();
    fs::create_dir(folder.path().join("road_masks")).unwrap();
    call_line(&line).refused(1, &["simulated drive", "choose another folder"]);
}

/// The marks that ship, with their truth.
fn shipped() -> Vec<(String, MarksFile, Vec<TruthRecord>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/marks");
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "json"))
        .map(|path| {
            let file = marks_from_json(&fs::read_to_string(&path).unwrap()).unwrap();
            let truth = truth_of_marks(&LaneMarks::from_file(&file), |frame| frame as f64 / 25.0).unwrap();
            (path.file_stem().unwrap().to_string_lossy().into_owned(), file, truth)
        })
        .collect()
}

#[test]
fn the_shipped_marks_are_whole() {
    let all = shipped();
    assert_eq!(all.len(), 3);
    for (name, file, truth) in all {
        let marks = LaneMarks::from_file(&file);
        let tenth: BTreeSet<u64> = (0..file.frames).step_by(10).chain([file.frames - 1]).collect();
        for side in [Side::Left, Side::Right] {
            let keys: BTreeSet<u64> = marks.key_frames(side).map(|(frame, _)| frame).collect();
            assert!(keys.is_superset(&tenth), "{name}: every tenth frame of {side:?}");
        }
        let base = f64::from(file.picture_px[1]) - 1.0;
        for truth in truth {
            let edges = [&truth.lane_left_px, &truth.lane_right_px];
            // All of the largest region of interest, and a lane that narrows upwards.
            let width = |row: f64| {
                let [left, right] = edges.map(|edge| column_at_row(edge, row).unwrap());
                right - left
            };
            let widths: Vec<f64> = (0..150).map(|up| width(base - f64::from(up))).collect();
            assert!(widths.is_sorted_by(|near, far| near > far), "{name} {}", truth.frame);
            assert!(widths[0] > 0.5 * f64::from(file.picture_px[0]), "{name} {}", truth.frame);
        }
    }
}

#[test]
fn the_shipped_marks_evaluate() {
    let bare = r#"{"frame": 0, "t_s": 0, "state": "no_route", "feature": null, "motion": null,
        "driving_line_m": [], "centreline": null, "lanes": null, "fix": null, "stage_ms": {}, "why": ""}"#;
    let bare: FrameRecord = serde_json::from_str(bare).unwrap();
    assert_eq!(bare.state, TrackState::NoRoute);
    for (name, file, truth) in shipped() {
        let run = |off: f64| -> Vec<FrameRecord> {
            let beside = |edge: &[[f64; 2]]| edge.iter().map(|[u, v]| [u + off, *v]).collect::<Vec<_>>();
            let lanes = |truth: &TruthRecord| LanesRecord {
                left_px: beside(&truth.lane_left_px),
                right_px: beside(&truth.lane_right_px),
                ..LanesRecord::default()
            };
            truth
                .iter()
                .map(|t| FrameRecord { frame: t.frame, lanes: Some(lanes(t)), ..bare.clone() })
                .collect()
        };
        let accuracy = |off| {
            evaluate_lanes(&run(off), &truth, file.picture_px, &LaneMeasure::default())
                .unwrap()
                .mean_accuracy_pct
                .unwrap()
        };
        assert!((accuracy(3.0) - 100.0).abs() < 1e-9, "{name}");
        // 16 squared pixels: true at the threshold of 20 alone.
        assert!((accuracy(4.0) - 100.0 / 3.0).abs() < 1e-9, "{name}");
    }
}

#[test]
fn more_idle_connections_than_open_files_leave_the_page_alive() {
    let folder = TempDir::new().unwrap();
    let (pictures, _) = marked(folder.path());
    // A limit that the server's own number of connections does not keep under.
    let script = "ulimit -n 40; exec \"$0\" mark \"$1\" --port 0 --out \"$2\"";
    let mut program = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_fingerpost")])
        .args([&pictures, &folder.path().join("marks")])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(program.stderr.take().unwrap()).lines();
    let address = said.find_map(|line| {
        let line = line.unwrap();
        Some(line.strip_prefix("open http://")?.split('/').next()?.to_owned())
    });
    let address = address.unwrap();
    let page = || {
        let mut stream = TcpStream::connect(&address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        write!(stream, "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    };
    assert!(page().starts_with("HTTP/1.1 200"));
    let idle: Vec<TcpStream> = (0..200).map(|_| TcpStream::connect(&address).unwrap()).collect();
    assert!(page().starts_with("HTTP/1.1 200"), "with {} idle connections", idle.len());
    program.kill().unwrap();
    program.wait().unwrap();
}

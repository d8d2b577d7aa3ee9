//! Lanes and warnings on simulated drives, by the camera alone.

use std::fs;
use std::path::Path;

use fingerpost_format::{FrameRecord, LanesRecord, Side, TruthRecord, from_json_lines};
use fingerpost_sim::Crossing;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{call_line, frames};

/// A simulated drive in `drive` and the run on it in `run`.
fn driven(simulation: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let at = folder.path().display();
    call_line(&format!("simulate {simulation} --size 640x480 --out {at}/drive")).done();
    call_line(&format!("run {at}/drive --camera {at}/drive/camera.toml --out {at}/run")).done();
    folder
}

fn records(folder: &TempDir) -> Vec<(FrameRecord, TruthRecord)> {
    let truth = fs::read_to_string(folder.path().join("drive/truth.jsonl")).unwrap();
    frames(&folder.path().join("run")).into_iter().zip(from_json_lines(&truth).unwrap()).collect()
}

fn mean_accuracy_pct(folder: &Path) -> f64 {
    let at = folder.display();
    let called = call_line(&format!("evaluate lanes {at}/run --truth {at}/drive/truth.jsonl --json")).done();
    let numbers: Value = serde_json::from_str(&called.stdout).unwrap();
    numbers["clips"][0]["mean_accuracy_pct"].as_f64().unwrap()
}

fn has_both_edges(lane: &LanesRecord) -> bool {
    !lane.left_px.is_empty() && !lane.right_px.is_empty()
}

fn warned_side(record: &FrameRecord) -> Option<Side> {
    record.lanes.as_ref()?.departure.as_ref()?.warning
}

/// Frames of an unmarked road in which a lane may be claimed, percent.
const MOST_FALSE_LANES_PCT: f64 = 2.0;

#[test]
fn broken_and_double_lines_are_found_where_they_are() {
    for conditions in ["lane_broken", "lane_double"] {
        let folder = driven(&format!(
            "--course highway --conditions {conditions} --driving keeping --frames 60 --fps 15"
        ));
        let accuracy_pct = mean_accuracy_pct(folder.path());
        assert!(accuracy_pct >= 97.0, "{conditions}: {accuracy_pct} %");
    }
}

/// Sealed strips run inside the lane; in the rain an edge is lost for frames and seen again.
#[test]
fn strips_and_rain_move_no_edge() {
    for (course, conditions, seed) in [("highway", "lane_patches", 41), ("country", "lane_rain", 7)] {
        let folder = driven(&format!(
            "--course {course} --conditions {conditions} --driving keeping --seed {seed} --frames 60 --fps 15"
        ));
        let accuracy_pct = mean_accuracy_pct(folder.path());
        assert!(accuracy_pct >= 97.0, "{course}, {conditions}: {accuracy_pct} %");
    }
}

/// Two images of lights in a wet road: half a metre inside the edge of a broken line, and in the middle of the lane.
#[test]
fn headlights_in_a_wet_road_are_no_lines() {
    for seed in [43, 61] {
        let folder = driven(&format!(
            "--course country --conditions lane_rain --driving keeping --seed {seed} --length-m 110 --frames 42 --fps 10"
        ));
        let lanes = records(&folder).into_iter().filter_map(|(record, _)| record.lanes);
        let lefts: Vec<f64> = lanes.filter_map(|lane| lane.left.map(|edge| edge.offset_m)).collect();
        assert!(lefts.len() >= 40, "seed {seed}: the left edge is seen in {} frames", lefts.len());
        for pair in lefts.windows(2) {
            assert!((pair[1] - pair[0]).abs() < 0.3, "seed {seed}: from {} m to {} m", pair[0], pair[1]);
        }
    }
}

#[test]
fn a_road_without_lines_has_no_lane() {
    let folder = driven("--course highway --conditions lane_none --frames 60 --fps 15");
    for (record, _) in records(&folder) {
        let lane = record.lanes.unwrap_or_default();
        assert!(lane.left_px.is_empty() && lane.right_px.is_empty(), "frame {}: {lane:?}", record.frame);
    }
}

/// Bare soil between asphalt and grass, and grass that reaches into the asphalt.
#[test]
fn an_asphalts_edge_is_no_marking() {
    for conditions in ["lane_none --fps 15", "unmarked"] {
        let folder = driven(&format!("--course country --conditions {conditions} --seed 2 --frames 90"));
        let at = folder.path().display();
        let called =
            call_line(&format!("evaluate lanes {at}/run --truth {at}/drive/truth.jsonl --json")).done();
        let numbers: Value = serde_json::from_str(&called.stdout).unwrap();
        let false_lanes_pct = numbers["clips"][0]["false_lanes_pct"].as_f64().unwrap();
        assert!(false_lanes_pct <= MOST_FALSE_LANES_PCT, "{conditions}: {false_lanes_pct} %");
    }
}

#[test]
fn a_standing_vehicle_keeps_its_lane_and_is_not_warned() {
    // It stands from 11.5 to 15.8 s.
    let folder =
        driven("--course country --conditions lane_continuous --driving stopping --frames 64 --fps 4");
    let standing: Vec<FrameRecord> = records(&folder)
        .into_iter()
        .filter(|(_, truth)| truth.speed_mps.abs() < 1e-9)
        .map(|(record, _)| record)
        .collect();
    assert!(standing.len() > 10, "{} frames", standing.len());
    for record in standing {
        let lane = record.lanes.as_ref();
        assert!(lane.is_some_and(has_both_edges), "frame {}: {lane:?}", record.frame);
        assert_eq!(warned_side(&record), None, "frame {}", record.frame);
    }
}

/// Time between a line's crossing by the wheel and the warning of it, seconds.
const MOST_DELAY_S: f64 = 0.3;

#[test]
fn a_drift_is_warned_of_when_a_wheel_crosses_the_line() {
    // To the left and to the right on straight road, and to the left in a bend.
    for (seed, frames_driven, side) in [(2, 78, Side::Left), (4, 78, Side::Right), (1, 100, Side::Left)] {
        let folder = driven(&format!(
            "--course country --conditions lane_continuous --driving drifting --seed {seed} --frames {frames_driven} --fps 10"
        ));
        let crossings = fs::read_to_string(folder.path().join("drive/crossings.jsonl")).unwrap();
        let crossings: Vec<Crossing> = from_json_lines(&crossings).unwrap();
        assert_eq!(crossings.iter().map(|crossing| crossing.side).collect::<Vec<_>>(), [side]);
        let run = frames(&folder.path().join("run"));
        let first = run.iter().find(|record| warned_side(record).is_some()).unwrap();
        assert_eq!(warned_side(first), Some(side));
        let delay_s = first.t_s - crossings[0].t_s;
        assert!(delay_s.abs() <= MOST_DELAY_S, "{delay_s} s after the crossing");
    }
}

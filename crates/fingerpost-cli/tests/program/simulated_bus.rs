//! The bus of a simulated drive, from the simulator's log to the run that reads it.

use std::fs;
use std::path::Path;

use fingerpost_format::{FrameRecord, Side, TruthRecord, from_json_lines};
use tempfile::TempDir;

use crate::program::{call_line, frames};

/// The column of signals.csv whose values are wanted, with their times.
fn column(csv: &str, name: &str) -> Vec<(f64, f64)> {
    let names: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let index = names.iter().position(|known| *known == name).unwrap();
    let rows = csv.lines().skip(1).filter_map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        Some((cells[1].parse().unwrap(), cells[index].parse().ok()?))
    });
    rows.collect()
}

fn newest(samples: &[(f64, f64)], t_s: f64) -> f64 {
    samples.iter().rev().find(|(at_s, _)| *at_s <= t_s + 1e-9).unwrap().1
}

fn truth(drive: &Path) -> Vec<TruthRecord> {
    from_json_lines(&fs::read_to_string(drive.join("truth.jsonl")).unwrap()).unwrap()
}

#[test]
fn the_log_decodes_to_the_truth() {
    let folder = TempDir::new().unwrap();
    let at = folder.path().display();
    call_line(&format!(
        "simulate --course highway --driving changing --seed 1 --frames 110 --size 160x120 --out {at}"
    ))
    .done();
    let called = call_line(&format!(
        "can {at}/can.log --dbc {at}/car.dbc --config {at}/can.toml --out {at}/signals.csv"
    ));
    let called = called.done();
    assert!(called.stderr.contains(", 0 lines that are none of a log's"), "{}", called.stderr);
    let csv = fs::read_to_string(folder.path().join("signals.csv")).unwrap();
    let [yaw_rate, speed, turn_signal] =
        ["yaw_rate_rps", "speed_mps", "turn_signal"].map(|name| column(&csv, name));
    // 10.9 s at 50 and at 10 a second.
    assert_eq!((yaw_rate.len(), speed.len(), turn_signal.len()), (546, 546, 110));
    let truth = truth(folder.path());
    for truth in &truth {
        // Every frame comes with a frame of the bus; what is left are half a step of 0.01 km/h and of 0.1 degrees a second.
        assert!((newest(&speed, truth.t_s) - truth.speed_mps).abs() < 0.0015, "{}", truth.frame);
        let off_deg = (newest(&yaw_rate, truth.t_s) - truth.yaw_rate_rps).to_degrees();
        assert!(off_deg.abs() < 0.051, "{}: {off_deg} degrees a second off", truth.frame);
        let signalled = truth.turn_signal.map_or(0.0, |side| if side == Side::Left { 1.0 } else { -1.0 });
        assert!((newest(&turn_signal, truth.t_s) - signalled).abs() < 1e-9, "{}", truth.frame);
    }
    assert!(truth.iter().any(|truth| truth.turn_signal == Some(Side::Left)));
}

#[test]
fn a_signalled_lane_change_is_silent_and_one_without_signal_is_not() {
    let folder = TempDir::new().unwrap();
    let at = folder.path().display();
    // Signalled from 3 s on, over the line at about 7 s.
    let simulation =
        "--course highway --conditions lane_broken --driving changing --seed 1 --frames 85 --fps 10";
    call_line(&format!("simulate {simulation} --size 640x480 --out {at}/drive")).done();
    let drive = folder.path().join("drive");
    let settings = fs::read_to_string(drive.join("can.toml")).unwrap();
    let unsignalled: String = settings
        .lines()
        .filter(|line| !line.starts_with("turn_signal"))
        .flat_map(|line| [line, "\n"])
        .collect();
    fs::write(folder.path().join("unsignalled.toml"), unsignalled).unwrap();
    let run = |config: &str| -> Vec<FrameRecord> {
        let can = format!("--can {at}/drive/can.log --dbc {at}/drive/car.dbc --config {config}");
        call_line(&format!("run {at}/drive --camera {at}/drive/camera.toml {can} --out {at}/run")).done();
        frames(&folder.path().join("run"))
    };
    let said = |records: &[FrameRecord]| -> (Vec<Side>, Vec<String>) {
        let departures = || records.iter().filter_map(|record| record.lanes.as_ref()?.departure.as_ref());
        let warnings = departures().filter_map(|departure| departure.warning).collect();
        (warnings, departures().filter_map(|departure| departure.silent_because.clone()).collect())
    };

    let records = run(&format!("{at}/drive/can.toml"));
    let (warnings, silences) = said(&records);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!(silences.iter().any(|cause| cause == "turn_signal"), "{silences:?}");
    for (record, truth) in records.iter().zip(truth(&drive)) {
        let signals = record.signals.as_ref().unwrap();
        assert!(signals.source["speed"] == "can" && signals.source["yaw_rate"] == "can", "{}", record.frame);
        assert!((signals.speed_mps.unwrap() - truth.speed_mps).abs() < 0.01, "{}", record.frame);
        assert!((signals.yaw_rate_rps.unwrap() - truth.yaw_rate_rps).abs() < 0.001, "{}", record.frame);
    }

    let (warnings, silences) = said(&run(&format!("{at}/unsignalled.toml")));
    assert_eq!(warnings.first(), Some(&Side::Left), "{silences:?}");
}

#[test]
fn a_speed_in_the_wrong_unit_is_named_and_not_used() {
    let folder = TempDir::new().unwrap();
    let at = folder.path().display();
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/../fingerpost-sim/assets");
    // 12 s at 8 m/s, on a road whose motion the camera sees.
    call_line(&format!(
        "simulate --map {assets}/town.osm --route {assets}/town_route.geojson --seed 1 --frames 120 --size 320x240 --out {at}/drive"
    ))
    .done();
    let settings = fs::read_to_string(folder.path().join("drive/can.toml")).unwrap();
    let wrong = settings.replace("speed_unit = \"km_per_h\"", "speed_unit = \"miles_per_h\"");
    assert_ne!(settings, wrong, "the simulator's bus tells km/h");
    fs::write(folder.path().join("wrong.toml"), wrong).unwrap();
    let run = |config: &str, out: &str| {
        let can = format!("--can {at}/drive/can.log --dbc {at}/drive/car.dbc --config {at}/{config}");
        call_line(&format!("run {at}/drive --camera {at}/drive/camera.toml {can} --out {at}/{out}")).done();
        frames(&folder.path().join(out))
    };
    let right = run("drive/can.toml", "right");
    assert!(right.iter().all(|record| record.signals.as_ref().unwrap().disagreement_m.is_none()));
    let records = run("wrong.toml", "wrong");
    let last = records.last().unwrap();
    let signals = last.signals.as_ref().unwrap();
    let found = signals.disagreement_m.unwrap();
    // A mile is 1.609 km.
    assert!((found.bus / found.camera - 1.609).abs() < 0.2, "{found:?}");
    assert_eq!(signals.not_used["speed"], "disagrees_with_camera");
    assert_eq!(signals.source["speed"], "camera");
    assert!(last.why.contains("disagree on the speed"), "{}", last.why);
}

//! `papers.toml`, the papers' own settings.

use std::fs;
use std::path::{Path, PathBuf};

use fingerpost::Config;
use fingerpost::lanes::LaneMethod;
use fingerpost::motion::{FlowModel, MotionMethod};
use fingerpost::road_surface::RoadMethod;
use fingerpost_format::TrackState;
use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::program::{call_line, frames, summary};

fn settings() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../papers.toml")
}

#[test]
fn every_setting_of_the_papers_names_its_section() {
    let text = fs::read_to_string(settings()).unwrap();
    let config = Config::from_toml(&text).unwrap();
    config.check().unwrap();
    assert_eq!(config.road_surface.detector, RoadMethod::Backprojection);
    assert_eq!(config.motion.estimator, MotionMethod::Farneback);
    assert_eq!(config.motion.farneback.model, FlowModel::Mean);
    assert_eq!(config.lanes.finder, LaneMethod::Sections);
    assert!((config.feature_mask.arm_width_share - 0.25).abs() < 1e-12);
    for line in text.lines().filter(|line| line.contains(" = ")) {
        let comment = line.split_once('#').map(|(_, comment)| comment).unwrap_or_default();
        assert!(comment.contains("paper") || comment.contains("the same"), "{line}");
    }
}

/// At the papers' resolution and frequency too.
#[test]
fn a_junction_is_found_with_the_settings_of_the_papers() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let (map, route, config) = (drive.map(), drive.route(), settings());
    let (map, route, config) = (map.display(), route.display(), config.display());
    let input = folder.path().join("drive");
    let simulate =
        format!("simulate --map {map} --route {route} --frames {FRAMES} --size 512x384 --traffic centre");
    call_line(&format!("{simulate} --conditions ideal --out {}", input.display())).done();
    let (truth, camera) = (input.join("truth.jsonl"), input.join("camera.toml"));
    for arguments in ["", "--width 256 --rate 10"] {
        let out = folder.path().join("run");
        let line = format!("run {} --camera {} --route {route}", input.display(), camera.display());
        let line = format!("{line} --start-m 5 --config {config} --truth {} {arguments}", truth.display());
        call_line(&format!("{line} --out {}", out.display())).done();
        let summary = summary(&out);
        let truth = summary.truth.as_ref().unwrap();
        let found = (truth.features_total, truth.features_detected, truth.false_detections, truth.arrivals);
        assert_eq!(found, (1, 1, 0, 1), "{arguments:?}: {truth:?}");
        assert!(truth.position_error_m.unwrap().p50 < 1.0, "{arguments:?}: {truth:?}");
        assert!(summary.features[0].detected_forward_m.unwrap() > 9.0, "{arguments:?}: {summary:?}");
        let followed = frames(&out).into_iter().filter(|record| record.state == TrackState::Tracking);
        assert!(followed.count() >= 1, "{arguments:?}");
    }
}

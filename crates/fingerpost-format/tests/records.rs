//! The records of a run and of truth, against the contract's own example.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use fingerpost_format::{
    ErrorQuantiles, FeatureSummary, FrameRecord, LinesError, StageTime, Summary, TimesError, TrackState,
    TruthRecord, TruthSummary, from_json_lines, parse_times, to_json_line,
};
use serde_json::{Value, json};

/// The example of the contract, on one line.
const EXAMPLE: &str = concat!(
    r#"{"frame": 41, "t_s": 4.1, "state": "tracking", "#,
    r#""feature": {"id": 24546162, "kind": "junction", "p": 0.91, "#,
    r#""sub": {"approach": 0.97, "exit": 0.94, "side_1": 0.91, "driving_line": 0.96}, "#,
    r#""forward_m": 12.31, "left_m": 0.42, "heading_rad": 0.02, "sigma_m": [0.2, 0.1]}, "#,
    r#""motion": {"forward_m": 0.81, "left_m": 0.0, "yaw_rad": 0.004, "quality": 0.93}, "#,
    r#""driving_line_m": [[3.1, 0.0], [5.0, 0.1]], "#,
    r#""centreline": {"offset_m": 0.12, "heading_rad": -0.01, "steer_rad": 0.02}, "#,
    r#""lanes": null, "fix": {"lat": 48.98, "lon": 8.39, "heading_rad": 1.2, "sigma_m": 0.8, "bound_m": 3.1}, "#,
    r#""stage_ms": {"ground_view": 0.2, "road": 0.1, "motion": 0.2, "match": 0.05}, "#,
    r#""why": "junction 24546162 12.3 m ahead: weakest arm side_1 0.91, threshold 0.75"}"#,
);

fn value(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn the_contracts_example_survives_reading_and_writing() {
    let frame: FrameRecord = serde_json::from_str(EXAMPLE).unwrap();
    assert_eq!((frame.frame, frame.state), (41, TrackState::Tracking));
    let feature = frame.feature.as_ref().unwrap();
    assert_eq!((feature.id, feature.p, feature.sub["side_1"]), (24_546_162, Some(0.91), 0.91));
    let line = to_json_line(&frame).unwrap();
    assert_eq!(line.matches('\n').count(), 1);
    assert!(line.ends_with('\n'));
    let (example, written) = (value(EXAMPLE), value(&line));
    for (key, expected) in example.as_object().unwrap() {
        assert_eq!(&written[key], expected, "{key}");
    }
    assert_eq!(from_json_lines::<FrameRecord>(&line).unwrap(), [frame]);
}

#[test]
fn states_have_their_names_of_the_contract() {
    for (state, name) in [
        (TrackState::NoRoute, "no_route"),
        (TrackState::Searching, "searching"),
        (TrackState::Tracking, "tracking"),
        (TrackState::Arrived, "arrived"),
        (TrackState::Lost, "lost"),
        (TrackState::RouteDone, "route_done"),
    ] {
        assert_eq!(serde_json::to_value(state).unwrap(), json!(name));
    }
}

#[test]
fn a_broken_line_is_named_and_empty_ones_are_passed_over() {
    let text = format!("{EXAMPLE}\n\n{EXAMPLE}\n{}", &EXAMPLE[..60]);
    match from_json_lines::<FrameRecord>(&text) {
        Err(LinesError::Parse { line: 4, .. }) => {}
        other => panic!("line 4 should be refused: {other:?}"),
    }
    let whole = text.rsplit_once('\n').unwrap().0;
    assert_eq!(from_json_lines::<FrameRecord>(whole).unwrap().len(), 2);
}

#[test]
fn truth_has_the_keys_of_the_contract_and_lanes_may_be_left_out() {
    let truth = TruthRecord { frame: 3, t_s: 0.3, feature_id: Some(7), ..TruthRecord::default() };
    let written = serde_json::to_value(&truth).unwrap();
    for key in [
        "frame",
        "t_s",
        "x_m",
        "y_m",
        "heading_rad",
        "lat",
        "lon",
        "speed_mps",
        "yaw_rate_rps",
        "feature_id",
        "feature_forward_m",
        "feature_left_m",
        "lane_left_px",
        "lane_right_px",
    ] {
        assert!(written.get(key).is_some(), "{key}");
    }
    let bare = r#"{"frame":3,"t_s":0.3,"x_m":0,"y_m":0,"heading_rad":0,"lat":0,"lon":0,"speed_mps":0,
        "yaw_rate_rps":0,"feature_id":7}"#;
    assert_eq!(serde_json::from_str::<TruthRecord>(bare).unwrap(), truth);
}

fn summary() -> Summary {
    Summary {
        written_by: None,
        frames: 130,
        fps: 31.5,
        stage_ms: [("road".to_owned(), StageTime { median: 0.1, p95: 0.3 })].into(),
        features: vec![FeatureSummary {
            id: 24_546_162,
            name: "Neckarstraße".to_owned(),
            kind: "junction".to_owned(),
            detected_frame: Some(62),
            detected_forward_m: Some(17.5),
            arrived_frame: None,
            max_p: Some(0.93),
            ..FeatureSummary::default()
        }],
        ..Summary::default()
    }
}

#[test]
fn a_summary_without_truth_has_no_key_of_the_comparison() {
    let written = serde_json::to_value(summary()).unwrap();
    assert_eq!(written["features"][0]["detected_frame"], json!(62));
    assert_eq!(written["stage_ms"], json!({"road": {"median": 0.1, "p95": 0.3}}));
    for key in ["truth", "features_total", "position_error_m", "bound_violations"] {
        assert!(written.get(key).is_none(), "{key}");
    }
    assert_eq!(serde_json::from_value::<Summary>(written).unwrap(), summary());
}

#[test]
fn the_comparison_with_truth_stands_at_the_top_level() {
    let truth = TruthSummary {
        features_total: 8,
        features_detected: 7,
        false_detections: 1,
        arrivals: 6,
        position_error_m: Some(ErrorQuantiles { p50: 0.1, p95: 0.4, max: 0.6 }),
        motion_error_pct: Some(1.5),
        fix_error_m: None,
        bound_violations: None,
    };
    let with_truth = Summary { truth: Some(truth), ..summary() };
    let written = serde_json::to_value(&with_truth).unwrap();
    assert_eq!(written["features_total"], json!(8));
    assert_eq!(written["features_detected"], json!(7));
    assert_eq!(written["false_detections"], json!(1));
    assert_eq!(written["arrivals"], json!(6));
    assert_eq!(written["position_error_m"], json!({"p50": 0.1, "p95": 0.4, "max": 0.6}));
    assert_eq!(written["motion_error_pct"], json!(1.5));
    assert_eq!(serde_json::from_value::<Summary>(written).unwrap(), with_truth);
}

#[test]
fn times_count_from_the_first_and_never_backwards() {
    assert_eq!(parse_times("10.5\r\n\n10.75\n1.1e1\n11\n").unwrap(), [0.0, 0.25, 0.5, 0.5]);
    assert_eq!(parse_times("").unwrap(), [0.0; 0]);
    assert_eq!(parse_times("1\n\n0.5\n"), Err(TimesError::Backwards { line: 3 }));
    for text in ["1\nsoon\n", "1\nnan\n", "1\ninf\n", "1\n2 3\n"] {
        assert!(matches!(parse_times(text), Err(TimesError::NotANumber { line: 2, .. })), "{text}");
    }
}

#[test]
fn a_surface_says_what_is_known_of_it_and_no_more() {
    let with = |surface: &str| EXAMPLE.replacen('{', &format!(r#"{{"surface": {surface}, "#), 1);
    let named = r#"{"detector":"combined","p":0.98,"name":"asphalt","likeness":0.9,"remembered_share":0.2}"#;
    for surface in [named, r#"{"detector":"backprojection","p":0.5}"#] {
        let frame: FrameRecord = serde_json::from_str(&with(surface)).unwrap();
        assert_eq!(value(&to_json_line(&frame).unwrap())["surface"], value(surface));
    }
    let frame: FrameRecord = serde_json::from_str(EXAMPLE).unwrap();
    assert_eq!(value(&to_json_line(&frame).unwrap()).get("surface"), None);
}

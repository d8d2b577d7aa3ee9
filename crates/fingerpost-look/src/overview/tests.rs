//! Curves and events of a made-up run.

use fingerpost_format::{
    CameraRecord, CameraRecordState, FeatureRecord, MotionDoubtRecord, MotionRecord, SignalsRecord,
    TrackState,
};

use super::*;
use crate::events::EventKind;

/// A record of a frame that knows nothing.
fn bare(frame: u64, state: TrackState) -> FrameRecord {
    let text = r#"{"frame": 0, "t_s": 0, "state": "no_route", "feature": null, "motion": null, "driving_line_m": [],
        "centreline": null, "lanes": null, "fix": null, "stage_ms": {}, "why": ""}"#;
    let record: FrameRecord = serde_json::from_str(text).expect("a record");
    FrameRecord { frame, t_s: frame as f64 / 10.0, state, ..record }
}

fn feature(id: i64, forward_m: f64) -> Option<FeatureRecord> {
    let text = r#"{"id": 0, "kind": "side_road", "p": 0.75, "sub": {}, "present": 0.9, "forward_m": 0, "left_m": 0,
        "heading_rad": 0, "sigma_m": [0.4, 0.2]}"#;
    let feature: FeatureRecord = serde_json::from_str(text).expect("a feature");
    Some(FeatureRecord { id, forward_m, ..feature })
}

fn overview(records: &[FrameRecord]) -> Overview {
    let mut overview = Overview::default();
    records.iter().for_each(|record| overview.add(record));
    overview
}

fn values(overview: &Overview, quantity: Quantity) -> Vec<Option<f64>> {
    let curve = overview.curves().iter().find(|curve| curve.quantity == quantity);
    curve.map(|curve| curve.values.clone()).unwrap_or_default()
}

#[test]
fn curves_have_a_value_a_frame_or_none() {
    let motion =
        |doubt| Some(MotionRecord { forward_m: 1.2, left_m: 0.0, yaw_rad: 0.0, quality: 1.0, doubt });
    let doubted = motion(Some(MotionDoubtRecord::NothingToGoBy));
    let by_bus = SignalsRecord { speed_mps: Some(7.5), ..SignalsRecord::default() };
    let records = [
        FrameRecord { motion: motion(None), ..bare(0, TrackState::Searching) },
        FrameRecord { motion: motion(None), ..bare(2, TrackState::Searching) },
        FrameRecord { motion: doubted, ..bare(4, TrackState::Searching) },
        FrameRecord { signals: Some(by_bus), feature: feature(5, 12.34567), ..bare(6, TrackState::Tracking) },
    ];
    let overview = overview(&records);
    assert_eq!(overview.frames(), [0, 2, 4, 6]);
    // 1.2 m in 0.2 s; the first frame has none before it.
    assert_eq!(values(&overview, Quantity::Speed), [None, Some(6.0), None, Some(7.5)]);
    assert_eq!(values(&overview, Quantity::Forward), [None, None, None, Some(12.346)]);
    assert_eq!(values(&overview, Quantity::Sigma)[3], Some(0.4));
    assert_eq!(values(&overview, Quantity::MatchP)[3], Some(0.75));
    assert_eq!(values(&overview, Quantity::Present)[3], Some(0.9));
}

#[test]
fn what_is_sought_has_a_probability_as_well() {
    let sought = r#"{"id": 3, "p": 0.5, "sub": {}, "present": 0.25, "forward_m": 9, "left_m": 0}"#;
    let sought = Some(serde_json::from_str(sought).expect("a sought feature"));
    let overview = overview(&[FrameRecord { sought, ..bare(0, TrackState::Searching) }]);
    assert_eq!(values(&overview, Quantity::Present), [Some(0.25)]);
    assert_eq!(values(&overview, Quantity::MatchP), [Some(0.5)]);
    assert_eq!(values(&overview, Quantity::Forward), [None]);
}

#[test]
fn what_changes_is_an_event() {
    let followed = |frame, state, id| FrameRecord { feature: feature(id, 14.0), ..bare(frame, state) };
    let records = [
        bare(0, TrackState::Searching),
        followed(1, TrackState::Tracking, 7),
        followed(2, TrackState::Tracking, 7),
        bare(3, TrackState::Lost),
        bare(4, TrackState::Searching),
        followed(5, TrackState::Tracking, 7),
        followed(6, TrackState::Arrived, 7),
        followed(7, TrackState::Tracking, 8),
        followed(8, TrackState::Tracking, 9),
        bare(9, TrackState::RouteDone),
    ];
    let overview = overview(&records);
    let found: Vec<(u64, EventKind, &str)> =
        overview.events().iter().map(|event| (event.frame, event.kind, event.text.as_str())).collect();
    assert_eq!(
        found,
        [
            (1, EventKind::Detection, "found: side road 7, 14.0 m ahead"),
            (3, EventKind::Loss, "lost: 7"),
            (4, EventKind::State, "searching"),
            (5, EventKind::Detection, "found: side road 7, 14.0 m ahead"),
            (6, EventKind::Arrival, "arrived: side road 7, 14.0 m ahead"),
            (7, EventKind::Detection, "found: side road 8, 14.0 m ahead"),
            (8, EventKind::Detection, "found: side road 9, 14.0 m ahead"),
            (9, EventKind::State, "the route is done"),
        ]
    );
}

#[test]
fn a_camera_that_shows_nothing_is_an_event_in_its_first_frame_alone() {
    let camera = |state| Some(CameraRecord { state, contrast: 0.0, needed_contrast: 1.3 });
    let seen = |frame, state| FrameRecord { camera: camera(state), ..bare(frame, TrackState::NoRoute) };
    let records = [
        seen(0, CameraRecordState::Black),
        seen(1, CameraRecordState::Black),
        seen(2, CameraRecordState::Clear),
        FrameRecord { error: Some("torn".to_owned()), ..bare(3, TrackState::NoRoute) },
        FrameRecord { error: Some("torn".to_owned()), ..bare(4, TrackState::NoRoute) },
        seen(5, CameraRecordState::Frozen),
    ];
    let overview = overview(&records);
    let found: Vec<(usize, &str)> =
        overview.events().iter().map(|event| (event.index, event.text.as_str())).collect();
    assert_eq!(
        found,
        [
            (0, "the camera was black"),
            (2, "the camera is clear again"),
            (3, "broken frame: torn"),
            (5, "the camera was frozen"),
        ]
    );
    assert!(overview.events().iter().all(|event| event.kind == EventKind::Camera));
}

#[test]
fn a_camera_that_was_turned_is_an_event() {
    let mount = r#"{"pitch_deg": 0, "yaw_deg": 0, "roll_deg": 0, "suspension_pitch_deg": 0, "sigma_deg": [1, 1, 1, 1],
        "state": "moved", "fault": {"angle": "pitch", "by_deg": -2.5, "since_frame": 4}}"#;
    let mount = Some(serde_json::from_str(mount).expect("a mount"));
    let overview =
        overview(&[bare(5, TrackState::NoRoute), FrameRecord { mount, ..bare(6, TrackState::NoRoute) }]);
    assert_eq!(overview.events().len(), 1);
    assert!(overview.events()[0].text.contains("turned by -2.5 degrees (pitch)"));
}

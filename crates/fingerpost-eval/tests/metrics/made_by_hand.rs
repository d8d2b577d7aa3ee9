//! Hand-made records and truths.

use std::collections::BTreeMap;

use fingerpost_format::{FeatureRecord, FrameRecord, MotionRecord, TrackState, TruthRecord};

/// A record without a feature.
pub(crate) fn record(frame: u64, state: TrackState) -> FrameRecord {
    FrameRecord {
        camera: None,
        sought: None,
        frame,
        t_s: 0.1 * frame as f64,
        state,
        feature: None,
        motion: None,
        mount: None,
        signals: None,
        surface: None,
        driving_line_m: Vec::new(),
        driving_line_curvature_per_m: Vec::new(),
        centreline: None,
        no_centreline: None,
        lanes: None,
        fix: None,
        advice: None,
        route_m: None,
        stage_ms: BTreeMap::new(),
        why: String::new(),
        error: None,
    }
}

/// A record with the feature `id` at a place, P(F) 0.9.
pub(crate) fn seen(frame: u64, state: TrackState, id: i64, forward_m: f64, left_m: f64) -> FrameRecord {
    let feature = FeatureRecord {
        id,
        kind: "junction".to_owned(),
        p: Some(0.9),
        sub: BTreeMap::new(),
        contrast: Default::default(),
        confidence: None,
        present: None,
        rivals: Vec::new(),
        forward_m,
        left_m,
        heading_rad: 0.0,
        sigma_m: [0.1, 0.1],
    };
    FrameRecord { feature: Some(feature), ..record(frame, state) }
}

/// The record with a motion.
pub(crate) fn moved(record: FrameRecord, forward_m: f64, yaw_rad: f64) -> FrameRecord {
    let motion = MotionRecord { forward_m, left_m: 0.0, yaw_rad, quality: 1.0, doubt: None };
    FrameRecord { motion: Some(motion), ..record }
}

/// A vehicle that drives north, one metre a frame, past features on the road at 10 m (node 1) and 30 m (node 2).
pub(crate) fn drive_north(frames: u64) -> Vec<TruthRecord> {
    (0..frames)
        .map(|frame| {
            let y_m = frame as f64;
            let next = [(1, 10.0), (2, 30.0)].into_iter().find(|(_, at_m)| *at_m > y_m);
            TruthRecord {
                frame,
                t_s: 0.1 * y_m,
                y_m,
                heading_rad: std::f64::consts::FRAC_PI_2,
                speed_mps: 10.0,
                feature_id: next.map(|(id, _)| id),
                feature_forward_m: next.map(|(_, at_m)| at_m - y_m),
                feature_left_m: next.map(|_| 0.0),
                ..TruthRecord::default()
            }
        })
        .collect()
}

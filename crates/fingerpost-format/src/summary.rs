//! `summary.json`: a run in numbers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{CameraRecordState, DriveSummary, MapNoticeRecord, MountFaultRecord};

/// A run in numbers; the last table only where a truth file was given.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Program, version and commit; none in results of a program that did not say yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub written_by: Option<String>,
    /// What the drive was; none in results of a program that did not say yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<DriveSummary>,
    /// Frames processed.
    pub frames: u64,
    /// Width and height of the input's pictures; none in results of a program that did not say yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture_px: Option<[u32; 2]>,
    /// What of the input was used, where that was not all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampling: Option<SamplingRecord>,
    /// What of the map was not understood, where there was one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub map_notices: Vec<MapNoticeRecord>,
    /// Frames that could not be read and were passed over.
    #[serde(default)]
    pub broken_frames: u64,
    /// Frames that were used although they are damaged and the decoder made up parts of them.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub damaged_frames: u64,
    /// Frames of a live input that came faster than they could be used, and were passed over for later ones.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub dropped_frames: u64,
    /// Frames a second of the whole run, decoding and writing included.
    pub fps: f64,
    /// Wall time of every stage.
    pub stage_ms: BTreeMap<String, StageTime>,
    /// Every feature of the route, in its order.
    pub features: Vec<FeatureSummary>,
    /// Frames in state `lost`.
    pub lost_frames: u64,
    /// Frames in which the camera showed nothing, or nothing new, by what was wrong; none where it always did.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub camera_frames: BTreeMap<CameraRecordState, u64>,
    /// Every time the camera was found to have been turned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mount_faults: Vec<MountFaultRecord>,
    /// Comparison with truth.
    #[serde(flatten)]
    pub truth: Option<TruthSummary>,
    /// Whether the run was ended before its input was.
    #[serde(default)]
    pub interrupted: bool,
    /// Why the input ended before it should have, where it did: a video that breaks off, stalls or goes on in another
    /// form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_broke_off: Option<String>,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// What of an input was used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SamplingRecord {
    /// Width and height of the pictures as they were used.
    pub picture_px: [u32; 2],
    /// Every n-th frame, where so many were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<u64>,
    /// Frames a second, where so many were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
}

/// Wall time of a stage over a run, milliseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
}

/// What became of one feature of the route, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FeatureOutcome {
    /// The vehicle came so near that its driving line began.
    Arrived,
    /// It was found and followed.
    Detected,
    /// The vehicle has passed it by all that is known, and it was never found.
    Missed,
    /// The drive ended before it.
    NotReached,
}

/// What became of one feature of the route.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct FeatureSummary {
    /// OpenStreetMap node.
    pub id: i64,
    /// Name of the place.
    #[serde(default)]
    pub name: String,
    /// `junction`, `side_road` or `bend`.
    #[serde(default)]
    pub kind: String,
    /// Distance along the route to its node, metres; none in results of a program that did not say yet.
    #[serde(default)]
    pub at_m: Option<f64>,
    /// What became of it in a word; none where it was not found and nothing says how far along the route the drive went.
    #[serde(default)]
    pub outcome: Option<FeatureOutcome>,
    /// Frame of its first detection.
    pub detected_frame: Option<u64>,
    /// How far ahead it was then, metres.
    #[serde(default)]
    pub detected_forward_m: Option<f64>,
    /// Frame of arrival.
    pub arrived_frame: Option<u64>,
    /// How far ahead its node was then, metres.
    #[serde(default)]
    pub arrived_forward_m: Option<f64>,
    /// Highest P(F) while it was searched for or followed; none where it never came into reach.
    pub max_p: Option<f64>,
}

/// A run against truth.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthSummary {
    /// Features that the truth passes.
    pub features_total: u64,
    /// Of those, detected.
    pub features_detected: u64,
    /// Detections of a feature that was not there.
    pub false_detections: u64,
    /// Features arrived at.
    pub arrivals: u64,
    /// Distance between reported and true place of the followed feature, metres.
    pub position_error_m: Option<ErrorQuantiles>,
    /// Error of the summed motion, percent of the distance driven.
    pub motion_error_pct: Option<f64>,
    /// Distance between fix and truth, metres.
    pub fix_error_m: Option<ErrorQuantiles>,
    /// Frames in which the fix was further from the truth than its bound.
    pub bound_violations: Option<u64>,
}

/// Quantiles of an error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorQuantiles {
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

//! One line of `truth.jsonl`: where the vehicle and its next feature really were.

use serde::{Deserialize, Serialize};

use crate::lanes::{MarkingRecord, Side};

/// Truth of one frame, written by the simulator and by converters of recorded drives.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthRecord {
    /// Index of the frame, from zero.
    pub frame: u64,
    /// Seconds since the first frame.
    pub t_s: f64,
    /// East of the route's first node, where that really is, metres.
    pub x_m: f64,
    /// North of the route's first node, where that really is, metres.
    pub y_m: f64,
    /// Radians anticlockwise from east.
    pub heading_rad: f64,
    /// Latitude, degrees.
    pub lat: f64,
    /// Longitude, degrees.
    pub lon: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate_rps: f64,
    /// OpenStreetMap node of the next feature of the route; none behind the last.
    #[serde(default)]
    pub feature_id: Option<i64>,
    /// How far ahead of the vehicle it is, metres.
    #[serde(default)]
    pub feature_forward_m: Option<f64>,
    /// How far to the left, metres.
    #[serde(default)]
    pub feature_left_m: Option<f64>,
    /// Width and height of the picture that the lane's pixels are of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture_px: Option<[u32; 2]>,
    /// Left edge of the vehicle's lane, the inner edge of its marking: `[u, v]` pixels, near to far; empty without one.
    #[serde(default)]
    pub lane_left_px: Vec<[f64; 2]>,
    /// Right edge of the vehicle's lane, likewise.
    #[serde(default)]
    pub lane_right_px: Vec<[f64; 2]>,
    /// The same points of the left edge in the vehicle frame, `[forward, left]` metres.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lane_left_m: Vec<[f64; 2]>,
    /// The same points of the right edge, likewise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lane_right_m: Vec<[f64; 2]>,
    /// The left edge's marking.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lane_left_marking: Option<MarkingRecord>,
    /// The right edge's marking.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lane_right_marking: Option<MarkingRecord>,
    /// The nearest kerb to the left that the picture shows, where kerbs are known: `[forward, left, height]` metres, near to far, in the
    /// vehicle frame.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kerb_left_m: Vec<[f64; 3]>,
    /// The nearest kerb to the right, likewise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kerb_right_m: Vec<[f64; 3]>,
    /// The turn signal that is on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_signal: Option<Side>,
}

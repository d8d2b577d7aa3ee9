//! Lanes in a frame's record and in its truth.

use serde::{Deserialize, Serialize};

/// How a marking is painted along the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MarkingKind {
    /// One line without gaps.
    Continuous,
    /// One line with gaps.
    Broken,
    /// Two lines beside each other, whether either has gaps or not.
    Double,
    /// Too little of it has been seen.
    #[default]
    Unknown,
}

/// The colour of a marking's paint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MarkingColour {
    /// White, or as grey as that is in the light.
    White,
    /// Yellow or orange.
    Yellow,
    /// Not told.
    #[default]
    Unknown,
}

/// A marking.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct MarkingRecord {
    /// How it is painted along the road.
    pub kind: MarkingKind,
    /// The paint's colour.
    pub colour: MarkingColour,
}

/// The lane in which the vehicle is. An edge is the inner edge of its marking, the one nearer to the vehicle.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LanesRecord {
    /// Left edge, `[u, v]` pixels of the camera's picture as it was taken, near to far; empty where there is none.
    pub left_px: Vec<[f64; 2]>,
    /// Right edge, likewise.
    pub right_px: Vec<[f64; 2]>,
    /// The left edge on the road; none where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<LaneEdgeRecord>,
    /// The right edge, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<LaneEdgeRecord>,
    /// Distance between the edges at the vehicle, metres; none where an edge is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
    /// How the lane is being left; none for a camera that is known by points alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub departure: Option<DepartureRecord>,
}

/// A lane's edge in the vehicle frame: left of the vehicle is positive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LaneEdgeRecord {
    /// Where the edge passes the rear axle, metres to the left.
    pub offset_m: f64,
    /// Its direction there against the vehicle's, radians.
    pub heading_rad: f64,
    /// Its curvature, 1/m.
    pub curvature_per_m: f64,
    /// The marking whose edge it is.
    pub marking: MarkingRecord,
    /// For how many frames nothing new has been seen of it; 0 in a frame that shows it.
    pub kept_frames: u32,
}

/// A side of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// How the vehicle moves towards the edges of its lane.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DepartureRecord {
    /// The side on which the lane is being left without a sign that this is wanted.
    pub warning: Option<Side>,
    /// Speed across the lane, m/s, positive to the left.
    pub lateral_speed_mps: Option<f64>,
    /// Time until a wheel reaches the edge ahead of it, seconds; none while it moves towards neither.
    pub time_to_crossing_s: Option<f64>,
    /// Why no warning is given although a wheel is at an edge: `turn_signal`, `slow`, `lane_change`, `cool_down`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub silent_because: Option<String>,
}

//! What a drive was: how far, how long, and of how much of it anything is known.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::MotionDoubtRecord;

/// What a drive was, in a few numbers, and why nothing was found where nothing was.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DriveSummary {
    /// Metres driven where the camera's motion was measured; none where it was not for the greater part of the time.
    pub distance_m: Option<f64>,
    /// Seconds from the first frame to the last.
    pub duration_s: f64,
    /// Mean speed where the motion was measured, metres a second; none where `distance_m` is.
    pub mean_speed_mps: Option<f64>,
    /// Seconds of the drive in which no motion was measured, or one that is not believed; `distance_m` is without them.
    #[serde(default)]
    pub unmeasured_s: f64,
    /// Share of the frames behind another one whose motion was measured, 0 to 1; elsewhere it goes on as before.
    pub motion_share: f64,
    /// Share of the frames in which an edge of the lane is known, 0 to 1; none where no lane was looked for.
    pub lane_share: Option<f64>,
    /// Share of the frames in which a feature of the route is followed, 0 to 1; none without a route.
    pub feature_share: Option<f64>,
    /// Frames whose motion is not believed, by why.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub motion_doubts: BTreeMap<MotionDoubtRecord, u64>,
    /// What a reader should know first, a sentence each: what contradicts what, and why nothing was found where nothing was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
}

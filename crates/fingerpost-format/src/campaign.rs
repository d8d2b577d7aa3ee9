//! `campaign.json`: many simulated drives in numbers.

use serde::{Deserialize, Serialize};

use crate::{ErrorQuantiles, FeatureSummary, TruthSummary};

/// A campaign of simulated drives: as a whole, by conditions, and drive by drive.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Campaign {
    /// Drives asked for.
    pub drives_wanted: u64,
    /// Whether the campaign was ended before all of them were done.
    pub interrupted: bool,
    /// All drives that are done.
    pub total: CampaignGroup,
    /// The same by conditions, in the order they were asked for; those of no drive are left out.
    pub conditions: Vec<CampaignGroup>,
    /// The drives with the most features missed or falsely detected, then with the largest errors, worst first.
    pub worst: Vec<WorstDrive>,
    /// Every drive that is done, in the order of seeds.
    pub drives: Vec<CampaignDrive>,
}

/// Several drives in numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CampaignGroup {
    /// Conditions of the drives; none for all.
    pub conditions: Option<String>,
    /// Drives done, failed ones with them.
    pub drives: u64,
    /// Drives that ended in an error; they are in no other number.
    pub drives_failed: u64,
    /// Features that the truths pass.
    pub features_total: u64,
    /// Of those, detected.
    pub features_detected: u64,
    /// Detections of a feature that was not there.
    pub false_detections: u64,
    /// Features arrived at.
    pub arrivals: u64,
    /// Times that a feature was lost.
    pub losses: u64,
    /// Share of the features that are detected; none without any.
    #[serde(default)]
    pub found_share: Option<f64>,
    /// False detections by these and the features that are detected; none without any.
    #[serde(default)]
    pub false_share: Option<f64>,
    /// Distance between reported and true place of the followed feature over the frames of all drives, metres.
    pub position_error_m: Option<ErrorQuantiles>,
    /// The same over features: of each the median over the frames in which it is followed, metres.
    #[serde(default)]
    pub feature_error_m: Option<ErrorQuantiles>,
    /// Error of a place forward and to the left, each by its reported standard deviation, over frames. Of honest standard
    /// deviations the quantiles are about 1, 2 and 2.6.
    #[serde(default)]
    pub error_per_sigma: Option<SigmaQuantiles>,
    /// The same over features: of each the medians over the frames in which it is followed.
    #[serde(default)]
    pub feature_error_per_sigma: Option<SigmaQuantiles>,
    /// Frames in which a feature is followed that is held for there with a probability of at least 0.95.
    #[serde(default)]
    pub confident_frames: u64,
    /// Of those, the ones whose feature is not there, or is farther than a false detection's bound from its reported place.
    #[serde(default)]
    pub confident_frames_off: u64,
    /// Features whose first detection can be held against where they were expected in the frame before.
    #[serde(default)]
    pub features_expected: u64,
    /// Of those, the ones whose distance was better known by that expectation than by the detection.
    #[serde(default)]
    pub features_made_worse: u64,
    /// Error of a drive's summed motion, percent of its length, over drives.
    pub motion_error_pct: Option<ErrorQuantiles>,
    /// Where the road surface ends against where the road does, over the frames of all drives; none where no edge was to be seen.
    #[serde(default)]
    pub road_edges: Option<RoadEdgeSummary>,
}

/// The ends of the road surface to the left and right of the vehicle's axis against the road's edges, 4 to 12 m ahead.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct RoadEdgeSummary {
    /// Edges that are in view and shown by the picture: one a side, section across the road and frame.
    pub edges: u64,
    /// Of those, the ones beyond which the surface goes on to the end of what is looked at.
    pub missed: u64,
    /// Share of the edges that the surface has within 0.3 m of their place.
    pub within_share: f64,
    /// Distance between the surface's end and the edge, across the vehicle's axis, metres, in steps of 2 cm, 4 m for all beyond; of those
    /// that are missed as far as the surface goes on.
    pub error_m: ErrorQuantiles,
}

/// Quantiles of errors by their standard deviations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SigmaQuantiles {
    /// 68th percentile.
    pub p68: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest.
    pub max: f64,
}

/// A simulated drive in numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CampaignDrive {
    /// The seed it follows from.
    pub seed: u64,
    /// Its conditions.
    pub conditions: String,
    /// Length of the route, metres.
    pub route_m: f64,
    /// Frames processed.
    pub frames: u64,
    /// Times that a feature was lost.
    pub losses: u64,
    /// Comparison with truth.
    #[serde(flatten)]
    pub truth: TruthSummary,
    /// Every feature of the route, in its order.
    pub features: Vec<FeatureSummary>,
    /// Where the road surface ends against where the road does; none where no edge was to be seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub road_edges: Option<RoadEdgeSummary>,
    /// Why there are no numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// A drive that is worth a look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstDrive {
    /// The seed it follows from.
    pub seed: u64,
    /// Its conditions.
    pub conditions: String,
    /// Features missed.
    pub missed: u64,
    /// Features falsely detected.
    pub false_detections: u64,
    /// 95th percentile of its position error, metres.
    pub position_error_p95_m: Option<f64>,
}

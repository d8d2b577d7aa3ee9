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
    /// Distance between reported and true place of the followed feature over the frames of all drives, metres.
    pub position_error_m: Option<ErrorQuantiles>,
    /// Error of a drive's summed motion, percent of its length, over drives.
    pub motion_error_pct: Option<ErrorQuantiles>,
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

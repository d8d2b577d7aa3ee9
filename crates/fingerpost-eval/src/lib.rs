//! Metrics: what became of each route feature of a run, how far results lie from the truth, how well road was told.
//!
//! Records of frames and truth in, numbers out. Nothing here knows how the method works or opens a file; the same
//! numbers come out of the same records wherever they are computed.
//!
//! Quantiles are nearest-rank: the smallest value that at least the stated share of values does not exceed, so that
//! every quantile is a value that occurred.

mod campaign;
mod claims;
mod closed_loop;
mod drive;
mod error;
mod features;
mod first_detections;
mod fixes;
mod junctions;
mod kerbs;
mod lanes;
mod location;
mod motion;
mod pose;
mod quantiles;
mod remarks;
mod road;
mod road_edges;
mod surface_end;
mod truth_features;

pub use campaign::CampaignTally;
pub use claims::{CONFIDENT_FROM, Claim, ClaimError, DriveClaims, FirstDetection};
pub use closed_loop::{LoopWatch, closed_loop_table};
pub use drive::DriveTotals;
pub use error::EvalError;
pub use features::{FeatureIdentity, FeatureOutcomes, feature_summaries};
pub use first_detections::first_detections;
pub use junctions::{COUNTED_WITHIN_M, FALSE_BEYOND_M, JunctionEvaluation, evaluate_junctions};
pub use kerbs::{KERBS_AHEAD_M, KerbEvaluation, KerbScores, LEAST_KERB_M, PAVEMENT_M};
pub use lanes::{
    LANE_ROI_ROWS, LANE_THRESHOLDS_PX2, LaneCell, LaneDeviation, LaneError, LaneEvaluation, LaneMean,
    LaneMeasure, LpdDivisor, TuSimpleScores, column_at_row, evaluate_lanes, evaluate_tusimple,
    lane_picture_px, mean_of_lanes,
};
pub use location::{FixSample, evaluate_location};
pub use motion::{MotionEvaluation, evaluate_motion};
pub use pose::{PlanarPose, PosesError, poses_from_kitti, poses_from_truth};
pub use quantiles::{error_quantiles, stage_time};
pub use road::{RoadEvaluation, RoadLabels, RoadScores};
pub use road_edges::{EDGE_WITHIN_M, EDGES_AHEAD_M, EDGES_ASIDE_M, EDGES_EVERY_M, EdgeScene, RoadEdgeScores};

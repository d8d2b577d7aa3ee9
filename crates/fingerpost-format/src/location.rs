//! `fix.jsonl` and `summary.json` of `locate`: where the vehicle is on the map.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{ErrorQuantiles, StageTime};

/// What a fix is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FixStatus {
    /// One place has all but the risk.
    Converged,
    /// Several places are possible.
    Ambiguous,
    /// It was converged; the place is still the most probable, but not to within the risk.
    Coasting,
    /// On no road of the map, or nothing is known.
    Lost,
}

/// One line of `fix.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FixLine {
    /// Time of the motion log's row, seconds.
    pub t_s: f64,
    /// What the fix is worth.
    pub status: FixStatus,
    /// Latitude, degrees.
    pub lat: f64,
    /// Longitude, degrees.
    pub lon: f64,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Covariance of the place, square metres: `[[east, east-north], [east-north, north]]`.
    pub covariance_m2: [[f64; 2]; 2],
    /// Protection level: the vehicle is farther away with at most the probability `risk`, metres; none where that cannot be said.
    pub bound_m: Option<f64>,
    /// Its risk.
    pub risk: f64,
    /// Probability of this place.
    pub weight: f64,
    /// Probability of being on no road of the map.
    pub off_map: f64,
    /// How long nothing had been measured before this row, seconds; none where rows follow each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen_s: Option<f64>,
    /// The place that GPS gave with this row, where it gave one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gps: Option<GpsLine>,
    /// Number of hypotheses.
    pub hypotheses: usize,
    /// The heaviest of them.
    pub places: Vec<PlaceLine>,
}

/// What was made of a place by GPS.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GpsLine {
    /// East and north of it from the fix, metres.
    pub innovation_m: [f64; 2],
    /// Whether it agrees with the fix; one that does not moves nothing.
    pub believed: bool,
}

/// Places by GPS over a drive.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GpsCount {
    /// How many there were.
    pub places: usize,
    /// How many of them did not agree with the fix.
    pub not_believed: usize,
}

/// What was wrong with a motion log.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionFaults {
    /// Lines passed over that hold something else than numbers.
    pub not_numbers: usize,
    /// Lines passed over that are no later than one before.
    pub not_later: usize,
    /// Rows passed over of which the motion is none of a car.
    pub impossible: usize,
    /// Gaps after which the vehicle may have gone anywhere near.
    pub gaps: usize,
    /// The longest of them, seconds; 0 where there is none.
    pub longest_gap_s: f64,
    /// The longest time in which the vehicle drove and neither speed nor yaw rate changed in any digit, seconds: a sensor that is
    /// stuck, or a log that is made up.
    pub longest_repeat_s: f64,
}

/// A place where the vehicle may be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlaceLine {
    /// Latitude, degrees.
    pub lat: f64,
    /// Longitude, degrees.
    pub lon: f64,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Its probability.
    pub weight: f64,
}

/// `summary.json` of `locate`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LocationSummary {
    /// Program, version and commit.
    pub written_by: String,
    /// Rows of the motion log.
    pub rows: usize,
    /// Rows by what their fix was worth.
    pub statuses: BTreeMap<FixStatus, usize>,
    /// Time of the first converged fix, seconds from the first row; none where there is none.
    pub converged_s: Option<f64>,
    /// Risk of the protection levels.
    pub risk: f64,
    /// Most hypotheses at a time.
    pub most_hypotheses: usize,
    /// What was wrong with the motion log.
    #[serde(default)]
    pub motion: MotionFaults,
    /// Places by GPS; none where there was no GPS.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gps: Option<GpsCount>,
    /// What of the map was not understood.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub map_notices: Vec<MapNoticeRecord>,
    /// Wall time of a row.
    pub row_ms: Option<StageTime>,
    /// Comparison with truth.
    #[serde(flatten)]
    pub truth: Option<LocationScores>,
}

/// How often something of one kind in a map was not understood.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapNoticeRecord {
    /// What it is about: `width`, `oneway`, `remark` and so on.
    pub kind: String,
    /// How many times.
    pub count: usize,
    /// The first place and what stands there.
    pub first: String,
}

/// Fixes against truth. Rows count from the first converged one on, whatever their status, unless something else is said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LocationScores {
    /// Distance driven up to the first converged fix, metres; none where there is none.
    pub converged_m: Option<f64>,
    /// Distance of the fix from the true place, metres.
    pub fix_error_m: Option<ErrorQuantiles>,
    /// The same across the true heading.
    pub lateral_error_m: Option<ErrorQuantiles>,
    /// The same along it.
    pub longitudinal_error_m: Option<ErrorQuantiles>,
    /// Shares of the rows with an error of at most 1, 3 and 5 m.
    pub recall: Option<Recall>,
    /// Converged rows in which the true place lies outside the protection level.
    pub bound_violations: usize,
    /// The longest time without interruption in which it did, seconds.
    pub longest_violation_s: f64,
    /// Protection levels of converged rows, metres.
    pub bound_m: Option<ErrorQuantiles>,
    /// Mean of the squared error of converged rows in units of `covariance_m2`, which counts the other places that are possible; 2 where it
    /// is honest.
    pub nees: Option<f64>,
}

/// Shares of rows within 1, 3 and 5 m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Recall {
    /// Across the true heading.
    pub lateral: [f64; 3],
    /// Along it.
    pub longitudinal: [f64; 3],
}

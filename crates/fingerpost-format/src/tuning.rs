//! `trials.jsonl` and `front.json`: settings that were tried, and those that no others beat in everything.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::CampaignGroup;

/// Values of settings by their keys, table and all, as in `track.detect_present`.
pub type TriedSettings = BTreeMap<String, Value>;

/// What is to be small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TuningObjective {
    /// Share of the features that are not found.
    Missed,
    /// False detections a drive.
    False,
    /// Median error of a feature's place over frames, metres.
    ErrorP50,
    /// Its 95th percentile, metres.
    ErrorP95,
    /// How far reported standard deviations are from honest ones: the unsigned logarithm of the 68th percentile of error by
    /// standard deviation, which is 1 of honest ones.
    Sigma,
    /// Wall time of the method, milliseconds a frame. It is the machine's as well as the settings'.
    Ms,
}

impl TuningObjective {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Missed, Self::False, Self::ErrorP50, Self::ErrorP95, Self::Sigma, Self::Ms];

    /// Its name in files and command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Missed => "missed",
            Self::False => "false",
            Self::ErrorP50 => "error_p50",
            Self::ErrorP95 => "error_p95",
            Self::Sigma => "sigma",
            Self::Ms => "ms",
        }
    }

    /// What it says, with its unit.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Missed => "features missed, share",
            Self::False => "false detections a drive",
            Self::ErrorP50 => "position error, median, m",
            Self::ErrorP95 => "position error, p95, m",
            Self::Sigma => "|ln| of p68 of error by sigma",
            Self::Ms => "method, ms a frame",
        }
    }

    /// Its value; none where it cannot be told, as the error of places where nothing is found.
    pub fn of(self, scores: &TuningScores, ms_per_frame: f64) -> Option<f64> {
        match self {
            Self::Missed => scores.missed_share,
            Self::False => scores.false_per_drive,
            Self::ErrorP50 => scores.error_p50_m,
            Self::ErrorP95 => scores.error_p95_m,
            Self::Sigma => {
                scores.error_per_sigma_p68.filter(|p68| *p68 > 0.0).map(|p68| libm::log(p68).abs())
            }
            Self::Ms => Some(ms_per_frame),
        }
    }
}

/// Settings on several drives, in numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct TuningScores {
    /// Features that the truths pass.
    pub features: u64,
    /// Share of them that are not found; none without any.
    pub missed_share: Option<f64>,
    /// False detections a drive; none without a drive.
    pub false_per_drive: Option<f64>,
    /// Distance between reported and true place of the followed feature over the frames of all drives, median, metres.
    pub error_p50_m: Option<f64>,
    /// Its 95th percentile, metres.
    pub error_p95_m: Option<f64>,
    /// 68th percentile of the error forward and to the left by its reported standard deviation: 1 of honest ones.
    pub error_per_sigma_p68: Option<f64>,
}

impl From<&CampaignGroup> for TuningScores {
    fn from(group: &CampaignGroup) -> Self {
        let drives = group.drives.saturating_sub(group.drives_failed);
        let missed = group.features_total.saturating_sub(group.features_detected);
        let share = |part: u64, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        Self {
            features: group.features_total,
            missed_share: share(missed, group.features_total),
            false_per_drive: share(group.false_detections, drives),
            error_p50_m: group.position_error_m.map(|error_m| error_m.p50),
            error_p95_m: group.position_error_m.map(|error_m| error_m.p95),
            error_per_sigma_p68: group.error_per_sigma.map(|by| by.p68),
        }
    }
}

/// What a trial is for, and so on which drives it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TuningPurpose {
    /// One setting changed, on the drives that are searched with: to see which settings matter.
    Screening,
    /// Settings that the search asked for, on the drives that are searched with.
    Search,
    /// Settings of the front, on the drives that the search never sees.
    HeldBack,
}

/// One line of `trials.jsonl`: settings that were tried on some drives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TuningTrial {
    /// Number of the trial among those of its purpose, or of the search where it is on drives held back; the first, 0, is that of
    /// the settings that the search begins with.
    pub trial: u64,
    /// What it is for.
    pub purpose: TuningPurpose,
    /// The settings that are searched.
    pub settings: TriedSettings,
    /// What came of them; none where the method refused them.
    pub scores: Option<TuningScores>,
    /// Wall time of the method, milliseconds a frame.
    pub ms_per_frame: f64,
    /// Why there are no scores.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl TuningTrial {
    /// What came of it, objective by objective; infinity where it cannot be told.
    pub fn objectives(&self, objectives: &[TuningObjective]) -> Vec<f64> {
        let value = |objective: &TuningObjective| objective.of(self.scores.as_ref()?, self.ms_per_frame);
        objectives.iter().map(|objective| value(objective).unwrap_or(f64::INFINITY)).collect()
    }
}

/// `front.json`: the settings that no tried ones beat in everything.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TuningFront {
    /// What was to be small.
    pub objectives: Vec<TuningObjective>,
    /// Trials that the front is of.
    pub trials: u64,
    /// Drives that were searched with, and drives that were held back.
    pub drives: [u64; 2],
    /// The settings that the search began with.
    pub defaults: TuningPoint,
    /// The front, by its first objective; the settings that the search began with are in it where none beat them.
    pub front: Vec<TuningPoint>,
}

/// Settings with what came of them. Times are in `trials.jsonl` alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TuningPoint {
    /// Number of the trial.
    pub trial: u64,
    /// Name of the file with all settings; none of the ones that the search began with.
    pub config: Option<String>,
    /// The settings that were searched.
    pub settings: TriedSettings,
    /// On the drives that were searched with.
    pub tuned: Option<TuningScores>,
    /// On the drives that were held back; none without any.
    pub held_back: Option<TuningScores>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ErrorQuantiles, SigmaQuantiles};

    #[test]
    fn objectives_are_those_of_the_drives_and_unknown_ones_worst() {
        let group = CampaignGroup {
            drives: 5,
            drives_failed: 1,
            features_total: 8,
            features_detected: 6,
            false_detections: 2,
            position_error_m: Some(ErrorQuantiles { p50: 0.2, p95: 0.9, max: 2.0 }),
            error_per_sigma: Some(SigmaQuantiles { p68: 0.5, ..SigmaQuantiles::default() }),
            ..CampaignGroup::default()
        };
        let mut trial = TuningTrial {
            trial: 3,
            purpose: TuningPurpose::Search,
            settings: TriedSettings::new(),
            scores: Some((&group).into()),
            ms_per_frame: 12.0,
            error: None,
        };
        let values = trial.objectives(&TuningObjective::ALL);
        for (value, expected) in values.iter().zip([0.25, 0.5, 0.2, 0.9, libm::log(2.0_f64), 12.0]) {
            assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        }
        trial.scores = Some((&CampaignGroup::default()).into());
        assert_eq!(trial.objectives(&TuningObjective::ALL[..5]), [f64::INFINITY; 5]);
        trial.scores = None;
        assert_eq!(trial.objectives(&[TuningObjective::Ms]), [f64::INFINITY]);
    }

    #[test]
    fn names_are_those_of_the_files() {
        for objective in TuningObjective::ALL {
            assert_eq!(serde_json::to_value(objective).unwrap(), objective.name());
        }
    }
}

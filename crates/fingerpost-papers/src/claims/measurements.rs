//! What was measured of every drive, as the file of measurements keeps it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::scatter::Mean;

/// What was measured on a drive or clip, by name.
pub type Measured = BTreeMap<String, f64>;

/// One drive or clip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Kind of roads, or day of a clip.
    pub kind: String,
    /// Its seed.
    pub seed: u64,
    /// Most frames that were to be rendered.
    pub frames: u64,
    /// The program that measured it.
    pub written_by: String,
    /// By name: run and metric.
    pub values: Measured,
}

fingerpost_format::json_records!(Measurement);

/// All of them, in the order of kinds and seeds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measurements(Vec<Measurement>);

impl Measurements {
    /// In an order that does not depend on which drive was finished first.
    pub fn new(mut all: Vec<Measurement>) -> Self {
        all.sort_by(|a, b| (&a.kind, a.seed).cmp(&(&b.kind, b.seed)));
        Self(all)
    }

    /// A figure of every drive of a kind that has it, with the drive's seed.
    pub(super) fn of(&self, kind: &str, key: &str) -> Vec<(u64, f64)> {
        let drives = self.0.iter().filter(|drive| drive.kind == kind);
        drives.filter_map(|drive| Some((drive.seed, *drive.values.get(key)?))).collect()
    }

    /// The mean of several figures of every drive of a kind that has them all.
    pub(super) fn mean_of(&self, kind: &str, keys: &[String]) -> Vec<(u64, f64)> {
        let drives = self.0.iter().filter(|drive| drive.kind == kind);
        let mean = |drive: &Measurement| {
            let values =
                keys.iter().map(|key| drive.values.get(key).copied()).collect::<Option<Vec<f64>>>()?;
            (!values.is_empty()).then(|| (drive.seed, values.iter().sum::<f64>() / values.len() as f64))
        };
        drives.filter_map(mean).collect()
    }

    /// Two figures of the same drives.
    pub(super) fn pairs(&self, kind: &str, keys: [&str; 2]) -> Vec<[f64; 2]> {
        let drives = self.0.iter().filter(|drive| drive.kind == kind);
        drives
            .filter_map(|drive| {
                let [one, other] = keys.map(|key| drive.values.get(key).copied());
                Some([one?, other?])
            })
            .collect()
    }

    /// A figure's mean over the drives of a kind.
    pub(super) fn mean(&self, kind: &str, key: &str) -> Option<Mean> {
        let values: Vec<f64> = self.of(kind, key).into_iter().map(|(_, value)| value).collect();
        Mean::of(&values)
    }
}

//! Many drives in numbers: sums, and quantiles over the frames of all of them.

use fingerpost_format::{Campaign, CampaignDrive, CampaignGroup, WorstDrive};

use crate::claims::summarise;
use crate::{DriveClaims, error_quantiles};

/// Drives that are named for a look.
const NAMED_DRIVES: usize = 5;

/// Collects drives, in any order, into a [`Campaign`].
#[derive(Debug, Clone)]
pub struct CampaignTally {
    conditions: Vec<String>,
    wanted: u64,
    /// By seed, each with what it claimed.
    drives: Vec<(CampaignDrive, DriveClaims)>,
}

impl CampaignTally {
    /// None of `wanted` drives so far; `conditions` are reported in this order.
    pub fn new(conditions: &[String], wanted: u64) -> Self {
        Self { conditions: conditions.to_vec(), wanted, drives: Vec::new() }
    }

    /// Adds a drive with what it claimed of its features.
    pub fn add(&mut self, drive: CampaignDrive, claims: DriveClaims) {
        let place = self.drives.partition_point(|(before, _)| before.seed <= drive.seed);
        self.drives.insert(place, (drive, claims));
    }

    /// Drives so far.
    pub fn done(&self) -> u64 {
        self.drives.len() as u64
    }

    /// The campaign so far; the same whatever order the drives came in.
    pub fn campaign(&self) -> Campaign {
        let groups = self.conditions.iter().map(|name| self.group(Some(name)));
        Campaign {
            drives_wanted: self.wanted,
            interrupted: self.done() < self.wanted,
            total: self.group(None),
            conditions: groups.filter(|group| group.drives > 0).collect(),
            worst: self.worst(),
            drives: self.drives.iter().map(|(drive, _)| drive.clone()).collect(),
        }
    }

    /// The drives of some conditions, or all.
    fn group(&self, conditions: Option<&String>) -> CampaignGroup {
        let mut group = CampaignGroup { conditions: conditions.cloned(), ..CampaignGroup::default() };
        let (mut claimed, mut motion_errors_pct) = (Vec::new(), Vec::new());
        for (drive, claims) in &self.drives {
            if conditions.is_some_and(|name| *name != drive.conditions) {
                continue;
            }
            group.drives += 1;
            if drive.error.is_some() {
                group.drives_failed += 1;
                continue;
            }
            group.features_total += drive.truth.features_total;
            group.features_detected += drive.truth.features_detected;
            group.false_detections += drive.truth.false_detections;
            group.arrivals += drive.truth.arrivals;
            group.losses += drive.losses;
            claimed.push(claims);
            motion_errors_pct.extend(drive.truth.motion_error_pct);
        }
        summarise(&mut group, claimed.into_iter());
        let share = |part: u64, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        group.found_share = share(group.features_detected, group.features_total);
        group.false_share = share(group.false_detections, group.features_detected + group.false_detections);
        group.motion_error_pct = error_quantiles(motion_errors_pct);
        group
    }

    fn worst(&self) -> Vec<WorstDrive> {
        let sound = self.drives.iter().map(|(drive, _)| drive).filter(|drive| drive.error.is_none());
        let mut worst: Vec<WorstDrive> = sound
            .map(|drive| WorstDrive {
                seed: drive.seed,
                conditions: drive.conditions.clone(),
                missed: drive.truth.features_total.saturating_sub(drive.truth.features_detected),
                false_detections: drive.truth.false_detections,
                position_error_p95_m: drive.truth.position_error_m.map(|error_m| error_m.p95),
            })
            .collect();
        let wrong = |drive: &WorstDrive| drive.missed + drive.false_detections;
        let error_m = |drive: &WorstDrive| drive.position_error_p95_m.unwrap_or(0.0);
        worst.sort_by(|a, b| wrong(b).cmp(&wrong(a)).then(error_m(b).total_cmp(&error_m(a))));
        worst.truncate(NAMED_DRIVES);
        worst
    }
}

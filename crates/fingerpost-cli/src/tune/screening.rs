//! Which settings matter: each of a list changed by itself, before the search.

use anyhow::Result;
use fingerpost_format::{TuningObjective, TuningPurpose, TuningTrial};
use fingerpost_io::TuningFolder;
use fingerpost_search::{effects, one_at_a_time};

use super::drives::TuneDrive;
use super::trials::{Bench, WantedTrial};
use crate::output;

/// Numbers that are screened: of tracker, road surface, motion, mount and progress those by which something is believed or
/// not. Steps, reaches and sizes are left out: they cost time or are geometry.
pub(super) const CANDIDATES: [&str; 10] = [
    "track.detect_present",
    "track.lost_present",
    "track.detect_sigma_m",
    "track.width_sigma_share",
    "track.kerb_radius_m",
    "road_surface.memory.doubt",
    "road_surface.online.half_step",
    "motion.direct.width_m",
    "mount.suspension_sigma_deg",
    "route_progress.start_sigma_m",
];

/// The names of the settings that matter most of those on the bench, `keep` of them, in the order of the list; none where an end
/// is wanted.
pub(super) fn screen(
    bench: &Bench<'_>,
    keep: usize,
    objectives: &[TuningObjective],
    drives: &[TuneDrive],
    done: &mut Vec<TuningTrial>,
    folder: &mut TuningFolder,
) -> Result<Option<Vec<String>>> {
    let settings = bench.settings;
    let start = settings.start();
    let allowed = |values: &[f64]| settings.config(&settings.named(values)).is_some();
    let points = one_at_a_time(&settings.variables(), &start, &allowed);
    let all = [&start].into_iter().chain(points.iter().map(|(_, values)| values));
    let wanted: Vec<WantedTrial> = (0..)
        .zip(all)
        .map(|(trial, values)| WantedTrial { trial, settings: settings.named(values) })
        .collect();
    bench.bar.inc_length(wanted.len() as u64);
    bench.trials(&wanted, TuningPurpose::Screening, drives, done, folder)?;
    let values =
        |trial: u64| super::trial(done, trial, TuningPurpose::Screening).map(|t| t.objectives(objectives));
    let of_points: Option<Vec<(usize, Vec<f64>)>> =
        (1..).zip(&points).map(|(trial, (index, _))| Some((*index, values(trial)?))).collect();
    let (Some(first), Some(changed)) = (values(0), of_points) else { return Ok(None) };
    let effects = effects(settings.keys.len(), &first, &changed);
    let mut order: Vec<usize> = (0..effects.len()).collect();
    order.sort_by(|&a, &b| effects[b].total_cmp(&effects[a]));
    output::message(
        "effect  key (largest change of each objective as a share of the largest of all keys, summed)",
    );
    for (place, &index) in order.iter().enumerate() {
        let taken = if place < keep { "searched" } else { "" };
        output::message(&format!("{:>6.2}  {:36}  {taken}", effects[index], settings.keys[index].name));
    }
    order.truncate(keep);
    order.sort_unstable();
    Ok(Some(order.into_iter().map(|index| settings.keys[index].name.clone()).collect()))
}

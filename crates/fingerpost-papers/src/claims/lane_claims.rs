//! What paper 3 claims of its accuracy (IV-B and figure 21), held against the simulated clips.

use fingerpost_eval::{LANE_ROI_ROWS, LANE_THRESHOLDS_PX2};

use super::measurements::Measurements;
use super::verdict::{Better, Compared, Expectation};

/// Six samples as in the paper, which chose them by marking, time of day, contrast, shadow and glare: the simulator's days that
/// come nearest.
pub const SAMPLES: [(&str, &str); 6] = [
    ("lane_continuous", "continuous lines"),
    ("lane_broken", "broken lines"),
    ("lane_double", "double line, the inner one broken"),
    ("lane_night", "night, oncoming lamps"),
    ("lane_shadows", "shadows"),
    ("lane_patches", "patches on the asphalt"),
];

/// Name of the accuracy of a region and a threshold.
pub fn cell_name(roi_rows: u32, threshold_px2: f64) -> String {
    format!("rows_{roi_rows}.within_{threshold_px2}")
}

/// Accuracy from which the paper's "87~98%" begins.
const LEAST_ACCURACY_PCT: f64 = 87.0;

/// A claim with its figures.
pub(super) struct LaneClaim {
    pub(super) title: &'static str,
    pub(super) words: &'static str,
    /// What is compared with what.
    pub(super) compared: [&'static str; 2],
    pub(super) expectation: Expectation,
    pub(super) result: Option<Compared>,
}

/// Accuracies by seed: of a sample, the mean over all cells that `wanted` names.
fn accuracies(
    measurements: &Measurements,
    sample: &str,
    wanted: &dyn Fn(u32, f64) -> bool,
) -> Vec<(u64, f64)> {
    let cells = LANE_ROI_ROWS.iter().flat_map(|rows| LANE_THRESHOLDS_PX2.map(|within| (*rows, within)));
    let keys: Vec<String> = cells
        .filter(|(rows, within)| wanted(*rows, *within))
        .map(|(rows, within)| cell_name(rows, within))
        .collect();
    measurements.mean_of(sample, &keys)
}

/// The mean over several samples, by seed, of the seeds that all of them have.
fn over_samples(
    measurements: &Measurements,
    samples: &[&str],
    wanted: &dyn Fn(u32, f64) -> bool,
) -> Vec<(u64, f64)> {
    let all: Vec<Vec<(u64, f64)>> =
        samples.iter().map(|sample| accuracies(measurements, sample, wanted)).collect();
    let Some((first, others)) = all.split_first() else { return Vec::new() };
    let mean = |(seed, value): &(u64, f64)| {
        let rest =
            others.iter().map(|other| other.iter().find(|(of, _)| of == seed).map(|(_, value)| *value));
        let sum: f64 = rest.collect::<Option<Vec<f64>>>()?.iter().sum();
        Some((*seed, (value + sum) / all.len() as f64))
    };
    first.iter().filter_map(mean).collect()
}

fn paired(one: &[(u64, f64)], other: &[(u64, f64)]) -> Vec<[f64; 2]> {
    let pair = |(seed, value): &(u64, f64)| {
        Some([*value, other.iter().find(|(of, _)| of == seed).map(|(_, value)| *value)?])
    };
    one.iter().filter_map(pair).collect()
}

/// Mean accuracy of every region (rows) and threshold (columns), over all samples and seeds, percent.
pub(super) fn table(measurements: &Measurements, samples: &[&str]) -> Vec<Vec<f64>> {
    let cell = |rows: u32, within: f64| {
        let wanted = move |r: u32, w: f64| r == rows && (w - within).abs() < f64::EPSILON;
        let values = over_samples(measurements, samples, &wanted);
        values.iter().map(|(_, value)| value).sum::<f64>() / values.len() as f64
    };
    LANE_ROI_ROWS
        .iter()
        .map(|rows| LANE_THRESHOLDS_PX2.iter().map(|within| cell(*rows, *within)).collect())
        .collect()
}

/// The claims with their figures.
pub(super) fn lane_claims(measurements: &Measurements) -> Vec<LaneClaim> {
    let samples: Vec<&str> = SAMPLES.iter().map(|(name, _)| *name).collect();
    let mean =
        |samples: &[&str], wanted: &dyn Fn(u32, f64) -> bool| over_samples(measurements, samples, wanted);
    let within = |px2: f64| move |_: u32, w: f64| (w - px2).abs() < f64::EPSILON;
    let rows = |count: u32| move |r: u32, _: f64| r == count;
    let any = |_: u32, _: f64| true;
    let judge = |expectation: Expectation, pairs: Vec<[f64; 2]>| expectation.judge(Better::Higher, &pairs);
    let all = mean(&samples, &any);
    let others =
        |name: &str| -> Vec<&str> { samples.iter().copied().filter(|sample| *sample != name).collect() };
    let claim = |title, words, compared, expectation, pairs| LaneClaim {
        title,
        words,
        compared,
        expectation,
        result: judge(expectation, pairs),
    };
    let better = Expectation::BetterThan;
    let (of_threshold, of_rows) = (
        paired(&mean(&samples, &within(20.0)), &mean(&samples, &within(10.0))),
        paired(&mean(&samples, &rows(100)), &mean(&samples, &rows(150))),
    );
    let effects = of_threshold.iter().zip(&of_rows).map(|(t, r)| [(t[0] - t[1]).abs(), (r[0] - r[1]).abs()]);
    let effects = effects.collect();
    vec![
        claim(
            "Accuracy of 87 to 98 %",
            "The results concentrate in the range of 87~98% of accuracy",
            ["mean accuracy", "87 %"],
            better,
            all.iter().map(|(_, value)| [*value, LEAST_ACCURACY_PCT]).collect(),
        ),
        claim(
            "A larger threshold, a higher accuracy",
            "the tracking accuracy grows up with higher deviation threshold values",
            ["threshold 20", "threshold 10"],
            better,
            of_threshold,
        ),
        claim(
            "The region's rows matter less than the threshold",
            "The variation of the ROI does not have the same impact on the results",
            ["change from threshold 10 to 20", "change from 150 to 100 rows"],
            better,
            effects,
        ),
        claim(
            "Continuous lines are the easiest",
            "The highest assertiveness indices were observed in tracks with continuous lane markings",
            ["continuous lines", "mean of the others"],
            better,
            paired(&mean(&["lane_continuous"], &any), &mean(&others("lane_continuous"), &any)),
        ),
        claim(
            "Double lines with an inner broken one are the hardest",
            "the lowest performance indices were observed double marked with the inner lane dashed",
            ["double line, the inner one broken", "mean of the others"],
            Expectation::WorseThan,
            paired(&mean(&["lane_double"], &any), &mean(&others("lane_double"), &any)),
        ),
    ]
}

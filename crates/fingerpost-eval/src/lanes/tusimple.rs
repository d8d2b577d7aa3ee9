//! The scores of the TuSimple lane benchmark (2017), as its program `lane.py` computes them.
//!
//! In each picture every labelled lane is held against every found one at the sampled rows. A row agrees where the two are
//! less than 20 pixels apart across the lane (so more along a row, by the lane's slant), or where neither has a point; the
//! best share of a labelled lane over the found ones is its accuracy, and from 0.85 on it is matched. Of the five lanes
//! that a picture may have, the worst is forgiven. Found lanes left over, as a share of the found, are false positives;
//! labelled lanes not matched, as a share of the labelled, false negatives. A picture with more than two lanes too many is
//! all false. All three are averaged over the pictures.

use std::collections::BTreeMap;

use fingerpost_format::{FrameRecord, LanesRecord, TUSIMPLE_NO_POINT, TruthRecord, TuSimpleRecord};
use serde::Serialize;

use super::edge::column_at_row;
use super::error::LaneError;
use crate::EvalError;
use crate::error::check_ascending;

/// A point agrees when it is less than this away, across a lane, pixels.
const POINT_WITHIN_PX: f64 = 20.0;
/// A lane is matched from this share of agreeing rows on.
const MATCHED_SHARE: f64 = 0.85;
/// Lanes that count in a picture; of one more the worst is forgiven.
const COUNTED_LANES: usize = 4;
/// So many lanes too many are still judged one by one.
const SPARE_LANES: usize = 2;
/// Where a missing point is put: far enough from every column, and beside another missing one.
const MISSING_U_PX: f64 = -100.0;
/// Rows between samples, where the truth is not in the benchmark's form: its own spacing.
const SAMPLE_ROWS: usize = 10;

/// Means over the pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct TuSimpleScores {
    /// Pictures with a labelled lane.
    pub pictures: u64,
    /// Share of rows told right, 0 to 1.
    pub accuracy: f64,
    /// FP: found lanes that are none, as a share of the found.
    pub false_positives: f64,
    /// FN: labelled lanes that were not found, as a share of the labelled.
    pub false_negatives: f64,
}

/// Scores a run against labels in the benchmark's form: one line a frame of the run, in its order.
///
/// The found lanes are the two edges of the vehicle's lane; the edges of other lanes in the labels count as not found.
/// `picture_px` is the size of the run's pictures, where it is known.
///
/// # Errors
/// [`LaneError`] when frames do not ascend, there is not a line for every frame, a lane has not a point for every row, or
/// labels lie outside the pictures.
pub fn evaluate_tusimple(
    records: &[FrameRecord],
    labels: &[TuSimpleRecord],
    picture_px: Option<[u32; 2]>,
) -> Result<TuSimpleScores, LaneError> {
    check_ascending("run", records.iter().map(|record| record.frame))?;
    if records.is_empty() {
        return Err(EvalError::NoFrames.into());
    }
    if records.len() != labels.len() {
        return Err(LaneError::LabelCount { frames: records.len(), labels: labels.len() });
    }
    for (index, label) in labels.iter().enumerate() {
        let rows = label.h_samples.len();
        if let Some(lane) = label.lanes.iter().find(|lane| lane.len() != rows) {
            return Err(LaneError::LabelRows { line: index + 1, rows, points: lane.len() });
        }
        if let Some(picture_px) = picture_px
            && !inside(label, picture_px)
        {
            return Err(LaneError::LabelOutside { line: index + 1, picture_px });
        }
    }
    let pictures = records.iter().zip(labels).map(|(record, label)| {
        let found = found_lanes(record.lanes.as_ref(), &label.h_samples, picture_px.map(|[width, _]| width));
        picture_scores(&found, &label.lanes, &label.h_samples)
    });
    Ok(mean_scores(pictures))
}

fn inside(label: &TuSimpleRecord, [width, height]: [u32; 2]) -> bool {
    label.h_samples.iter().all(|row| *row < f64::from(height))
        && label.lanes.iter().flatten().all(|u| *u < f64::from(width))
}

/// Scores against edges in pictures, at every tenth row that the truth reaches anywhere in the clip.
pub(super) fn scores_of_truth(
    by_frame: &BTreeMap<u64, &FrameRecord>,
    truth: &[TruthRecord],
    [width, height]: [u32; 2],
) -> Option<TuSimpleScores> {
    let edges = |truth: &TruthRecord| [truth.lane_left_px.clone(), truth.lane_right_px.clone()];
    let reached = |row: f64| {
        let mut all = truth.iter().flat_map(|truth| [&truth.lane_left_px, &truth.lane_right_px]);
        all.any(|edge| column_at_row(edge, row).is_some())
    };
    let rows: Vec<f64> =
        (0..height).step_by(SAMPLE_ROWS).map(f64::from).filter(|row| reached(*row)).collect();
    let pictures: Vec<_> = truth
        .iter()
        .filter_map(|truth| {
            let labelled = sampled(&edges(truth), &rows, Some(width));
            let lanes = by_frame.get(&truth.frame).and_then(|record| record.lanes.as_ref());
            let found = found_lanes(lanes, &rows, Some(width));
            (!labelled.is_empty()).then(|| picture_scores(&found, &labelled, &rows))
        })
        .collect();
    (!pictures.is_empty()).then(|| mean_scores(pictures.into_iter()))
}

fn found_lanes(lanes: Option<&LanesRecord>, rows: &[f64], width: Option<u32>) -> Vec<Vec<f64>> {
    lanes
        .map_or_else(Vec::new, |lanes| sampled(&[lanes.left_px.clone(), lanes.right_px.clone()], rows, width))
}

/// Edges in the benchmark's form; those without a point are left out.
fn sampled(edges: &[Vec<[f64; 2]>], rows: &[f64], width: Option<u32>) -> Vec<Vec<f64>> {
    let column = |edge: &[[f64; 2]], row: f64| {
        let u = column_at_row(edge, row)?;
        let inside = u >= 0.0 && width.is_none_or(|width| u < f64::from(width));
        inside.then_some(u)
    };
    edges
        .iter()
        .map(|edge| rows.iter().map(|&row| column(edge, row).unwrap_or(TUSIMPLE_NO_POINT)).collect())
        .filter(|lane: &Vec<f64>| lane.iter().any(|&u| u >= 0.0))
        .collect()
}

/// Accuracy, false positives and false negatives of one picture.
fn picture_scores(found: &[Vec<f64>], labelled: &[Vec<f64>], rows: &[f64]) -> [f64; 3] {
    if found.len() > labelled.len() + SPARE_LANES {
        return [0.0, 0.0, 1.0];
    }
    let accuracies: Vec<f64> = labelled
        .iter()
        .map(|lane| {
            let within_px = POINT_WITHIN_PX / libm::cos(libm::atan(slant(lane, rows)));
            found.iter().map(|found| share(found, lane, within_px)).fold(0.0, f64::max)
        })
        .collect();
    let matched = accuracies.iter().filter(|accuracy| **accuracy >= MATCHED_SHARE).count();
    let (mut sum, mut missed) = (accuracies.iter().sum::<f64>(), labelled.len() - matched);
    if labelled.len() > COUNTED_LANES {
        sum -= accuracies.iter().copied().fold(f64::INFINITY, f64::min);
        missed = missed.saturating_sub(1);
    }
    let counted = labelled.len().clamp(1, COUNTED_LANES) as f64;
    let wrong = found.len() as f64 - matched as f64;
    [sum / counted, wrong / found.len().max(1) as f64, missed as f64 / counted]
}

/// Share of rows at which two lanes agree.
fn share(found: &[f64], labelled: &[f64], within_px: f64) -> f64 {
    let place = |u: f64| if u >= 0.0 { u } else { MISSING_U_PX };
    let agree = found.iter().zip(labelled).filter(|(f, l)| (place(**f) - place(**l)).abs() < within_px);
    agree.count() as f64 / labelled.len().max(1) as f64
}

/// Columns a row by which the straight line closest to a lane's points leans; 0 for a single point.
fn slant(lane: &[f64], rows: &[f64]) -> f64 {
    let points = || lane.iter().zip(rows).filter(|(u, _)| **u >= 0.0);
    let count = points().count() as f64;
    let (sum_u, sum_row) = points().fold((0.0, 0.0), |(us, rows), (u, row)| (us + u, rows + row));
    let (mean_u, mean_row) = (sum_u / count, sum_row / count);
    let (mut together, mut spread) = (0.0, 0.0);
    for (u, row) in points() {
        together += (u - mean_u) * (row - mean_row);
        spread += (row - mean_row).powi(2);
    }
    if spread > 0.0 { together / spread } else { 0.0 }
}

fn mean_scores(pictures: impl Iterator<Item = [f64; 3]>) -> TuSimpleScores {
    let (mut sums, mut count) = ([0.0; 3], 0_u64);
    for scores in pictures {
        count += 1;
        for (sum, score) in sums.iter_mut().zip(scores) {
            *sum += score;
        }
    }
    let [accuracy, false_positives, false_negatives] = sums.map(|sum| sum / count.max(1) as f64);
    TuSimpleScores { pictures: count, accuracy, false_positives, false_negatives }
}

//! Whether a run and a truth are of the same pictures.

use fingerpost_format::{FrameRecord, TruthRecord};

use super::error::LaneError;
use crate::EvalError;
use crate::error::check_ascending;

/// The size of the pictures that a run and a truth are about: what either says, which must agree, or else `given`.
///
/// # Errors
/// [`LaneError`] when they do not agree, neither says it and none is given, or a truth that does not say it reaches below
/// the pictures of that size.
pub fn lane_picture_px(
    run: Option<[u32; 2]>,
    truth: &[TruthRecord],
    given: Option<[u32; 2]>,
) -> Result<[u32; 2], LaneError> {
    let of_truth = size_of_truth(truth)?;
    if let (Some(run_px), Some(truth_px)) = (run.or(given), of_truth)
        && run_px != truth_px
    {
        return Err(LaneError::PictureSize { run_px, truth_px });
    }
    if let (Some(run_px), Some(truth_px)) = (run, given)
        && run_px != truth_px
    {
        return Err(LaneError::PictureSize { run_px, truth_px });
    }
    let picture_px = run.or(of_truth).or(given).ok_or(LaneError::NoPictureSize)?;
    if of_truth.is_none() {
        check_inside(truth, picture_px[1])?;
    }
    Ok(picture_px)
}

/// The size that the truth says its pictures have.
fn size_of_truth(truth: &[TruthRecord]) -> Result<Option<[u32; 2]>, LaneError> {
    let mut sizes = truth.iter().filter_map(|record| Some((record.frame, record.picture_px?)));
    let Some((_, before_px)) = sizes.next() else { return Ok(None) };
    match sizes.find(|(_, picture_px)| *picture_px != before_px) {
        Some((frame, picture_px)) => Err(LaneError::SizeChanges { frame, picture_px, before_px }),
        None => Ok(Some(before_px)),
    }
}

/// Edges below the last row are those of a larger picture.
fn check_inside(truth: &[TruthRecord], height: u32) -> Result<(), LaneError> {
    // A picture ends half a pixel below the middle of its last row; another half is left to rounding.
    let outside = |row: f64| row > f64::from(height);
    for record in truth {
        let points = record.lane_left_px.iter().chain(&record.lane_right_px);
        if let Some(&[_, row]) = points.clone().find(|point| outside(point[1])) {
            return Err(LaneError::Outside { frame: record.frame, row, height });
        }
    }
    Ok(())
}

/// Every frame of the run must be one of the truth.
pub(super) fn check_frames(records: &[FrameRecord], truth: &[TruthRecord]) -> Result<(), LaneError> {
    check_ascending("run", records.iter().map(|record| record.frame))?;
    check_ascending("truth", truth.iter().map(|record| record.frame))?;
    if records.is_empty() {
        return Err(EvalError::NoFrames.into());
    }
    let known = |frame: u64| truth.binary_search_by_key(&frame, |truth| truth.frame).is_ok();
    match records.iter().find(|record| !known(record.frame)) {
        Some(record) => Err(EvalError::NoTruth {
            frame: record.frame,
            truths: truth.len(),
            first: truth.first().map_or(0, |truth| truth.frame),
            last: truth.last().map_or(0, |truth| truth.frame),
        }
        .into()),
        None => Ok(()),
    }
}

//! The contact sheet: which pictures are on it, and what is beside them.

use fingerpost_report::{RoadSheetCell, RoadSheetRow, road_sheet};
use fingerpost_vision::picture::RgbImage;

use super::{Contestant, Kept, RoadNumbers};

/// Pictures on a contact sheet: what can be looked at in one.
const SHEET_PICTURES: usize = 12;
/// Outline on a contact sheet of pictures without labels.
const UNLABELLED_THRESHOLD: u8 = 128;

/// Whether a picture of `count` is on the sheet: all of few, some at even distances of many.
pub(super) const fn on_sheet(index: usize, count: usize) -> bool {
    count <= SHEET_PICTURES || (index * SHEET_PICTURES) % count < SHEET_PICTURES
}

/// The sheet of the pictures that were kept.
pub(super) fn sheet(kept: &[Kept], contestants: &[Contestant], numbers: &RoadNumbers) -> RgbImage {
    let rows: Vec<RoadSheetRow<'_>> = kept
        .iter()
        .enumerate()
        .map(|(index, kept)| RoadSheetRow {
            caption: kept.caption.clone(),
            picture: &kept.picture,
            labelled: kept.labelled.as_ref(),
            surfaces: contestants
                .iter()
                .zip(&numbers.detectors)
                .filter_map(|(contestant, numbers)| {
                    let threshold = numbers.evaluation.map_or(UNLABELLED_THRESHOLD, |evaluation| {
                        (255.0 * evaluation.threshold).round() as u8
                    });
                    let probability = contestant.kept.get(index)?;
                    Some(RoadSheetCell { caption: numbers.detector.to_owned(), probability, threshold })
                })
                .collect(),
        })
        .collect();
    road_sheet(&rows)
}

//! Lane edges against marked ones.
//!
//! The measures of paper 3 (IV-B, equations 1 and 2), which takes them from A. Borkar, M. Hayes and M. T. Smith, "A novel
//! lane detection system with efficient ground truth generation" (2012): the Lane Position Deviation of an edge in a
//! frame, its root, and the share of edges whose deviation stays below a threshold, over several regions of interest and
//! thresholds. Beside them the scores of the TuSimple lane benchmark ([`evaluate_tusimple`]).
//!
//! What the paper leaves open is decided so:
//!
//! - A region of interest of N rows is the N lowest rows of the picture, whose centres lie at H - 1 to H - N.
//! - Rows of it that the truth's edge does not reach are not evaluated, and the sum is divided by the number of rows that
//!   are ([`LpdDivisor`] has the equation as printed, too). An edge of which the truth reaches no row of the region is not evaluated.
//! - If the output lacks a single row that is evaluated, the edge is false in that frame and has no deviation. So it is in a
//!   frame that the run has no record of.
//! - The threshold is compared with the deviation itself, in squared pixels, as the paper's text says, though its authors
//!   may have thought of pixels: 10 allows an edge 3.2 pixels beside the truth, not 10.
//! - An edge that is found where the truth has none is neither a true nor a false positive of equation 2; such edges are
//!   counted by themselves, and so are frames that show an edge where the truth has none on either side: false lanes. A
//!   truth that has no edge at all is of an unmarked road, and false lanes are all that there is to count.

mod deviation;
mod edge;
mod error;
mod measure;
mod pairs;
mod tusimple;

use std::collections::BTreeMap;

use fingerpost_format::{FrameRecord, TruthRecord};
use serde::Serialize;

pub use self::edge::column_at_row;
pub use self::error::LaneError;
pub use self::measure::{LANE_ROI_ROWS, LANE_THRESHOLDS_PX2, LaneMeasure, LpdDivisor};
pub use self::pairs::lane_picture_px;
pub use self::tusimple::{TuSimpleScores, evaluate_tusimple};

use self::deviation::{Deviation, Region, deviation};
use self::pairs::check_frames;
use self::tusimple::scores_of_truth;

/// A region of interest with a threshold: edges told truly and falsely, and equation 2.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LaneCell {
    /// Rows of the region of interest.
    pub roi_rows: u32,
    /// Threshold of the Lane Position Deviation, squared pixels.
    pub threshold_px2: f64,
    /// Edges with a deviation of at most the threshold.
    pub true_positives: u64,
    /// Edges with a larger one, or without output.
    pub false_positives: u64,
    /// ACC, equation 2: share of true positives, percent.
    pub accuracy_pct: f64,
}

/// Deviations in a region of interest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LaneDeviation {
    /// Rows of the region of interest.
    pub roi_rows: u32,
    /// Edges evaluated.
    pub edges: u64,
    /// Of those, edges whose output lacks some evaluated row, or all.
    pub edges_without_output: u64,
    /// Mean of the Root Mean Squared Deviation over edges with output, pixels; none where there is no output at all.
    pub rmsd_mean_px: Option<f64>,
    /// Its standard deviation over them (of the population), pixels.
    pub rmsd_standard_deviation_px: Option<f64>,
}

/// A run's lane edges against truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LaneEvaluation {
    /// Width and height of the pictures.
    pub picture_px: [u32; 2],
    /// Frames of the truth.
    pub frames: u64,
    /// Frames of the truth that the run has no record of; their edges count as false.
    pub frames_without_record: u64,
    /// Mean of the accuracies of all cells, percent; none where the truth has no edge.
    pub mean_accuracy_pct: Option<f64>,
    /// Every region of interest with every threshold; thresholds change first. Empty where the truth has no edge.
    pub cells: Vec<LaneCell>,
    /// Every region of interest; empty where the truth has no edge.
    pub deviations: Vec<LaneDeviation>,
    /// Edges that the truth does not have, by frame and side.
    pub edges_not_in_truth: u64,
    /// Of those, edges that the run has all the same.
    pub false_edges: u64,
    /// Frames of the run where there are no markings: the truth has no edge on either side.
    pub unmarked_frames: u64,
    /// Of those, frames with a false lane: the run has an edge.
    pub false_lane_frames: u64,
    /// Share of frames with a false lane, percent; none without unmarked frames.
    pub false_lanes_pct: Option<f64>,
    /// The scores of the TuSimple benchmark; none where no sampled row shows an edge.
    pub tusimple: Option<TuSimpleScores>,
}

/// Evaluations of several marked clips together, each counting the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LaneMean {
    /// Clips whose truth has edges; the others say nothing about accuracy.
    pub clips: u64,
    /// Mean of all cells' accuracies, percent.
    pub mean_accuracy_pct: f64,
    /// Mean accuracy of every cell; its counts are summed.
    pub cells: Vec<LaneCell>,
    /// Mean over the clips of their mean deviation, pixels, for every region of interest.
    pub rmsd_mean_px: Vec<Option<f64>>,
}

/// An edge in a frame: what the truth and the run say.
type EdgePair<'a> = (&'a [[f64; 2]], &'a [[f64; 2]]);

/// Compares a run's lane edges with truth, by frame.
///
/// `picture_px` is the size of the pictures ([`lane_picture_px`]), `measure` the regions of interest and thresholds.
///
/// # Errors
/// [`LaneError`] when frames do not ascend, a frame of the run has no truth, or all of the truth's edges lie above a region.
pub fn evaluate_lanes(
    records: &[FrameRecord],
    truth: &[TruthRecord],
    picture_px: [u32; 2],
    measure: &LaneMeasure,
) -> Result<LaneEvaluation, LaneError> {
    check_frames(records, truth)?;
    let by_frame: BTreeMap<u64, &FrameRecord> = records.iter().map(|record| (record.frame, record)).collect();
    let pairs: Vec<EdgePair<'_>> = truth
        .iter()
        .flat_map(|truth| {
            let lanes = by_frame.get(&truth.frame).and_then(|record| record.lanes.as_ref());
            let [left, right] = lanes.map_or([&[][..]; 2], |lanes| [&lanes.left_px[..], &lanes.right_px[..]]);
            [(&truth.lane_left_px[..], left), (&truth.lane_right_px[..], right)]
        })
        .collect();
    let is_marked = pairs.iter().any(|pair| !pair.0.is_empty());
    let (mut cells, mut deviations) = (Vec::new(), Vec::new());
    for &roi_rows in measure.roi_rows.iter().filter(|_| is_marked) {
        let region = Region { height: picture_px[1], roi_rows, divisor: measure.divisor };
        let found: Vec<Deviation> =
            pairs.iter().filter_map(|(truth, run)| deviation(truth, run, &region)).collect();
        if found.is_empty() {
            return Err(LaneError::NoEdges { roi_rows });
        }
        let thresholds = measure.thresholds_px2.iter();
        cells.extend(thresholds.map(|threshold_px2| cell(roi_rows, *threshold_px2, &found)));
        deviations.push(deviations_of(roi_rows, &found));
    }
    let unseen = |pair: &&EdgePair<'_>| pair.0.is_empty();
    let [unmarked_frames, false_lane_frames] = false_lanes(&by_frame, truth);
    Ok(LaneEvaluation {
        picture_px,
        frames: truth.len() as u64,
        frames_without_record: truth.iter().filter(|t| !by_frame.contains_key(&t.frame)).count() as u64,
        mean_accuracy_pct: mean(cells.iter().map(|cell: &LaneCell| cell.accuracy_pct)),
        cells,
        deviations,
        edges_not_in_truth: pairs.iter().filter(unseen).count() as u64,
        false_edges: pairs.iter().filter(unseen).filter(|pair| !pair.1.is_empty()).count() as u64,
        unmarked_frames,
        false_lane_frames,
        false_lanes_pct: (unmarked_frames > 0)
            .then(|| 100.0 * false_lane_frames as f64 / unmarked_frames as f64),
        tusimple: scores_of_truth(&by_frame, truth, picture_px),
    })
}

/// Frames of the run whose truth has no edge on either side, and those of them in which the run has one.
fn false_lanes(by_frame: &BTreeMap<u64, &FrameRecord>, truth: &[TruthRecord]) -> [u64; 2] {
    let unmarked = truth.iter().filter(|t| t.lane_left_px.is_empty() && t.lane_right_px.is_empty());
    unmarked.filter_map(|truth| by_frame.get(&truth.frame)).fold([0, 0], |[frames, falsely], record| {
        let is_false =
            record.lanes.as_ref().is_some_and(|l| !(l.left_px.is_empty() && l.right_px.is_empty()));
        [frames + 1, falsely + u64::from(is_false)]
    })
}

/// The mean of several clips' evaluations, as the paper's figure 21 shows it, over those whose truth has edges; none of none.
pub fn mean_of_lanes(clips: &[LaneEvaluation]) -> Option<LaneMean> {
    let marked = || clips.iter().filter(|clip| !clip.cells.is_empty());
    let first = marked().next()?;
    let cells: Vec<LaneCell> = first
        .cells
        .iter()
        .enumerate()
        .map(|(index, cell)| {
            let all = || marked().filter_map(move |clip| clip.cells.get(index));
            LaneCell {
                true_positives: all().map(|cell| cell.true_positives).sum(),
                false_positives: all().map(|cell| cell.false_positives).sum(),
                accuracy_pct: mean(all().map(|cell| cell.accuracy_pct)).unwrap_or_default(),
                ..*cell
            }
        })
        .collect();
    let rmsd = |index: usize| mean(marked().filter_map(|clip| clip.deviations.get(index)?.rmsd_mean_px));
    Some(LaneMean {
        clips: marked().count() as u64,
        mean_accuracy_pct: mean(cells.iter().map(|cell| cell.accuracy_pct))?,
        rmsd_mean_px: (0..first.deviations.len()).map(rmsd).collect(),
        cells,
    })
}

fn cell(roi_rows: u32, threshold_px2: f64, found: &[Deviation]) -> LaneCell {
    let is_true =
        |found: &&Deviation| matches!(found, Deviation::Of { lpd_px2 } if *lpd_px2 <= threshold_px2);
    let true_positives = found.iter().filter(is_true).count() as u64;
    let all = found.len() as u64;
    LaneCell {
        roi_rows,
        threshold_px2,
        true_positives,
        false_positives: all - true_positives,
        accuracy_pct: 100.0 * true_positives as f64 / all as f64,
    }
}

fn deviations_of(roi_rows: u32, found: &[Deviation]) -> LaneDeviation {
    let rmsd_px: Vec<f64> = found
        .iter()
        .filter_map(|found| match found {
            Deviation::Of { lpd_px2 } => Some(lpd_px2.sqrt()),
            Deviation::NoOutput => None,
        })
        .collect();
    let rmsd_mean_px = mean(rmsd_px.iter().copied());
    let variance = rmsd_mean_px.and_then(|middle| mean(rmsd_px.iter().map(|px| (px - middle).powi(2))));
    LaneDeviation {
        roi_rows,
        edges: found.len() as u64,
        edges_without_output: (found.len() - rmsd_px.len()) as u64,
        rmsd_mean_px,
        rmsd_standard_deviation_px: variance.map(f64::sqrt),
    }
}

/// None of nothing.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u64), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

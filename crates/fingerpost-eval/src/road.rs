//! Road probabilities against labels.
//!
//! One threshold is chosen for a whole set of pictures, the best one, as benchmarks of road detection do (J. Fritsch, T.
//! Kuehnl and A. Geiger, "A new performance measure and evaluation benchmark for road detection algorithms", 2013): MaxF is
//! the largest F1 measure over all thresholds, and the intersection over union at that threshold is its largest too, since
//! IoU = F / (2 - F).

use serde::Serialize;

use crate::EvalError;

/// Values that an 8-bit probability can have.
const VALUES: usize = 256;

/// Numbers that labels have for what matters here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoadLabels {
    /// Road.
    pub road: u8,
    /// Pixels that count for nothing, where there are such.
    pub void: Option<u8>,
}

/// How often each probability fell on road and on something else.
///
/// ```
/// use fingerpost_eval::{RoadLabels, RoadScores};
/// let mut scores = RoadScores::new(RoadLabels { road: 3, void: Some(11) });
/// scores.add(&[200, 200, 90, 255], &[3, 4, 3, 11])?;
/// let best = scores.best()?;
/// // At 90/255 both road pixels and one other are taken for road.
/// assert!((best.iou - 2.0 / 3.0).abs() < 1e-12 && (best.max_f - 0.8).abs() < 1e-12);
/// # Ok::<(), fingerpost_eval::EvalError>(())
/// ```
#[derive(Debug, Clone)]
pub struct RoadScores {
    labels: RoadLabels,
    /// Pixels of road by their probability.
    road: [u64; VALUES],
    /// Pixels of all else.
    other: [u64; VALUES],
}

/// A detector's road probabilities against labels, at the threshold that serves the whole set best.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RoadEvaluation {
    /// Largest F1 measure.
    pub max_f: f64,
    /// Intersection over union of found and labelled road.
    pub iou: f64,
    /// Probability from which a pixel counts as road, 0 to 1.
    pub threshold: f64,
    /// Intersection over union where what is likelier road than not counts as road: what a probability is worth that nobody has set a
    /// threshold for.
    pub iou_at_half: f64,
}

impl RoadScores {
    /// Scores of no pixel.
    pub const fn new(labels: RoadLabels) -> Self {
        Self { labels, road: [0; VALUES], other: [0; VALUES] }
    }

    /// Adds pixels by their probability (255 is 1) and label.
    ///
    /// # Errors
    /// [`EvalError::LabelCount`] when there are not as many of the one as of the other.
    pub fn add(&mut self, probabilities: &[u8], labels: &[u8]) -> Result<(), EvalError> {
        if probabilities.len() != labels.len() {
            return Err(EvalError::LabelCount { probabilities: probabilities.len(), labels: labels.len() });
        }
        for (&p, &label) in probabilities.iter().zip(labels) {
            if label == self.labels.road {
                self.road[usize::from(p)] += 1;
            } else if Some(label) != self.labels.void {
                self.other[usize::from(p)] += 1;
            }
        }
        Ok(())
    }

    /// The evaluation at the best threshold; of several equally good ones the highest.
    ///
    /// # Errors
    /// [`EvalError::NoRoad`] when no pixel was road.
    pub fn best(&self) -> Result<RoadEvaluation, EvalError> {
        let all_road: u64 = self.road.iter().sum();
        if all_road == 0 {
            return Err(EvalError::NoRoad { road: self.labels.road });
        }
        let (mut found_road, mut found_other) = (0, 0);
        let mut best = RoadEvaluation { max_f: 0.0, iou: 0.0, threshold: 1.0, iou_at_half: 0.0 };
        for value in (0..VALUES).rev() {
            found_road += self.road[value];
            found_other += self.other[value];
            let iou = found_road as f64 / (all_road + found_other) as f64;
            if iou > best.iou {
                let threshold = value as f64 / (VALUES - 1) as f64;
                best = RoadEvaluation { max_f: 2.0 * iou / (1.0 + iou), iou, threshold, ..best };
            }
            if value == VALUES / 2 {
                best.iou_at_half = iou;
            }
        }
        Ok(best)
    }
}

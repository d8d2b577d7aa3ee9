//! Weighing: what a candidate's frames say for it, and whether that is enough to track it.

use fingerpost_vision::span::SpanError;

use super::searching::Found;
use super::{Candidate, Mode, Tracker};
use crate::track::{CandidatePlace, Decision, Missing, PoseFilter, TrackConfig, TrackEvidence};

/// A candidate whose place is not sure after this many times the frames that are needed is another place.
const CANDIDATE_PATIENCE: usize = 10;
/// A vehicle that follows its road wanders so far from the heading at which it found a feature, radians: 3 degrees.
const STEERED_RAD: f64 = 0.052;
/// Standard deviation of a curve's place up to which it is followed, metres: what a vehicle can still steer by.
const CURVE_SIGMA_M: f64 = 1.2;
/// Sums of weights that differ by less are equal.
const WEIGHT_ROUNDING: f64 = 1e-9;

impl Tracker {
    /// Adds what this frame says for a candidate, and decides whether it is detected.
    pub(super) fn weigh(
        &mut self,
        found: Found,
        aligned_p: f64,
        contrast: Option<f64>,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        let surprise = self.surprise(&found.filter).unwrap_or(0.0);
        let (config, index) = (&self.config, self.next);
        let is_curve = self.stops.get(index).is_some_and(|stop| stop.model.is_curve());
        let most_m = if is_curve { CURVE_SIGMA_M.max(self.known_sigma_m) } else { self.known_sigma_m };
        let Found { filter, frames, weight, .. } = found;
        let (frames, weight) = (frames + 1, weight + frame_weight(config, aligned_p, contrast, surprise));
        if contrast.is_none() {
            evidence.needed_p = Some(config.detect_threshold);
        }
        let most_frames = CANDIDATE_PATIENCE * config.detect_frames;
        if weight <= 0.0 {
            evidence.decision = without_weight(config, index, aligned_p, contrast, surprise);
        } else if frames > most_frames {
            evidence.decision = Decision::Dropped { index, frames, most_frames };
        } else if let Some(missing) = missing(config, (frames, weight), &filter, most_m) {
            evidence.decision = Decision::Candidate { index, frames, p: aligned_p, missing };
            self.unsure = matches!(missing, Missing::Distance { .. }).then(|| CandidatePlace {
                index,
                vehicle_from_feature: *filter.pose(),
                covariance: *filter.covariance(),
                present: aligned_p,
            });
            if let Mode::Searching { candidate, .. } = &mut self.mode {
                *candidate = Some(Candidate { filter, frames, weight });
            }
        } else if let Some(stop) = self.stops.get_mut(index) {
            stop.masks.draw_about(filter.pose().rotation.angle(), STEERED_RAD)?;
            evidence.decision = Decision::Detected;
            self.spare.extend(evidence.sought.take().map(|sought| sought.matched));
            self.mode = Mode::Tracking { filter, unconfirmed: 0 };
        }
        Ok(())
    }
}

/// What a frame says for a candidate: its contrast beyond half of the one that is needed, so that a weak contrast must
/// last longer and none at all speaks against it; a great one counts no more than twice what is needed. Where no verge is
/// seen a match that is good enough without one says as much as that contrast. Where the feature is not expected it must
/// stand out by so much more.
fn frame_weight(config: &TrackConfig, p: f64, contrast: Option<f64>, surprise: f64) -> f64 {
    let needed = config.detect_contrast;
    match contrast {
        Some(contrast) => (contrast - surprise).min(2.0 * needed) - 0.5 * needed,
        None if p >= config.detect_threshold => 0.5 * needed - surprise,
        None => f64::NEG_INFINITY,
    }
}

/// Why a match has no weight: [`frame_weight`] is not above zero.
fn without_weight(
    config: &TrackConfig,
    index: usize,
    p: f64,
    contrast: Option<f64>,
    surprise: f64,
) -> Decision {
    match contrast {
        Some(contrast) => Decision::NoVerge { index, p, contrast, surprise },
        None if p < config.detect_threshold => {
            Decision::NoVergeInView { index, p, needed_p: config.detect_threshold }
        }
        None => Decision::NotExpected { index, p, surprise, most: 0.5 * config.detect_contrast },
    }
}

/// What a candidate lacks, if anything.
fn missing(
    config: &TrackConfig,
    (frames, weight): (usize, f64),
    filter: &PoseFilter,
    most_m: f64,
) -> Option<Missing> {
    let needed = config.detect_frames as f64 * frame_weight(config, 1.0, Some(config.detect_contrast), 0.0);
    let sigma_m = filter.covariance()[(0, 0)].sqrt();
    if frames < config.detect_frames {
        Some(Missing::Frames { needed: config.detect_frames })
    } else if weight < needed - WEIGHT_ROUNDING {
        Some(Missing::Contrast { sum: weight, needed })
    } else if sigma_m > most_m {
        Some(Missing::Distance { sigma_m, most_m })
    } else {
        None
    }
}

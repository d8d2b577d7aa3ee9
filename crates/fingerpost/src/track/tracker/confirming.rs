//! Tracking: the feature that is followed is confirmed where ego-motion expects it, bracketed, or lost.

use fingerpost_vision::span::SpanError;

use super::{FOUND_SIGMAS, Mode, Tracker};
use crate::matching::LaidSurface;
use crate::track::{Decision, TrackEvidence};

/// A bracketed place must match, or stand out from the verge, better than the predicted one by this much: less is the noise of the road surface.
const CLEARLY_BETTER: f64 = 0.1;

impl Tracker {
    /// Confirms the tracked feature at its predicted place, or brackets, or counts towards its loss.
    pub(super) fn confirm(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        let (Mode::Tracking { filter, unconfirmed }, Some(stop)) =
            (&mut self.mode, self.stops.get_mut(self.next))
        else {
            return Ok(());
        };
        let (config, predicted) = (&self.config, *filter.pose());
        let predicted_p = laid.probability(&mut stop.masks, &predicted)?;
        let contrast = laid.contrast(&mut stop.masks, &predicted)?;
        evidence.predicted = Some(predicted);
        evidence.predicted_p = predicted_p;
        evidence.needed_p = Some(config.confirming_p(contrast));
        // Where no sub-mask is seen (close to the feature) there is nothing to confirm or deny.
        if predicted_p.is_none_or(|p| config.confirms(p, contrast)) {
            evidence.decision = Decision::Confirmed;
        } else {
            let threshold = config.detect_threshold_at_verge.min(config.confirm_threshold);
            let tried = self.search.about(config, laid, &mut stop.masks, threshold, filter)?;
            evidence.tried = tried.count;
            let better = match tried.best {
                Some((pose, p)) => {
                    let there = laid.contrast(&mut stop.masks, &pose)?;
                    let clearly_more_road = p >= predicted_p.unwrap_or(0.0) + CLEARLY_BETTER;
                    let stands_out_more =
                        there.is_some_and(|c| c >= contrast.unwrap_or(0.0) + CLEARLY_BETTER);
                    evidence.needed_p = Some(config.confirming_p(there));
                    (config.confirms(p, there) && (clearly_more_road || stands_out_more)).then_some(pose)
                }
                None => None,
            };
            let Some(pose) = better else {
                *unconfirmed += 1;
                evidence.decision = Decision::NotConfirmed { frames: *unconfirmed };
                if *unconfirmed >= config.lost_frames {
                    evidence.decision = Decision::Lost { index: self.next };
                    self.mode = Mode::Searching { candidate: None, lost: true };
                }
                return Ok(());
            };
            filter.relocate(pose, FOUND_SIGMAS);
            evidence.decision = Decision::FoundByBracketing;
        }
        *unconfirmed = 0;
        let before = filter.clone();
        evidence.sections.extend_from_slice(self.aligner.align(laid, &stop.arms, filter)?);
        let contrast = laid.contrast(&mut stop.masks, filter.pose())?;
        let p = laid.probability(&mut stop.masks, filter.pose())?;
        if p.is_some_and(|p| !self.config.confirms(p, contrast)) {
            // Edges that lead the masks off the road belong to something else.
            *filter = before;
        }
        Ok(())
    }
}

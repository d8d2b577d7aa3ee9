//! Tracking: the feature that is followed is confirmed where ego-motion expects it, bracketed, or lost.
//!
//! P(F) is flat: a place half a road's width off is as much road as the true one. So a place is not confirmed either of which most
//! edges of the arms that tell the feature lie too far off. Bracketing (paper 1, section VI) then tries places about it,
//! as far away as the prediction is unsure, measures the best of them anew, and is believed where edges or a clearly better match
//! speak for it.

use fingerpost_vision::span::SpanError;

use super::searching::{edges_by_which_it_is_told, edges_elsewhere};
use super::{FOUND_SIGMAS, Mode, SETTLING_ROUNDS, Tracker};
use crate::matching::LaidSurface;
use crate::track::Reach;
use crate::track::alignment::Aligner;
use crate::track::{CandidateSearch, Decision, PoseFilter, RouteStop, TrackConfig, TrackEvidence};

/// A bracketed place must match, or stand out from the verge, better than the predicted one by this much: less is the noise of the road surface.
const CLEARLY_BETTER: f64 = 0.1;

/// How a feature matches at a place.
#[derive(Debug, Clone, Copy)]
struct Matching {
    p: Option<f64>,
    contrast: Option<f64>,
}

impl Tracker {
    /// Confirms the tracked feature at its predicted place, or brackets, or counts towards its loss.
    pub(super) fn confirm(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        let Self { config, search, aligner, stops, mode, next, view_m, .. } = self;
        let (Mode::Tracking { filter, unconfirmed }, Some(stop)) = (&mut *mode, stops.get_mut(*next)) else {
            return Ok(());
        };
        let predicted = filter.clone();
        let there = Matching::at(laid, stop, &predicted)?;
        evidence.predicted = Some(*predicted.pose());
        evidence.predicted_p = there.p;
        evidence.needed_p = Some(config.confirming_p(there.contrast));
        let is_confirmed = there.confirms(config);
        let mut is_elsewhere = false;
        if is_confirmed {
            evidence.decision = Decision::Confirmed;
            evidence.sections.extend_from_slice(aligner.align(laid, &stop.arms, filter)?);
            if !Matching::at(laid, stop, filter)?.confirms(config) {
                // Edges that lead the masks off the road belong to something else.
                *filter = predicted.clone();
            }
            is_elsewhere = edges_elsewhere(&evidence.sections).is_some();
        }
        if !is_confirmed || is_elsewhere {
            let mut bracketing = Bracketing { config, search, aligner, laid, view_m: *view_m };
            if let Some(found) = bracketing.find(stop, &predicted, evidence)? {
                *filter = found;
                evidence.decision = Decision::FoundByBracketing;
            } else if !is_confirmed {
                *unconfirmed += 1;
                evidence.decision = Decision::NotConfirmed { frames: *unconfirmed };
                if *unconfirmed >= config.lost_frames {
                    evidence.decision = Decision::Lost { index: *next };
                    *mode = Mode::Searching { candidate: None, lost: true };
                }
                return Ok(());
            }
        }
        *unconfirmed = 0;
        Ok(())
    }
}

impl Matching {
    fn at(laid: &LaidSurface<'_>, stop: &mut RouteStop, filter: &PoseFilter) -> Result<Self, SpanError> {
        let p = laid.probability(&mut stop.masks, filter.pose())?;
        Ok(Self { p, contrast: laid.contrast(&mut stop.masks, filter.pose())? })
    }

    /// Where no sub-mask is seen (close to the feature) there is nothing to confirm or deny.
    fn confirms(&self, config: &TrackConfig) -> bool {
        self.p.is_none_or(|p| config.confirms(p, self.contrast))
    }

    fn is_clearly_better_than(&self, other: &Self) -> bool {
        let more_road = self.p.is_some_and(|p| p >= other.p.unwrap_or(0.0) + CLEARLY_BETTER);
        let stands_out_more =
            self.contrast.is_some_and(|c| c >= other.contrast.unwrap_or(0.0) + CLEARLY_BETTER);
        more_road || stands_out_more
    }
}

/// What looks for a feature about where it was predicted.
pub(super) struct Bracketing<'a> {
    pub(super) config: &'a TrackConfig,
    pub(super) search: &'a mut CandidateSearch,
    pub(super) aligner: &'a mut Aligner,
    pub(super) laid: &'a LaidSurface<'a>,
    /// Length of the view ahead, metres.
    pub(super) view_m: f64,
}

impl Bracketing<'_> {
    /// The feature where it is found about a prediction; none where nothing speaks for any other place.
    pub(super) fn find(
        &mut self,
        stop: &mut RouteStop,
        predicted: &PoseFilter,
        evidence: &mut TrackEvidence,
    ) -> Result<Option<PoseFilter>, SpanError> {
        let Self { config, search, aligner, laid, view_m } = self;
        let threshold = config.detect_threshold_at_verge.min(config.confirm_threshold);
        let reach = Reach::covering(config, predicted, *view_m);
        let tried = search.about(config, laid, &mut stop.masks, threshold, (predicted, reach))?;
        evidence.tried = tried.count;
        let Some((pose, _)) = tried.best else { return Ok(None) };
        let mut found = PoseFilter::new(pose, FOUND_SIGMAS);
        for _ in 0..SETTLING_ROUNDS {
            aligner.align(laid, &stop.arms, &mut found)?;
            found = PoseFilter::new(*found.pose(), FOUND_SIGMAS);
        }
        let sections = aligner.align(laid, &stop.arms, &mut found)?;
        let (told, elsewhere) = (edges_by_which_it_is_told(sections), edges_elsewhere(sections).is_some());
        let (there, here) = (Matching::at(laid, stop, predicted)?, Matching::at(laid, stop, &found)?);
        let speaks =
            told > edges_by_which_it_is_told(&evidence.sections) || here.is_clearly_better_than(&there);
        if elsewhere || !speaks || !here.confirms(config) || here.p.is_none() {
            return Ok(None);
        }
        evidence.needed_p = Some(config.confirming_p(here.contrast));
        evidence.sections.clear();
        evidence.sections.extend_from_slice(sections);
        Ok(Some(found))
    }
}

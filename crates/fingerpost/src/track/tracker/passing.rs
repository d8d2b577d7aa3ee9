//! Passing: a feature that was arrived at is carried along until it lies behind.

use fingerpost_vision::span::SpanError;
use nalgebra::Point2;

use super::confirming::Bracketing;
use super::searching::edges_elsewhere;
use super::{Mode, PASSED_M, Passing, Tracker};
use crate::feature_masks::MaskCurve;
use crate::matching::LaidSurface;
use crate::track::{Decision, RouteStop, State, TrackEvidence};

impl Tracker {
    /// Carries the feature that is being passed, and says the state of a frame in which none is tracked.
    pub(super) fn pass(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<State, SpanError> {
        if let Some(gone) = self.passing.take_if(|passing| passed(&self.stops, passing)) {
            self.forget_masks(gone.index);
        }
        if let Some(passing) = &mut self.passing
            && let Some(stop) = self.stops.get_mut(passing.index)
        {
            // Once only arms straight ahead are seen they would turn the feature as they please.
            let (pose, config) = (passing.filter.pose(), &self.config);
            let threshold = config.detect_threshold_at_verge.min(config.confirm_threshold);
            let contrast = laid.contrast(&mut stop.masks, pose)?;
            if laid.score(&mut stop.masks, pose, threshold)?.is_some_and(|p| config.confirms(p, contrast)) {
                let predicted = passing.filter.clone();
                let sections = self.aligner.align(laid, &stop.arms, &mut passing.filter)?;
                let is_elsewhere = edges_elsewhere(sections).is_some();
                if evidence.sections.is_empty() {
                    evidence.sections.extend_from_slice(sections);
                    let Self { config, search, aligner, view_m, .. } = self;
                    let mut bracketing = Bracketing { config, search, aligner, laid, view_m: *view_m };
                    if is_elsewhere && let Some(found) = bracketing.find(stop, &predicted, evidence)? {
                        passing.filter = found;
                        evidence.decision = Decision::FoundByBracketing;
                    }
                }
            }
            if matches!(
                evidence.decision,
                Decision::NotInReach { .. } | Decision::NotFound { .. } | Decision::NoRoute
            ) {
                evidence.decision = Decision::Passing;
            }
            return Ok(State::Arrived);
        }
        if self.stops.is_empty() {
            return Ok(State::NoRoute);
        }
        if self.next >= self.stops.len() {
            evidence.decision = Decision::RouteDone;
            return Ok(State::RouteDone);
        }
        let lost = matches!(self.mode, Mode::Searching { lost: true, .. });
        Ok(if lost { State::Lost } else { State::Searching })
    }
}

/// Whether the vehicle's origin is past the end of the papers' curve through the feature.
fn passed(stops: &[RouteStop], passing: &Passing) -> bool {
    let end = stops
        .get(passing.index)
        .and_then(|stop| stop.mask_curve.as_ref())
        .map_or(Point2::origin(), MaskCurve::end);
    let end_in_vehicle = passing.filter.pose() * end;
    let node_in_vehicle = passing.filter.pose() * Point2::origin();
    end_in_vehicle.x < 0.0 && node_in_vehicle.x < PASSED_M
}

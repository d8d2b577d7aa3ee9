//! Searching: the next feature of the route is looked for where it can be.

use std::ops::RangeInclusive;

use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};

use super::{Candidate, FOUND_SIGMAS, Mode, PASSED_M, SETTLING_ROUNDS, Tracker};
use crate::feature_masks::MaskCache;
use crate::feature_model::FeatureModel;
use crate::matching::{LaidSurface, Match};
use crate::track::Reach;
use crate::track::alignment::{CrossSection, CrossSectionUse};
use crate::track::{Decision, Expectation, ExpectedAhead, PoseFilter, RouteStop, TrackEvidence};

/// Standard deviations of the place at which a feature stands out most from its verges, against those of the frames before:
/// metres, metres, radians.
const STANDS_OUT_SIGMAS: [f64; 3] = [0.9, 0.9, 0.1];
/// The same where edges say otherwise: what leads the search astray does so for many frames.
const SEARCHED_SIGMAS: [f64; 3] = [1.8, 1.2, 0.1];
/// Standard deviation of a vehicle's heading against its road's, radians: 3 degrees, as in keeping a lane past parked cars.
const ON_ROAD_SIGMA_RAD: f64 = 0.052;
/// A vehicle farther than this beyond the approach's edge by the map is not on it, metres: as far as maps lie
/// beside the road.
const OFF_ROAD_M: f64 = 1.0;
/// So near the verges of the arms that leave the approach are often out of view, metres.
const VERGES_OUT_OF_VIEW_M: f64 = 11.0;
/// Loss in rank up to which a feature is where it is expected: within two standard deviations.
const EXPECTED: f64 = 0.1;
/// A feature nearer than this many metres beyond the bottom of the view is not searched for: its arms are out of view.
const NEAREST_BEYOND_M: f64 = 0.5;

/// Where a frame's search found a feature, and what was known of it before.
pub(super) struct Found {
    /// What earlier frames know of it, or the place that was found where there are none.
    pub(super) filter: PoseFilter,
    /// Frames in which it was seen before, and their weight.
    pub(super) frames: usize,
    pub(super) weight: f64,
    /// The best match of this frame.
    pose: Isometry2<f64>,
    p: f64,
}

impl Tracker {
    /// Searches for the next feature where it can be; tracks it once it matched in enough frames.
    pub(super) fn search_next(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        self.skip_passed(evidence);
        let range = self.search_range(evidence);
        let Mode::Searching { candidate, .. } = &mut self.mode else { return Ok(()) };
        let found = match (candidate.take(), range) {
            (Some(candidate), _) => self.find_again(laid, candidate, evidence)?,
            (None, Some(range)) => self.find_anew(laid, &range, evidence)?,
            (None, None) => None,
        };
        let Some(mut found) = found else { return Ok(()) };
        let by_search = self.align(laid, &mut found, evidence)?;
        if let Some(gated) = edges_elsewhere(&evidence.sections) {
            evidence.decision = Decision::EdgesElsewhere { index: self.next, p: found.p, gated };
            return Ok(());
        }
        match self.settle(laid, &mut found, by_search, evidence)? {
            Some((aligned_p, contrast)) => self.weigh(found, aligned_p, contrast, evidence),
            None => Ok(()),
        }
    }

    /// Searches for a candidate about where its frames have it.
    fn find_again(
        &mut self,
        laid: &LaidSurface<'_>,
        candidate: Candidate,
        evidence: &mut TrackEvidence,
    ) -> Result<Option<Found>, SpanError> {
        let (config, index, shown) = (&self.config, self.next, self.shown);
        let Some(RouteStop { masks, .. }) = self.stops.get_mut(index) else { return Ok(None) };
        let threshold = config.detect_threshold_at_verge;
        let tried =
            self.search.about(config, laid, masks, threshold, (&candidate.filter, Reach::of(config)))?;
        evidence.needed_p = Some(threshold);
        evidence.tried = tried.count;
        let Some((pose, p)) = tried.best else {
            evidence.decision = Decision::NotFound { index };
            if let Some(closest) = &tried.closest {
                let matched = explained(laid, masks, closest, &mut self.spare)?;
                evidence.sought = Some(shown.sought(index, matched));
            }
            return Ok(None);
        };
        let Candidate { filter, frames, weight } = candidate;
        Ok(Some(Found { filter, frames, weight, pose, p }))
    }

    /// Searches along the approach, where nothing was found yet.
    fn find_anew(
        &mut self,
        laid: &LaidSurface<'_>,
        range: &RangeInclusive<f64>,
        evidence: &mut TrackEvidence,
    ) -> Result<Option<Found>, SpanError> {
        let (config, index, shown) = (&self.config, self.next, self.shown);
        let Some(RouteStop { model, masks, arms, .. }) = self.stops.get_mut(index) else { return Ok(None) };
        let expectation = Expectation::Ahead(model, &self.expected);
        let tried = self.search.along_approach(config, laid, model, masks, range, expectation)?;
        evidence.needed_p = Some(config.detect_threshold_at_verge);
        evidence.tried = tried.count;
        if let Some(closest) = &tried.closest {
            let matched = explained(laid, masks, closest, &mut self.spare)?;
            evidence.sought = Some(shown.sought(index, matched));
        }
        let Some((pose, p)) = tried.best else {
            evidence.decision = Decision::NotFound { index };
            return Ok(None);
        };
        // The search is coarse: until the place settles, each alignment starts anew from the one before.
        let mut filter = PoseFilter::new(pose, FOUND_SIGMAS);
        for _ in 0..SETTLING_ROUNDS {
            stay_on_the_road(model, &mut filter);
            self.aligner.align(laid, arms, &mut filter)?;
            filter = PoseFilter::new(*filter.pose(), FOUND_SIGMAS);
        }
        stay_on_the_road(model, &mut filter);
        Ok(Some(Found { filter, frames: 0, weight: 0.0, pose, p }))
    }

    /// Takes in what the cross-sections say of a found place; returns it as the search alone has it.
    fn align(
        &mut self,
        laid: &LaidSurface<'_>,
        found: &mut Found,
        evidence: &mut TrackEvidence,
    ) -> Result<PoseFilter, SpanError> {
        let is_new = found.frames == 0;
        let mut by_search =
            if is_new { PoseFilter::new(found.pose, FOUND_SIGMAS) } else { found.filter.clone() };
        let by_pitch = self.aligner.pitch().moves_m(Point2::from(found.pose.translation.vector));
        by_search.update_pose(&found.pose, SEARCHED_SIGMAS, by_pitch);
        let Some(stop) = self.stops.get(self.next) else { return Ok(by_search) };
        evidence.sections.extend_from_slice(self.aligner.align(laid, &stop.arms, &mut found.filter)?);
        let by_edges = |section: &CrossSection| {
            section.leaves_the_line && section.section_use == CrossSectionUse::Accepted
        };
        if !is_new && !self.expected.is_empty() && !evidence.sections.iter().any(by_edges) {
            // Without an edge the place at which the arms stand out most is what is known, frame by frame anew; where nothing
            // is known of the distance, that alone would make a junction of any road that widens.
            found.filter.update_pose(&found.pose, STANDS_OUT_SIGMAS, by_pitch);
        }
        Ok(by_search)
    }

    /// Puts a found place where the match holds: where the edges have it or, if that is nowhere and the feature is expected
    /// there, where the search alone has it, less surely. Returns P(F) and contrast there; none where it is refused.
    fn settle(
        &mut self,
        laid: &LaidSurface<'_>,
        found: &mut Found,
        by_search: PoseFilter,
        evidence: &mut TrackEvidence,
    ) -> Result<Option<(f64, Option<f64>)>, SpanError> {
        let mut aligned = self.spare.pop().unwrap_or_default();
        if let Some(refused) = self.refusal(laid, &found.filter, found.p, &mut aligned)? {
            let is_taken = self.is_expected(&by_search)
                && self.refusal(laid, &by_search, found.p, &mut aligned)?.is_none();
            if !is_taken {
                self.spare.push(aligned);
                evidence.decision = refused;
                return Ok(None);
            }
            evidence.sections.clear();
            found.filter = by_search;
        }
        let (aligned_p, contrast) = (aligned.p.unwrap_or(0.0), aligned.contrast());
        // What is shown is the place that is judged from here on.
        let before_it = evidence.sought.replace(self.shown.sought(self.next, aligned));
        self.spare.extend(before_it.map(|sought| sought.matched));
        let is_near = found.filter.pose().translation.x <= VERGES_OUT_OF_VIEW_M;
        let is_bounded = contrast.is_some()
            || (is_near && self.is_expected(&found.filter))
            || evidence.sections.iter().any(tells_it);
        if !is_bounded {
            evidence.decision = Decision::Unbounded { index: self.next, p: aligned_p };
        }
        Ok(is_bounded.then_some((aligned_p, contrast)))
    }

    /// What speaks against a place that a search found with this P(F), if anything does; `aligned` becomes the match there.
    fn refusal(
        &mut self,
        laid: &LaidSurface<'_>,
        filter: &PoseFilter,
        p: f64,
        aligned: &mut Match,
    ) -> Result<Option<Decision>, SpanError> {
        let index = self.next;
        let Some(RouteStop { model, masks, .. }) = self.stops.get_mut(index) else { return Ok(None) };
        laid.explain(masks, filter.pose(), aligned)?;
        let most_m = model.approach().map_or(0.0, |arm| 0.5 * arm.width_m) + OFF_ROAD_M;
        let beside_m = model.left_of_approach_m(filter.pose()).abs();
        let (aligned_p, needed_p) = (aligned.p.unwrap_or(0.0), self.config.detect_threshold_at_verge);
        Ok(if beside_m > most_m {
            Some(Decision::OffApproach { index, p, beside_m, most_m })
        } else if aligned_p < needed_p {
            Some(Decision::EdgesDisagree { index, p, aligned_p, needed_p })
        } else {
            None
        })
    }

    /// Loss in rank of a place by where the feature is expected; none where that is not known.
    pub(super) fn surprise(&self, filter: &PoseFilter) -> Option<f64> {
        let stop = self.stops.get(self.next)?;
        let expectation = Expectation::Ahead(&stop.model, &self.expected);
        (!self.expected.is_empty()).then(|| expectation.penalty(filter.pose()))
    }

    fn is_expected(&self, filter: &PoseFilter) -> bool {
        self.surprise(filter).is_some_and(|surprise| surprise <= EXPECTED)
    }

    /// Moves on past features that lie behind by all that is known.
    fn skip_passed(&mut self, evidence: &mut TrackEvidence) {
        while let Some(stop) = self.stops.get_mut(self.next)
            && self.progress.at_least_m() > stop.model.route_m + PASSED_M
        {
            stop.masks.clear();
            evidence.decision = Decision::Skipped { index: self.next };
            self.next += 1;
            self.mode = Mode::Searching { candidate: None, lost: false };
        }
    }

    /// Distances of the next feature's node that are possible and in view, metres; none when there are none.
    fn search_range(&mut self, evidence: &mut TrackEvidence) -> Option<RangeInclusive<f64>> {
        let stop = self.stops.get(self.next)?;
        let (mut low, mut high) = (self.nearest_seen_m + NEAREST_BEYOND_M, self.farthest_m);
        self.expected.clear();
        let (mut least_m, mut most_m) = (f64::INFINITY, f64::NEG_INFINITY);
        for (mean, sigma_m) in self.progress.beliefs_m() {
            let ahead_m = stop.model.route_m - mean;
            least_m = least_m.min(self.shown.shown_ahead_m(ahead_m - 3.0 * sigma_m));
            most_m = most_m.max(self.shown.shown_ahead_m(ahead_m + 3.0 * sigma_m));
            self.expected.push(ExpectedAhead { ahead_m: self.shown.shown_ahead_m(ahead_m), sigma_m });
        }
        if let Some((mean, _)) = self.progress.belief_m() {
            (low, high) = (low.max(least_m), high.min(most_m));
            if !matches!(evidence.decision, Decision::Skipped { .. }) {
                let ahead_m = stop.model.route_m - mean;
                evidence.decision = Decision::NotInReach { index: self.next, ahead_m };
            }
        }
        (low <= high).then_some(low..=high)
    }
}

/// The match at a pose, in memory of one that was handed out before.
fn explained(
    laid: &LaidSurface<'_>,
    masks: &mut MaskCache,
    vehicle_from_feature: &Isometry2<f64>,
    spare: &mut Vec<Match>,
) -> Result<Match, SpanError> {
    let mut matched = spare.pop().unwrap_or_default();
    laid.explain(masks, vehicle_from_feature, &mut matched)?;
    Ok(matched)
}

/// A vehicle that has not come to the feature yet drives along the approach: its heading says how the feature is turned.
fn stay_on_the_road(model: &FeatureModel, filter: &mut PoseFilter) {
    filter.update_heading(model.heading_off_approach_rad(filter.pose()), ON_ROAD_SIGMA_RAD);
}

/// How many edges of the arms that tell the feature lie too far from where it would be; none unless they are more than lie
/// where it would be.
pub(super) fn edges_elsewhere(sections: &[CrossSection]) -> Option<usize> {
    let is_gated = |section: &&CrossSection| matches!(section.section_use, CrossSectionUse::Gated { .. });
    let gated = sections.iter().filter(|section| section.leaves_the_line).filter(is_gated).count();
    (gated > edges_by_which_it_is_told(sections)).then_some(gated)
}

/// How many edges of the arms that tell the feature lie where it would be.
pub(super) fn edges_by_which_it_is_told(sections: &[CrossSection]) -> usize {
    let tells =
        |section: &&CrossSection| section.leaves_the_line && section.section_use == CrossSectionUse::Accepted;
    sections.iter().filter(tells).count()
}

/// Whether a cross-section shows an edge of an arm that tells the feature from a plain road.
fn tells_it(section: &CrossSection) -> bool {
    section.leaves_the_line
        && section.edges_m != [None, None]
        && !matches!(section.section_use, CrossSectionUse::WidthDisagrees { .. })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Vector2;

    use super::*;

    fn section(leaves_the_line: bool, section_use: CrossSectionUse) -> CrossSection {
        CrossSection {
            label: Arc::from("arm"),
            p_in_vehicle: Point2::origin(),
            left: Vector2::y(),
            edges_m: [Some(2.0), None],
            pavement_sigma_m: [0.0; 2],
            by_line: [false; 2],
            leaves_the_line,
            section_use,
        }
    }

    #[test]
    fn a_feature_is_elsewhere_when_most_edges_of_the_arms_that_tell_it_are() {
        let (near, far) = (CrossSectionUse::Accepted, CrossSectionUse::Gated { sigmas: 4.0 });
        let telling = |uses: &[CrossSectionUse]| uses.iter().map(|u| section(true, *u)).collect::<Vec<_>>();
        assert_eq!(edges_elsewhere(&telling(&[far, near, far])), Some(2));
        assert_eq!(edges_elsewhere(&telling(&[far, near])), None, "as many near it");
        assert_eq!(edges_elsewhere(&telling(&[CrossSectionUse::NoEdges])), None, "nothing is seen");
        let along = [section(false, far), section(false, far), section(true, near)];
        assert_eq!(edges_elsewhere(&along), None, "the road ahead does not tell the feature");
    }
}

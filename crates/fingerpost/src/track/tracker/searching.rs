//! Searching: the next feature of the route is looked for where it can be.

use std::ops::RangeInclusive;

use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};

use super::{Candidate, FOUND_SIGMAS, Mode, PASSED_M, Tracker};
use crate::feature_masks::MaskCache;
use crate::feature_model::FeatureModel;
use crate::matching::{LaidSurface, Match};
use crate::track::alignment::{CrossSection, CrossSectionUse};
use crate::track::{Decision, Expectation, ExpectedAhead, Missing, PoseFilter, TrackConfig, TrackEvidence};

/// Alignments before the one that counts, in the first frame of a candidate.
const SETTLING_ROUNDS: usize = 3;
/// A feature is only taken as detected when its distance is known to this standard deviation, metres.
const KNOWN_SIGMA_M: f64 = 0.45;
/// Standard deviations of the place at which a feature stands out most from its verges, against those of the frames before:
/// metres, metres, radians.
const STANDS_OUT_SIGMAS: [f64; 3] = [0.9, 0.9, 0.1];
/// The same where edges say otherwise: what leads the search astray does so for many frames.
const SEARCHED_SIGMAS: [f64; 3] = [1.8, 1.2, 0.1];
/// A candidate whose place is not sure after this many times the frames that are needed is another place.
const CANDIDATE_PATIENCE: usize = 10;
/// Standard deviation of a vehicle's heading against its road's, radians: 3 degrees, as in keeping a lane past parked cars.
const ON_ROAD_SIGMA_RAD: f64 = 0.052;
/// A vehicle that follows its road wanders so far from the heading at which it found a feature, radians: 3 degrees.
const STEERED_RAD: f64 = 0.052;
/// A vehicle farther than this beyond the approach's edge by the map is not on it, metres: as far as maps lie
/// beside the road.
const OFF_ROAD_M: f64 = 1.0;
/// So near the verges of the arms that leave the approach are often out of view, metres.
const VERGES_OUT_OF_VIEW_M: f64 = 11.0;
/// Loss in rank up to which a feature is where it is expected: within two standard deviations.
const EXPECTED: f64 = 0.1;
/// Sums of weights that differ by less are equal.
const WEIGHT_ROUNDING: f64 = 1e-9;
/// A feature nearer than this many metres beyond the bottom of the view is not searched for: its arms are out of view.
const NEAREST_BEYOND_M: f64 = 0.5;

impl Tracker {
    /// Searches for the next feature where it can be; tracks it once it matched in enough frames.
    pub(super) fn search_next(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        self.skip_passed(evidence);
        let range = self.search_range(evidence);
        let (Mode::Searching { candidate, .. }, Some(stop)) = (&mut self.mode, self.stops.get_mut(self.next))
        else {
            return Ok(());
        };
        let (config, index, masks, shown) = (&self.config, self.next, &mut stop.masks, self.shown);
        let (mut filter, before, found) = match (candidate.take(), &range) {
            (Some(candidate), _) => {
                let threshold = config.detect_threshold_at_verge;
                let tried = self.search.about(config, laid, masks, threshold, &candidate.filter)?;
                evidence.needed_p = Some(threshold);
                evidence.tried = tried.count;
                let Some(found) = tried.best else {
                    evidence.decision = Decision::NotFound { index };
                    if let Some(closest) = &tried.closest {
                        let matched = explained(laid, masks, closest, &mut self.spare)?;
                        evidence.sought = Some(shown.sought(index, matched));
                    }
                    return Ok(());
                };
                (candidate.filter, (candidate.frames, candidate.weight), found)
            }
            (None, Some(range)) => {
                let expectation = Expectation::Ahead(&stop.model, &self.expected);
                let tried =
                    self.search.along_approach(config, laid, &stop.model, masks, range, expectation)?;
                evidence.needed_p = Some(config.detect_threshold_at_verge);
                evidence.tried = tried.count;
                if let Some(closest) = &tried.closest {
                    let matched = explained(laid, masks, closest, &mut self.spare)?;
                    evidence.sought = Some(shown.sought(index, matched));
                }
                let Some(found) = tried.best else {
                    evidence.decision = Decision::NotFound { index };
                    return Ok(());
                };
                // The search is coarse: until the place settles, each alignment starts anew from the one before.
                let mut filter = PoseFilter::new(found.0, FOUND_SIGMAS);
                for _ in 0..SETTLING_ROUNDS {
                    stay_on_the_road(&stop.model, &mut filter);
                    self.aligner.align(laid, &stop.arms, &mut filter)?;
                    filter = PoseFilter::new(*filter.pose(), FOUND_SIGMAS);
                }
                stay_on_the_road(&stop.model, &mut filter);
                (filter, (0, 0.0), found)
            }
            (None, None) => return Ok(()),
        };
        let (found_pose, p) = found;
        let mut by_search =
            if before.0 > 0 { filter.clone() } else { PoseFilter::new(found_pose, FOUND_SIGMAS) };
        let by_pitch = self.aligner.pitch().moves_m(Point2::from(found_pose.translation.vector));
        by_search.update_pose(&found_pose, SEARCHED_SIGMAS, by_pitch);
        evidence.sections.extend_from_slice(self.aligner.align(laid, &stop.arms, &mut filter)?);
        let by_edges = |section: &CrossSection| {
            section.leaves_the_line && section.section_use == CrossSectionUse::Accepted
        };
        if before.0 > 0 && !self.expected.is_empty() && !evidence.sections.iter().any(by_edges) {
            // Without an edge the place at which the arms stand out most is what is known, frame by frame anew; where nothing
            // is known of the distance, that alone would make a junction of any road that widens.
            filter.update_pose(&found_pose, STANDS_OUT_SIGMAS, by_pitch);
        }
        if let Some(gated) = edges_elsewhere(&evidence.sections) {
            evidence.decision = Decision::EdgesElsewhere { index, p, gated };
            return Ok(());
        }
        // The match must hold where the edges say the feature is. Edges that lead it elsewhere belong to something else; where
        // the feature is expected, the search alone then says where it is, less surely.
        let surprise = |filter: &PoseFilter| {
            let expectation = Expectation::Ahead(&stop.model, &self.expected);
            (!self.expected.is_empty()).then(|| expectation.penalty(filter.pose()))
        };
        let is_expected = |filter: &PoseFilter| surprise(filter).is_some_and(|surprise| surprise <= EXPECTED);
        let most_m = stop.model.approach().map_or(0.0, |arm| 0.5 * arm.width_m) + OFF_ROAD_M;
        let mut aligned = self.spare.pop().unwrap_or_default();
        // What speaks against a place, if anything does.
        let mut refusal = |filter: &PoseFilter| -> Result<Option<Decision>, SpanError> {
            laid.explain(masks, filter.pose(), &mut aligned)?;
            let beside_m = stop.model.left_of_approach_m(filter.pose()).abs();
            let (aligned_p, needed_p) = (aligned.p.unwrap_or(0.0), config.detect_threshold_at_verge);
            Ok(if beside_m > most_m {
                Some(Decision::OffApproach { index, p, beside_m, most_m })
            } else if aligned_p < needed_p {
                Some(Decision::EdgesDisagree { index, p, aligned_p, needed_p })
            } else {
                None
            })
        };
        if let Some(refused) = refusal(&filter)? {
            if !is_expected(&by_search) || refusal(&by_search)?.is_some() {
                self.spare.push(aligned);
                evidence.decision = refused;
                return Ok(());
            }
            evidence.sections.clear();
            filter = by_search;
        }
        let (aligned_p, contrast) = (aligned.p.unwrap_or(0.0), aligned.contrast());
        // What is shown is the place that is judged from here on.
        let before_it = evidence.sought.replace(shown.sought(index, aligned));
        self.spare.extend(before_it.map(|sought| sought.matched));
        let is_near = filter.pose().translation.x <= VERGES_OUT_OF_VIEW_M;
        if contrast.is_none() && !(is_near && is_expected(&filter)) && !evidence.sections.iter().any(tells_it)
        {
            evidence.decision = Decision::Unbounded { index, p: aligned_p };
            return Ok(());
        }
        let surprise = surprise(&filter).unwrap_or(0.0);
        let (frames, weight) = (before.0 + 1, before.1 + frame_weight(config, aligned_p, contrast, surprise));
        let most_frames = CANDIDATE_PATIENCE * config.detect_frames;
        if weight <= 0.0 {
            evidence.decision = without_weight(config, index, aligned_p, contrast, surprise);
        } else if frames > most_frames {
            evidence.decision = Decision::Dropped { index, frames, most_frames };
        } else if let Some(missing) = missing(config, frames, weight, &filter) {
            evidence.decision = Decision::Candidate { index, frames, p: aligned_p, missing };
            *candidate = Some(Candidate { filter, frames, weight });
        } else {
            masks.draw_about(filter.pose().rotation.angle(), STEERED_RAD)?;
            evidence.decision = Decision::Detected;
            self.spare.extend(evidence.sought.take().map(|sought| sought.matched));
            self.mode = Mode::Tracking { filter, unconfirmed: 0 };
        }
        Ok(())
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
fn missing(config: &TrackConfig, frames: usize, weight: f64, filter: &PoseFilter) -> Option<Missing> {
    let needed = config.detect_frames as f64 * frame_weight(config, 1.0, Some(config.detect_contrast), 0.0);
    let sigma_m = filter.covariance()[(0, 0)].sqrt();
    if frames < config.detect_frames {
        Some(Missing::Frames { needed: config.detect_frames })
    } else if weight < needed - WEIGHT_ROUNDING {
        Some(Missing::Contrast { sum: weight, needed })
    } else if sigma_m > KNOWN_SIGMA_M {
        Some(Missing::Distance { sigma_m, most_m: KNOWN_SIGMA_M })
    } else {
        None
    }
}

/// A vehicle that has not come to the feature yet drives along the approach: its heading says how the feature is turned.
fn stay_on_the_road(model: &FeatureModel, filter: &mut PoseFilter) {
    filter.update_heading(model.heading_off_approach_rad(filter.pose()), ON_ROAD_SIGMA_RAD);
}

/// How many edges of the arms that tell the feature lie too far from where it would be; none unless they are more than lie
/// where it would be.
fn edges_elsewhere(sections: &[CrossSection]) -> Option<usize> {
    let telling = |is: fn(&CrossSectionUse) -> bool| {
        sections.iter().filter(|section| section.leaves_the_line && is(&section.section_use)).count()
    };
    let gated = telling(|section_use| matches!(section_use, CrossSectionUse::Gated { .. }));
    let accepted = telling(|section_use| *section_use == CrossSectionUse::Accepted);
    (gated > accepted).then_some(gated)
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

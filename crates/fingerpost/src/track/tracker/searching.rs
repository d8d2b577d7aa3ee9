//! Searching: the next feature of the route is looked for where it can be.

use std::ops::RangeInclusive;

use fingerpost_vision::span::SpanError;

use super::{Candidate, FOUND_SIGMAS, Mode, PASSED_M, Tracker};
use crate::matching::LaidSurface;
use crate::track::alignment::{CrossSection, CrossSectionUse};
use crate::track::{Decision, PoseFilter, Sought, TrackEvidence};

/// Alignments before the one that counts, in the first frame of a candidate.
const SETTLING_ROUNDS: usize = 3;
/// A feature is only taken as detected when its distance is known to this standard deviation, metres.
const KNOWN_SIGMA_M: f64 = 0.45;
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
        let (config, index, masks) = (&self.config, self.next, &mut stop.masks);
        let tried = match (&candidate, &range) {
            (Some(candidate), _) => {
                self.search.about(config, laid, masks, config.detect_threshold, candidate.filter.pose())?
            }
            (None, Some(range)) => self.search.along_approach(config, laid, &stop.model, masks, range)?,
            (None, None) => return Ok(()),
        };
        evidence.tried = tried.count;
        if let Some(closest) = tried.closest {
            let mut matched = self.spare.pop().unwrap_or_default();
            laid.explain(masks, &closest, &mut matched)?;
            evidence.sought = Some(Sought { index, matched });
        }
        let Some((pose, p)) = tried.best else {
            *candidate = None;
            evidence.decision = Decision::NotFound { index };
            return Ok(());
        };
        let (mut filter, frames) = match candidate.take() {
            Some(candidate) => (candidate.filter, candidate.frames + 1),
            None => (PoseFilter::new(pose, FOUND_SIGMAS), 1),
        };
        if frames == 1 {
            // The search is coarse: until the place settles, each alignment starts anew from the one before.
            for _ in 0..SETTLING_ROUNDS {
                self.aligner.align(laid, &stop.arms, &mut filter)?;
                filter = PoseFilter::new(*filter.pose(), FOUND_SIGMAS);
            }
        }
        evidence.sections.extend_from_slice(self.aligner.align(laid, &stop.arms, &mut filter)?);
        if !evidence.sections.iter().any(tells_it) {
            evidence.decision = Decision::Unbounded { index, p };
            return Ok(());
        }
        // The match must hold where the edges say the feature is, and they must say it well enough.
        let mut aligned = self.spare.pop().unwrap_or_default();
        laid.explain(masks, filter.pose(), &mut aligned)?;
        let (aligned_p, contrast) = (aligned.p.unwrap_or(0.0), aligned.contrast());
        if aligned_p < config.detect_threshold {
            self.spare.push(aligned);
            evidence.decision = Decision::EdgesDisagree { index, p, aligned_p };
            return Ok(());
        }
        // What is shown is the place that is judged from here on.
        self.spare
            .extend(evidence.sought.replace(Sought { index, matched: aligned }).map(|sought| sought.matched));
        if let Some(contrast) = contrast.filter(|&contrast| contrast < config.detect_contrast) {
            evidence.decision = Decision::NoVerge { index, p: aligned_p, contrast };
        } else if frames < config.detect_frames || filter.covariance()[(0, 0)].sqrt() > KNOWN_SIGMA_M {
            evidence.decision = Decision::Candidate { index, frames, p: aligned_p };
            *candidate = Some(Candidate { filter, frames });
        } else {
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
    fn search_range(&self, evidence: &mut TrackEvidence) -> Option<RangeInclusive<f64>> {
        let stop = self.stops.get(self.next)?;
        let (mut low, mut high) = (self.nearest_seen_m + NEAREST_BEYOND_M, self.farthest_m);
        if let Some((mean, sigma)) = self.progress.belief_m() {
            let ahead_m = stop.model.route_m - mean;
            low = low.max(ahead_m - 3.0 * sigma);
            high = high.min(ahead_m + 3.0 * sigma);
            if !matches!(evidence.decision, Decision::Skipped { .. }) {
                evidence.decision = Decision::NotInReach { index: self.next, ahead_m };
            }
        }
        (low <= high).then_some(low..=high)
    }
}

/// Whether a cross-section shows an edge of an arm that tells the feature from a plain road.
fn tells_it(section: &CrossSection) -> bool {
    section.leaves_the_line
        && section.edges_m != [None, None]
        && !matches!(section.section_use, CrossSectionUse::WidthDisagrees { .. })
}

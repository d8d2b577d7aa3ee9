//! The tracker's states and how a frame moves it from one to the next.

use fingerpost_geometry::{GeometryError, GroundGrid, Polyline};
use fingerpost_map::Route;
use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};

use super::alignment::{self, CrossSection, CrossSectionUse};
use super::candidates;
use super::route_stop::{RouteStop, TrackerSetting, route_stops};
use super::{Decision, Followed, PoseFilter, Sought, State, TrackConfig, TrackEvidence, TrackOutput};
use crate::driving_line::DrivingLine;
use crate::feature_masks::{PlacedMasks, node_pixel};
use crate::matching::{LaidSurface, Match};
use crate::motion::Motion;
use crate::route_progress::RouteProgress;

#[derive(Debug)]
enum Mode {
    Searching { candidate: Option<Candidate>, lost: bool },
    Tracking { filter: PoseFilter, unconfirmed: usize },
}

#[derive(Debug)]
struct Candidate {
    filter: PoseFilter,
    frames: usize,
}

#[derive(Debug)]
struct Passing {
    index: usize,
    filter: PoseFilter,
}

/// Follows the features of a route, one after the other.
#[derive(Debug)]
pub struct Tracker {
    config: TrackConfig,
    stops: Vec<RouteStop>,
    route_in_map: Option<Polyline>,
    next: usize,
    mode: Mode,
    passing: Option<Passing>,
    progress: RouteProgress,
    nearest_seen_m: f64,
    farthest_m: f64,
    camera_height_m: f64,
}

/// Standard deviations of a place found by a search: metres, metres, radians.
const FOUND_SIGMAS: [f64; 3] = [1.2, 0.8, 0.1];
/// Alignments before the one that counts, in the first frame of a candidate.
const SETTLING_ROUNDS: usize = 3;
/// A feature is only taken as detected when its distance is known to this standard deviation, metres.
const KNOWN_SIGMA_M: f64 = 0.45;
/// A bracketed place must match better than the predicted one by this much: less is the noise of the road surface.
const CLEARLY_BETTER: f64 = 0.1;
/// A node at least this far behind by all that is known has been passed, metres.
const PASSED_M: f64 = 3.0;
/// Room between the farthest node that is searched for and the view's edge, metres: a road's half width must show.
const EDGE_ROOM_M: f64 = 1.0;
/// A feature nearer than this many metres beyond the bottom of the view is not searched for: its arms are out of view.
const NEAREST_BEYOND_M: f64 = 0.5;

impl Tracker {
    /// A tracker at the start of `route`, or without one.
    ///
    /// # Errors
    /// [`GeometryError`] when a feature's arms have no extent.
    pub fn new(
        setting: TrackerSetting<'_>,
        route: Option<&Route>,
        start_m: Option<f64>,
    ) -> Result<Self, GeometryError> {
        let (stops, route_in_map) = route_stops(setting, route)?;
        Ok(Self {
            config: setting.track.clone(),
            stops,
            route_in_map,
            next: 0,
            mode: Mode::Searching { candidate: None, lost: false },
            passing: None,
            progress: RouteProgress::new(setting.progress, start_m),
            nearest_seen_m: setting.nearest_seen_m,
            farthest_m: setting.grid.far_m() - EDGE_ROOM_M,
            camera_height_m: setting.camera_height_m,
        })
    }

    /// The features of the route with their driving lines.
    pub fn stops(&self) -> &[RouteStop] {
        &self.stops
    }

    /// The masks with which the feature of that index was matched.
    pub fn placed_masks(&self, index: usize, matched: &Match, grid: &GroundGrid) -> Option<PlacedMasks<'_>> {
        let pose = &matched.vehicle_from_feature;
        let masks = self.stops.get(index)?.masks.drawn(pose.rotation.angle())?;
        let (column, row) = node_pixel(grid, pose);
        Some(PlacedMasks { masks, column, row })
    }

    /// Takes one frame in: the motion since the last, the road surface, and a GPS position in the map frame.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub fn step(
        &mut self,
        motion: Option<&Motion>,
        laid: &LaidSurface<'_>,
        gps_in_map: Option<Point2<f64>>,
    ) -> Result<(TrackOutput, TrackEvidence), SpanError> {
        let mut evidence = TrackEvidence {
            decision: Decision::NoRoute,
            predicted: None,
            predicted_p: None,
            tried: 0,
            sought: None,
            sections: Vec::new(),
            gps: None,
        };
        if let Some(motion) = motion {
            self.predict(motion);
        }
        if let (Some(route), Some(p_in_map)) = (&self.route_in_map, gps_in_map) {
            evidence.gps = Some(self.progress.observe_gps(route, p_in_map));
        }
        let tracked = match &self.mode {
            Mode::Tracking { .. } => self.track(laid, &mut evidence)?,
            Mode::Searching { .. } => self.search(laid, &mut evidence)?,
        };
        let (state, followed) = match tracked {
            Some(followed) => (State::Tracking, Some(followed)),
            None => self.untracked(laid, &mut evidence)?,
        };
        let (state, followed) = self.arrive(laid, state, followed, &mut evidence)?;
        if let Some(followed) = &followed {
            self.observe_progress(followed);
        }
        let route_m = self.progress.belief_m().map(|(mean, _)| mean);
        Ok((TrackOutput { state, followed, route_m }, evidence))
    }

    fn predict(&mut self, motion: &Motion) {
        self.progress.advance(motion.previous_from_current.translation.x);
        if let Some(passing) = &mut self.passing {
            passing.filter.predict(motion);
        }
        match &mut self.mode {
            Mode::Tracking { filter, .. } => filter.predict(motion),
            Mode::Searching { candidate: Some(candidate), .. } => candidate.filter.predict(motion),
            Mode::Searching { candidate: None, .. } => {}
        }
    }

    /// Confirms the tracked feature at its predicted place, or brackets, or counts towards its loss.
    fn track(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<Option<Followed>, SpanError> {
        let (Mode::Tracking { filter, unconfirmed }, Some(stop)) =
            (&mut self.mode, self.stops.get_mut(self.next))
        else {
            return Ok(None);
        };
        let predicted = *filter.pose();
        let matched = laid.explain(&mut stop.masks, predicted)?;
        evidence.predicted = Some(predicted);
        evidence.predicted_p = matched.p;
        // Where no sub-mask is seen (close to the feature) there is nothing to confirm or deny.
        let confirmed = matched.p.is_none_or(|p| p >= self.config.confirm_threshold);
        if confirmed {
            *unconfirmed = 0;
            evidence.decision = Decision::Confirmed;
        } else {
            let threshold = self.config.confirm_threshold;
            let tried = candidates::about(&self.config, laid, &mut stop.masks, threshold, &predicted)?;
            evidence.tried = tried.count;
            let clearly_better = matched.p.unwrap_or(0.0) + CLEARLY_BETTER;
            if let Some((pose, _)) = tried.best.filter(|&(_, p)| p >= clearly_better) {
                *unconfirmed = 0;
                filter.relocate(pose, FOUND_SIGMAS);
                evidence.decision = Decision::FoundByBracketing;
            } else {
                *unconfirmed += 1;
                evidence.decision = Decision::NotConfirmed { frames: *unconfirmed };
                if *unconfirmed >= self.config.lost_frames {
                    evidence.decision = Decision::Lost { index: self.next };
                    self.mode = Mode::Searching { candidate: None, lost: true };
                    return Ok(None);
                }
            }
        }
        let matched_there = follow(laid, stop, self.next, filter)?;
        if *unconfirmed > 0 {
            return Ok(Some(matched_there));
        }
        let before = filter.clone();
        evidence.sections =
            alignment::align(&self.config.alignment, self.camera_height_m, laid, &stop.model, filter)?;
        let aligned = follow(laid, stop, self.next, filter)?;
        if aligned.matched.p.is_some_and(|p| p < self.config.confirm_threshold) {
            // Edges that lead the masks off the road belong to something else.
            *filter = before;
            return Ok(Some(matched_there));
        }
        Ok(Some(aligned))
    }

    /// Searches for the next feature where it can be; tracks it once it matched in enough frames.
    fn search(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<Option<Followed>, SpanError> {
        self.skip_passed(evidence);
        let range = self.search_range(evidence);
        let (Mode::Searching { candidate, .. }, Some(stop)) = (&mut self.mode, self.stops.get_mut(self.next))
        else {
            return Ok(None);
        };
        let tried = match (&candidate, range) {
            (Some(candidate), _) => {
                let (threshold, pose) = (self.config.detect_threshold, candidate.filter.pose());
                candidates::about(&self.config, laid, &mut stop.masks, threshold, pose)?
            }
            (None, Some(range)) => {
                candidates::along_approach(&self.config, laid, &stop.model, &mut stop.masks, range)?
            }
            (None, None) => return Ok(None),
        };
        evidence.tried = tried.count;
        if let Some(closest) = tried.closest {
            let matched = laid.explain(&mut stop.masks, closest)?;
            evidence.sought = Some(Sought { index: self.next, matched });
        }
        let Some((pose, p)) = tried.best else {
            *candidate = None;
            evidence.decision = Decision::NotFound { index: self.next };
            return Ok(None);
        };
        let (config, height) = (&self.config.alignment, self.camera_height_m);
        let (mut filter, frames) = match candidate.take() {
            Some(candidate) => (candidate.filter, candidate.frames + 1),
            None => (PoseFilter::new(pose, FOUND_SIGMAS), 1),
        };
        if frames == 1 {
            // The search is coarse: until the place settles, each alignment starts anew from the one before.
            for _ in 0..SETTLING_ROUNDS {
                alignment::align(config, height, laid, &stop.model, &mut filter)?;
                filter = PoseFilter::new(*filter.pose(), FOUND_SIGMAS);
            }
        }
        evidence.sections = alignment::align(config, height, laid, &stop.model, &mut filter)?;
        let told = |section: &CrossSection| {
            section.leaves_the_line
                && section.edges_m != [None, None]
                && !matches!(section.section_use, CrossSectionUse::WidthDisagrees { .. })
        };
        if !evidence.sections.iter().any(told) {
            evidence.decision = Decision::Unbounded { index: self.next, p };
            return Ok(None);
        }
        // The match must hold where the edges say the feature is, and they must say it well enough.
        let followed = follow(laid, stop, self.next, &filter)?;
        let aligned_p = followed.matched.p.unwrap_or(0.0);
        if aligned_p < self.config.detect_threshold {
            evidence.decision = Decision::EdgesDisagree { index: self.next, p, aligned_p };
            return Ok(None);
        }
        if frames < self.config.detect_frames || filter.covariance()[(0, 0)].sqrt() > KNOWN_SIGMA_M {
            evidence.decision = Decision::Candidate { index: self.next, frames, p: aligned_p };
            *candidate = Some(Candidate { filter, frames });
            return Ok(None);
        }
        evidence.decision = Decision::Detected;
        evidence.sought = None;
        self.mode = Mode::Tracking { filter, unconfirmed: 0 };
        Ok(Some(followed))
    }

    /// Moves on past features that lie behind by all that is known.
    fn skip_passed(&mut self, evidence: &mut TrackEvidence) {
        while let Some(stop) = self.stops.get(self.next)
            && self.progress.at_least_m() > stop.model.route_m + PASSED_M
        {
            evidence.decision = Decision::Skipped { index: self.next };
            self.next += 1;
            self.mode = Mode::Searching { candidate: None, lost: false };
        }
    }

    /// Distances of the next feature's node that are possible and in view, metres; none when there are none.
    fn search_range(&self, evidence: &mut TrackEvidence) -> Option<std::ops::RangeInclusive<f64>> {
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

    /// State and carried feature of a frame in which none is tracked.
    fn untracked(
        &mut self,
        laid: &LaidSurface<'_>,
        evidence: &mut TrackEvidence,
    ) -> Result<(State, Option<Followed>), SpanError> {
        let gone = self.passing.as_ref().is_some_and(|passing| passed(&self.stops, passing));
        if gone {
            self.passing = None;
        }
        if let Some(passing) = &mut self.passing
            && let Some(stop) = self.stops.get_mut(passing.index)
        {
            let matched = laid.explain(&mut stop.masks, *passing.filter.pose())?;
            if matched.p.is_some_and(|p| p >= self.config.confirm_threshold) {
                let (config, height) = (&self.config.alignment, self.camera_height_m);
                let sections = alignment::align(config, height, laid, &stop.model, &mut passing.filter)?;
                if evidence.sections.is_empty() {
                    evidence.sections = sections;
                }
            }
            if matches!(
                evidence.decision,
                Decision::NotInReach { .. } | Decision::NotFound { .. } | Decision::NoRoute
            ) {
                evidence.decision = Decision::Passing;
            }
            let followed = follow(laid, stop, passing.index, &passing.filter)?;
            return Ok((State::Arrived, Some(followed)));
        }
        let state = if self.stops.is_empty() {
            State::NoRoute
        } else if self.next >= self.stops.len() {
            evidence.decision = Decision::RouteDone;
            State::RouteDone
        } else {
            match self.mode {
                Mode::Searching { lost: true, .. } => State::Lost,
                _ => State::Searching,
            }
        };
        Ok((state, None))
    }

    /// The papers' rule: when the driving line's start reaches the bottom of the view, the vehicle has arrived.
    fn arrive(
        &mut self,
        laid: &LaidSurface<'_>,
        state: State,
        followed: Option<Followed>,
        evidence: &mut TrackEvidence,
    ) -> Result<(State, Option<Followed>), SpanError> {
        let (State::Tracking, Some(followed), Mode::Tracking { filter, .. }) = (state, &followed, &self.mode)
        else {
            return Ok((state, followed));
        };
        let Some(stop) = self.stops.get(self.next) else { return Ok((state, Some(followed.clone()))) };
        let start = stop.line.as_ref().map_or(Point2::origin(), DrivingLine::start);
        let bottom_m = laid.grid().near_m().max(self.nearest_seen_m);
        // The frame of detection is reported as tracking first.
        if matches!(evidence.decision, Decision::Detected) || (filter.pose() * start).x > bottom_m {
            return Ok((state, Some(followed.clone())));
        }
        evidence.decision = Decision::Arrived;
        self.passing = Some(Passing { index: self.next, filter: filter.clone() });
        self.next += 1;
        self.mode = Mode::Searching { candidate: None, lost: false };
        Ok((State::Arrived, Some(followed.clone())))
    }

    fn observe_progress(&mut self, followed: &Followed) {
        let Some(stop) = self.stops.get(followed.index) else { return };
        let p_in_feature = followed.vehicle_from_feature.inverse() * Point2::origin();
        let along = |course: &Polyline| course.nearest(p_in_feature);
        let (approach, exit) = (stop.model.approach(), stop.model.exit());
        let before = approach.map(|arm| along(&arm.course));
        let behind = exit.map(|arm| along(&arm.course));
        let route_m = match (before, behind) {
            (Some(before), Some(behind)) if behind.left_m.abs() < before.left_m.abs() => {
                stop.model.route_m + behind.along_m
            }
            (Some(before), _) => stop.model.route_m - before.along_m,
            _ => return,
        };
        let sigma = followed.covariance.fixed_view::<2, 2>(0, 0).trace().sqrt();
        self.progress.observe(route_m, sigma);
    }
}

/// Whether the vehicle's origin is past the end of the line through the feature.
fn passed(stops: &[RouteStop], passing: &Passing) -> bool {
    let end = stops
        .get(passing.index)
        .and_then(|stop| stop.line.as_ref())
        .map_or(Point2::origin(), DrivingLine::end);
    let end_in_vehicle = passing.filter.pose() * end;
    let node_in_vehicle = passing.filter.pose() * Point2::origin();
    end_in_vehicle.x < 0.0 && node_in_vehicle.x < PASSED_M
}

fn follow(
    laid: &LaidSurface<'_>,
    stop: &mut RouteStop,
    index: usize,
    filter: &PoseFilter,
) -> Result<Followed, SpanError> {
    let vehicle_from_feature: Isometry2<f64> = *filter.pose();
    let matched = laid.explain(&mut stop.masks, vehicle_from_feature)?;
    Ok(Followed { index, vehicle_from_feature, covariance: *filter.covariance(), matched })
}

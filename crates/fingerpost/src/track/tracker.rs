//! The tracker's states and how a frame moves it from one to the next.

mod confirming;
mod first_to_come;
mod passing;
mod searching;
mod weighing;

use fingerpost_geometry::{GeometryError, Polyline};
use fingerpost_map::Route;
use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};

use self::searching::edges_by_which_it_is_told;
use super::alignment::Aligner;
use super::candidates::CandidateSearch;
use super::route_stop::{RouteStop, TrackerSetting, route_stops};
use super::shown::ShownRoad;
use super::{
    CandidatePlace, Decision, ExpectedAhead, FeatureTracker, Followed, Moved, PoseFilter, ShownSurface,
    State, TrackConfig, TrackEvidence, TrackOutput,
};
use crate::feature_masks::MaskCurve;
use crate::ground_view::{CameraTurn, Viewpoint};
use crate::matching::{LaidSurface, Match};
use crate::motion::FeatureStep;
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
    /// What its frames say for it so far.
    weight: f64,
}

/// Where a feature is, and the variances of its distance (m2) and its heading (rad2).
#[derive(Debug, Clone, Copy)]
struct AtHand {
    index: usize,
    vehicle_from_feature: Isometry2<f64>,
    variances: [f64; 2],
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
    found_off: Option<(f64, f64)>,
    /// The candidate of this frame of which only the distance is not sure.
    unsure: Option<CandidatePlace>,
    search: CandidateSearch,
    /// Where the next feature is expected.
    expected: Vec<ExpectedAhead>,
    aligner: Aligner,
    /// Memory of matches that were handed out with the frame before.
    spare: Vec<Match>,
    nearest_seen_m: f64,
    farthest_m: f64,
    /// Length of the view ahead, metres.
    view_m: f64,
    /// Standard deviation of its distance up to which a feature is tracked, metres.
    known_sigma_m: f64,
    viewpoint: Viewpoint,
    /// Where the last frame shows the road. Poses of the filters are where features are shown.
    shown: ShownRoad,
}

/// Reach of the view for which `track.detect_sigma_m` is given, metres (paper 2, section 6: 15 to 20).
const USUAL_FAR_M: f64 = 20.0;
/// Alignments before the one that counts, of a place that a search found: it is coarse.
const SETTLING_ROUNDS: usize = 3;
/// Standard deviations of a place found by a search: metres, metres, radians.
const FOUND_SIGMAS: [f64; 3] = [1.6, 0.8, 0.1];
/// A node at least this far behind by all that is known has been passed, metres.
const PASSED_M: f64 = 3.0;
/// Room between the farthest node that is searched for and the view's edge, metres: a road's half width must show.
const EDGE_ROOM_M: f64 = 1.0;

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
        let progress = RouteProgress::new(setting.progress, start_m);
        Ok(Self { stops, ..Self::without_stops(setting, progress, 0, route_in_map) })
    }

    fn without_stops(
        setting: TrackerSetting<'_>,
        progress: RouteProgress,
        next: usize,
        route_in_map: Option<Polyline>,
    ) -> Self {
        Self {
            config: setting.track.clone(),
            stops: Vec::new(),
            route_in_map,
            next,
            mode: Mode::Searching { candidate: None, lost: false },
            passing: None,
            progress,
            found_off: None,
            unsure: None,
            search: CandidateSearch::default(),
            expected: Vec::new(),
            aligner: Aligner::new(&setting.track.alignment, setting.viewpoint),
            spare: Vec::new(),
            nearest_seen_m: setting.nearest_seen_m,
            farthest_m: setting.grid.far_m() - EDGE_ROOM_M,
            view_m: setting.grid.far_m() - setting.grid.near_m(),
            known_sigma_m: setting.track.detect_sigma_m
                * (setting.grid.far_m() / USUAL_FAR_M).max(1.0).powi(2),
            viewpoint: setting.viewpoint,
            shown: ShownRoad::new(&CameraTurn::default(), setting.viewpoint),
        }
    }

    fn predict(&mut self, moved: &Moved<'_>) {
        if let Some(attitude) = &moved.camera {
            self.aligner.know_attitude(attitude);
        }
        let before = self.shown;
        let now = moved.camera.map_or(before, |camera| ShownRoad::new(&camera.turn, self.viewpoint));
        let predict = |filter: &mut PoseFilter| {
            filter.place(before.road_from_shown(filter.pose()));
            if let Some(motion) = moved.motion {
                filter.predict(motion);
            }
            filter.place(now.shown_from_road(filter.pose()));
        };
        self.progress.elapse(moved.time_s());
        if let Some(travel) = moved.travel() {
            self.progress.advance(travel, moved.time_s());
        }
        if let Some(passing) = &mut self.passing {
            predict(&mut passing.filter);
        }
        match &mut self.mode {
            Mode::Tracking { filter, .. } => predict(filter),
            Mode::Searching { candidate: Some(candidate), .. } => predict(&mut candidate.filter),
            Mode::Searching { candidate: None, .. } => {}
        }
        self.shown = now;
    }

    /// The feature by which the vehicle's motion shows: the one that is followed, sought or passed, where it is on the road.
    fn at_hand(&self) -> Option<AtHand> {
        let of = |index: usize, filter: &PoseFilter| AtHand {
            index,
            vehicle_from_feature: self.shown.road_from_shown(filter.pose()),
            variances: [filter.covariance()[(0, 0)], filter.covariance()[(2, 2)]],
        };
        match (&self.mode, &self.passing) {
            (Mode::Tracking { filter, .. }, _) => Some(of(self.next, filter)),
            (Mode::Searching { candidate: Some(Candidate { filter, .. }), .. }, None) => {
                Some(of(self.next, filter))
            }
            (Mode::Searching { .. }, Some(passing)) => Some(of(passing.index, &passing.filter)),
            (Mode::Searching { candidate: None, .. }, None) => None,
        }
    }

    /// The papers' rule: when the start of their curve reaches the bottom of the view, the vehicle has arrived.
    fn arrive(&mut self, laid: &LaidSurface<'_>, evidence: &mut TrackEvidence) -> State {
        let (Mode::Tracking { filter, .. }, Some(stop)) = (&self.mode, self.stops.get(self.next)) else {
            return State::Tracking;
        };
        let start = stop.mask_curve.as_ref().map_or(Point2::origin(), MaskCurve::start);
        let bottom_m = laid.grid().near_m().max(self.nearest_seen_m);
        // The frame of detection is reported as tracking first.
        if matches!(evidence.decision, Decision::Detected) || (filter.pose() * start).x > bottom_m {
            return State::Tracking;
        }
        evidence.decision = Decision::Arrived;
        let arrived = Passing { index: self.next, filter: filter.clone() };
        if let Some(before) = self.passing.replace(arrived) {
            self.forget_masks(before.index);
        }
        self.next += 1;
        self.mode = Mode::Searching { candidate: None, lost: false };
        State::Arrived
    }

    /// The feature that is followed in `state`, with its match.
    fn followed(&mut self, state: State, laid: &LaidSurface<'_>) -> Result<Option<Followed>, SpanError> {
        let (index, filter) = match (state, &self.mode, &self.passing) {
            (State::Tracking, Mode::Tracking { filter, .. }, _) => (self.next, filter),
            (State::Arrived, _, Some(passing)) => (passing.index, &passing.filter),
            _ => return Ok(None),
        };
        let Some(stop) = self.stops.get_mut(index) else { return Ok(None) };
        let mut matched = self.spare.pop().unwrap_or_default();
        laid.explain(&mut stop.masks, filter.pose(), &mut matched)?;
        let (vehicle_from_feature, covariance) =
            (self.shown.road_from_shown(filter.pose()), *filter.covariance());
        Ok(Some(Followed { index, vehicle_from_feature, covariance, present: None, matched }))
    }

    /// Frees the masks of a feature that lies behind, so that memory does not grow with the route that was driven.
    fn forget_masks(&mut self, index: usize) {
        if let Some(stop) = self.stops.get_mut(index) {
            stop.masks.clear();
        }
    }
}

/// How the vehicle moved between two frames that both know where the same feature is.
fn step_by(before: Option<AtHand>, now: Option<AtHand>) -> Option<FeatureStep> {
    let (before, now) = before.zip(now).filter(|(before, now)| before.index == now.index)?;
    Some(FeatureStep {
        previous_from_current: before.vehicle_from_feature * now.vehicle_from_feature.inverse(),
        variances: [0, 1].map(|i| before.variances[i] + now.variances[i]),
    })
}

impl FeatureTracker for Tracker {
    fn stops(&self) -> &[RouteStop] {
        &self.stops
    }

    fn step(
        &mut self,
        moved: Moved<'_>,
        shown: ShownSurface<'_>,
        gps_in_map: Option<Point2<f64>>,
        output: &mut TrackOutput,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        let laid = &shown.laid;
        self.spare.extend(output.followed.take().map(|followed| followed.matched));
        self.spare.extend(evidence.sought.take().map(|sought| sought.matched));
        evidence.clear();
        output.begin_frame();
        self.unsure = None;
        let before = self.at_hand();
        self.predict(&moved);
        if let (Some(route), Some(p_in_map)) = (&self.route_in_map, gps_in_map) {
            evidence.gps = Some(self.progress.observe_gps(route, p_in_map));
        }
        match self.mode {
            Mode::Tracking { .. } => self.confirm(laid, evidence)?,
            Mode::Searching { .. } => self.search_next(laid, evidence)?,
        }
        output.state = match self.mode {
            Mode::Tracking { .. } => self.arrive(laid, evidence),
            Mode::Searching { .. } => self.pass(laid, evidence)?,
        };
        if edges_by_which_it_is_told(&evidence.sections) > 0 {
            output.step = step_by(before, self.at_hand());
        }
        output.candidate = self.unsure;
        output.skipped = evidence.decision.skipped();
        output.followed = self.followed(output.state, laid)?;
        if let Some(followed) = &output.followed {
            let feature_m = self.stops.get(followed.index).map_or(0.0, |stop| stop.model.route_m);
            match (followed.route_m(&self.stops), &evidence.decision) {
                (Some((route_m, sigma_m)), Decision::Detected) => {
                    let expected = self.progress.belief_m();
                    self.found_off =
                        expected.map(|(mean_m, of_m)| (route_m - mean_m, libm::hypot(of_m, sigma_m)));
                    self.progress.observe_found(feature_m, route_m, sigma_m);
                }
                (Some((route_m, sigma_m)), _) => self.progress.observe(route_m, sigma_m),
                (None, _) => {}
            }
        }
        (output.route_m, output.route_sigma_m) = self.progress.belief_m().unzip();
        Ok(())
    }
}

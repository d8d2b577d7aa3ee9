//! The tracker that is one belief: the states are read off how probable it is that the next feature is there, and where.
//!
//! What is seen of the ground is kept on the ground (`ground_memory.rs`), and from it follows afresh, as often as it has more to
//! say, how probable every place of the next feature is, and that it is not there (`feature_belief.rs`):
//!
//! p(place, unknowns | ground) ~ p(place | progress) p(unknowns) prod (h + (1 - h) prod [q(d) e^l + 1 - q(d)] / [b e^l + 1 - b])
//!
//! over the stretches of the arms, of which a share h is hidden, and the cells of the ground beside each, with l a cell's log-odds of road, d its signed distance from the edge of the road at that
//! place, q the share of such ground that looks like road and b that of ground of which nothing is known. Against it stands the
//! same of a plain road without the feature. Searching while neither is sure, tracking once the feature is there and its place
//! is known well enough to steer by, arrived when the driving line's start reaches the bottom of the view, lost when the
//! probability goes elsewhere. A feature that was arrived at is measured on until it lies behind, while the next is searched for.
//!
//! Limits: on recorded streets, where shadows and parked cars make whole stretches of road look like none, it finds less than the rules.

mod feature_belief;
mod fit;
mod ground_memory;
pub(super) mod junction_shape;
mod likelihood;

use fingerpost_geometry::{GeometryError, GroundGrid, Polyline};
use fingerpost_map::Route;
use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};

use self::feature_belief::{Expected, FeatureBelief, Moments, Seen, Workspace};
use self::ground_memory::GroundMemory;
use self::likelihood::Ground;
use super::route_stop::{RouteStop, TrackerSetting, route_stops};
use super::shown::ShownRoad;
use super::{
    Decision, FeatureTracker, Followed, Lack, Moved, ShownSurface, Sought, State, TrackConfig, TrackEvidence,
    TrackOutput,
};
use crate::driving_line::DrivingLine;
use crate::ground_view::{CameraTurn, Viewpoint};
use crate::matching::{LaidSurface, Match};
use crate::motion::CameraAttitude;
use crate::route_progress::RouteProgress;

/// A feature that was arrived at, until it lies behind.
#[derive(Debug)]
struct Passing {
    index: usize,
    belief: FeatureBelief,
}

/// Follows the features of a route, one after the other.
#[derive(Debug)]
pub struct BeliefTracker {
    config: TrackConfig,
    stops: Vec<RouteStop>,
    route_in_map: Option<Polyline>,
    /// The feature that is searched for or tracked.
    next: usize,
    belief: FeatureBelief,
    state: State,
    passing: Option<Passing>,
    progress: RouteProgress,
    expected: Vec<Expected>,
    memory: GroundMemory,
    ground: Ground,
    work: Workspace,
    /// Metres driven since the beliefs were computed; none before the first time.
    since_update_m: Option<f64>,
    /// Memory of matches that were handed out with the frame before.
    spare: Vec<Match>,
    view_m: [f64; 2],
    viewpoint: Viewpoint,
    /// Angle that a row of the picture spans, radians.
    row_rad: f64,
    /// Where the last frame shows the road.
    shown: ShownRoad,
    /// Standard deviations of the camera's pitch and roll, radians.
    attitude_sigma_rad: [f64; 2],
}

/// A node at least this far behind by all that is known has been passed, metres.
const PASSED_M: f64 = 3.0;
/// Distance driven after which the ground has more to say, metres: a cell of its map.
const NEWS_M: f64 = 0.25;
/// A vehicle that follows its road wanders so far from the heading at which it found a feature, radians: 3 degrees.
const STEERED_RAD: f64 = 0.052;
/// A tracked feature is lost when its place is less sure than the bound for tracking by this factor, so that it does not come and go.
const LOST_SIGMA_FACTOR: f64 = 1.6;
/// Standard deviation of the distance to a feature while nothing is known of the progress, metres: it may be anywhere in view
/// and beyond.
const UNKNOWN_SIGMA_M: f64 = 15.0;

impl BeliefTracker {
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
            state: if stops.is_empty() { State::NoRoute } else { State::Searching },
            stops,
            route_in_map,
            next: 0,
            belief: FeatureBelief::default(),
            passing: None,
            progress: RouteProgress::new(setting.progress, start_m),
            expected: Vec::new(),
            memory: GroundMemory::new(setting.viewpoint.foot),
            ground: Ground::default(),
            work: Workspace::default(),
            since_update_m: None,
            spare: Vec::new(),
            view_m: [setting.nearest_seen_m, setting.grid.far_m()],
            viewpoint: setting.viewpoint,
            row_rad: setting.row_rad,
            shown: ShownRoad::new(&CameraTurn::default(), setting.viewpoint),
            attitude_sigma_rad: CameraAttitude::default().sigma_rad,
        })
    }

    /// Moves everything on with the vehicle.
    fn carry(&mut self, moved: &Moved<'_>) {
        if let Some(CameraAttitude { turn, sigma_rad }) = moved.camera {
            self.shown = ShownRoad::new(&turn, self.viewpoint);
            self.attitude_sigma_rad = sigma_rad;
        }
        let Some(motion) = moved.motion else { return };
        let step = &motion.previous_from_current;
        self.memory.carry(step);
        self.progress.advance(step.translation.x);
        self.belief.carry(step);
        if let Some(passing) = &mut self.passing {
            passing.belief.carry(step);
        }
        self.since_update_m = self.since_update_m.map(|since_m| since_m + step.translation.vector.norm());
    }

    /// Computes the beliefs afresh where the ground has more to say.
    fn compute(&mut self, evidence: &mut TrackEvidence) {
        self.skip_passed(evidence);
        let reaches = self.expect();
        if self.since_update_m.is_some_and(|since_m| since_m < NEWS_M) {
            return;
        }
        if !reaches && self.passing.is_none() {
            self.belief.clear();
            self.since_update_m = None;
            return;
        }
        self.since_update_m = Some(0.0);
        self.ground.take(self.memory.squares(), self.viewpoint, self.row_rad);
        let Self { config, stops, ground, expected, view_m, attitude_sigma_rad, work, .. } = self;
        let mut update = |index: usize, belief: &mut FeatureBelief| {
            let Some(stop) = stops.get(index) else { return 0 };
            belief.update(
                work,
                Seen {
                    config,
                    stop,
                    ground,
                    expected,
                    view_m: *view_m,
                    attitude_sigma_rad: *attitude_sigma_rad,
                },
            )
        };
        if let Some(passing) = &mut self.passing {
            update(passing.index, &mut passing.belief);
        }
        if reaches {
            evidence.tried = update(self.next, &mut self.belief);
        } else {
            self.belief.clear();
        }
    }

    /// Moves on past features that lie behind by all that is known.
    fn skip_passed(&mut self, evidence: &mut TrackEvidence) {
        while self.state != State::Tracking
            && let Some(stop) = self.stops.get_mut(self.next)
            && self.progress.at_least_m() > stop.model.route_m + PASSED_M
        {
            stop.masks.clear();
            evidence.decision = Decision::Skipped { index: self.next };
            self.next += 1;
            self.belief.clear();
            self.state = State::Searching;
        }
    }

    /// Where the next feature is expected; whether that may be in view.
    fn expect(&mut self) -> bool {
        self.expected.clear();
        let Some(stop) = self.stops.get(self.next) else { return false };
        let beliefs = self.progress.beliefs_m();
        self.expected.extend(
            beliefs.map(|(mean_m, sigma_m)| Expected { ahead_m: stop.model.route_m - mean_m, sigma_m }),
        );
        if self.expected.is_empty() {
            let ahead_m = 0.5 * (self.view_m[0] + self.view_m[1]);
            self.expected.push(Expected { ahead_m, sigma_m: UNKNOWN_SIGMA_M });
        }
        self.expected.iter().any(|e| e.ahead_m - 3.0 * e.sigma_m < self.view_m[1])
    }

    /// Reads the state off the beliefs.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    fn decide(&mut self, grid: &GroundGrid, evidence: &mut TrackEvidence) -> Result<(), SpanError> {
        if let Some(gone) = self.passing.take_if(|passing| passed(&self.stops, passing)) {
            self.forget_masks(gone.index);
        }
        let moments = self.belief.moments();
        let tracked = self.state == State::Tracking;
        let lack = moments.and_then(|moments| self.lack(&moments, tracked));
        match (tracked, moments, lack) {
            (false, Some(moments), None) => {
                evidence.decision = Decision::Detected;
                self.state = State::Tracking;
                if let Some(stop) = self.stops.get_mut(self.next) {
                    stop.masks.draw_about(moments.vehicle_from_feature.rotation.angle(), STEERED_RAD)?;
                }
            }
            (true, Some(moments), None) => {
                evidence.decision = Decision::Confirmed;
                self.arrive(&moments, grid, evidence);
            }
            (true, _, lack) => {
                let lack =
                    lack.unwrap_or(Lack::Presence { present: 0.0, needed: self.config.belief.lost_present });
                evidence.decision = Decision::NoLongerSure { index: self.next, lack };
                self.state = State::Lost;
            }
            (false, ..) if self.passing.is_some() => evidence.decision = Decision::Passing,
            (false, Some(_), Some(lack)) => {
                evidence.decision = Decision::NotSure { index: self.next, lack };
            }
            (false, ..) => self.decide_without_place(evidence),
        }
        Ok(())
    }

    /// What is decided where the next feature has no place.
    fn decide_without_place(&mut self, evidence: &mut TrackEvidence) {
        if self.next >= self.stops.len() {
            evidence.decision = Decision::RouteDone;
            self.state = State::RouteDone;
        } else if let (Some(expected), 0) = (self.expected.first(), evidence.tried) {
            if !matches!(evidence.decision, Decision::Skipped { .. }) {
                evidence.decision = Decision::NotInReach { index: self.next, ahead_m: expected.ahead_m };
            }
        } else {
            evidence.decision = Decision::NotFound { index: self.next };
        }
    }

    /// What a feature lacks to be tracked, or to be tracked on.
    fn lack(&self, moments: &Moments, tracked: bool) -> Option<Lack> {
        let config = &self.config;
        let (needed, most_m) = if tracked {
            (config.belief.lost_present, LOST_SIGMA_FACTOR * config.belief.detect_sigma_m)
        } else {
            (config.belief.detect_present, config.belief.detect_sigma_m)
        };
        let (present, sigma_m) = (moments.present, moments.sigma_m());
        if present < needed {
            Some(Lack::Presence { present, needed })
        } else if sigma_m > most_m {
            Some(Lack::Place { present, sigma_m, most_m })
        } else {
            None
        }
    }

    /// The papers' rule: when the driving line's start reaches the bottom of the view, the vehicle has arrived.
    fn arrive(&mut self, moments: &Moments, grid: &GroundGrid, evidence: &mut TrackEvidence) {
        let Some(stop) = self.stops.get(self.next) else { return };
        let start = stop.line.as_ref().map_or(Point2::origin(), DrivingLine::start);
        let bottom_m = grid.near_m().max(self.view_m[0]);
        if (moments.vehicle_from_feature * start).x > bottom_m {
            return;
        }
        evidence.decision = Decision::Arrived;
        self.belief.leave_approach();
        let arrived = Passing { index: self.next, belief: std::mem::take(&mut self.belief) };
        if let Some(before) = self.passing.replace(arrived) {
            self.forget_masks(before.index);
        }
        self.next += 1;
        self.state = State::Searching;
    }

    /// Frees the masks of a feature that lies behind, so that memory does not grow with the route that was driven.
    fn forget_masks(&mut self, index: usize) {
        if let Some(stop) = self.stops.get_mut(index) {
            stop.masks.clear();
        }
    }

    /// The output of this frame, and what it rests on.
    fn give(
        &mut self,
        laid: &LaidSurface<'_>,
        output: &mut TrackOutput,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        let is_followed = |state: State| matches!(state, State::Tracking | State::Arrived);
        output.state = match (self.state, &self.passing) {
            (State::Tracking | State::NoRoute, _) | (_, None) => self.state,
            (_, Some(_)) => State::Arrived,
        };
        let (index, belief) = match &self.passing {
            Some(passing) if output.state == State::Arrived => (passing.index, &passing.belief),
            _ => (self.next, &self.belief),
        };
        let (Some(moments), Some(stop)) = (belief.moments(), self.stops.get_mut(index)) else {
            return Ok(());
        };
        evidence.places.extend(belief.places());
        belief.edges(stop, &mut evidence.edges);
        let Moments { vehicle_from_feature, covariance, present } = moments;
        let mut matched = self.spare.pop().unwrap_or_default();
        laid.explain(&mut stop.masks, &self.shown.shown_from_road(&vehicle_from_feature), &mut matched)?;
        if is_followed(output.state) {
            output.followed =
                Some(Followed { index, vehicle_from_feature, covariance, present: Some(present), matched });
        } else {
            evidence.sought = Some(Sought { index, vehicle_from_feature, matched });
        }
        Ok(())
    }
}

impl FeatureTracker for BeliefTracker {
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
        self.spare.extend(output.followed.take().map(|followed| followed.matched));
        self.spare.extend(evidence.sought.take().map(|sought| sought.matched));
        evidence.clear();
        if !self.stops.is_empty() {
            self.carry(&moved);
            self.memory.see(shown.laid.grid(), (&shown.surface.probability, shown.seen), self.shown.map());
            if let (Some(route), Some(p_in_map)) = (&self.route_in_map, gps_in_map) {
                evidence.gps = Some(self.progress.observe_gps(route, p_in_map));
            }
            self.compute(evidence);
            self.decide(shown.laid.grid(), evidence)?;
        }
        self.give(&shown.laid, output, evidence)?;
        let beside = output.followed.as_ref().and_then(|followed| followed.route_m(&self.stops));
        if let (Some((route_m, sigma_m)), State::Arrived) = (beside, output.state) {
            // Before it is reached a feature does not say where it is to be expected.
            self.progress.observe(route_m, sigma_m);
        }
        output.route_m = beside.or_else(|| self.progress.belief_m()).map(|(route_m, _)| route_m);
        Ok(())
    }
}

/// Whether the vehicle's origin is past the end of the line through the feature.
fn passed(stops: &[RouteStop], passing: &Passing) -> bool {
    let stop = stops.get(passing.index);
    let end = stop.and_then(|stop| stop.line.as_ref()).map_or(Point2::origin(), DrivingLine::end);
    let Some(moments) = passing.belief.moments() else { return true };
    let pose: Isometry2<f64> = moments.vehicle_from_feature;
    (pose * end).x < 0.0 && (pose * Point2::origin()).x < PASSED_M
}

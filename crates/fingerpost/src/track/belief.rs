//! The tracker that is one belief: the states are read off how probable it is that the next feature is there, and where.
//!
//! What is seen of the ground is kept on the ground (`ground_memory.rs`), and from it follows afresh, as often as it has more to
//! say, how probable every place of the next feature is, and that it is not there (`feature_belief.rs`):
//!
//! p(place, unknowns | ground) ~ p(place | progress) p(unknowns) prod (h + (1 - h) prod [q(d) e^l + 1 - q(d)] / [b e^l + 1 - b])
//!
//! over the stretches of the arms, of which a share h is hidden, and the cells of the ground beside each, with l a cell's log-odds of
//! road, d its signed distance from the edge of the road at that place, q the share of such ground that looks like road and b that of ground of which nothing is known. Against it stands the
//! same of a plain road without the feature. Searching while neither is sure, tracking once the feature is there and its place
//! is known well enough to steer by, arrived when the start of their curve reaches the bottom of the view, lost when the
//! probability goes elsewhere. A feature that was arrived at is measured on until it lies behind, while the next is searched for.
//! Where the vehicle is along the route is part of it (`route_belief.rs`).
//!
//! Limits: without a start it finds little, as every feature may be the next.

mod along_route;
mod feature_belief;
mod fit;
mod ground_memory;
pub(super) mod junction_shape;
mod likelihood;
mod route_belief;

use fingerpost_geometry::{GeometryError, GroundGrid, Polyline};
use fingerpost_map::Route;
use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};

use self::feature_belief::{Moments, Workspace};
use self::ground_memory::{GroundMemory, Looks};
use self::likelihood::Ground;
use self::route_belief::{FeatureInView, PASSED_M, RouteBelief, Stage, View};
use super::route_stop::{RouteStop, TrackerSetting, route_stops};
use super::shown::ShownRoad;
use super::{
    CandidatePlace, Decision, FeatureTracker, Followed, Lack, Moved, ShownSurface, Sought, State,
    TrackConfig, TrackEvidence, TrackOutput,
};
use crate::feature_masks::MaskCurve;
use crate::ground_view::{CameraTurn, Viewpoint};
use crate::matching::{LaidSurface, Match};
use crate::motion::CameraAttitude;
use crate::progress::Travel;

/// Follows the features of a route, one after the other.
#[derive(Debug)]
pub struct BeliefTracker {
    config: TrackConfig,
    stops: Vec<RouteStop>,
    route_in_map: Option<Polyline>,
    route: RouteBelief,
    /// While no feature is followed.
    state: State,
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

/// Distance driven after which the ground has more to say, metres: a cell of its map.
const NEWS_M: f64 = 0.25;
/// A vehicle that follows its road wanders so far from the heading at which it found a feature, radians: 3 degrees.
const STEERED_RAD: f64 = 0.052;
/// A tracked feature is lost when its place is less sure than the bound for tracking by this factor, so that it does not come and go.
const LOST_SIGMA_FACTOR: f64 = 1.6;
/// Probability from which all features lie behind.
const DONE: f64 = 0.5;

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
        let route_length_m = route_in_map.as_ref().map_or(0.0, Polyline::length_m);
        Ok(Self {
            config: setting.track.clone(),
            state: if stops.is_empty() { State::NoRoute } else { State::Searching },
            stops,
            route_in_map,
            route: RouteBelief::new(setting.progress, start_m, route_length_m),
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
        let Some((motion, travel)) = moved.motion.zip(moved.travel()) else { return };
        self.route.advance(travel, moved.time_s());
        if let Travel::Measured { .. } = travel {
            let step = &motion.previous_from_current;
            self.memory.carry(step);
            self.route.carry(step);
            self.since_update_m = self.since_update_m.map(|since_m| since_m + step.translation.vector.norm());
        } else {
            self.leave_ground();
        }
    }

    /// The vehicle went on unseen: what is remembered of the ground lies nobody knows where.
    fn leave_ground(&mut self) {
        self.memory.clear();
        self.route.leave_ground();
        self.since_update_m = None;
        if matches!(self.state, State::Tracking | State::Arrived) {
            self.state = State::Lost;
        }
    }

    /// Computes the beliefs afresh where the ground has more to say.
    fn compute(&mut self, evidence: &mut TrackEvidence) {
        if self.since_update_m.is_some_and(|since_m| since_m < NEWS_M) {
            return;
        }
        if let Some(index) = self.route.choose(&self.stops, self.view_m) {
            self.forget_masks(index);
            evidence.decision = Decision::Skipped { index };
            self.state = State::Searching;
        }
        if self.route.features().is_empty() {
            self.since_update_m = None;
            return;
        }
        self.since_update_m = Some(0.0);
        self.ground.take(self.memory.squares(), self.viewpoint, self.row_rad);
        let Self { config, stops, ground, view_m, attitude_sigma_rad, route, work, .. } = self;
        let (view_m, attitude_sigma_rad) = (*view_m, *attitude_sigma_rad);
        evidence.tried = route.weigh(View { config, stops, ground, view_m, attitude_sigma_rad }, work);
    }

    /// Reads the state off the beliefs.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    fn decide(&mut self, grid: &GroundGrid, evidence: &mut TrackEvidence) -> Result<(), SpanError> {
        let gone = |feature: &&FeatureInView| feature.stage == Stage::Arrived && passed(&self.stops, feature);
        if let Some(index) = self.route.features().iter().find(gone).map(|gone| gone.index) {
            self.route.leave(&self.stops, index);
            self.forget_masks(index);
        }
        let bottom_m = grid.near_m().max(self.view_m[0]);
        let next = self.next().unwrap_or(self.stops.len());
        let mut decided = None;
        let mut state = if self.state == State::Lost { State::Lost } else { State::Searching };
        let mut arrived = None;
        for feature in self.route.features_mut() {
            let index = feature.index;
            let Some(stop) = self.stops.get_mut(index) else { continue };
            let moments = feature.belief.moments();
            let lack = moments.map(|moments| lack(&self.config, &moments, feature.stage));
            match (feature.stage, moments, lack) {
                (Stage::Arrived, ..) => {}
                (Stage::Sought, Some(moments), Some(None)) if index <= next => {
                    feature.stage = Stage::Tracked;
                    stop.masks.draw_about(moments.vehicle_from_feature.rotation.angle(), STEERED_RAD)?;
                    decided = Some(Decision::Detected);
                    state = State::Tracking;
                }
                // It waits until those before it lie behind.
                (Stage::Sought, Some(_), Some(None)) => {}
                (Stage::Sought, _, lack) => {
                    let undecided = lack
                        .flatten()
                        .map_or(Decision::NotFound { index }, |lack| Decision::NotSure { index, lack });
                    decided = decided.or(Some(undecided));
                }
                (Stage::Tracked, Some(moments), Some(None)) => {
                    decided = Some(Decision::Confirmed);
                    state = State::Tracking;
                    if has_begun(stop, &moments, bottom_m) {
                        decided = Some(Decision::Arrived);
                        feature.belief.leave_approach();
                        feature.stage = Stage::Arrived;
                        arrived = Some(index);
                        state = State::Searching;
                    }
                }
                (Stage::Tracked, _, lack) => {
                    let needed = self.config.belief.lost_present;
                    let lack = lack.flatten().unwrap_or(Lack::Presence { present: 0.0, needed });
                    decided = Some(Decision::NoLongerSure { index, lack });
                    feature.stage = Stage::Sought;
                    state = State::Lost;
                }
            }
        }
        if let Some(arrived) = arrived {
            self.leave_arrived_before(arrived);
        }
        let is_passing = self
            .route
            .features()
            .iter()
            .any(|feature| feature.stage == Stage::Arrived && feature.belief.moments().is_some());
        if is_passing && matches!(state, State::Searching | State::Lost) {
            state = State::Arrived;
        }
        self.state = state;
        self.say(decided, evidence);
        Ok(())
    }

    /// The first feature that does not lie behind.
    fn next(&self) -> Option<usize> {
        let progress = self.route.progress();
        self.stops.iter().position(|stop| progress.mass_behind(stop.model.route_m) < DONE)
    }

    /// One feature at a time is on its way through: those before `index` lie behind.
    fn leave_arrived_before(&mut self, index: usize) {
        let is_before = |feature: &&FeatureInView| feature.stage == Stage::Arrived && feature.index != index;
        while let Some(before) = self.route.features().iter().find(is_before).map(|feature| feature.index) {
            self.route.leave(&self.stops, before);
            self.forget_masks(before);
        }
    }

    /// Says what was decided of the features in view, or what there is to say where none is.
    fn say(&mut self, decided: Option<Decision>, evidence: &mut TrackEvidence) {
        let is_undecided =
            |decision: &Decision| matches!(decision, Decision::NotSure { .. } | Decision::NotFound { .. });
        let progress = self.route.progress();
        evidence.decision = match (decided, self.state, self.next()) {
            (Some(decided), ..) if !is_undecided(&decided) => decided,
            (_, State::Arrived, _) => Decision::Passing,
            (Some(undecided), ..) => undecided,
            (None, ..) if matches!(evidence.decision, Decision::Skipped { .. }) => return,
            (None, _, Some(index)) => {
                let (route_m, _) = progress.moments_m();
                let ahead_m = self.stops.get(index).map_or(0.0, |stop| stop.model.route_m - route_m);
                Decision::NotInReach { index, ahead_m }
            }
            (None, _, None) => {
                self.state = State::RouteDone;
                Decision::RouteDone
            }
        };
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
        output.state = self.state;
        output.skipped = evidence.decision.skipped();
        let at = |stage: Stage| self.route.features().iter().find(|feature| feature.stage == stage);
        let followed = match self.state {
            State::Tracking => at(Stage::Tracked),
            State::Arrived => at(Stage::Arrived),
            _ => None,
        };
        let Some(feature) = followed.or_else(|| at(Stage::Sought)) else { return Ok(()) };
        let FeatureInView { index, belief, .. } = feature;
        let (Some(moments), Some(stop)) = (belief.moments(), self.stops.get_mut(*index)) else {
            return Ok(());
        };
        evidence.places.extend(belief.places());
        belief.edges(stop, &mut evidence.edges);
        let (index, is_followed) = (*index, followed.is_some());
        let Moments { vehicle_from_feature, covariance, present } = moments;
        output.candidate = matches!(evidence.decision, Decision::NotSure { lack: Lack::Place { .. }, .. })
            .then_some(CandidatePlace { index, vehicle_from_feature, covariance, present });
        let mut matched = self.spare.pop().unwrap_or_default();
        laid.explain(&mut stop.masks, &self.shown.shown_from_road(&vehicle_from_feature), &mut matched)?;
        if is_followed {
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
        output.begin_frame();
        if !self.stops.is_empty() {
            self.carry(&moved);
            let looks = Looks {
                probability: &shown.surface.probability,
                uninformed_log_odds: shown.surface.uninformed_log_odds,
                seen: shown.seen,
            };
            self.memory.see(shown.laid.grid(), looks, self.shown.map());
            if let (Some(route), Some(p_in_map)) = (&self.route_in_map, gps_in_map) {
                evidence.gps = Some(self.route.observe_gps(route, p_in_map));
            }
            self.compute(evidence);
            self.decide(shown.laid.grid(), evidence)?;
        }
        self.give(&shown.laid, output, evidence)?;
        let beside = output.followed.as_ref().and_then(|followed| followed.route_m(&self.stops));
        let likeliest = || {
            let likeliest = self.route.progress().components().next()?;
            Some((likeliest.mean_m, likeliest.sigma_m))
        };
        (output.route_m, output.route_sigma_m) = beside.or_else(likeliest).unzip();
        Ok(())
    }
}

/// What a feature lacks to be tracked, or to be tracked on.
fn lack(config: &TrackConfig, moments: &Moments, stage: Stage) -> Option<Lack> {
    let (needed, most_m) = match stage {
        Stage::Sought => (config.belief.detect_present, config.belief.detect_sigma_m),
        _ => (config.belief.lost_present, LOST_SIGMA_FACTOR * config.belief.detect_sigma_m),
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

/// The papers' rule: when the start of their curve reaches the bottom of the view, the vehicle has arrived.
fn has_begun(stop: &RouteStop, moments: &Moments, bottom_m: f64) -> bool {
    let start = stop.mask_curve.as_ref().map_or(Point2::origin(), MaskCurve::start);
    (moments.vehicle_from_feature * start).x <= bottom_m
}

/// Whether the vehicle's origin is past the end of the papers' curve through the feature.
fn passed(stops: &[RouteStop], feature: &FeatureInView) -> bool {
    let stop = stops.get(feature.index);
    let end = stop.and_then(|stop| stop.mask_curve.as_ref()).map_or(Point2::origin(), MaskCurve::end);
    feature
        .belief
        .pose()
        .is_none_or(|pose: Isometry2<f64>| (pose * end).x < 0.0 && (pose * Point2::origin()).x < PASSED_M)
}

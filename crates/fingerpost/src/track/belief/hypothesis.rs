//! One of the answers to where a drive began, with all that follows from it.
//!
//! Paper 1, section VII takes the features as directions in their order, begun at the first. A vehicle that begins in mid-route
//! sees a later one first, and junctions look alike. So every feature may be the first one to come, and each of these hypotheses has a
//! progress and features of its own. Their probabilities are how well they explain what was seen, and what was not.

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};

use super::super::{Decision, Lack, RouteStop, State, TrackConfig};
use super::feature_belief::Moments;
use super::route_belief::{FeatureInView, PASSED_M, RouteBelief, Stage};
use crate::feature_masks::MaskCurve;
use crate::progress::Progress;

/// A vehicle that follows its road wanders so far from the heading at which it found a feature, radians: 3 degrees.
const STEERED_RAD: f64 = 0.052;
/// A tracked feature is lost when its place is less sure than the bound for tracking by this factor, so that it does not come and go.
const LOST_SIGMA_FACTOR: f64 = 1.6;
/// Probability from which all features lie behind.
const DONE: f64 = 0.5;
/// Hypotheses that have the vehicle within this of each other say the same, metres: as much as a feature may be off to count as found.
const SAME_M: f64 = 3.0;

/// Where the drive may have begun.
#[derive(Debug)]
pub(super) struct Hypothesis {
    /// Index of the feature that comes first by it.
    pub(super) first: usize,
    pub(super) route: RouteBelief,
    /// While no feature is followed.
    pub(super) state: State,
    pub(super) decision: Decision,
    /// Logarithm of its probability before anything was seen.
    log_prior: f64,
    /// Its probability.
    pub(super) weight: f64,
}

/// What the states are read off with.
#[derive(Debug)]
pub(super) struct Reading<'a> {
    pub(super) config: &'a TrackConfig,
    pub(super) stops: &'a mut [RouteStop],
    pub(super) grid: &'a GroundGrid,
    /// Bottom of what is seen ahead, metres.
    pub(super) nearest_seen_m: f64,
}

impl Hypothesis {
    pub(super) fn new(first: usize, progress: Progress, prior: f64) -> Self {
        Self {
            first,
            route: RouteBelief::new(progress),
            state: State::Searching,
            decision: Decision::default(),
            log_prior: libm::log(prior),
            weight: prior,
        }
    }

    /// Logarithm of its probability, up to what all hypotheses share.
    pub(super) fn log_weight(&self) -> f64 {
        self.log_prior + self.route.log_evidence()
    }

    /// Whether both have the vehicle at the same place.
    pub(super) fn agrees_with(&self, other: &Self) -> bool {
        let located = |hypothesis: &Self| {
            let progress = hypothesis.route.progress();
            let moments = progress.components().next().map(|_| progress.moments_m());
            moments.filter(|(_, sigma_m)| *sigma_m < SAME_M)
        };
        let (own, others) = (located(self), located(other));
        own.zip(others).is_some_and(|((own_m, _), (other_m, _))| (own_m - other_m).abs() < SAME_M)
    }

    /// Takes over the probability of another one that agrees.
    pub(super) fn take(&mut self, other: &Self) {
        self.log_prior += libm::log1p(other.weight / self.weight.max(f64::MIN_POSITIVE));
        self.weight += other.weight;
    }

    /// The vehicle went on unseen: what is remembered of the ground lies nobody knows where.
    pub(super) fn leave_ground(&mut self) {
        self.route.leave_ground();
        if matches!(self.state, State::Tracking | State::Arrived) {
            self.state = State::Lost;
        }
    }

    /// Takes up the features that may be in view, and leaves those that no longer can.
    pub(super) fn choose(&mut self, stops: &mut [RouteStop], view_m: [f64; 2]) {
        if let Some(index) = self.route.choose(stops, view_m) {
            forget_masks(stops, index);
            self.decision = Decision::Skipped { index };
            self.state = State::Searching;
        }
    }

    /// Reads the state off the beliefs.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub(super) fn decide(&mut self, reading: Reading<'_>) -> Result<(), SpanError> {
        let Reading { config, stops, grid, nearest_seen_m } = reading;
        let gone = |feature: &&FeatureInView| feature.stage == Stage::Arrived && passed(stops, feature);
        if let Some(index) = self.route.features().iter().find(gone).map(|gone| gone.index) {
            self.route.leave(stops, index);
            forget_masks(stops, index);
        }
        let bottom_m = grid.near_m().max(nearest_seen_m);
        let next = self.next(stops).unwrap_or(stops.len());
        let mut decided = None;
        let mut state = if self.state == State::Lost { State::Lost } else { State::Searching };
        let mut arrived = None;
        for feature in self.route.features_mut() {
            let index = feature.index;
            let lies_behind = passed(stops, feature);
            let Some(stop) = stops.get_mut(index) else { continue };
            let moments = feature.belief.moments();
            let lack = moments.map(|moments| lack(config, &moments, feature.stage));
            match (feature.stage, moments, lack) {
                (Stage::Arrived, ..) => {}
                (Stage::Sought, Some(moments), Some(None)) if index <= next && !lies_behind => {
                    feature.stage = Stage::Tracked;
                    stop.masks.draw_about(moments.vehicle_from_feature.rotation.angle(), STEERED_RAD)?;
                    decided = Some(Decision::Detected);
                    state = State::Tracking;
                }
                // It waits until those before it lie behind, or says what was passed unseen: nobody is led through that.
                (Stage::Sought, Some(_), Some(None)) => {}
                (Stage::Sought, _, lack) => {
                    let undecided = match lack.flatten() {
                        Some(lack) => Decision::NotSure { index, lack },
                        None => Decision::NotFound { index, places: feature.belief.places_scanned() },
                    };
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
                    let needed = config.lost_present;
                    let lack = lack.flatten().unwrap_or(Lack::Presence { present: 0.0, needed });
                    decided = Some(Decision::NoLongerSure { index, lack });
                    feature.stage = Stage::Sought;
                    state = State::Lost;
                }
            }
        }
        if let Some(arrived) = arrived {
            self.leave_arrived_before(stops, arrived);
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
        self.say(decided, stops);
        Ok(())
    }

    /// The first feature that does not lie behind.
    pub(super) fn next(&self, stops: &[RouteStop]) -> Option<usize> {
        let progress = self.route.progress();
        stops.iter().position(|stop| progress.mass_behind(stop.model.route_m) < DONE)
    }

    /// One feature at a time is on its way through: those before `index` lie behind.
    fn leave_arrived_before(&mut self, stops: &mut [RouteStop], index: usize) {
        let is_before = |feature: &&FeatureInView| feature.stage == Stage::Arrived && feature.index != index;
        while let Some(before) = self.route.features().iter().find(is_before).map(|feature| feature.index) {
            self.route.leave(stops, before);
            forget_masks(stops, before);
        }
    }

    /// Says what was decided of the features in view, or what there is to say where none is.
    fn say(&mut self, decided: Option<Decision>, stops: &[RouteStop]) {
        let is_undecided =
            |decision: &Decision| matches!(decision, Decision::NotSure { .. } | Decision::NotFound { .. });
        let progress = self.route.progress();
        self.decision = match (decided, self.state, self.next(stops)) {
            (Some(decided), ..) if !is_undecided(&decided) => decided,
            (_, State::Arrived, _) => Decision::Passing,
            (Some(undecided), ..) => undecided,
            (None, ..) if matches!(self.decision, Decision::Skipped { .. }) => return,
            (None, _, Some(index)) => {
                let (route_m, _) = progress.moments_m();
                let ahead_m = stops.get(index).map_or(0.0, |stop| stop.model.route_m - route_m);
                Decision::NotInReach { index, ahead_m }
            }
            (None, _, None) => {
                self.state = State::RouteDone;
                Decision::RouteDone
            }
        };
    }
}

/// Frees the masks of a feature that lies behind, so that memory does not grow with the route that was driven.
fn forget_masks(stops: &mut [RouteStop], index: usize) {
    if let Some(stop) = stops.get_mut(index) {
        stop.masks.clear();
    }
}

/// What a feature lacks to be tracked, or to be tracked on.
fn lack(config: &TrackConfig, moments: &Moments, stage: Stage) -> Option<Lack> {
    let (needed, most_m) = match stage {
        Stage::Sought => (config.detect_present, config.detect_sigma_m),
        _ => (config.lost_present, LOST_SIGMA_FACTOR * config.detect_sigma_m),
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

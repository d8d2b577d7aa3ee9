//! Where along the route the vehicle is, and the features that may therefore be in view: one belief.
//!
//! The progress from before any feature in view goes on with the vehicle. Whenever the ground has more to say, each of these
//! features is weighed afresh with the progress as the others have it, and all of them together give the progress as it is now
//! (`progress/feature.rs`). What a feature said is taken over for good when it can be in view no more. A wrong start, a feature
//! that the map has and the road has not, and a vehicle that was moved are thus one case: mass goes where the ground is explained.

use fingerpost_geometry::{Polyline, heading_of, wrap_angle};
use nalgebra::{Isometry2, Point2};

use super::feature_belief::{FeatureBelief, Seen, Workspace, as_on_map};
use super::junction_shape::Neighbour;
use super::likelihood::{Ground, pose_of};
use crate::feature_model::FeatureModel;
use crate::progress::{GpsUse, Progress, Travel};
use crate::track::route_stop::MOUTH_M;
use crate::track::{RouteStop, TrackConfig};

/// Most features that are weighed at a time: what a view of 20 m can hold, and one that a doubt about the progress adds.
const MOST_IN_VIEW: usize = 3;
/// A feature is looked for from this probability of being in view on, and no more below half of it: a fiftieth of the doubts.
const LEAST_IN_VIEW: f64 = 0.02;
/// Standard deviation of a vehicle's heading against its road's behind a feature, radians: 17 degrees; and how often it is turned otherwise.
const TURNED_SIGMA_RAD: f64 = 0.3;
const TURNED_OTHERWISE: f64 = 0.02;
/// A node at least this far behind can be in view no more, metres.
pub(super) const PASSED_M: f64 = 3.0;

/// How far the vehicle has come with a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// It is looked for.
    Sought,
    /// It is there, and its place sure enough to steer by.
    Tracked,
    /// Its driving line has begun.
    Arrived,
}

/// A feature that may be in view.
#[derive(Debug)]
pub(super) struct FeatureInView {
    pub(super) index: usize,
    pub(super) stage: Stage,
    pub(super) belief: FeatureBelief,
}

/// What features are weighed against, besides the progress.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) config: &'a TrackConfig,
    pub(super) stops: &'a [RouteStop],
    pub(super) ground: &'a Ground,
    /// Bottom and top of the view, metres.
    pub(super) view_m: [f64; 2],
    /// Standard deviations of the camera's pitch and roll, radians.
    pub(super) attitude_sigma_rad: [f64; 2],
}

/// The belief of the route.
#[derive(Debug)]
pub(super) struct RouteBelief {
    /// Without what the features in view say.
    before: Progress,
    now: Progress,
    /// In the order of the route.
    features: Vec<FeatureInView>,
    /// Logarithm of how well the vehicle is turned as its route is behind the features that it came by.
    log_turned: f64,
}

impl RouteBelief {
    /// At the first frame, with the vehicle where this says.
    pub(super) fn new(before: Progress) -> Self {
        Self { now: before.clone(), before, features: Vec::with_capacity(MOST_IN_VIEW), log_turned: 0.0 }
    }

    pub(super) const fn progress(&self) -> &Progress {
        &self.now
    }

    pub(super) fn features(&self) -> &[FeatureInView] {
        &self.features
    }

    pub(super) fn features_mut(&mut self) -> &mut [FeatureInView] {
        &mut self.features
    }

    /// The vehicle came so far in so many seconds.
    pub(super) fn advance(&mut self, travel: Travel, dt_s: f64) {
        self.before.advance(travel, dt_s);
        self.now.advance(travel, dt_s);
    }

    /// The features stay where they are on the ground.
    pub(super) fn carry(&mut self, previous_from_current: &Isometry2<f64>) {
        self.features.iter_mut().for_each(|feature| feature.belief.carry(previous_from_current));
    }

    /// The ground that was seen is left behind, and what it said is kept.
    pub(super) fn leave_ground(&mut self) {
        self.before = self.now.clone();
        self.features.clear();
    }

    /// Logarithm of how probable what was seen is by this belief, against a road without the route's features.
    pub(super) fn log_evidence(&self) -> f64 {
        self.now.log_evidence() + self.log_turned
    }

    /// Takes in a GPS position, in the map frame, with `route` in the same.
    pub(super) fn observe_gps(&mut self, route: &Polyline, p_in_map: Point2<f64>) -> GpsUse {
        self.before.observe_gps(route, p_in_map);
        self.now.observe_gps(route, p_in_map)
    }

    /// Leaves a feature that lies behind; what it said of the progress is kept.
    pub(super) fn leave(&mut self, stops: &[RouteStop], index: usize) {
        for left in self.features.extract_if(.., |feature| feature.index == index) {
            let Some(stop) = stops.get(left.index) else { continue };
            if left.stage == Stage::Arrived {
                self.log_turned += left.belief.pose().map_or(0.0, |pose| log_turned(&stop.model, &pose));
            }
            self.before = self.before.conditioned(stop.model.route_m, &left.belief.outcome());
        }
    }

    /// Leaves the features that can be in view no more, and takes up those that can; returns one that was left without having
    /// been arrived at.
    pub(super) fn choose(&mut self, stops: &[RouteStop], view_m: [f64; 2]) -> Option<usize> {
        let in_view = |progress: &Progress, index: usize, nearest_m: f64| {
            let route_m = stops.get(index).map_or(0.0, |stop| stop.model.route_m);
            progress.probability_between(route_m - view_m[1], route_m - nearest_m)
        };
        let mut skipped = None;
        while let Some(gone) = self.features.iter().find(|feature| {
            feature.stage != Stage::Arrived
                && in_view(&self.now, feature.index, -PASSED_M) < 0.5 * LEAST_IN_VIEW
        }) {
            skipped = Some(gone.index);
            self.leave(stops, gone.index);
        }
        let nothing_known = self.now.components().next().is_none();
        while self.features.len() < MOST_IN_VIEW {
            let is_new = |index: &usize| self.features.iter().all(|feature| feature.index != *index);
            let probable =
                (0..stops.len()).filter(is_new).map(|index| (index, in_view(&self.now, index, view_m[0])));
            // Of equally probable ones the first.
            let likeliest = probable.fold(None, |best: Option<(usize, f64)>, next| match best {
                Some(best) if best.1 >= next.1 => Some(best),
                _ => Some(next),
            });
            let Some((index, probability)) = likeliest else { break };
            if probability < LEAST_IN_VIEW && !(nothing_known && probability > 0.0) {
                break;
            }
            let belief = FeatureBelief::default();
            self.features.push(FeatureInView { index, stage: Stage::Sought, belief });
            self.features.sort_unstable_by_key(|feature| feature.index);
        }
        skipped
    }

    /// Weighs the features afresh; returns how many places were tried.
    pub(super) fn weigh(&mut self, view: View<'_>, work: &mut Workspace) -> usize {
        let View { config, stops, ground, view_m, attitude_sigma_rad } = view;
        let mut tried = 0;
        for i in 0..self.features.len() {
            let Some(index) = self.features.get(i).map(|feature| feature.index) else { continue };
            let progress = &self.conditioned(stops, |other| other != index);
            let neighbours = self.neighbours(config, stops, index);
            let Some(feature) = self.features.get_mut(i) else { continue };
            let Some(stop) = stops.get(feature.index) else { continue };
            let seen = Seen { config, stop, neighbours, ground, progress, view_m, attitude_sigma_rad };
            tried += feature.belief.update(work, seen);
        }
        self.now = self.conditioned(stops, |_| true);
        tried
    }

    /// The features before and behind one on the route whose mouths meet its own, as wide as they are believed to be, or else as the map has
    /// them: those farther off are told from it by its own road.
    fn neighbours<'a>(
        &self,
        config: &TrackConfig,
        stops: &'a [RouteStop],
        index: usize,
    ) -> [Option<Neighbour<'a>>; 2] {
        [0, 1].map(|side| {
            let beside = if side == 0 { index.checked_sub(1)? } else { index + 1 };
            let (stop, other) = (stops.get(index)?, stops.get(beside)?);
            if (other.model.route_m - stop.model.route_m).abs() >= 2.0 * MOUTH_M {
                return None;
            }
            let in_view = self.features.iter().find(|other| other.index == beside);
            let believed = in_view.and_then(|other| other.belief.best());
            let outline = other.shape.outline(believed.unwrap_or(&as_on_map(config)));
            Neighbour::new(&stop.model, (&other.model, side), outline, believed.map(pose_of).as_ref())
        })
    }

    /// The progress as those features in view have it that count.
    fn conditioned(&self, stops: &[RouteStop], counts: impl Fn(usize) -> bool) -> Progress {
        let mut progress = self.before.clone();
        for feature in self.features.iter().filter(|feature| counts(feature.index)) {
            if let Some(stop) = stops.get(feature.index) {
                progress = progress.conditioned(stop.model.route_m, &feature.belief.outcome());
            }
        }
        progress
    }
}

/// Logarithm of how well a vehicle that comes by a feature is turned as its exit is, against one that is so for sure.
fn log_turned(model: &FeatureModel, vehicle_from_feature: &Isometry2<f64>) -> f64 {
    let feature_from_vehicle = vehicle_from_feature.inverse();
    let p_in_feature = feature_from_vehicle * Point2::origin();
    let exit_rad =
        model.exit().map(|exit| heading_of(exit.course.at(exit.course.nearest(p_in_feature).along_m).1));
    let off_rad =
        exit_rad.map_or(0.0, |exit_rad| wrap_angle(feature_from_vehicle.rotation.angle() - exit_rad));
    let off = off_rad / TURNED_SIGMA_RAD;
    libm::log(TURNED_OTHERWISE + (1.0 - TURNED_OTHERWISE) * libm::exp(-0.5 * off * off))
}

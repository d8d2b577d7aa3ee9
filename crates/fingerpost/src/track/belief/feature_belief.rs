//! The belief about one feature of the route: where it may be, and that it may not be there.
//!
//! Computed afresh from the map of the ground whenever that has more to say, never multiplied up from frame to frame:
//!
//! p(place, unknowns | ground) ~ p(place | progress) p(unknowns) p(ground | place, unknowns),
//!
//! against p(nothing there) p(ground | plain road, or ground that is paved all over), where p(place | progress) is what the route's
//! other features leave open, and some of what looks like the feature is none of the route's (`along_route.rs`). The places that a scan along the approach finds
//! are fitted together with what is not known of widths, corners and camera; each is a Gaussian with the weight of its evidence.

mod on_route;

use fingerpost_geometry::wrap_angle;
use fingerpost_map::FeatureKind;
use nalgebra::{Isometry2, Matrix3, Point2, Vector2, Vector3};

use super::along_route::{Expected, expected_at, is_placed};
use super::fit::{Fit, Fitter, Prior, Start};
use super::junction_shape::{
    CORNERS, FORWARD, HEADING, JunctionShape, LEFT, MOST_ARMS, Neighbour, OFFSETS, PITCH, ROLL, SCALE,
    Surroundings, Unknowns, WIDTHS,
};
use super::likelihood::{Ground, log_sum, pose_of, set_pose};
use crate::feature_model::FeatureModel;
use crate::progress::{FeaturePlace, Progress};
use crate::track::{PossiblePlace, RouteStop, TrackConfig};

/// Standard deviation of a vehicle's place beside the middle of its road, metres: either lane of a road of 8 m.
const BESIDE_SIGMA_M: f64 = 2.0;
/// Standard deviation of a vehicle's heading against its road's before the curve begins, radians.
const HEADING_SIGMA_RAD: f64 = 0.15;
/// A vehicle is turned as its road is within so many metres: half of what a turning circle of 5 m takes.
const TURNS_WITHIN_M: f64 = 4.0;
/// Standard deviation of the middle of an arm's road against the map's, metres: nodes are drawn to a quarter of a metre each,
/// roads of different width meet along their edges.
const OFFSET_SIGMA_M: f64 = 0.3;
/// Standard deviation of the logarithm of a corner's radius: a factor of two and a half, from a square corner to a wide mouth.
const CORNER_LOG_SIGMA: f64 = 0.9;
/// A square corner's radius, metres.
const LEAST_RADIUS_M: f64 = 0.3;
/// Standard deviation of the camera's height, share of it: measured with a tape.
const SCALE_SIGMA: f64 = 0.03;
/// How often a feature of the map is not there, or not as the map says.
const MAP_WRONG: f64 = 0.03;
/// How often the ground about a place is paved all over, as yards and car parks are: a guess.
const PAVED: f64 = 0.05;
/// Step of the scan along the approach, metres, and how soft edges are for it, metres: what a step must not jump over.
const SCAN_STEP_M: f64 = 0.5;
const SCAN_SOFT_M: f64 = 0.4;
/// The scan takes every so many-th square of cells: neighbours err together.
const SCAN_EVERY: usize = 3;
/// Of the best places of a scan that are not known so many take turns, one a scan; and most places that are kept.
const SCANNED_PLACES: usize = 3;
const MOST_PLACES: usize = 4;
/// Places nearer to each other are one, metres.
const SAME_PLACE_M: f64 = 0.7;
/// A place of less weight is forgotten.
const LEAST_WEIGHT: f64 = 1e-4;
/// Distance driven after which the approach is scanned anew, metres.
const SCAN_EVERY_M: f64 = 0.7;
/// Once the curve has begun the approach no longer says how the vehicle is turned. What was known then is carried on, its
/// standard deviations doubled, because the ground that gave it is looked at again.
const CARRIED_SIGMAS: f64 = 2.0;
/// Room between the farthest node that is searched for and the view's edge, metres: a road's half width must show.
const EDGE_ROOM_M: f64 = 1.0;

/// The places together, matched by their moments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments {
    pub(super) vehicle_from_feature: Isometry2<f64>,
    pub(super) covariance: Matrix3<f64>,
    /// Probability that the feature is there at all.
    pub(super) present: f64,
}

impl Moments {
    /// Standard deviation of the place, metres.
    pub(super) fn sigma_m(&self) -> f64 {
        self.covariance.fixed_view::<2, 2>(0, 0).trace().sqrt()
    }
}

#[derive(Debug, Clone)]
struct Place {
    fit: Fit,
    /// Where it was expected.
    expected: Expected,
    /// Logarithm of how much likelier it makes the ground than a plain road does, with the probability of being there.
    log_share: f64,
    /// Probability of a feature here by what the ground says alone.
    by_ground: f64,
    weight: f64,
}

/// The belief about one feature.
#[derive(Debug, Clone, Default)]
pub(super) struct FeatureBelief {
    places: Vec<Place>,
    /// The plain road without the feature, as the last fit left it.
    plain: Option<Start>,
    /// What is carried on once the curve has begun.
    carried: Option<Carried>,
    /// Metres driven since the approach was scanned; none before the first scan.
    since_scan_m: Option<f64>,
    scans: usize,
    /// What the scan found: how far ahead, metres, and the log-likelihood there against that of a plain road.
    scanned: Vec<(f64, f64)>,
    /// The places as the progress sees them.
    on_route: Vec<FeaturePlace>,
    /// Where ahead it would have been seen, metres, and the probability that it is there and was not.
    looked_for: Option<([f64; 2], f64)>,
    /// Logarithm of the likelihood of its best place when the curve began, and how much more the ground said after.
    log_likelihood: f64,
    log_said_after: f64,
}

/// What was known of a feature when the curve began.
#[derive(Debug, Clone, Copy)]
struct Carried {
    vehicle_from_feature: Isometry2<f64>,
    /// Standard deviations, metres and radians.
    sigmas: [f64; 3],
    /// Logarithm of the share of the places against that of a plain road.
    log_share: f64,
    /// Logarithm of how much likelier it made the ground than a plain road does; none before the first fit.
    log_ratio: Option<f64>,
}

/// Memory that is reused from belief to belief.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    fitter: Fitter,
    starts: Vec<Start>,
    scores: Vec<(Unknowns, f64)>,
    expected: Vec<Expected>,
}

/// What a belief is computed from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen<'a> {
    pub(super) config: &'a TrackConfig,
    pub(super) stop: &'a RouteStop,
    /// The features before and behind it on the route, where their mouths meet its own.
    pub(super) neighbours: [Option<Neighbour<'a>>; 2],
    pub(super) ground: &'a Ground,
    /// Where the vehicle is along the route, without what this feature says.
    pub(super) progress: &'a Progress,
    /// Bottom and top of the view, metres.
    pub(super) view_m: [f64; 2],
    /// Standard deviations of the camera's pitch and roll, radians.
    pub(super) attitude_sigma_rad: [f64; 2],
}

impl<'a> Seen<'a> {
    /// The feature, or the road without it, among those next to it.
    const fn around(&self, shape: &'a JunctionShape) -> Surroundings<'a> {
        Surroundings { shape, neighbours: self.neighbours }
    }
}

impl FeatureBelief {
    /// The vehicle moves on: places, and what is carried, stay on the ground.
    pub(super) fn carry(&mut self, previous_from_current: &Isometry2<f64>) {
        let current_from_previous = previous_from_current.inverse();
        let carry = |unknowns: &mut Unknowns| {
            set_pose(unknowns, &(current_from_previous * pose_of(unknowns)));
        };
        self.places.iter_mut().for_each(|place| carry(&mut place.fit.unknowns));
        self.plain.iter_mut().for_each(|plain| carry(&mut plain.unknowns));
        let moved = previous_from_current.translation.vector;
        if let Some(Carried { vehicle_from_feature, .. }) = &mut self.carried {
            *vehicle_from_feature = current_from_previous * *vehicle_from_feature;
        }
        self.since_scan_m = self.since_scan_m.map(|since_m| since_m + moved.norm());
        self.scanned.iter_mut().for_each(|(ahead_m, _)| *ahead_m -= moved.x);
        self.on_route.iter_mut().for_each(|place| place.ahead_m -= moved.x);
        if let Some((looked_for_m, _)) = &mut self.looked_for {
            looked_for_m.iter_mut().for_each(|ahead_m| *ahead_m -= moved.x);
        }
    }

    /// From now on the approach no longer says how the vehicle is turned.
    pub(super) fn leave_approach(&mut self) {
        if let (None, Some(moments)) = (&self.carried, self.moments()) {
            let Moments { vehicle_from_feature, covariance, present } = moments;
            let sigmas = [0, 1, 2].map(|i| CARRIED_SIGMAS * covariance[(i, i)].sqrt());
            let absent = (1.0 - present).max(f64::EPSILON);
            let log_share = libm::log(present / absent) - libm::log((1.0 - MAP_WRONG) / MAP_WRONG);
            self.carried = Some(Carried { vehicle_from_feature, sigmas, log_share, log_ratio: None });
        }
    }

    /// Where the feature is, or would be by what was known when the curve began.
    pub(super) fn pose(&self) -> Option<Isometry2<f64>> {
        let carried = self.carried.map(|carried| carried.vehicle_from_feature);
        self.moments().map(|moments| moments.vehicle_from_feature).or(carried)
    }

    /// Places that the last scan tried.
    pub(super) const fn places_scanned(&self) -> usize {
        self.scanned.len()
    }

    /// Computes the belief afresh; returns how many places were tried.
    pub(super) fn update(&mut self, work: &mut Workspace, seen: Seen<'_>) -> usize {
        let Workspace { fitter, starts, scores, expected } = work;
        let Seen { stop, ground, .. } = seen;
        expected.clear();
        expected.extend(Expected::by_progress(seen));
        // Where the feature is beyond the view, the road that is seen is still a plain one, and the map may end it before the feature.
        let [nearest_m, farthest_m] = seen.view_m;
        let first_m = expected.first().map_or(0.5 * (nearest_m + farthest_m), |first| first.ahead_m);
        let in_view_m = first_m.max(nearest_m).min(farthest_m);
        let Some(plain) = self.fit_plain(fitter, seen, expected, in_view_m) else { return 0 };
        self.plain = Some(plain.start());
        starts.clear();
        starts.extend(self.places.iter().map(|place| place.fit.start()));
        let known = starts.len();
        let mut tried = known;
        if self.carried.is_none() && self.since_scan_m.is_none_or(|since_m| since_m >= SCAN_EVERY_M) {
            self.since_scan_m = Some(0.0);
            tried += self.scan(seen, &plain.unknowns, expected, (starts, scores));
        }
        self.places.clear();
        let at = |unknowns: &Unknowns| pose_of(unknowns).translation.vector;
        let is_same = |a: &Unknowns, b: &Unknowns| (at(a) - at(b)).norm() < SAME_PLACE_M;
        for (index, start) in starts.iter().enumerate() {
            let before_m = stop.model.before_m(&pose_of(&start.unknowns));
            let expected = expected_at(seen, expected, before_m);
            let prior = self.prior(seen, &stop.model, &expected, before_m);
            let is_known = |unknowns: &Unknowns| {
                index >= known && self.places.iter().any(|place| is_same(&place.fit.unknowns, unknowns))
            };
            let Some(fit) = fitter.fit(ground, &seen.around(&stop.shape), &prior, start, is_known) else {
                continue;
            };
            let place = Place { fit, expected, log_share: f64::NEG_INFINITY, by_ground: 0.0, weight: 0.0 };
            // Where nothing speaks for or against a place, as beyond the view, the feature is not seen, which is weighed as a whole.
            let is_placed = self.carried.is_some() || is_placed(&stop.model, &place.fit, &place.expected);
            if at(&place.fit.unknowns).x > seen.view_m[1] - EDGE_ROOM_M || !is_placed {
                continue;
            }
            match self.places.iter_mut().find(|other| is_same(&other.fit.unknowns, &place.fit.unknowns)) {
                Some(other) if other.log_evidence() < place.log_evidence() => *other = place,
                Some(_) => {}
                None => self.places.push(place),
            }
        }
        self.places.sort_unstable_by(|a, b| b.log_evidence().total_cmp(&a.log_evidence()));
        self.places.truncate(MOST_PLACES);
        let at_best = self.places.first().map(|best| ahead_m(&stop.model, &pose_of(&best.fit.unknowns)));
        let plain_at_best = at_best.and_then(|best_m| self.fit_plain(fitter, seen, expected, best_m));
        let mut plain =
            plain_at_best.map_or(plain.log_evidence, |other| plain.log_evidence.max(other.log_evidence));
        // What looks like the feature may be the one next to it, where that is believed to be.
        for neighbour in seen.neighbours.into_iter().flatten() {
            let Some(before_m) = neighbour.feature_before_m else { continue };
            let log_weight = expected_at(seen, expected, before_m).log_weight;
            let there = self.fit_plain(fitter, seen, expected, before_m);
            plain = there.map_or(plain, |there| plain.max(there.log_evidence + log_weight));
        }
        self.place_on_route(seen, log_sum(plain, libm::log(PAVED) + ground.log_likelihood_paved()));
        self.weigh(self.in_view(seen));
        tried
    }

    /// The road without the feature, whose node would be `before_m` ahead along the approach.
    fn fit_plain(
        &self,
        fitter: &mut Fitter,
        seen: Seen<'_>,
        expected: &[Expected],
        before_m: f64,
    ) -> Option<Fit> {
        let Seen { stop, ground, .. } = seen;
        let prior = self.prior(seen, &stop.plain, &expected_at(seen, expected, before_m), before_m);
        let start = self.plain.map_or(Start::new(prior.mean), |mut start| {
            let pose = pose_of(&start.unknowns);
            let (left_m, heading_rad) =
                (stop.plain.left_of_approach_m(&pose), stop.plain.heading_off_approach_rad(&pose));
            let pose = stop.plain.vehicle_from_feature(before_m, left_m, heading_rad);
            set_pose(&mut start.unknowns, &pose);
            start
        });
        fitter.fit(ground, &seen.around(&stop.plain_shape), &prior, &start, |_| false)
    }

    /// What is known before of a feature whose node is `before_m` ahead along the approach.
    fn prior(&self, seen: Seen<'_>, model: &FeatureModel, expected: &Expected, before_m: f64) -> Prior {
        let config = seen.config;
        let carried = self.carried.map(|carried| (carried.vehicle_from_feature, carried.sigmas));
        let (pose, sigmas) = carried.unwrap_or_else(|| {
            let here = model.vehicle_from_feature(before_m, 0.0, 0.0);
            // As far off along the road as the place is from where it is expected.
            let along = model.vehicle_from_feature(before_m - 1.0, 0.0, 0.0).translation.vector
                - here.translation.vector;
            let mean = here.translation.vector - (expected.ahead_m - before_m) * along;
            // Where the road bends a vehicle is turned as one a little before or behind may be.
            let heading = |m: f64| model.vehicle_from_feature(before_m + m, 0.0, 0.0).rotation;
            let bends_rad = heading(TURNS_WITHIN_M).angle_to(&heading(-TURNS_WITHIN_M)).abs();
            let heading_sigma_rad = libm::hypot(HEADING_SIGMA_RAD, 0.5 * bends_rad);
            let sigmas = [expected.sigma_m, BESIDE_SIGMA_M, heading_sigma_rad];
            (Isometry2::new(mean, here.rotation.angle()), sigmas)
        });
        let (mut mean, mut sigma) = (as_on_map(config), Unknowns::repeat(1.0));
        set_pose(&mut mean, &pose);
        [sigma[FORWARD], sigma[LEFT], sigma[HEADING]] = sigmas;
        for arm in 0..MOST_ARMS {
            sigma[WIDTHS + arm] = config.width_sigma_share;
            sigma[OFFSETS + arm] = OFFSET_SIGMA_M;
            sigma[CORNERS + arm] = CORNER_LOG_SIGMA;
        }
        [sigma[PITCH], sigma[ROLL]] = seen.attitude_sigma_rad;
        sigma[SCALE] = SCALE_SIGMA;
        Prior { mean, sigma }
    }

    /// Adds the best places along the approach; returns how many were tried.
    fn scan(
        &mut self,
        seen: Seen<'_>,
        plain: &Unknowns,
        expected: &[Expected],
        (starts, scores): (&mut Vec<Start>, &mut Vec<(Unknowns, f64)>),
    ) -> usize {
        let Seen { stop, ground, view_m, .. } = seen;
        // The plain road says where beside its road the vehicle is; a bend is another road, of which a known place says so.
        let known = self.best().filter(|_| stop.model.kind == FeatureKind::Bend);
        let (road, of_road) = known.map_or((&stop.plain, plain), |best| (&stop.model, best));
        let pose = pose_of(of_road);
        let (left_m, heading_rad) = (road.left_of_approach_m(&pose), road.heading_off_approach_rad(&pose));
        let plain_score = ground.score(&seen.around(&stop.plain_shape), plain, SCAN_SOFT_M, SCAN_EVERY);
        let [nearest_m, farthest_m] = [view_m[0] - EDGE_ROOM_M, view_m[1] - EDGE_ROOM_M];
        let steps = ((farthest_m - nearest_m) / SCAN_STEP_M).floor().max(0.0) as usize;
        scores.clear();
        self.scanned.clear();
        for i in 0..=steps {
            let before_m = nearest_m + SCAN_STEP_M * i as f64;
            let pose = stop.model.vehicle_from_feature(before_m, left_m, heading_rad);
            let expected = expected_at(seen, expected, before_m);
            let mut unknowns = self.prior(seen, &stop.model, &expected, before_m).mean;
            set_pose(&mut unknowns, &pose);
            (unknowns[PITCH], unknowns[ROLL]) = (plain[PITCH], plain[ROLL]);
            let score = ground.score(&seen.around(&stop.shape), &unknowns, SCAN_SOFT_M, SCAN_EVERY);
            self.scanned.push((before_m, score - plain_score));
            scores.push((unknowns, score + expected.log_per_m(before_m)));
        }
        let tried = scores.len();
        keep_peaks(scores);
        let at = |unknowns: &Unknowns| pose_of(unknowns).translation.vector;
        let is_known = |unknowns: &Unknowns| {
            starts.iter().any(|start| (at(&start.unknowns) - at(unknowns)).norm() < SAME_PLACE_M)
        };
        scores.retain(|(unknowns, _)| !is_known(unknowns));
        let turn = self.scans % scores.len().clamp(1, SCANNED_PLACES);
        starts.extend(scores.get(turn).map(|(unknowns, _)| Start::new(*unknowns)));
        self.scans += 1;
        tried
    }

    /// Probability that the feature would be in view if it is there.
    fn in_view(&self, Seen { stop, progress, view_m, .. }: Seen<'_>) -> f64 {
        if self.carried.is_some() {
            return 1.0;
        }
        let route_m = stop.model.route_m;
        progress.probability_between(route_m - view_m[1] + EDGE_ROOM_M, route_m)
    }

    /// Gives every place its probability against that of a plain road, as far as the ground speaks for it: a bend that is seen
    /// nowhere is not there because the far end of the view is the one place where nothing speaks against it.
    fn weigh(&mut self, in_view: f64) {
        let best = self.places.iter().map(|place| place.log_share).fold(0.0, f64::max);
        let there = |place: &Place| (1.0 - MAP_WRONG) * libm::exp(place.log_share - best);
        let nowhere = (1.0 - (1.0 - MAP_WRONG) * in_view) * libm::exp(-best);
        let total = nowhere + self.places.iter().map(there).sum::<f64>();
        for place in &mut self.places {
            place.weight = place.by_ground * there(place) / total.max(f64::MIN_POSITIVE);
        }
        self.places.retain(|place| place.weight > LEAST_WEIGHT);
        self.places.sort_unstable_by(|a, b| b.weight.total_cmp(&a.weight));
    }

    /// The places, the likeliest first.
    pub(super) fn places(&self) -> impl Iterator<Item = PossiblePlace> {
        self.places.iter().map(|place| PossiblePlace {
            vehicle_from_feature: pose_of(&place.fit.unknowns),
            covariance: place.fit.covariance.fixed_view::<3, 3>(0, 0).into_owned(),
            weight: place.weight,
        })
    }

    /// The most probable values of the unknowns.
    pub(super) fn best(&self) -> Option<&Unknowns> {
        self.places.first().map(|place| &place.fit.unknowns)
    }

    /// The places together; none where there is none.
    pub(super) fn moments(&self) -> Option<Moments> {
        let best = pose_of(&self.places.first()?.fit.unknowns);
        let present: f64 = self.places.iter().map(|place| place.weight).sum();
        let off = |place: &PossiblePlace| {
            let moved: Vector2<f64> = place.vehicle_from_feature.translation.vector - best.translation.vector;
            let turned = wrap_angle(place.vehicle_from_feature.rotation.angle() - best.rotation.angle());
            Vector3::new(moved.x, moved.y, turned)
        };
        let share = |place: &PossiblePlace| place.weight / present;
        let mean: Vector3<f64> = self.places().map(|place| share(&place) * off(&place)).sum();
        let covariance: Matrix3<f64> = self
            .places()
            .map(|place| {
                let off = off(&place) - mean;
                share(&place) * (place.covariance + off * off.transpose())
            })
            .sum();
        let vehicle_from_feature =
            Isometry2::new(best.translation.vector + mean.xy(), best.rotation.angle() + mean.z);
        Some(Moments { vehicle_from_feature, covariance, present })
    }

    /// The edges of the road at the likeliest place, vehicle frame, metres.
    pub(super) fn edges(&self, stop: &RouteStop, edges: &mut Vec<[Point2<f64>; 2]>) {
        edges.clear();
        let Some(best) = self.best() else { return };
        let vehicle_from_feature = pose_of(best);
        stop.shape.outline(best).each_edge(|from, to| {
            edges.push([vehicle_from_feature * from, vehicle_from_feature * to]);
        });
    }
}

/// How far ahead along the route a feature is, metres; negative behind its node.
fn ahead_m(model: &FeatureModel, vehicle_from_feature: &Isometry2<f64>) -> f64 {
    let before_m = model.before_m(vehicle_from_feature);
    let behind = model.route_m_of_vehicle(vehicle_from_feature).filter(|_| before_m <= 0.0);
    behind.map_or(before_m, |route_m| model.route_m - route_m)
}

/// Widths and offsets as the map has them, and corners as they are without having been seen.
pub(super) fn as_on_map(config: &TrackConfig) -> Unknowns {
    let mut unknowns = Unknowns::zeros();
    let log_radius = libm::log(config.kerb_radius_m.max(LEAST_RADIUS_M));
    (0..MOST_ARMS).for_each(|arm| unknowns[CORNERS + arm] = log_radius);
    unknowns
}

impl Place {
    /// Logarithm of its evidence and of the probability of being there.
    fn log_evidence(&self) -> f64 {
        self.fit.log_evidence + self.expected.log_weight
    }
}

/// Keeps those that are higher than their neighbours, the highest first.
fn keep_peaks(scores: &mut Vec<(Unknowns, f64)>) {
    let (mut before, mut kept) = (f64::NEG_INFINITY, 0);
    for i in 0..scores.len() {
        let here = scores[i].1;
        let behind = scores.get(i + 1).map_or(f64::NEG_INFINITY, |(_, score)| *score);
        if here >= before && here > behind {
            scores.swap(kept, i);
            kept += 1;
        }
        before = here;
    }
    scores.truncate(kept);
    scores.sort_unstable_by(|a, b| b.1.total_cmp(&a.1));
}

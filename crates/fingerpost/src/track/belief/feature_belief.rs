//! The belief about one feature of the route: where it may be, and that it may not be there.
//!
//! Computed afresh from the map of the ground whenever that has more to say, never multiplied up from frame to frame:
//!
//! p(place, unknowns | ground) ~ p(place | progress) p(unknowns) p(ground | place, unknowns),
//!
//! against p(nothing there) p(ground | plain road). The places that a scan along the approach finds are fitted together with
//! what is not known of widths, corners and camera; each is a Gaussian with the weight of its evidence.

use fingerpost_geometry::wrap_angle;
use nalgebra::{Isometry2, Matrix3, Point2, Vector2, Vector3};

use super::fit::{Fit, Fitter, Prior};
use super::junction_shape::{
    CORNERS, FORWARD, HEADING, LEFT, MOST_ARMS, OFFSETS, PITCH, ROLL, SCALE, Unknowns, WIDTHS,
};
use super::likelihood::{Ground, pose_of};
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
/// Step of the scan along the approach, metres, and how soft edges are for it, metres: what a step must not jump over.
const SCAN_STEP_M: f64 = 0.5;
const SCAN_SOFT_M: f64 = 0.4;
/// The scan takes every so many-th square of cells: neighbours err together.
const SCAN_EVERY: usize = 3;
/// Most places that a scan adds, and that are kept.
const SCANNED_PLACES: usize = 3;
const MOST_PLACES: usize = 4;
/// Places nearer to each other are one, metres.
const SAME_PLACE_M: f64 = 0.7;
/// A place of less weight is forgotten.
const LEAST_WEIGHT: f64 = 1e-4;
/// Rounds of a fit from a new start, and from what the last frame left.
const ROUNDS: usize = 12;
const WARM_ROUNDS: usize = 4;
/// Distance driven after which the approach is scanned anew, metres.
const SCAN_EVERY_M: f64 = 0.7;
/// Once the curve has begun the approach no longer says how the vehicle is turned. What was known then is carried on, its
/// standard deviations doubled, because the ground that gave it is looked at again.
const CARRIED_SIGMAS: f64 = 2.0;
/// Room between the farthest node that is searched for and the view's edge, metres: a road's half width must show.
const EDGE_ROOM_M: f64 = 1.0;

/// Where the vehicle may be along its route, by all that is known without the feature.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    /// Distance of the node ahead along the route, metres.
    pub(super) ahead_m: f64,
    pub(super) sigma_m: f64,
}

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
    weight: f64,
}

/// The belief about one feature.
#[derive(Debug, Clone, Default)]
pub(super) struct FeatureBelief {
    places: Vec<Place>,
    /// The plain road without the feature, as the last fit left it.
    plain: Option<Unknowns>,
    /// Pose and standard deviations that are carried on once the curve has begun.
    carried: Option<(Isometry2<f64>, [f64; 3])>,
    /// Metres driven since the approach was scanned; none before the first scan.
    since_scan_m: Option<f64>,
}

/// Memory that is reused from belief to belief.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    fitter: Fitter,
    starts: Vec<(Unknowns, usize)>,
    scores: Vec<(Unknowns, f64)>,
}

/// What a belief is computed from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen<'a> {
    pub(super) config: &'a TrackConfig,
    pub(super) stop: &'a RouteStop,
    pub(super) ground: &'a Ground,
    /// The likeliest first; never empty.
    pub(super) expected: &'a [Expected],
    /// Bottom and top of the view, metres.
    pub(super) view_m: [f64; 2],
    /// Standard deviations of the camera's pitch and roll, radians.
    pub(super) attitude_sigma_rad: [f64; 2],
}

impl FeatureBelief {
    /// Nothing is known any more.
    pub(super) fn clear(&mut self) {
        self.places.clear();
        (self.plain, self.carried, self.since_scan_m) = (None, None, None);
    }

    /// The vehicle moves on: places, and what is carried, stay on the ground.
    pub(super) fn carry(&mut self, previous_from_current: &Isometry2<f64>) {
        let current_from_previous = previous_from_current.inverse();
        let carry = |unknowns: &mut Unknowns| {
            let pose = current_from_previous * pose_of(unknowns);
            (unknowns[FORWARD], unknowns[LEFT]) = (pose.translation.x, pose.translation.y);
            unknowns[HEADING] = pose.rotation.angle();
        };
        self.places.iter_mut().for_each(|place| carry(&mut place.fit.unknowns));
        self.plain.iter_mut().for_each(carry);
        let moved_m = previous_from_current.translation.vector.norm();
        if let Some((pose, _)) = &mut self.carried {
            *pose = current_from_previous * *pose;
        }
        self.since_scan_m = self.since_scan_m.map(|since_m| since_m + moved_m);
    }

    /// From now on the approach no longer says how the vehicle is turned.
    pub(super) fn leave_approach(&mut self) {
        if let (None, Some(moments)) = (&self.carried, self.moments()) {
            let sigmas = [0, 1, 2].map(|i| CARRIED_SIGMAS * moments.covariance[(i, i)].sqrt());
            self.carried = Some((moments.vehicle_from_feature, sigmas));
        }
    }

    /// Computes the belief afresh; returns how many places were tried.
    pub(super) fn update(&mut self, work: &mut Workspace, seen: Seen<'_>) -> usize {
        let Workspace { fitter, starts, scores } = work;
        let Seen { stop, ground, expected, .. } = seen;
        let Some(first) = expected.first() else { return 0 };
        let here = self.prior(seen, first.ahead_m);
        let (start, rounds) = self.plain.map_or((here.mean, ROUNDS), |plain| (plain, WARM_ROUNDS));
        let plain = fitter.fit(ground, &stop.plain_shape, &here, &start, rounds);
        self.plain = Some(plain.unknowns);
        starts.clear();
        starts.extend(self.places.iter().map(|place| (place.fit.unknowns, WARM_ROUNDS)));
        let mut tried = starts.len();
        if self.carried.is_none() && self.since_scan_m.is_none_or(|since_m| since_m >= SCAN_EVERY_M) {
            self.since_scan_m = Some(0.0);
            tried += self.scan(seen, &plain.unknowns, starts, scores);
        }
        self.places.clear();
        for (start, rounds) in starts.iter() {
            let prior = self.prior(seen, stop.model.before_m(&pose_of(start)));
            let fit = fitter.fit(ground, &stop.shape, &prior, start, *rounds);
            let at = |place: &Place| pose_of(&place.fit.unknowns).translation.vector;
            let place = Place { fit, weight: 0.0 };
            // Beyond the view nothing speaks against a place: there the feature is not seen, which is weighed as a whole.
            if at(&place).x > seen.view_m[1] - EDGE_ROOM_M {
                continue;
            }
            match self.places.iter_mut().find(|other| (at(other) - at(&place)).norm() < SAME_PLACE_M) {
                Some(other) if other.fit.log_evidence < place.fit.log_evidence => *other = place,
                Some(_) => {}
                None => self.places.push(place),
            }
        }
        self.places.sort_unstable_by(|a, b| b.fit.log_evidence.total_cmp(&a.fit.log_evidence));
        self.places.truncate(MOST_PLACES);
        self.weigh(plain.log_evidence, self.in_view(seen));
        tried
    }

    /// What is known before of a feature whose node is `before_m` ahead along the approach.
    fn prior(&self, seen: Seen<'_>, before_m: f64) -> Prior {
        let config = seen.config;
        let (pose, sigmas) = self.carried.unwrap_or_else(|| {
            let off = |expected: &&Expected| ((before_m - expected.ahead_m) / expected.sigma_m).abs();
            let nearest = seen.expected.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            let (ahead_m, sigma_m) = nearest.map_or((before_m, 1.0), |e| (e.ahead_m, e.sigma_m));
            let here = seen.stop.model.vehicle_from_feature(before_m, 0.0, 0.0);
            // As far off along the road as the place is from where it is expected.
            let along = seen.stop.model.vehicle_from_feature(before_m - 1.0, 0.0, 0.0).translation.vector
                - here.translation.vector;
            let mean = here.translation.vector - (ahead_m - before_m) * along;
            // Where the road bends a vehicle is turned as one a little before or behind may be.
            let heading = |m: f64| seen.stop.model.vehicle_from_feature(before_m + m, 0.0, 0.0).rotation;
            let bends_rad = heading(TURNS_WITHIN_M).angle_to(&heading(-TURNS_WITHIN_M)).abs();
            let heading_sigma_rad = HEADING_SIGMA_RAD.hypot(0.5 * bends_rad);
            (Isometry2::new(mean, here.rotation.angle()), [sigma_m, BESIDE_SIGMA_M, heading_sigma_rad])
        });
        let (mut mean, mut sigma) = (Unknowns::zeros(), Unknowns::repeat(1.0));
        (mean[FORWARD], mean[LEFT], mean[HEADING]) =
            (pose.translation.x, pose.translation.y, pose.rotation.angle());
        [sigma[FORWARD], sigma[LEFT], sigma[HEADING]] = sigmas;
        for arm in 0..MOST_ARMS {
            sigma[WIDTHS + arm] = config.alignment.width_sigma_share;
            sigma[OFFSETS + arm] = OFFSET_SIGMA_M;
            mean[CORNERS + arm] = config.alignment.kerb_radius_m.max(LEAST_RADIUS_M).ln();
            sigma[CORNERS + arm] = CORNER_LOG_SIGMA;
        }
        [sigma[PITCH], sigma[ROLL]] = seen.attitude_sigma_rad;
        sigma[SCALE] = SCALE_SIGMA;
        Prior { mean, sigma }
    }

    /// Adds the best places along the approach, the vehicle beside it as the plain road says; returns how many were tried.
    fn scan(
        &self,
        seen: Seen<'_>,
        plain: &Unknowns,
        starts: &mut Vec<(Unknowns, usize)>,
        scores: &mut Vec<(Unknowns, f64)>,
    ) -> usize {
        let Seen { stop, ground, expected, view_m, .. } = seen;
        let plain_pose = pose_of(plain);
        let left_m = stop.model.left_of_approach_m(&plain_pose);
        let heading_rad = stop.model.heading_off_approach_rad(&plain_pose);
        let reach = |side: f64| expected.iter().map(move |e| e.ahead_m + side * 3.0 * e.sigma_m);
        let nearest_m = reach(-1.0).fold(f64::INFINITY, f64::min).max(view_m[0] - EDGE_ROOM_M);
        let farthest_m = reach(1.0).fold(f64::NEG_INFINITY, f64::max).min(view_m[1] - EDGE_ROOM_M);
        let steps = ((farthest_m - nearest_m) / SCAN_STEP_M).floor();
        if steps.is_nan() || steps < 0.0 {
            return 0;
        }
        scores.clear();
        scores.extend((0..=steps as usize).map(|i| {
            let before_m = nearest_m + SCAN_STEP_M * i as f64;
            let pose = stop.model.vehicle_from_feature(before_m, left_m, heading_rad);
            let mut unknowns = self.prior(seen, before_m).mean;
            (unknowns[FORWARD], unknowns[LEFT]) = (pose.translation.x, pose.translation.y);
            unknowns[HEADING] = pose.rotation.angle();
            (unknowns[PITCH], unknowns[ROLL]) = (plain[PITCH], plain[ROLL]);
            let off = expected.iter().map(|e| ((before_m - e.ahead_m) / e.sigma_m).powi(2));
            let score = ground.score(&stop.shape, &unknowns, SCAN_SOFT_M, SCAN_EVERY)
                - 0.5 * off.fold(f64::INFINITY, f64::min);
            (unknowns, score)
        }));
        let tried = scores.len();
        keep_peaks(scores);
        let known = starts.len();
        for (unknowns, _) in scores.iter() {
            let at = |unknowns: &Unknowns| pose_of(unknowns).translation.vector;
            let is_known = starts.iter().any(|(start, _)| (at(start) - at(unknowns)).norm() < SAME_PLACE_M);
            if !is_known && starts.len() < known + SCANNED_PLACES {
                starts.push((*unknowns, ROUNDS));
            }
        }
        tried
    }

    /// Probability that the feature would be in view if it is there.
    fn in_view(&self, Seen { expected, view_m, .. }: Seen<'_>) -> f64 {
        if self.carried.is_some() {
            return 1.0;
        }
        let within = |e: &Expected| {
            let below = |m: f64| normal_share((m - e.ahead_m) / e.sigma_m);
            (below(view_m[1] - EDGE_ROOM_M) - below(0.0)).clamp(0.0, 1.0)
        };
        expected.iter().map(within).sum::<f64>() / expected.len().max(1) as f64
    }

    /// Gives every place its probability against that of a plain road.
    fn weigh(&mut self, plain_log_evidence: f64, in_view: f64) {
        let there = (1.0 - MAP_WRONG) * in_view;
        let best = self
            .places
            .first()
            .map_or(plain_log_evidence, |place| place.fit.log_evidence.max(plain_log_evidence));
        let share = |log_evidence: f64| (log_evidence - best).exp();
        let nowhere = (1.0 - there) * share(plain_log_evidence);
        let total =
            nowhere + there * self.places.iter().map(|place| share(place.fit.log_evidence)).sum::<f64>();
        for place in &mut self.places {
            place.weight = there * share(place.fit.log_evidence) / total.max(f64::MIN_POSITIVE);
        }
        self.places.retain(|place| place.weight > LEAST_WEIGHT);
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

/// Share of a normal distribution below so many standard deviations.
fn normal_share(sigmas: f64) -> f64 {
    0.5 * libm::erfc(-sigmas / std::f64::consts::SQRT_2)
}

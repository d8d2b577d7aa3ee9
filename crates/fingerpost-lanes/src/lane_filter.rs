//! The lane on the road, followed from frame to frame.
//!
//! Both edges are parallel curves in the vehicle frame, y = offset + heading x + curvature x^2 / 2, seen by a camera whose
//! pitch swings with the suspension, and that does not look quite where the vehicle drives: a degree of yaw more than its
//! calibration says would else carry a lane aside by half a metre a second. Parallel edges that do not look parallel from
//! above show that pitch. A frame's points are taken in at once by Gauss-Newton steps from the prediction (an iterated
//! extended Kalman filter), with weights against outliers; the vehicle's motion carries the lane on.

mod pitch_swing;

use fingerpost_geometry::{Camera, Pixel};
use nalgebra::{Point2, SMatrix, SVector};

use self::pitch_swing::PitchSwing;
use super::Side;
use super::road_view::RoadView;
use fingerpost_geometry::ObservedAngle;

const STATES: usize = 6;
const HEADING: usize = 2;
const CURVATURE: usize = 3;
const PITCH: usize = 4;
const SKEW: usize = 5;

/// How far a lane's offset, heading, curvature, the camera's pitch and its skew, the angle by which it looks left of where the
/// vehicle drives, may be off before anything is seen: metres, radians, 1/m, radians, radians.
const PRIOR_SIGMA: [f64; STATES] = [1.5, 1.5, 0.12, 2e-3, 0.01, 0.02];
/// How much the vehicle drifts in a second beyond what its motion says, metres, and without a known motion.
const DRIFT_WALK_M: f64 = 0.03;
const UNKNOWN_DRIFT_WALK_M: f64 = 0.2;
/// How much the lane's width changes in a second, metres.
const WIDTH_WALK_M: f64 = 0.015;
/// How much the heading wanders in a second beyond what the motion says, radians, and without a known motion.
const HEADING_WALK_RAD: f64 = 0.008;
const UNKNOWN_HEADING_WALK_RAD: f64 = 0.03;
/// How much the curvature changes in a second, 1/m, where the speed is not known: a motorway's transition curve at speed.
const CURVATURE_WALK_PER_M: f64 = 8e-4;
/// How much the acceleration towards a bend's middle changes in a second, m/s2: the slower a road is driven, the sooner its
/// bends begin and end.
const LATERAL_JERK_MPS3: f64 = 0.72;
/// Below this speed bends are as sharp as they are at it, and begin the slower, m/s.
const SLOWEST_BEND_MPS: f64 = 15.0;
/// How much the skew changes in a second: load, crosswind and slopes across the road, radians.
const SKEW_WALK_RAD: f64 = 3e-4;
/// Time in which the mean pitch is learned, seconds.
const PITCH_MEAN_S: f64 = 4.0;
/// Frames without a known motion are taken as so long, seconds.
const UNKNOWN_STEP_S: f64 = 0.1;
/// Residuals beyond this many standard deviations lose weight (Cauchy).
const OUTLIER_SIGMAS: f64 = 2.0;
/// A frame's points share their errors (lens, ground, paint): an edge's count as at most so many independent ones.
const INDEPENDENT_POINTS: f64 = 8.0;
/// Gauss-Newton steps a frame.
const STEPS: usize = 4;

/// A point of an edge in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgePoint {
    pub(super) side: Side,
    pub(super) pixel: Pixel,
    /// Standard deviation of its column, pixels.
    pub(super) sigma_px: f64,
    /// The same without the road's unevenness, and more for a speck that may be no paint of the line, pixels.
    pub(super) column_sigma_px: f64,
    /// What the fit made of it: 0, an outlier, to 1.
    pub(super) weight: f64,
}

impl EdgePoint {
    /// Its squared distance from the fit, in its standard deviations, by its weight.
    pub(super) fn squared_deviation(&self) -> f64 {
        OUTLIER_SIGMAS * OUTLIER_SIGMAS * (1.0 / self.weight - 1.0).max(0.0)
    }
}

/// How the vehicle moved since the frame before.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct LaneMotion {
    pub(super) dt_s: Option<f64>,
    /// Forward, metres, and yaw, radians; none where neither is known.
    pub(super) forward_m: Option<f64>,
    pub(super) yaw_rad: Option<f64>,
    /// Change of the camera's pitch, where the picture shows it.
    pub(super) pitch_change: Option<ObservedAngle>,
}

/// The lane's shape with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LaneFilter {
    state: SVector<f64, STATES>,
    covariance: SMatrix<f64, STATES, STATES>,
    mean_pitch_rad: f64,
}

impl LaneFilter {
    pub(super) fn new() -> Self {
        let variances = PRIOR_SIGMA.map(|sigma| sigma * sigma);
        Self {
            state: SVector::zeros(),
            covariance: SMatrix::from_diagonal(&SVector::from(variances)),
            mean_pitch_rad: 0.0,
        }
    }

    /// Nothing is known of the lane; of the pitch, its mean.
    pub(super) fn forget_lane(&mut self) {
        let mean_pitch_rad = self.mean_pitch_rad;
        *self = Self::new();
        self.state[PITCH] = mean_pitch_rad;
        self.mean_pitch_rad = mean_pitch_rad;
    }

    /// The camera's pitch against its mount, radians.
    pub(super) fn pitch_rad(&self) -> f64 {
        self.state[PITCH]
    }

    pub(super) fn heading_rad(&self) -> f64 {
        self.state[HEADING]
    }

    pub(super) fn curvature_per_m(&self) -> f64 {
        self.state[CURVATURE]
    }

    /// Where an edge passes the rear axle, metres to the left.
    pub(super) fn offset_m(&self, side: Side) -> f64 {
        self.state[side.index()]
    }

    pub(super) fn offset_sigma_m(&self, side: Side) -> f64 {
        self.covariance[(side.index(), side.index())].sqrt()
    }

    /// Where an edge lies at a distance ahead, metres to the left.
    pub(super) fn left_at(&self, side: Side, ahead_m: f64) -> f64 {
        self.state[side.index()]
            + self.state[HEADING] * ahead_m
            + 0.5 * self.state[CURVATURE] * ahead_m * ahead_m
    }

    /// Standard deviation of that, metres.
    pub(super) fn left_sigma_m(&self, side: Side, ahead_m: f64) -> f64 {
        let mut row = SVector::<f64, STATES>::zeros();
        row[side.index()] = 1.0;
        row[HEADING] = ahead_m;
        row[CURVATURE] = 0.5 * ahead_m * ahead_m;
        (row.transpose() * self.covariance * row)[0].max(0.0).sqrt()
    }

    /// Forgets where an edge is; `offset_m` is a first guess.
    pub(super) fn place_edge(&mut self, side: Side, offset_m: f64, sigma_m: f64) {
        let index = side.index();
        self.covariance.row_mut(index).fill(0.0);
        self.covariance.column_mut(index).fill(0.0);
        self.covariance[(index, index)] = sigma_m * sigma_m;
        self.state[index] = offset_m;
    }

    /// A first guess of direction and curvature, where no edge is known.
    pub(super) fn place_direction(&mut self, heading_rad: f64) {
        for (index, value) in [(HEADING, heading_rad), (CURVATURE, 0.0)] {
            self.covariance.row_mut(index).fill(0.0);
            self.covariance.column_mut(index).fill(0.0);
            self.covariance[(index, index)] = PRIOR_SIGMA[index].powi(2);
            self.state[index] = value;
        }
    }

    /// The left edge becomes the right one, or the other way round: the vehicle has crossed it.
    pub(super) fn exchange(&mut self) {
        self.state.swap_rows(0, 1);
        self.covariance.swap_rows(0, 1);
        self.covariance.swap_columns(0, 1);
    }

    /// Carries the lane on over the vehicle's motion.
    pub(super) fn predict(&mut self, motion: &LaneMotion) {
        let dt_s = motion.dt_s.unwrap_or(UNKNOWN_STEP_S);
        let (forward_m, yaw_rad) = (motion.forward_m.unwrap_or(0.0), motion.yaw_rad.unwrap_or(0.0));
        let mut transition = SMatrix::<f64, STATES, STATES>::identity();
        for side in [0, 1] {
            transition[(side, HEADING)] = forward_m;
            transition[(side, SKEW)] = forward_m;
            transition[(side, CURVATURE)] = 0.5 * forward_m * forward_m;
        }
        transition[(HEADING, CURVATURE)] = forward_m;
        let swing = PitchSwing::over(dt_s, motion.pitch_change);
        transition[(PITCH, PITCH)] = 1.0 - swing.returned;
        self.state = transition * self.state;
        // The way is an arc: its end lies half of the turn beside its first direction.
        for side in [0, 1] {
            self.state[side] -= 0.5 * forward_m * yaw_rad;
        }
        self.state[HEADING] -= yaw_rad;
        self.state[PITCH] += swing.returned * self.mean_pitch_rad + swing.seen_rad;
        // Without a motion the vehicle is taken to follow its lane, more or less.
        let [drift, turn] = match (motion.forward_m, motion.yaw_rad) {
            (Some(_), Some(_)) => [DRIFT_WALK_M, HEADING_WALK_RAD],
            _ => [UNKNOWN_DRIFT_WALK_M, UNKNOWN_HEADING_WALK_RAD],
        };
        let curvature_walk = motion.forward_m.map_or(CURVATURE_WALK_PER_M, |forward_m| {
            let speed_mps = (forward_m / dt_s).abs();
            let slowed = (speed_mps / SLOWEST_BEND_MPS).min(1.0);
            slowed * LATERAL_JERK_MPS3 / speed_mps.max(SLOWEST_BEND_MPS).powi(2)
        });
        let mut walk = SMatrix::<f64, STATES, STATES>::zeros();
        // The vehicle drifts against both edges alike, while the lane's width hardly changes.
        let [common, width] = [drift * drift * dt_s, 0.25 * WIDTH_WALK_M * WIDTH_WALK_M * dt_s];
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            walk[(row, column)] = if row == column { common + width } else { common - width };
        }
        for (index, sigma) in [(HEADING, turn), (CURVATURE, curvature_walk), (SKEW, SKEW_WALK_RAD)] {
            walk[(index, index)] = sigma * sigma * dt_s;
        }
        walk[(PITCH, PITCH)] = swing.variance_rad2;
        self.covariance = transition * self.covariance * transition.transpose() + walk;
        // The mean pitch is not known better than the mount: what swings back does so to within this.
        for (index, sigma) in PRIOR_SIGMA.iter().enumerate() {
            let most = sigma * sigma;
            if self.covariance[(index, index)] > most {
                let shrink = (most / self.covariance[(index, index)]).sqrt();
                self.covariance.row_mut(index).scale_mut(shrink);
                self.covariance.column_mut(index).scale_mut(shrink);
            }
        }
        self.mean_pitch_rad +=
            (1.0 - libm::exp(-dt_s / PITCH_MEAN_S)) * (self.state[PITCH] - self.mean_pitch_rad);
    }

    /// Takes the points of a frame in and sets their weights.
    pub(super) fn update(&mut self, camera: &Camera, points: &mut [EdgePoint]) {
        let Some(prior_information) = self.covariance.cholesky().map(|factor| factor.inverse()) else {
            *self = Self::new();
            return;
        };
        let prior = self.state;
        let share = [Side::Left, Side::Right].map(|side| {
            let count = points.iter().filter(|point| point.side == side).count() as f64;
            (INDEPENDENT_POINTS / count.max(1.0)).min(1.0)
        });
        let pitch_known = RoadView::knows_pitch(camera);
        for _ in 0..STEPS {
            let mut information = prior_information;
            let mut vector = prior_information * (prior - self.state);
            for point in points.iter_mut() {
                let Some(row) = self.linearised(camera, point, pitch_known) else {
                    point.weight = 0.0;
                    continue;
                };
                let deviations = row.residual_m / row.sigma_m;
                point.weight = 1.0 / (1.0 + (deviations / OUTLIER_SIGMAS).powi(2));
                let weight = point.weight * share[point.side.index()] / (row.sigma_m * row.sigma_m);
                information += weight * row.jacobian * row.jacobian.transpose();
                vector += weight * row.residual_m * row.jacobian;
            }
            let Some(factor) = information.cholesky() else { return };
            let step = factor.solve(&vector);
            self.state += step;
            self.covariance = factor.inverse();
            if step.norm() < 1e-7 {
                break;
            }
        }
    }

    fn linearised(&self, camera: &Camera, point: &EdgePoint, pitch_known: bool) -> Option<LinearisedPoint> {
        const TURN_RAD: f64 = 1e-4;
        let pitch_rad = self.state[PITCH];
        let view = RoadView::new(camera, pitch_rad);
        let place = view.ground_of_pixel(point.pixel)?;
        let beside = view.ground_of_pixel(Pixel::new(point.pixel.u + 1.0, point.pixel.v))?;
        let slope = self.state[HEADING] + self.state[CURVATURE] * place.x;
        let across = |p: Point2<f64>| p.y - slope * p.x;
        let mut jacobian = SVector::<f64, STATES>::zeros();
        jacobian[point.side.index()] = 1.0;
        jacobian[HEADING] = place.x;
        jacobian[CURVATURE] = 0.5 * place.x * place.x;
        if pitch_known {
            let turned = RoadView::new(camera, pitch_rad + TURN_RAD).ground_of_pixel(point.pixel)?;
            jacobian[PITCH] = -(across(turned) - across(place)) / TURN_RAD;
        }
        Some(LinearisedPoint {
            residual_m: place.y - self.left_at(point.side, place.x),
            sigma_m: (point.sigma_px * (across(beside) - across(place)).abs()).max(1e-4),
            jacobian,
        })
    }
}

/// What a point says about the state.
struct LinearisedPoint {
    residual_m: f64,
    sigma_m: f64,
    jacobian: SVector<f64, STATES>,
}

#[cfg(test)]
mod tests;

//! One assumption of where the vehicle is: a course, and a Gaussian about a place on it.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::odometry::Motion;
use crate::path::{Course, SPACING_M, Sample};
use crate::roads::Roads;
use crate::state::{EAST, HEADING, NORTH, OFFSET, OffsetModel, State};

/// Standard deviation of the vehicle's distance from the road's line beside the correlated offset, metres: the line's corners are
/// set by hand, a metre or so apart from the road's true curve on bends.
pub(crate) const LINE_NOISE_M: f64 = 1.0;
/// Standard deviation of the heading against the line, radians: steering about, and lines of few corners. Used to tell which place
/// of the line belongs to a pose, not to correct the heading.
const LINE_HEADING_RAD: f64 = 0.2;
/// Reach of the search along the line, standard deviations.
const REACH_SIGMAS: f64 = 3.0;
/// Reach beyond that, metres.
const REACH_M: f64 = 4.0;
/// Samples from one look to the next where a pose's place on the line is looked for at first.
const COARSE: usize = 3;
/// Distance to a course's end below which it branches, metres beyond what the place is unsure by: half a junction.
pub(crate) const BRANCH_AHEAD_M: f64 = 20.0;

/// How well a hypothesis fits what was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fit {
    /// Logarithm of the density of its place beside the road, 1/m.
    pub(crate) log_density: f64,
    /// Squared innovation in units of its variance: 1 on average.
    pub(crate) surprise: f64,
}

impl Fit {
    const NONE: Self = Self { log_density: f64::NEG_INFINITY, surprise: f64::INFINITY };
}

/// A course and a Gaussian.
#[derive(Debug, Clone)]
pub(crate) struct Hypothesis {
    pub(crate) course: Arc<Course>,
    /// Distance along the course, metres.
    pub(crate) along_m: f64,
    pub(crate) state: State,
    /// Natural logarithm of its weight.
    pub(crate) log_weight: f64,
    /// The last landmark that says where it is.
    pub(crate) placed_by: Option<usize>,
}

impl Hypothesis {
    /// Moves by what was measured.
    pub(crate) fn go(&mut self, motion: &Motion, offset: &OffsetModel) {
        let before = self.state.place();
        self.state.go(motion, offset);
        self.along_m += (self.state.place() - before).norm();
    }

    /// Takes in that the vehicle drives along the course: gives how well that fits.
    pub(crate) fn hold_to_road(&mut self) -> Fit {
        let sigma_m = self.state.sigma_along_m(self.ahead());
        let reach_m = REACH_SIGMAS * sigma_m + REACH_M;
        let (first, samples) = self.course.between(self.along_m - reach_m, self.along_m + reach_m);
        let spread = self.state.covariance.fixed_view::<3, 3>(0, 0)
            + Matrix3::from_diagonal(&Vector3::new(
                LINE_NOISE_M.powi(2) + self.state.covariance[(OFFSET, OFFSET)],
                LINE_NOISE_M.powi(2) + self.state.covariance[(OFFSET, OFFSET)],
                LINE_HEADING_RAD.powi(2),
            ));
        let Some(precision) = spread.try_inverse() else { return Fit::NONE };
        let place = self.state.place();
        let heading = self.ahead();
        let cost = |sample: &Sample| {
            let off = place - sample.point;
            let off = Vector3::new(off.x, off.y, turned(sample.ahead, heading));
            off.dot(&(precision * off))
        };
        let cheapest = |from: usize, to: usize, step: usize| {
            let numbers = (from..to.min(samples.len())).step_by(step);
            let costs = numbers.filter_map(|number| Some((cost(samples.get(number)?), number)));
            costs.reduce(|best, next| if next.0 < best.0 { next } else { best })
        };
        // The cost is smooth from sample to sample: a coarse look finds the valley.
        let Some((_, near)) = cheapest(0, samples.len(), COARSE) else { return Fit::NONE };
        let Some((_, best)) = cheapest(near.saturating_sub(COARSE - 1), near + COARSE, 1) else {
            return Fit::NONE;
        };
        let Some(sample) = samples.get(best) else { return Fit::NONE };
        let number = first + best;
        let off = place - sample.point;
        let beyond_m = off.dot(&sample.ahead);
        self.along_m = number as f64 * SPACING_M + beyond_m.clamp(-SPACING_M, SPACING_M);
        let left = Vector2::new(-sample.ahead.y, sample.ahead.x);
        let innovation = self.state.mean[OFFSET] - off.dot(&left);
        let (log_density, surprise) = self.state.hold_to_line(innovation, left, LINE_NOISE_M.powi(2));
        // Past the end of a road that goes nowhere else there is no road.
        let past =
            if self.course.is_last(number) { (beyond_m / (sigma_m + LINE_NOISE_M)).max(0.0) } else { 0.0 };
        Fit { log_density: log_density - 0.5 * past * past, surprise }
    }

    /// The same where the road's line is suddenly somewhere else: nothing is known of the offset any more, the place stays.
    pub(crate) fn off_line(&self, sigma_m: f64) -> Self {
        let mut off = self.clone();
        off.state.covariance[(OFFSET, OFFSET)] += sigma_m * sigma_m;
        off
    }

    /// The same where the vehicle was off the road for a while and may have come back elsewhere on it.
    pub(crate) fn come_back(&self, place_sigma_m: f64, heading_sigma_rad: f64) -> Self {
        let mut back = self.clone();
        let covariance = &mut back.state.covariance;
        covariance[(EAST, EAST)] += place_sigma_m * place_sigma_m;
        covariance[(NORTH, NORTH)] += place_sigma_m * place_sigma_m;
        covariance[(HEADING, HEADING)] += heading_sigma_rad * heading_sigma_rad;
        back
    }

    /// Direction of travel.
    pub(crate) fn ahead(&self) -> Vector2<f64> {
        let (sine, cosine) = libm::sincos(self.state.mean[HEADING]);
        Vector2::new(cosine, sine)
    }

    /// Whether its course ends so near ahead that the vehicle may be past its end.
    pub(crate) fn nears_end(&self) -> bool {
        let sigma_m = self.state.sigma_along_m(self.ahead());
        self.along_m + (REACH_SIGMAS * sigma_m).min(2.0 * BRANCH_AHEAD_M) + BRANCH_AHEAD_M
            > self.course.length_m
    }

    /// The exits at its course's end.
    pub(crate) fn exits<'a>(&self, roads: &'a Roads) -> &'a [(u32, f64)] {
        self.course.edges.last().map_or(&[], |edge| &roads.edge(*edge).exits)
    }
}

/// About the angle from one unit vector to another, radians to the left: its sine up to a right angle, and growing from there on. No
/// more is needed to tell places of a line apart, and it is asked for at every one.
fn turned(from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    let (sine, cosine) = (from.perp(&to), from.dot(&to));
    if cosine >= 0.0 { sine } else { (2.0 - sine.abs()).copysign(sine) }
}

/// Logarithm of the density of a normal distribution, by the square of the deviation and the variance.
pub(crate) fn log_normal(squared: f64, variance: f64) -> f64 {
    -0.5 * (squared / variance + libm::log(TAU * variance))
}

//! Places by GPS, whose errors keep for minutes, and which may lie.
//!
//! A receiver's error is a Gauss-Markov process: its next fix says little that is new. Each fix counts as the part of an
//! independent one that it is by the time since the one before, in the hypotheses' states (with a variance divided by it) and in
//! their weights (to its power). That bounds what a constant error can do, without the error as a part of every state.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Point2, Vector2};

use crate::belief::Belief;
use crate::fix::Estimate;

/// Standard deviation east and north, metres: between houses it is a multiple of what the open sky gives, 8 m at 95 % (Global
/// Positioning System Standard Positioning Service Performance Standard, 2020).
const SIGMA_M: f64 = 10.0;
/// Time over which the error keeps 1/e, seconds: multipath changes over a minute or two, the ionosphere and orbits over many (E.
const CORRELATION_S: f64 = 300.0;
/// Part of the fixes that say nothing, and the area over which they may lie anywhere, square metres: a town.
const LIES: f64 = 0.05;
const LIES_WITHIN_M2: f64 = 1e8;
/// Squared deviations of an innovation that are believed: 99.9 % of a Gaussian's are within.
const BELIEVED: f64 = 13.8;

/// What was made of a place by GPS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpsEvidence {
    /// East and north of it from the fix before it was taken in, metres.
    pub innovation_m: [f64; 2],
    /// Whether it agrees with the fix; one that does not moves nothing.
    pub believed: bool,
}

/// A receiver's history.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Receiver {
    before_s: Option<f64>,
}

impl Receiver {
    /// The part of an independent fix that one at this time is; none for a time that is no later than that of the one before.
    pub(crate) fn weight(&mut self, t_s: f64) -> Option<f64> {
        let weight = match self.before_s {
            Some(before_s) if t_s <= before_s => return None,
            Some(before_s) => 1.0 - libm::exp(-2.0 * (t_s - before_s) / CORRELATION_S),
            None => 1.0,
        };
        self.before_s = Some(t_s);
        Some(weight)
    }
}

impl Belief {
    /// Weighs all hypotheses by a place and moves those that it agrees with.
    pub(crate) fn take_gps(&mut self, place_m: Point2<f64>, weight: f64, estimate: &Estimate) -> GpsEvidence {
        self.weigh(|hypothesis| {
            let innovation = place_m - hypothesis.state.place();
            let fit = Agreement::of(innovation, hypothesis.state.place_covariance());
            hypothesis.log_weight += weight * fit.log_density;
            if fit.is_believed() {
                hypothesis.state.take_place(innovation, SIGMA_M * SIGMA_M / weight);
            }
        });
        let innovation = place_m - estimate.state.place();
        let believed = Agreement::of(innovation, estimate.state.place_covariance()).is_believed();
        GpsEvidence { innovation_m: [innovation.x, innovation.y], believed }
    }
}

/// How well a place by GPS fits a Gaussian.
struct Agreement {
    /// Logarithm of its density, 1/m².
    log_density: f64,
    squared: f64,
}

impl Agreement {
    fn of(innovation: Vector2<f64>, covariance: Matrix2<f64>) -> Self {
        let expected = covariance + Matrix2::identity() * SIGMA_M * SIGMA_M;
        let squared = expected
            .try_inverse()
            .map_or(f64::INFINITY, |precision| innovation.dot(&(precision * innovation)));
        let true_density =
            libm::exp(-0.5 * squared) / (TAU * expected.determinant().max(f64::MIN_POSITIVE).sqrt());
        Self { log_density: libm::log((1.0 - LIES) * true_density + LIES / LIES_WITHIN_M2), squared }
    }

    fn is_believed(&self) -> bool {
        self.squared <= BELIEVED
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixes_in_a_row_count_together_as_their_time_says() {
        let mut receiver = Receiver::default();
        assert_eq!(receiver.weight(0.0), Some(1.0));
        let together: f64 = (1..=100).filter_map(|t_s| receiver.weight(f64::from(t_s))).sum();
        assert!((0.6..0.7).contains(&together), "{together}");
        assert_eq!(receiver.weight(50.0), None);
        assert!(receiver.weight(10_000.0).unwrap() > 0.999);
    }

    #[test]
    fn what_lies_far_off_is_not_believed_and_rules_nothing_out() {
        let covariance = Matrix2::identity() * 4.0;
        let at = |x: f64| Agreement::of(Vector2::new(x, 0.0), covariance);
        assert!(at(15.0).is_believed() && !at(100.0).is_believed());
        assert!(at(0.0).log_density > at(15.0).log_density && at(15.0).log_density > at(100.0).log_density);
        assert!((at(100.0).log_density - at(1e6).log_density).abs() < 1e-6);
    }
}

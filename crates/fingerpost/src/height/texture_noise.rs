//! How well two views of one place are expected to correlate: the more, the more texture stands out of the camera's noise.
//!
//! In a window whose grey values have a variance v, of which the noise of sensor, quantisation and compression is n, both views share
//! v - n, less what differs because they were taken from different places. So the correlation of places that lie where they are
//! thought to be is 1 - e - n / v. Both e and n are fitted to the road ahead, which lies on its plane.

use fingerpost_vision::parallax::GREY_STEPS;
use nalgebra::{Matrix2, Vector2};

/// Correlations that are told apart as expected ones: the first is none.
pub(super) const EXPECTED: usize = 32;
/// Least variance of noise, square greys: that of rounding to whole ones.
const LEAST_NOISE_GREY2: f64 = 1.0 / 12.0;
/// Least share that two views do not have in common: grey values between pixels are not those of the ground.
const LEAST_MISMATCH: f64 = 0.05;

/// The fit: sums over windows of the road ahead.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TextureNoise {
    /// Of 1 and 1 / v, times themselves, and times 1 - r.
    information: Matrix2<f64>,
    vector: Vector2<f64>,
}

/// What is expected of a pair of views.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExpectedCorrelation {
    mismatch: f64,
    noise_grey2: f64,
    cells: f64,
}

/// One over a window's variance, by one over the root of its sum of squares (in steps).
fn inverse_variance(scale: f32, cells: f64) -> f64 {
    f64::from(scale * scale) * cells * f64::from(GREY_STEPS * GREY_STEPS)
}

impl TextureNoise {
    /// Takes in a window of so many cells on the plane: its scale and how its two views correlate.
    pub(super) fn add(&mut self, scale: f32, cells: f64, r: f32) {
        let terms = Vector2::new(1.0, inverse_variance(scale, cells));
        self.information += terms * terms.transpose();
        self.vector += terms * f64::from(1.0 - r);
    }

    pub(super) fn expected(&self, cells: f64) -> ExpectedCorrelation {
        let [windows, inverse] = [self.information.m11.max(1.0), self.information.m12];
        let solved = self.information.try_inverse().map_or(0.0, |covariance| (covariance * self.vector).y);
        let noise_grey2 = solved.max(LEAST_NOISE_GREY2);
        let mismatch = (self.vector.x - noise_grey2 * inverse) / windows;
        ExpectedCorrelation { mismatch: mismatch.clamp(LEAST_MISMATCH, 1.0), noise_grey2, cells }
    }
}

impl ExpectedCorrelation {
    /// Of a window with such a scale, in `EXPECTED`ths.
    pub(super) fn of(&self, scale: f32) -> u8 {
        if scale <= 0.0 {
            return 0;
        }
        let r = 1.0 - self.mismatch - self.noise_grey2 * inverse_variance(scale, self.cells);
        (r.max(0.0) * EXPECTED as f64) as u8
    }
}

/// Log-likelihood ratio, for each pair of witnesses, of two views' correlation r if it is expected to be `expected` against none:
/// that of pairs of normal values of unit variance. It is linear in r: its value at 0, and what it grows by.
pub(super) fn log_likelihood_ratio_by_r(expected: f32) -> [f32; 2] {
    let unshared = 1.0 - expected * expected;
    let slope = 2.0 * expected / unshared;
    [-(libm::logf(unshared) + slope * expected), slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The scale of a window of that variance, square greys.
    fn scale(variance: f64) -> f32 {
        (1.0 / (variance * CELLS).sqrt() / f64::from(GREY_STEPS)) as f32
    }

    const CELLS: f64 = 75.0;

    #[test]
    fn noise_and_mismatch_come_out_of_windows_of_many_variances() {
        let mut noise = TextureNoise::default();
        for step in 0..40 {
            let variance = 3.0 + 2.0 * f64::from(step);
            noise.add(scale(variance), CELLS, (1.0 - 0.1 - 2.0 / variance) as f32);
        }
        let expected = noise.expected(CELLS);
        assert!((expected.noise_grey2 - 2.0).abs() < 0.01 && (expected.mismatch - 0.1).abs() < 0.01);
        let of = |variance: f64| f64::from(expected.of(scale(variance))) / EXPECTED as f64;
        assert!((of(20.0) - 0.8).abs() < 0.05, "{}", of(20.0));
        assert!(of(1.5) <= 0.0 && expected.of(0.0) == 0, "noise alone is not expected to correlate");
    }

    #[test]
    fn what_correlates_as_expected_is_likelier_and_chance_less_likely_the_more_is_expected() {
        let log_likelihood_ratio = |r: f32, expected: f32| {
            let [offset, slope] = log_likelihood_ratio_by_r(expected);
            offset + slope * r
        };
        let mut before = [0.0, 0.0];
        for expected in [0.3, 0.6, 0.9] {
            let [right, chance] = [expected, 0.0].map(|r| log_likelihood_ratio(r, expected));
            assert!(right > before[0] && chance < before[1], "{expected}: {right}, {chance}");
            before = [right, chance];
        }
        assert!(
            log_likelihood_ratio(0.8, 0.0).abs() < f32::EPSILON,
            "where nothing is expected, nothing is said"
        );
    }
}

//! One Gaussian of the mixture: the progress, the scale error of the measured distance and the slow error of GPS, together.

use std::f64::consts::{PI, SQRT_2};

use nalgebra::{Matrix3, Vector3};

use super::noise::Noise;
use super::travel::Step;

/// The progress alone, of the state (progress, scale error, slow GPS error).
pub(crate) const PROGRESS: Vector3<f64> = Vector3::new(1.0, 0.0, 0.0);
/// The slow error of GPS alone.
const GPS_ERROR: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);
/// What GPS measures: the progress and its own slow error.
pub(crate) const GPS: Vector3<f64> = Vector3::new(1.0, 0.0, 1.0);

/// A truncated Gaussian keeps at least this share of its variance: the difference that gives it is rounded far out in a tail.
const LEAST_TRUNCATED: f64 = 1e-4;

/// A weighted Gaussian over (progress in metres, scale error as a share, slow GPS error in metres).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Component {
    pub(super) weight: f64,
    pub(super) mean: Vector3<f64>,
    pub(super) covariance: Matrix3<f64>,
    /// What the slow error of GPS comes back to, metres: 0, or where the receiver jumped to.
    pub(super) gps_level_m: f64,
}

impl Component {
    pub(super) const NONE: Self = Self {
        weight: 0.0,
        mean: Vector3::new(0.0, 0.0, 0.0),
        covariance: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        gps_level_m: 0.0,
    };

    /// At `mean_m` along the route, with nothing known of the scale and of GPS but their priors.
    pub(crate) fn at(weight: f64, mean_m: f64, sigma_m: f64, noise: &Noise) -> Self {
        let sigmas = Vector3::new(sigma_m, noise.scale_sigma, noise.gps_slow_m);
        Self {
            weight,
            mean: Vector3::new(mean_m, 0.0, 0.0),
            covariance: Matrix3::from_diagonal(&sigmas.component_mul(&sigmas)),
            gps_level_m: 0.0,
        }
    }

    pub(crate) fn mean_m(&self) -> f64 {
        self.mean.x
    }

    pub(crate) fn sigma_m(&self) -> f64 {
        self.covariance.m11.max(0.0).sqrt()
    }

    /// Mean and variance of what `measured` picks of the state.
    pub(crate) fn predicted(&self, measured: &Vector3<f64>) -> (f64, f64) {
        (measured.dot(&self.mean), measured.dot(&(self.covariance * measured)).max(f64::MIN_POSITIVE))
    }

    /// Moves on with the vehicle.
    pub(super) fn advance(&mut self, step: &Step, noise: &Noise) {
        let scaled_m = step.measured_m;
        let scale_kept = noise.scale_kept(scaled_m);
        let transition = Matrix3::new(1.0, scaled_m, 0.0, 0.0, scale_kept, 0.0, 0.0, 0.0, 1.0);
        self.mean = transition * self.mean + PROGRESS * (scaled_m + step.unscaled_m);
        // What adds up within a run of unknown motion errs in one direction; it can go along with what was unsure before no
        // more than that was unsure.
        let along_m = 2.0 * step.run_before_m.min(self.sigma_m()) + step.run_added_m;
        let added = Vector3::new(
            step.white_sigma_m.powi(2) + along_m * step.run_added_m,
            noise.scale_sigma.powi(2) * (1.0 - scale_kept * scale_kept),
            0.0,
        );
        self.covariance =
            transition * self.covariance * transition.transpose() + Matrix3::from_diagonal(&added);
        self.forget_gps_error(step.dt_s, noise);
    }

    /// So many seconds went by, and the slow error of GPS becomes another one (first-order Gauss-Markov process).
    pub(crate) fn forget_gps_error(&mut self, dt_s: f64, noise: &Noise) {
        let kept = noise.gps_kept(dt_s);
        let transition = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, kept));
        self.mean.z = kept * self.mean.z + (1.0 - kept) * self.gps_level_m;
        self.covariance = transition * self.covariance * transition;
        self.covariance.m33 += noise.gps_slow_m.powi(2) * (1.0 - kept * kept);
    }

    /// The same once what `measured` picks of the state is known to have this mean and variance: a measurement, or a range that
    /// is ruled out.
    #[must_use]
    pub(crate) fn given(&self, measured: &Vector3<f64>, mean: f64, variance: f64) -> Self {
        let (expected, before) = self.predicted(measured);
        let gain = self.covariance * measured / before;
        let covariance = self.covariance + gain * gain.transpose() * (variance - before);
        Self {
            mean: self.mean + gain * (mean - expected),
            covariance: (covariance + covariance.transpose()) * 0.5,
            ..*self
        }
    }

    /// The same after what `measured` picks was measured as `value` with this variance (Kalman).
    #[must_use]
    pub(super) fn measured(&self, measured: &Vector3<f64>, value: f64, variance: f64) -> Self {
        let (expected, before) = self.predicted(measured);
        let gain = before / (before + variance);
        self.given(measured, expected + gain * (value - expected), gain * variance)
    }

    /// The same with another slow error of GPS, of which nothing else is known: about `level_m`, to which it comes back.
    #[must_use]
    pub(super) fn with_gps_error(&self, level_m: f64, sigma_m: f64) -> Self {
        let mut other = Self { gps_level_m: level_m, ..*self };
        other.mean.z = level_m;
        other.covariance.set_row(2, &Vector3::zeros().transpose());
        other.covariance.set_column(2, &(GPS_ERROR * (sigma_m * sigma_m)));
        other
    }

    /// The part whose progress lies between `from_m` and `to_m`, by its first two moments, and its share of the weight; none
    /// where that share is below `least_share`.
    pub(super) fn between(&self, from_m: f64, to_m: f64, least_share: f64) -> Option<Self> {
        let (mean_m, sigma_m) = (self.mean_m(), self.sigma_m());
        let (from, to) = ((from_m - mean_m) / sigma_m, (to_m - mean_m) / sigma_m);
        let share = normal_between(from, to);
        if share <= least_share {
            return None;
        }
        let density = |at: f64| if at.is_finite() { normal_density(at) } else { 0.0 };
        let moment = |at: f64| if at.is_finite() { at * normal_density(at) } else { 0.0 };
        let shift = (density(from) - density(to)) / share;
        let narrowed = 1.0 + (moment(from) - moment(to)) / share - shift * shift;
        let variance = sigma_m * sigma_m * narrowed.clamp(LEAST_TRUNCATED, 1.0);
        let part = self.given(&PROGRESS, mean_m + sigma_m * shift, variance);
        Some(Self { weight: self.weight * share, ..part })
    }

    /// Probability that the progress lies between `from_m` and `to_m`, without the weight.
    pub(super) fn share_between(&self, from_m: f64, to_m: f64) -> f64 {
        let (mean_m, sigma_m) = (self.mean_m(), self.sigma_m());
        normal_between((from_m - mean_m) / sigma_m, (to_m - mean_m) / sigma_m)
    }
}

/// Density of a Gaussian of this variance at `from_mean` from its mean.
pub(super) fn gaussian(from_mean: f64, variance: f64) -> f64 {
    libm::exp(-0.5 * from_mean * from_mean / variance) / (2.0 * PI * variance).sqrt()
}

fn normal_density(at: f64) -> f64 {
    gaussian(at, 1.0)
}

/// Probability of a standard normal number between two bounds, exact in both tails.
fn normal_between(from: f64, to: f64) -> f64 {
    let beyond = |at: f64| 0.5 * libm::erfc(at / SQRT_2);
    let share = if from > 0.0 { beyond(from) - beyond(to) } else { beyond(-to) - beyond(-from) };
    share.max(0.0)
}

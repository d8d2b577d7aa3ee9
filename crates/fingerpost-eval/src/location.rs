//! Fixes on the map against truth.

use fingerpost_format::{FixStatus, LocationScores, Recall};

use crate::quantiles::error_quantiles;

/// A fix beside the truth at its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixSample {
    /// Time, seconds.
    pub t_s: f64,
    /// Distance truly driven so far, metres.
    pub driven_m: f64,
    /// East and north of the fix from the true place, metres.
    pub off_m: [f64; 2],
    /// True heading, radians anticlockwise from east.
    pub true_heading_rad: f64,
    /// Mean square of the vehicle's distance from the fix, square metres, as the fix says it: the other places that are possible count.
    pub covariance_m2: [[f64; 2]; 2],
    /// Its protection level, metres.
    pub bound_m: Option<f64>,
    /// What it is worth.
    pub status: FixStatus,
}

/// Errors that recall is counted at, metres (OrienterNet, P.-E. Sarlin et al., CVPR 2023).
const RECALL_AT_M: [f64; 3] = [1.0, 3.0, 5.0];

/// Compares fixes, in the order of time, with the truth.
pub fn evaluate_location(samples: &[FixSample]) -> LocationScores {
    let first = samples.iter().position(|sample| sample.status == FixStatus::Converged);
    let after = first.map_or(&[][..], |first| &samples[first..]);
    let converged = || samples.iter().filter(|sample| sample.status == FixStatus::Converged);
    let lateral: Vec<f64> = after.iter().map(|sample| sample.lateral_m().abs()).collect();
    let longitudinal: Vec<f64> = after.iter().map(|sample| sample.longitudinal_m().abs()).collect();
    let recall = Recall { lateral: shares(&lateral), longitudinal: shares(&longitudinal) };
    let nees: Vec<f64> = converged().filter_map(FixSample::normalised_squared_error).collect();
    LocationScores {
        converged_m: first.map(|first| samples[first].driven_m),
        fix_error_m: error_quantiles(after.iter().map(FixSample::error_m)),
        recall: (!after.is_empty()).then_some(recall),
        lateral_error_m: error_quantiles(lateral),
        longitudinal_error_m: error_quantiles(longitudinal),
        bound_violations: samples.iter().filter(|sample| sample.violates()).count(),
        longest_violation_s: longest_violation_s(samples),
        bound_m: error_quantiles(converged().filter_map(|sample| sample.bound_m)),
        nees: (!nees.is_empty()).then(|| nees.iter().sum::<f64>() / nees.len() as f64),
    }
}

fn shares(errors_m: &[f64]) -> [f64; 3] {
    RECALL_AT_M.map(|at_m| {
        errors_m.iter().filter(|error_m| **error_m <= at_m).count() as f64 / errors_m.len().max(1) as f64
    })
}

fn longest_violation_s(samples: &[FixSample]) -> f64 {
    let mut since_s = None;
    let mut longest_s: f64 = 0.0;
    for sample in samples {
        since_s = if sample.violates() { since_s.or(Some(sample.t_s)) } else { None };
        longest_s = longest_s.max(since_s.map_or(0.0, |since_s| sample.t_s - since_s));
    }
    longest_s
}

impl FixSample {
    fn error_m(&self) -> f64 {
        libm::hypot(self.off_m[0], self.off_m[1])
    }

    fn longitudinal_m(&self) -> f64 {
        self.off_m[0] * libm::cos(self.true_heading_rad) + self.off_m[1] * libm::sin(self.true_heading_rad)
    }

    fn lateral_m(&self) -> f64 {
        self.off_m[1] * libm::cos(self.true_heading_rad) - self.off_m[0] * libm::sin(self.true_heading_rad)
    }

    fn violates(&self) -> bool {
        self.status == FixStatus::Converged && self.bound_m.is_none_or(|bound_m| self.error_m() > bound_m)
    }

    /// The squared error in units of the mean square that the fix says, which is 2 on average where that is honest; of a fix that has
    /// rivals it is the whole mixture's, as of one that has none. None where that is singular.
    fn normalised_squared_error(&self) -> Option<f64> {
        let ([[east, mixed], [_, north]], [x, y]) = (self.covariance_m2, self.off_m);
        let determinant = east * north - mixed * mixed;
        (determinant > 0.0).then(|| (north * x * x - 2.0 * mixed * x * y + east * y * y) / determinant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(t_s: f64, off_m: [f64; 2], status: FixStatus) -> FixSample {
        FixSample {
            t_s,
            driven_m: 10.0 * t_s,
            off_m,
            true_heading_rad: std::f64::consts::FRAC_PI_2,
            covariance_m2: [[4.0, 0.0], [0.0, 1.0]],
            bound_m: (status == FixStatus::Converged).then_some(5.0),
            status,
        }
    }

    fn are_near(found: &[f64], expected: &[f64]) -> bool {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12)
    }

    #[test]
    #[allow(clippy::float_cmp, reason = "errors as given, and counts over counts")]
    fn errors_count_from_the_first_converged_fix_on() {
        use FixStatus::{Ambiguous, Coasting, Converged};
        let samples = [
            sample(0.0, [900.0, 0.0], Ambiguous),
            sample(1.0, [2.0, 0.0], Converged),
            sample(2.0, [0.0, 4.0], Converged),
            sample(3.0, [0.0, 6.0], Converged),
            sample(4.0, [0.0, 6.5], Converged),
            sample(5.0, [0.0, 8.0], Coasting),
        ];
        let scores = evaluate_location(&samples);
        assert!(are_near(&[scores.converged_m.unwrap()], &[10.0]));
        let error_m = scores.fix_error_m.unwrap();
        assert!(are_near(&[error_m.p50, error_m.max], &[6.0, 8.0]));
        // North is ahead: what lies east is across.
        let recall = scores.recall.unwrap();
        assert!(are_near(&recall.lateral, &[0.8, 1.0, 1.0]));
        assert!(are_near(&recall.longitudinal, &[0.2, 0.2, 0.4]));
        assert_eq!(scores.bound_violations, 2);
        assert!((scores.longest_violation_s - 1.0).abs() < 1e-12);
        assert!((scores.nees.unwrap() - (1.0 + 16.0 + 36.0 + 42.25) / 4.0).abs() < 1e-12);
    }

    #[test]
    fn without_a_converged_fix_there_are_no_errors() {
        let scores = evaluate_location(&[sample(0.0, [1.0, 0.0], FixStatus::Lost)]);
        assert!(scores.converged_m.is_none() && scores.fix_error_m.is_none() && scores.bound_violations == 0);
    }
}

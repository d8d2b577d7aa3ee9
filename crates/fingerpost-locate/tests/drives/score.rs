//! Converged fixes against the truth.

use std::fmt::{self, Display, Formatter};

use fingerpost_locate::{Fix, MotionSample, Status};
use nalgebra::Point2;

use super::Pose;

/// How near fixes are to the true places beside them.
pub(crate) fn score(fixes: &[(Fix, Point2<f64>)], rows: &[(MotionSample, Pose)]) -> Score {
    let mut score = Score { never_converged: 1, ..Score::default() };
    let beside = fixes.iter().zip(rows).filter(|((fix, _), _)| fix.status == Status::Converged);
    for ((fix, truth), (_, pose)) in beside {
        if score.never_converged == 1 {
            score.converged_m.push(pose.driven_m);
            score.never_converged = 0;
        }
        let (off, level_m) = (fix.place_m - truth, fix.level_m.unwrap());
        score.errors_m.push(off.norm());
        score.levels_m.push(level_m);
        score.violations += usize::from(off.norm() > level_m);
        score.squared_errors += (off.transpose() * fix.covariance_m2.try_inverse().unwrap() * off)[0];
    }
    score
}

/// Converged fixes of some drives against truth.
#[derive(Debug, Default)]
pub(crate) struct Score {
    pub(crate) errors_m: Vec<f64>,
    pub(crate) levels_m: Vec<f64>,
    pub(crate) converged_m: Vec<f64>,
    pub(crate) violations: usize,
    pub(crate) squared_errors: f64,
    pub(crate) never_converged: usize,
}

impl Score {
    pub(crate) fn add(&mut self, other: &Self) {
        self.errors_m.extend(&other.errors_m);
        self.levels_m.extend(&other.levels_m);
        self.converged_m.extend(&other.converged_m);
        self.violations += other.violations;
        self.squared_errors += other.squared_errors;
        self.never_converged += other.never_converged;
    }

    pub(crate) fn violations_part(&self) -> f64 {
        self.violations as f64 / self.errors_m.len().max(1) as f64
    }

    pub(crate) fn median_error_m(&self) -> f64 {
        quantile(&self.errors_m, 0.5)
    }

    pub(crate) fn nees(&self) -> f64 {
        self.squared_errors / self.errors_m.len().max(1) as f64
    }
}

impl Display for Score {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "converged after {:.0} m (median; never {}), error {:.2} m, p95 {:.2} m, level {:.2} m, {} of {} outside, NEES {:.2}",
            quantile(&self.converged_m, 0.5),
            self.never_converged,
            self.median_error_m(),
            quantile(&self.errors_m, 0.95),
            quantile(&self.levels_m, 0.5),
            self.violations,
            self.errors_m.len(),
            self.nees()
        )
    }
}

/// The value that a share of the values does not exceed.
pub(crate) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(f64::NAN)
}

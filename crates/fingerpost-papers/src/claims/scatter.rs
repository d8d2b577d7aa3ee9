//! Means with their scatter: what drives that are drawn anew would give as well.

/// 97.5 % quantiles of Student's t distribution for 1 to 30 degrees of freedom, to three digits (any statistical table); beyond,
/// that of the normal distribution is taken, which is 0.04 less at most.
const STUDENT_T: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
];
const NORMAL: f64 = 1.960;

/// A mean and the 95 % interval about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mean {
    pub(super) value: f64,
    /// Half the width of the interval; infinite for a single value.
    pub(super) within: f64,
    pub(super) count: usize,
}

impl Mean {
    /// The mean of independent values; none of nothing.
    pub(super) fn of(values: &[f64]) -> Option<Self> {
        let count = values.len();
        let value = values.iter().sum::<f64>() / count as f64;
        let freedom = count.checked_sub(1)?;
        let t = freedom.checked_sub(1).map_or(f64::INFINITY, |i| STUDENT_T.get(i).copied().unwrap_or(NORMAL));
        let variance = values.iter().map(|v| (v - value).powi(2)).sum::<f64>() / freedom.max(1) as f64;
        let within = if freedom == 0 { f64::INFINITY } else { t * (variance / count as f64).sqrt() };
        Some(Self { value, within, count })
    }

    /// Lower end of the interval.
    pub(super) fn low(&self) -> f64 {
        self.value - self.within
    }

    /// Upper end of the interval.
    pub(super) fn high(&self) -> f64 {
        self.value + self.within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_student() {
        // Mean 3, standard deviation sqrt(2.5): 2.776 * sqrt(2.5 / 5).
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert!((mean.value - 3.0).abs() < 1e-12 && (mean.within - 1.963).abs() < 1e-3, "{mean:?}");
        assert_eq!(Mean::of(&[]), None);
        assert!(Mean::of(&[1.0]).unwrap().within.is_infinite());
        assert!(Mean::of(&[2.0, 2.0]).unwrap().within.abs() < 1e-12);
    }
}

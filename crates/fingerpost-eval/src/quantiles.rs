//! Nearest-rank quantiles.

use fingerpost_format::{ErrorQuantiles, SigmaQuantiles, StageTime};

/// Median, 95th percentile and largest of `values`; none of none. Values that are no numbers are left out.
///
/// ```
/// let quantiles = fingerpost_eval::error_quantiles([4.0, 1.0, 3.0, 2.0]).unwrap();
/// assert!(quantiles.p50 == 2.0 && quantiles.p95 == 4.0 && quantiles.max == 4.0);
/// ```
pub fn error_quantiles(values: impl IntoIterator<Item = f64>) -> Option<ErrorQuantiles> {
    let sorted = sorted(values);
    Some(ErrorQuantiles {
        p50: nearest_rank(&sorted, 50)?,
        p95: nearest_rank(&sorted, 95)?,
        max: *sorted.last()?,
    })
}

/// 68th, 95th and 99th percentile and largest of `values`; none of none. Values that are no numbers are left out.
pub(crate) fn sigma_quantiles(values: impl IntoIterator<Item = f64>) -> Option<SigmaQuantiles> {
    let sorted = sorted(values);
    Some(SigmaQuantiles {
        p68: nearest_rank(&sorted, 68)?,
        p95: nearest_rank(&sorted, 95)?,
        p99: nearest_rank(&sorted, 99)?,
        max: *sorted.last()?,
    })
}

/// Median of `values`; none of none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    nearest_rank(&sorted(values), 50)
}

/// Median and 95th percentile of wall times, milliseconds; none of none.
pub fn stage_time(values_ms: impl IntoIterator<Item = f64>) -> Option<StageTime> {
    let sorted = sorted(values_ms);
    Some(StageTime { median: nearest_rank(&sorted, 50)?, p95: nearest_rank(&sorted, 95)? })
}

fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.into_iter().filter(|value| !value.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The smallest value that at least `percent` of the sorted values do not exceed.
fn nearest_rank(sorted: &[f64], percent: usize) -> Option<f64> {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.max(1) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_occurred() {
        let quantiles = error_quantiles((1..=100).rev().map(f64::from)).unwrap();
        assert_eq!(quantiles, ErrorQuantiles { p50: 50.0, p95: 95.0, max: 100.0 });
        let quantiles = error_quantiles([7.0]).unwrap();
        assert_eq!(quantiles, ErrorQuantiles { p50: 7.0, p95: 7.0, max: 7.0 });
        assert_eq!(error_quantiles([]), None);
        assert_eq!(error_quantiles([f64::NAN]), None);
    }

    #[test]
    fn one_slow_frame_in_twenty_one_is_beyond_the_95th_percentile() {
        let times = (0..21).map(|i| if i == 3 { 100.0 } else { 1.0 });
        assert_eq!(stage_time(times), Some(StageTime { median: 1.0, p95: 1.0 }));
    }
}

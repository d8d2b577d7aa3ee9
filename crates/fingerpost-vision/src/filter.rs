//! Smoothing of `f32` pictures: separable kernels and the box mean.
//!
//! Every pixel's sum runs in one fixed order on every code path, so that results are the same bytes everywhere.

mod box_mean;
mod separable;

pub use box_mean::BoxMean;
pub(crate) use box_mean::{ColumnSums, RowWindow};
pub use separable::SeparableFilter;

/// Weights of a Gaussian of the given standard deviation at `-radius..=radius`, summing to 1; a deviation of 0 or below
/// gives a single 1 in the middle.
#[must_use]
pub fn gaussian_taps(sigma: f64, radius: usize) -> Vec<f64> {
    let mut taps: Vec<f64> = (0..=2 * radius)
        .map(|tap| {
            let offset = tap as f64 - radius as f64;
            if sigma > 0.0 {
                libm::exp(-0.5 * (offset / sigma).powi(2))
            } else {
                f64::from(u8::from(tap == radius))
            }
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|weight| *weight /= sum);
    taps
}

/// Folds an index into `0..length` by mirrors through the first and the last element.
pub(crate) fn mirror(index: isize, length: usize) -> usize {
    let last = length as isize - 1;
    // One mirror is enough but for kernels wider than the picture; more of them cost a division.
    let once = if index < 0 { -index } else { index.min(2 * last - index) };
    if (0..=last).contains(&once) {
        return once as usize;
    }
    if length <= 1 {
        return 0;
    }
    let period = 2 * (length - 1);
    let folded = index.rem_euclid(period as isize) as usize;
    if folded < length { folded } else { period - folded }
}

#[cfg(test)]
mod tests;

//! Smoothing of `f32` pictures: separable kernels and the box mean.
//!
//! Sums run in a fixed order, so results are the same bytes everywhere.

use crate::error::{PictureError, check_size};
use crate::picture::Plane;

/// Weights of a Gaussian of the given standard deviation at `-radius..=radius`, summing to 1; a deviation of 0 or below
/// gives a single 1 in the middle.
#[must_use]
pub fn gaussian_taps(sigma: f64, radius: usize) -> Vec<f64> {
    let mut taps: Vec<f64> = (0..=2 * radius)
        .map(|tap| {
            let offset = tap as f64 - radius as f64;
            if sigma > 0.0 {
                (-0.5 * (offset / sigma).powi(2)).exp()
            } else {
                f64::from(u8::from(tap == radius))
            }
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|weight| *weight /= sum);
    taps
}

/// A smoothing by one row of weights, first along columns, then along rows.
///
/// Beyond its edges the picture is continued by a mirror through the centre of the edge pixel (dcb|abcd).
#[derive(Debug, Clone)]
pub struct SeparableFilter {
    taps: Vec<f32>,
    row_sum: Vec<f32>,
}

impl SeparableFilter {
    /// A filter with the given weights, an odd number of them; of an even number the last is left out.
    #[must_use]
    pub fn new(taps: &[f64]) -> Self {
        let odd = taps.len() - usize::from(taps.len().is_multiple_of(2) && !taps.is_empty());
        Self { taps: taps[..odd].iter().map(|&weight| weight as f32).collect(), row_sum: Vec::new() }
    }

    /// Filters `source` into `target`.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: &Plane<f32>, target: &mut Plane<f32>) -> Result<(), PictureError> {
        check_size("filter target", source.size(), target.size())?;
        let (width, height) = source.size();
        if width == 0 {
            return Ok(());
        }
        let radius = self.taps.len() / 2;
        self.row_sum.resize(width + 2 * radius, 0.0);
        for y in 0..height {
            let middle = &mut self.row_sum[radius..radius + width];
            middle.fill(0.0);
            for (tap, &weight) in self.taps.iter().enumerate() {
                let row = source.row(mirror(y as isize + tap as isize - radius as isize, height));
                middle.iter_mut().zip(row).for_each(|(sum, &value)| *sum += weight * value);
            }
            for beyond in 1..=radius {
                self.row_sum[radius - beyond] = self.row_sum[radius + mirror(-(beyond as isize), width)];
                let right = mirror((width - 1 + beyond) as isize, width);
                self.row_sum[radius + width - 1 + beyond] = self.row_sum[radius + right];
            }
            let out = target.row_mut(y);
            out.fill(0.0);
            for (tap, &weight) in self.taps.iter().enumerate() {
                let shifted = &self.row_sum[tap..tap + width];
                out.iter_mut().zip(shifted).for_each(|(sum, &value)| *sum += weight * value);
            }
        }
        Ok(())
    }
}

/// Folds an index into `0..length` by mirrors through the first and the last element.
pub(crate) fn mirror(index: isize, length: usize) -> usize {
    if length <= 1 {
        return 0;
    }
    let period = 2 * (length - 1);
    let folded = index.rem_euclid(period as isize) as usize;
    if folded < length { folded } else { period - folded }
}

/// The mean over a square window, by running sums: the cost does not depend on the window.
///
/// Beyond its edges the picture is continued by its edge pixels.
#[derive(Debug, Clone)]
pub struct BoxMean {
    radius: usize,
    column_sums: Vec<f64>,
}

impl BoxMean {
    /// A mean over `2 * radius_px + 1` pixels each way.
    #[must_use]
    pub fn new(radius_px: usize) -> Self {
        Self { radius: radius_px, column_sums: Vec::new() }
    }

    /// Fills `target` with the means of `source`.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: &Plane<f32>, target: &mut Plane<f32>) -> Result<(), PictureError> {
        check_size("box target", source.size(), target.size())?;
        let (width, height) = source.size();
        if width == 0 || height == 0 {
            return Ok(());
        }
        let radius = self.radius;
        let window = (2 * radius + 1) as f64;
        let scale = 1.0 / (window * window);
        let (last_row, last_col) = (height - 1, width - 1);
        // `f64` keeps what is added and taken away again from leaving a trace that matters.
        self.column_sums.clear();
        self.column_sums.extend(source.row(0).iter().map(|&value| (radius + 1) as f64 * f64::from(value)));
        for y in 1..=radius {
            let row = source.row(y.min(last_row));
            self.column_sums.iter_mut().zip(row).for_each(|(sum, &value)| *sum += f64::from(value));
        }
        for y in 0..height {
            let sums = &self.column_sums;
            let mut sum = (radius + 1) as f64 * sums[0];
            sum += (1..=radius).map(|x| sums[x.min(last_col)]).sum::<f64>();
            for (x, out) in target.row_mut(y).iter_mut().enumerate() {
                *out = (sum * scale) as f32;
                sum += sums[(x + radius + 1).min(last_col)] - sums[x.saturating_sub(radius)];
            }
            let entering = source.row((y + radius + 1).min(last_row));
            let leaving = source.row(y.saturating_sub(radius));
            for ((sum, &new), &old) in self.column_sums.iter_mut().zip(entering).zip(leaving) {
                *sum += f64::from(new) - f64::from(old);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(width: usize, height: usize) -> Plane<f32> {
        let values = (0..width * height).map(|index| ((index * 7919 + 13) % 101) as f32).collect();
        Plane::from_vec(width, height, values).unwrap()
    }

    #[test]
    fn separable_filter_equals_the_sum_over_the_window() {
        let taps = gaussian_taps(1.1, 2);
        for (width, height) in [(9, 7), (1, 5), (2, 2), (16, 1)] {
            let source = pattern(width, height);
            let mut target = Plane::new(width, height, 0.0);
            SeparableFilter::new(&taps).apply(&source, &mut target).unwrap();
            for y in 0..height {
                for x in 0..width {
                    let mut sum = 0.0;
                    for (j, wy) in taps.iter().enumerate() {
                        for (i, wx) in taps.iter().enumerate() {
                            let row = mirror(y as isize + j as isize - 2, height);
                            let col = mirror(x as isize + i as isize - 2, width);
                            sum += wx * wy * f64::from(source.row(row)[col]);
                        }
                    }
                    assert!((f64::from(target.row(y)[x]) - sum).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn mirrors_leave_out_the_edge_pixel() {
        let folded: Vec<usize> = (-3..7).map(|index| mirror(index, 4)).collect();
        assert_eq!(folded, vec![3, 2, 1, 0, 1, 2, 3, 2, 1, 0]);
    }

    #[test]
    fn box_mean_equals_the_sum_over_the_window() {
        for (width, height, radius) in [(9, 7, 2), (3, 4, 7), (1, 1, 3), (12, 5, 0)] {
            let source = pattern(width, height);
            let mut target = Plane::new(width, height, 0.0);
            BoxMean::new(radius).apply(&source, &mut target).unwrap();
            let reach = radius as isize;
            let clamp = |index: isize, length: usize| index.clamp(0, length as isize - 1) as usize;
            for y in 0..height {
                for x in 0..width {
                    let mut sum = 0.0;
                    for j in -reach..=reach {
                        for i in -reach..=reach {
                            let row = source.row(clamp(y as isize + j, height));
                            sum += f64::from(row[clamp(x as isize + i, width)]);
                        }
                    }
                    let mean = sum / ((2 * radius + 1) * (2 * radius + 1)) as f64;
                    assert!((f64::from(target.row(y)[x]) - mean).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn a_gaussian_sums_to_one_and_none_is_a_single_tap() {
        assert!((gaussian_taps(1.5, 4).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(gaussian_taps(0.0, 1), vec![0.0, 1.0, 0.0]);
        let mut same = Plane::new(4, 3, 0.0);
        SeparableFilter::new(&gaussian_taps(0.0, 1)).apply(&pattern(4, 3), &mut same).unwrap();
        assert_eq!(same, pattern(4, 3));
        assert!(SeparableFilter::new(&[1.0]).apply(&pattern(4, 3), &mut Plane::new(3, 4, 0.0)).is_err());
    }
}

//! Colour pictures made smaller by area averaging.
//!
//! A pixel of the smaller picture is the mean of what lies under it, pixels that lie under it in part counting by that part.
//! So nothing between the samples is lost and nothing is counted twice: textures finer than the new pixels become their mean
//! instead of a pattern. All weights are whole numbers, and the mean is the exact one, rounded.

use crate::error::{PictureError, check_size};
use crate::picture::RgbImage;
use crate::simd::{CodePath, simd_kernel};

/// Makes pictures of one size smaller, always to the same size; tables and sums are kept between them.
///
/// The outer edges of both pictures coincide: a place `u` of the source lies at `(u + 1/2) s - 1/2` of the target, with `s`
/// the ratio of their widths, and likewise down the picture.
///
/// ```
/// use fingerpost_vision::{picture::RgbImage, shrinking::Shrinker};
/// let source = RgbImage::from_vec(3, 1, vec![0, 0, 0, 90, 90, 90, 30, 60, 240])?;
/// let mut target = RgbImage::new(2, 1);
/// Shrinker::new((3, 1), (2, 1))?.shrink(&source, &mut target)?;
/// // One pixel and half of the next to either side.
/// assert_eq!(target.as_slice(), &[30, 30, 30, 50, 70, 190]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Shrinker {
    source: (usize, usize),
    columns: Vec<Share>,
    rows: Vec<Share>,
    /// Weighted sums along the source's columns, for one row of the target.
    sums: Vec<u32>,
}

/// What of the source lies under a row or column of the target.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Share {
    first: usize,
    /// How much of each row or column from `first` on, in parts of the target's side.
    weights: Vec<u32>,
}

impl Shrinker {
    /// From pictures of `source` to pictures of `target`, both width and height in pixels.
    ///
    /// # Errors
    /// [`PictureError::Growth`] when a side of the target is zero or longer than the source's.
    pub fn new(source: (usize, usize), target: (usize, usize)) -> Result<Self, PictureError> {
        if !(1..=source.0).contains(&target.0) || !(1..=source.1).contains(&target.1) {
            return Err(PictureError::Growth {
                width: source.0,
                height: source.1,
                target_width: target.0,
                target_height: target.1,
            });
        }
        let sums = vec![0; source.0 * RgbImage::CHANNELS];
        Ok(Self { source, columns: shares(source.0, target.0), rows: shares(source.1, target.1), sums })
    }

    /// Fills `target` with `source` at its size.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when one of them does not have the size that was given for it.
    pub fn shrink(&mut self, source: &RgbImage, target: &mut RgbImage) -> Result<(), PictureError> {
        check_size("picture to be made smaller", self.source, source.size())?;
        check_size("smaller picture", (self.columns.len(), self.rows.len()), target.size())?;
        let per_weight = 1.0 / (self.source.0 as f64 * self.source.1 as f64);
        for (y, row) in self.rows.iter().enumerate() {
            self.sums.fill(0);
            for (offset, &weight) in row.weights.iter().enumerate() {
                add_row(CodePath::fastest(), source.row(row.first + offset), weight, &mut self.sums);
            }
            let pixels = target.row_mut(y).as_chunks_mut::<{ RgbImage::CHANNELS }>().0;
            for (pixel, column) in pixels.iter_mut().zip(&self.columns) {
                *pixel = column.sum(&self.sums).map(|sum| (sum as f64 * per_weight).round() as u8);
            }
        }
        Ok(())
    }
}

impl Share {
    /// The weighted sum of each channel.
    fn sum(&self, sums: &[u32]) -> [u64; RgbImage::CHANNELS] {
        let pixels = &sums.as_chunks::<{ RgbImage::CHANNELS }>().0[self.first..];
        let mut total = [0; RgbImage::CHANNELS];
        for (pixel, &weight) in pixels.iter().zip(&self.weights) {
            for (total, &value) in total.iter_mut().zip(pixel) {
                *total += u64::from(value) * u64::from(weight);
            }
        }
        total
    }
}

/// What lies under each of `target` rows or columns, of `source` ones.
fn shares(source: usize, target: usize) -> Vec<Share> {
    // Counted in parts so small that both kinds of pixels have a whole number of them.
    let share = |index: usize| {
        let (begin, end) = (index * source, (index + 1) * source);
        let (first, last) = (begin / target, (end - 1) / target);
        let weight = |at: usize| end.min((at + 1) * target) - begin.max(at * target);
        Share { first, weights: (first..=last).map(|at| weight(at) as u32).collect() }
    };
    (0..target).map(share).collect()
}

simd_kernel! {
    fn add_row(row: &[u8], weight: u32, sums: &mut [u32]) {
        for (sum, &value) in sums.iter_mut().zip(row) {
            *sum += u32::from(value) * weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of what lies under a target's pixel, by the definition.
    fn mean_under(source: &RgbImage, target: (usize, usize), at: (usize, usize), channel: usize) -> f64 {
        let overlap = |index: usize, pixel: usize, ratio: f64| {
            let (begin, end) = (pixel as f64 * ratio, (pixel + 1) as f64 * ratio);
            (end.min((index + 1) as f64) - begin.max(index as f64)).max(0.0)
        };
        let (width, height) = source.size();
        let (across, down) = (width as f64 / target.0 as f64, height as f64 / target.1 as f64);
        let mut sum = 0.0;
        for y in 0..height {
            for x in 0..width {
                let value = f64::from(source.get(x, y).unwrap_or_default()[channel]);
                sum += value * overlap(x, at.0, across) * overlap(y, at.1, down);
            }
        }
        sum / (across * down)
    }

    #[test]
    fn every_pixel_is_the_mean_of_what_lies_under_it() {
        let size = (13, 11);
        let bytes = (0..size.0 * size.1 * 3).map(|i| (i * 7919 % 251) as u8).collect();
        let source = RgbImage::from_vec(size.0, size.1, bytes).unwrap();
        for target in [(13, 11), (12, 10), (7, 5), (4, 11), (1, 1)] {
            let mut small = RgbImage::new(target.0, target.1);
            Shrinker::new(size, target).unwrap().shrink(&source, &mut small).unwrap();
            for (x, y) in (0..target.0).flat_map(|x| (0..target.1).map(move |y| (x, y))) {
                for channel in 0..3 {
                    let (found, mean) = (
                        f64::from(small.get(x, y).unwrap()[channel]),
                        mean_under(&source, target, (x, y), channel),
                    );
                    assert!((found - mean).abs() <= 0.5 + 1e-9, "{target:?} {x} {y}: {found} for {mean}");
                }
            }
        }
    }

    #[test]
    fn white_stays_white_in_the_largest_pictures_and_all_paths_agree() {
        let source = RgbImage::from_vec(40, 16_384, vec![255; 40 * 16_384 * 3]).unwrap();
        let mut small = RgbImage::new(7, 33);
        Shrinker::new((40, 16_384), (7, 33)).unwrap().shrink(&source, &mut small).unwrap();
        assert!(small.as_slice().iter().all(|value| *value == 255));
        let row: Vec<u8> = (0..100).collect();
        for path in CodePath::available() {
            let mut sums = vec![5; 100];
            add_row(path, &row, 300, &mut sums);
            assert!(sums.iter().zip(0..).all(|(sum, value)| *sum == 5 + 300 * value), "{path:?}");
        }
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        for target in [(0, 3), (3, 0), (5, 3), (4, 4)] {
            assert!(matches!(Shrinker::new((4, 3), target), Err(PictureError::Growth { .. })), "{target:?}");
        }
        let mut shrinker = Shrinker::new((4, 4), (2, 2)).unwrap();
        let four = RgbImage::new(4, 4);
        assert!(shrinker.shrink(&RgbImage::new(4, 3), &mut RgbImage::new(2, 2)).is_err());
        assert!(shrinker.shrink(&four, &mut RgbImage::new(2, 1)).is_err());
    }
}

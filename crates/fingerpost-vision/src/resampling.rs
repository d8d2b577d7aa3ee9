//! Colour pictures brought to another size: by area averaging where they shrink, bilinearly where they grow.
//!
//! A pixel of a smaller picture is the mean of what lies under it, pixels that lie under it in part counting by that part.
//! So nothing between the samples is lost and nothing is counted twice: textures finer than the new pixels become their mean
//! instead of a pattern. Across and down are treated alike and each by itself. All weights are whole numbers, and the mean is
//! the exact one, rounded.

use std::ops::Range;

use crate::error::{PictureError, check_size};
use crate::picture::{Rect, RgbImage};
use crate::simd::{CodePath, simd_kernel};

/// Brings a part of pictures of one size to another size, always the same; tables and sums are kept between them.
///
/// The outer edges of the part and of the target coincide: a place `u` of the part lies at `(u + 1/2) s - 1/2` of the target,
/// with `s` the ratio of their widths, and likewise down the picture.
///
/// ```
/// use fingerpost_vision::{picture::{Rect, RgbImage}, resampling::Resampler};
/// let source = RgbImage::from_vec(3, 1, vec![0, 0, 0, 90, 90, 90, 30, 60, 240])?;
/// let whole = Rect { x: 0, y: 0, width: 3, height: 1 };
/// let mut target = RgbImage::new(2, 1);
/// Resampler::new((3, 1), whole, (2, 1))?.resample(&source, &mut target)?;
/// // One pixel and half of the next to either side.
/// assert_eq!(target.as_slice(), &[30, 30, 30, 50, 70, 190]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Resampler {
    source: (usize, usize),
    part: Rect,
    columns: Vec<Share>,
    rows: Vec<Share>,
    /// Sum of all weights under a pixel of the target.
    weight: f64,
    /// Sums of whole rows of the part, and weighted sums of all its rows, for one row of the target.
    whole: Vec<u16>,
    sums: Vec<u32>,
}

/// What of the part lies under a row or column of the target: some wholly, and at most two in part or in another weight.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Share {
    whole: Range<usize>,
    whole_weight: u32,
    /// Index and weight.
    others: [(usize, u32); 2],
}

/// Rows of bytes whose sums fit 16 bits.
const ROWS_IN_16_BITS: usize = 257;

impl Resampler {
    /// From the `part` of pictures of `source` to pictures of `target`, both width and height in pixels.
    ///
    /// # Errors
    /// [`PictureError::Empty`] when part or target have no pixels, [`PictureError::CropOutside`] when the part reaches outside.
    pub fn new(source: (usize, usize), part: Rect, target: (usize, usize)) -> Result<Self, PictureError> {
        for (what, (width, height)) in
            [("picture to be resampled", (part.width, part.height)), ("resampled picture", target)]
        {
            if width == 0 || height == 0 {
                return Err(PictureError::Empty { what, width, height });
            }
        }
        part.check_inside(source)?;
        let length = part.width * RgbImage::CHANNELS;
        let weight = |from: usize, to: usize| (if to <= from { from } else { 2 * to }) as f64;
        Ok(Self {
            source,
            part,
            columns: shares(part.width, target.0),
            rows: shares(part.height, target.1),
            weight: weight(part.width, target.0) * weight(part.height, target.1),
            whole: vec![0; length],
            sums: vec![0; length],
        })
    }

    /// Width and height of the pictures it reads, pixels.
    #[must_use]
    pub fn source_size(&self) -> (usize, usize) {
        self.source
    }

    /// The part of them that is resampled.
    #[must_use]
    pub fn part(&self) -> Rect {
        self.part
    }

    /// Fills `target` with the part of `source` at its size.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when one of them does not have the size that was given for it.
    pub fn resample(&mut self, source: &RgbImage, target: &mut RgbImage) -> Result<(), PictureError> {
        self.resample_on(CodePath::fastest(), source, target)
    }

    pub(crate) fn resample_on(
        &mut self,
        path: CodePath,
        source: &RgbImage,
        target: &mut RgbImage,
    ) -> Result<(), PictureError> {
        check_size("picture to be resampled", self.source, source.size())?;
        check_size("resampled picture", (self.columns.len(), self.rows.len()), target.size())?;
        let bytes = self.part.x * RgbImage::CHANNELS..(self.part.x + self.part.width) * RgbImage::CHANNELS;
        let (top, per_weight) = (self.part.y, 1.0 / self.weight);
        for (y, Share { whole, whole_weight, others }) in self.rows.iter().enumerate() {
            let row = |at: usize| &source.row(top + at)[bytes.clone()];
            let [(first, first_weight), (second, second_weight)] = *others;
            weigh(path, [row(first), row(second)], [first_weight, second_weight], &mut self.sums);
            let mut start = whole.start;
            while start < whole.end {
                let end = whole.end.min(start + ROWS_IN_16_BITS);
                self.whole.fill(0);
                (start..end).for_each(|at| add_row(path, row(at), &mut self.whole));
                add_whole(path, &self.whole, *whole_weight, &mut self.sums);
                start = end;
            }
            let pixels = target.row_mut(y).as_chunks_mut::<{ RgbImage::CHANNELS }>().0;
            average(path, &self.columns, &self.sums, per_weight, pixels);
        }
        Ok(())
    }
}

/// What lies under each of `target` rows or columns, of `source` ones.
fn shares(source: usize, target: usize) -> Vec<Share> {
    if target > source {
        return (0..target).map(|index| between(index, source, target)).collect();
    }
    // Counted in parts so small that both kinds of pixels have a whole number of them.
    let share = |index: usize| {
        let (begin, end) = (index * source, (index + 1) * source);
        let (first, last) = (begin / target, (end - 1) / target);
        let overlap = |at: usize| (end.min((at + 1) * target) - begin.max(at * target)) as u32;
        let whole = begin.div_ceil(target)..end / target;
        // Counted here where it is not counted among the whole ones.
        let other = |at: usize| (at, if whole.contains(&at) { 0 } else { overlap(at) });
        let others = [other(first), if last == first { (last, 0) } else { other(last) }];
        Share { whole, whole_weight: target as u32, others }
    };
    (0..target).map(share).collect()
}

/// The two pixels of `source` ones between whose centres that of a pixel of `target` ones lies.
fn between(index: usize, source: usize, target: usize) -> Share {
    // In parts of half a target's pixel: the place's distance from the first pixel's centre, 0 where it lies before that.
    let parts = ((2 * index + 1) * source).saturating_sub(target);
    let (lower, beyond) = (parts / (2 * target), (parts % (2 * target)) as u32);
    let upper = (lower + 1).min(source - 1);
    Share { whole: 0..0, whole_weight: 0, others: [(lower, 2 * target as u32 - beyond), (upper, beyond)] }
}

simd_kernel! {
    fn weigh(rows: [&[u8]; 2], weights: [u32; 2], sums: &mut [u32]) {
        let [first, second] = rows;
        for ((sum, &first), &second) in sums.iter_mut().zip(first).zip(second) {
            *sum = u32::from(first) * weights[0] + u32::from(second) * weights[1];
        }
    }
}

simd_kernel! {
    fn add_row(row: &[u8], sums: &mut [u16]) {
        for (sum, &value) in sums.iter_mut().zip(row) {
            *sum += u16::from(value);
        }
    }
}

simd_kernel! {
    fn add_whole(whole: &[u16], weight: u32, sums: &mut [u32]) {
        for (sum, &whole) in sums.iter_mut().zip(whole) {
            *sum += u32::from(whole) * weight;
        }
    }
}

simd_kernel! {
    /// The mean of each channel under every pixel of a row.
    fn average(columns: &[Share], sums: &[u32], per_weight: f64, pixels: &mut [[u8; RgbImage::CHANNELS]]) {
        let sums = sums.as_chunks::<{ RgbImage::CHANNELS }>().0;
        for (pixel, Share { whole, whole_weight, others }) in pixels.iter_mut().zip(columns) {
            let mut total = [0_u64; RgbImage::CHANNELS];
            for sums in &sums[whole.clone()] {
                for (total, &sum) in total.iter_mut().zip(sums) {
                    *total += u64::from(sum);
                }
            }
            for (channel, value) in pixel.iter_mut().enumerate() {
                let of = |(at, weight): (usize, u32)| u64::from(sums[at][channel]) * u64::from(weight);
                let sum = total[channel] * u64::from(*whole_weight) + of(others[0]) + of(others[1]);
                // The sum is below 2^53, and the mean at most 255: half a level more rounds it.
                *value = (sum as f64 * per_weight + 0.5) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(width: usize, height: usize) -> Rect {
        Rect { x: 0, y: 0, width, height }
    }

    /// The mean of what lies under a target's pixel, by the definition.
    fn mean_under(
        source: &RgbImage,
        part: Rect,
        target: (usize, usize),
        at: (usize, usize),
        channel: usize,
    ) -> f64 {
        let overlap = |index: usize, pixel: usize, ratio: f64| {
            let (begin, end) = (pixel as f64 * ratio, (pixel + 1) as f64 * ratio);
            (end.min((index + 1) as f64) - begin.max(index as f64)).max(0.0) / ratio
        };
        // About the place, whose weight beyond the outermost centres is theirs.
        let triangle = |index: usize, pixel: usize, ratio: f64, length: usize| {
            let place = ((pixel as f64 + 0.5) * ratio - 0.5).clamp(0.0, (length - 1) as f64);
            (1.0 - (place - index as f64).abs()).max(0.0)
        };
        let weight = |index: usize, pixel: usize, from: usize, to: usize| {
            let ratio = from as f64 / to as f64;
            if to > from { triangle(index, pixel, ratio, from) } else { overlap(index, pixel, ratio) }
        };
        let mut sum = 0.0;
        for y in 0..part.height {
            for x in 0..part.width {
                let value = f64::from(source.get(part.x + x, part.y + y).unwrap_or_default()[channel]);
                sum += value * weight(x, at.0, part.width, target.0) * weight(y, at.1, part.height, target.1);
            }
        }
        sum
    }

    #[test]
    fn every_pixel_is_the_mean_of_what_lies_under_it_or_lies_between_its_neighbours() {
        let size = (13, 11);
        let bytes = (0..size.0 * size.1 * 3).map(|i| (i * 7919 % 251) as u8).collect();
        let source = RgbImage::from_vec(size.0, size.1, bytes).unwrap();
        for part in [
            whole(13, 11),
            Rect { x: 2, y: 3, width: 9, height: 8 },
            Rect { x: 12, y: 0, width: 1, height: 1 },
        ] {
            for target in [(13, 11), (12, 10), (7, 5), (4, 11), (1, 1), (29, 3), (18, 33)] {
                let mut made = RgbImage::new(target.0, target.1);
                Resampler::new(size, part, target).unwrap().resample(&source, &mut made).unwrap();
                for (x, y) in (0..target.0).flat_map(|x| (0..target.1).map(move |y| (x, y))) {
                    for channel in 0..3 {
                        let (found, mean) = (
                            f64::from(made.get(x, y).unwrap()[channel]),
                            mean_under(&source, part, target, (x, y), channel),
                        );
                        let apart = (found - mean).abs();
                        assert!(apart <= 0.5 + 1e-9, "{part:?} {target:?} {x} {y}: {found} for {mean}");
                    }
                }
            }
        }
    }

    #[test]
    fn white_stays_white_in_the_largest_pictures_and_all_paths_agree() {
        let source = RgbImage::from_vec(40, 16_384, vec![255; 40 * 16_384 * 3]).unwrap();
        let mut small = RgbImage::new(7, 33);
        Resampler::new((40, 16_384), whole(40, 16_384), (7, 33))
            .unwrap()
            .resample(&source, &mut small)
            .unwrap();
        assert!(small.as_slice().iter().all(|value| *value == 255));
        let noise: Vec<u8> =
            (0..100 * 90 * 3_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let source = RgbImage::from_vec(100, 90, noise).unwrap();
        for target in [(37, 23), (190, 11)] {
            let mut made = CodePath::available().map(|path| {
                let mut made = RgbImage::new(target.0, target.1);
                let mut resampler = Resampler::new((100, 90), whole(100, 90), target).unwrap();
                resampler.resample_on(path, &source, &mut made).unwrap();
                made
            });
            let portable = made.next().unwrap();
            assert!(made.all(|made| made == portable), "{target:?}");
        }
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        for (part, target) in [(whole(4, 3), (0, 3)), (whole(4, 3), (3, 0)), (whole(0, 3), (2, 2))] {
            let made = Resampler::new((4, 3), part, target);
            assert!(matches!(made, Err(PictureError::Empty { .. })), "{target:?}");
        }
        let outside = Resampler::new((4, 3), Rect { x: 1, ..whole(4, 3) }, (2, 2));
        assert!(matches!(outside, Err(PictureError::CropOutside { .. })));
        let mut resampler = Resampler::new((4, 4), whole(4, 4), (2, 2)).unwrap();
        let four = RgbImage::new(4, 4);
        assert!(resampler.resample(&RgbImage::new(4, 3), &mut RgbImage::new(2, 2)).is_err());
        assert!(resampler.resample(&four, &mut RgbImage::new(2, 1)).is_err());
    }
}

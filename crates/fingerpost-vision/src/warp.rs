//! Resampling a picture through a table that is built once.
//!
//! Each target pixel holds the place in the source picture that it shows. The table keeps that place in steps of 1/32
//! pixel and interpolates bilinearly between the four pixels around it in integers, so that the result is the same on
//! every machine. A target pixel whose place lies outside the source is *unseen*: 0 in the validity mask and in every
//! warped picture.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod resample;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod windows;

use std::ops::Range;

use crate::colour::{BinDivision, grey_and_bins_of_all};
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, RgbImage, ValidityMask};
use crate::simd::CodePath;
use resample::{Neighbours, Taps, Weights, resample_grey, resample_rgb};

/// Steps a pixel in which a place in the source is kept: fine enough that rounding costs at most 1/64 pixel, and the
/// weights of the four neighbours are exact integers.
const STEPS_PER_PX: u8 = 32;

/// A resampling from pictures of one size to pictures of another.
///
/// ```
/// use fingerpost_vision::{picture::Plane, warp::WarpTable};
/// // Half a pixel to the right: each target pixel is the mean of two source pixels; the last looks outside.
/// let table = WarpTable::new(3, 1, 3, 1, |col, row| Some([col as f64 + 0.5, row as f64]))?;
/// let source = Plane::from_vec(3, 1, vec![10_u8, 20, 40])?;
/// let mut target = Plane::new(3, 1, 0);
/// table.warp_grey(&source, &mut target)?;
/// assert_eq!(target.as_slice(), &[15, 30, 0]);
/// assert_eq!(table.validity().plane().as_slice(), &[1, 1, 0]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WarpTable {
    source_width: usize,
    source_height: usize,
    validity: ValidityMask,
    /// For each seen pixel, run by run, the index of the upper left of the four source pixels.
    indices: Vec<u32>,
    /// For each seen pixel, run by run, the weights of the four source pixels.
    weights: Vec<Weights>,
}

impl WarpTable {
    /// Builds the table from `source_from_target`, which gives the place (u, v) in the source, in pixels, that the
    /// target pixel (column, row) shows, or `None` where it shows nothing.
    ///
    /// Places outside `[0, source_width - 1] x [0, source_height - 1]` and places that are not finite are unseen.
    ///
    /// # Errors
    /// [`PictureError::TooLarge`] when the source has more pixels than 32 bits can number.
    pub fn new(
        target_width: usize,
        target_height: usize,
        source_width: usize,
        source_height: usize,
        source_from_target: impl Fn(usize, usize) -> Option<[f64; 2]>,
    ) -> Result<Self, PictureError> {
        // Three bytes a pixel are still addressed in 32 bits.
        let limit = u32::MAX as usize / RgbImage::CHANNELS;
        if source_width.saturating_mul(source_height) > limit {
            return Err(PictureError::TooLarge {
                what: "warp source",
                width: source_width,
                height: source_height,
                limit,
            });
        }
        let mut validity = Plane::new(target_width, target_height, 0_u8);
        let (mut indices, mut weights) = (Vec::new(), Vec::new());
        for row in 0..target_height {
            for col in 0..target_width {
                let place = source_from_target(col, row)
                    .and_then(|[u, v]| Some((split(u, source_width)?, split(v, source_height)?)));
                if let Some(((x, right), (y, below))) = place {
                    // The check above keeps every source index within 32 bits.
                    indices.push((y * source_width + x) as u32);
                    weights.push([STEPS_PER_PX - below, below, STEPS_PER_PX - right, right]);
                    validity.row_mut(row)[col] = 1;
                }
            }
        }
        Ok(Self {
            source_width,
            source_height,
            validity: ValidityMask::from_plane(validity),
            indices,
            weights,
        })
    }

    /// Which target pixels show the source.
    #[must_use]
    pub fn validity(&self) -> &ValidityMask {
        &self.validity
    }

    /// Width and height of the pictures that the table reads, pixels.
    #[must_use]
    pub fn source_size(&self) -> (usize, usize) {
        (self.source_width, self.source_height)
    }

    /// Width and height of the pictures that the table makes, pixels.
    #[must_use]
    pub fn target_size(&self) -> (usize, usize) {
        self.validity.size()
    }

    /// Resamples a colour picture into `target`; unseen pixels become black.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when either picture has not the table's size.
    pub fn warp_rgb(&self, source: &RgbImage, target: &mut RgbImage) -> Result<(), PictureError> {
        self.warp_rgb_on(CodePath::fastest(), source, target)
    }

    fn warp_rgb_on(
        &self,
        path: CodePath,
        source: &RgbImage,
        target: &mut RgbImage,
    ) -> Result<(), PictureError> {
        self.check(source.size(), target.size())?;
        let (source, target) = (source.pixels(), target.pixels_mut());
        for Part { gap, run, taps } in self.parts() {
            target[gap].fill([0; 3]);
            resample_rgb(path, source, self.neighbours(), taps, &mut target[run]);
        }
        Ok(())
    }

    /// Resamples a grey picture into `target`; unseen pixels become 0.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when either picture has not the table's size.
    pub fn warp_grey(&self, source: &Plane<u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
        self.warp_grey_on(CodePath::fastest(), source, target)
    }

    fn warp_grey_on(
        &self,
        path: CodePath,
        source: &Plane<u8>,
        target: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        self.check(source.size(), target.size())?;
        let (source, target) = (source.as_slice(), target.as_mut_slice());
        for Part { gap, run, taps } in self.parts() {
            target[gap].fill(0);
            resample_grey(path, source, self.neighbours(), taps, &mut target[run]);
        }
        Ok(())
    }

    /// Resamples a colour picture into `colour`, and its luma into `grey` and the indices of its hue-saturation bins into
    /// `bin`, in one pass; unseen pixels become 0 in all three.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when a picture has not the table's size.
    pub fn warp_ground(
        &self,
        source: &RgbImage,
        division: &BinDivision,
        colour: &mut RgbImage,
        grey: &mut Plane<u8>,
        bin: &mut Plane<u16>,
    ) -> Result<(), PictureError> {
        self.warp_ground_on(CodePath::fastest(), source, division, (colour, grey, bin))
    }

    fn warp_ground_on(
        &self,
        path: CodePath,
        source: &RgbImage,
        division: &BinDivision,
        (colour, grey, bin): (&mut RgbImage, &mut Plane<u8>, &mut Plane<u16>),
    ) -> Result<(), PictureError> {
        self.check(source.size(), colour.size())?;
        check_size("grey picture", self.target_size(), grey.size())?;
        check_size("bin picture", self.target_size(), bin.size())?;
        let (source, colour) = (source.pixels(), colour.pixels_mut());
        let (grey, bin) = (grey.as_mut_slice(), bin.as_mut_slice());
        for Part { gap, run, taps } in self.parts() {
            colour[gap.clone()].fill([0; 3]);
            grey[gap.clone()].fill(0);
            bin[gap].fill(0);
            // The colours of a run are still in the first cache when they are looked at again.
            resample_rgb(path, source, self.neighbours(), taps, &mut colour[run.clone()]);
            grey_and_bins_of_all(path, &colour[run.clone()], division, &mut grey[run.clone()], &mut bin[run]);
        }
        Ok(())
    }

    fn check(&self, source: (usize, usize), target: (usize, usize)) -> Result<(), PictureError> {
        check_size("warp source", self.source_size(), source)?;
        check_size("warp target", self.target_size(), target)
    }

    fn neighbours(&self) -> Neighbours {
        Neighbours {
            right: usize::from(self.source_width > 1),
            below: if self.source_height > 1 { self.source_width } else { 0 },
        }
    }

    /// The whole target, as gaps and the runs that follow them; the run after the last gap is empty.
    fn parts(&self) -> impl Iterator<Item = Part<'_>> {
        let (width, height) = self.target_size();
        let runs = (0..height).flat_map(move |row| {
            self.validity.runs(row).iter().map(move |run| row * width + run.start..row * width + run.end)
        });
        let end = width * height;
        let mut filled = 0;
        let mut taps = Taps { indices: &self.indices, weights: &self.weights };
        runs.chain(std::iter::once(end..end)).map(move |run| {
            let gap = filled..run.start;
            filled = run.end;
            let (here, rest) = taps.split_at(run.len());
            taps = rest;
            Part { gap, run, taps: here }
        })
    }
}

/// A run of seen pixels and the unseen ones before it, as indices of the target's pixels.
struct Part<'a> {
    gap: Range<usize>,
    run: Range<usize>,
    taps: Taps<'a>,
}

/// Splits a coordinate into the lower of its two pixels and the upper one's weight in steps; `None` when it lies outside
/// a picture of `length` pixels.
fn split(coordinate_px: f64, length: usize) -> Option<(usize, u8)> {
    let last = length.checked_sub(1)?;
    // Written so that NaN is outside.
    if !(coordinate_px >= 0.0 && coordinate_px <= last as f64) {
        return None;
    }
    let steps = (coordinate_px * f64::from(STEPS_PER_PX)).round_ties_even() as usize;
    let (pixel, step) = (steps / usize::from(STEPS_PER_PX), steps % usize::from(STEPS_PER_PX));
    if pixel == last && last > 0 {
        // The last pixel is the upper one of the last pair, so that the pair stays inside.
        return Some((pixel - 1, STEPS_PER_PX));
    }
    Some((pixel, step as u8))
}

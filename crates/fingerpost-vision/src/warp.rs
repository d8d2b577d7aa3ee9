//! Resampling a picture through a table that is built once.
//!
//! Each target pixel holds the place in the source picture that it shows. The table keeps that place in steps of 1/32
//! pixel and interpolates bilinearly between the four pixels around it in integers, so that the result is the same on
//! every machine. A target pixel whose place lies outside the source is *unseen*: 0 in the validity mask and in every
//! warped picture.

use crate::colour::{BinDivision, grey_and_bins_of};
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, RgbImage, ValidityMask};

/// Steps a pixel in which a place in the source is kept: fine enough that rounding costs at most 1/64 pixel, and the
/// weights of the four neighbours are exact integers.
const STEPS_PER_PX: u8 = 32;
/// Sum of the four neighbours' weights, `STEPS_PER_PX` squared, as a power of two.
const WEIGHT_BITS: u32 = 10;
const HALF: u32 = 1 << (WEIGHT_BITS - 1);

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

/// Weights of the upper and the lower row and of the left and the right column, steps; each pair sums to
/// [`STEPS_PER_PX`].
type Weights = [u8; 4];

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
        check_size("warp source", self.source_size(), source.size())?;
        check_size("warp target", self.target_size(), target.size())?;
        self.resample::<3>(source.as_slice(), target.as_mut_slice(), |_, _| {});
        Ok(())
    }

    /// Resamples a grey picture into `target`; unseen pixels become 0.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when either picture has not the table's size.
    pub fn warp_grey(&self, source: &Plane<u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
        check_size("warp source", self.source_size(), source.size())?;
        check_size("warp target", self.target_size(), target.size())?;
        self.resample::<1>(source.as_slice(), target.as_mut_slice(), |_, _| {});
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
        check_size("warp source", self.source_size(), source.size())?;
        check_size("warp target", self.target_size(), colour.size())?;
        check_size("grey picture", self.target_size(), grey.size())?;
        check_size("bin picture", self.target_size(), bin.size())?;
        grey.as_mut_slice().fill(0);
        bin.as_mut_slice().fill(0);
        let (grey, bin) = (grey.as_mut_slice(), bin.as_mut_slice());
        self.resample::<3>(source.as_slice(), colour.as_mut_slice(), |start, pixels| {
            let part = start..start + pixels.len();
            grey_and_bins_of(pixels, division, &mut grey[part.clone()], &mut bin[part]);
        });
        Ok(())
    }

    /// Resamples run by run and hands each finished run to `finished`: the index of its first pixel, and its pixels.
    fn resample<const CHANNELS: usize>(
        &self,
        source: &[u8],
        target: &mut [u8],
        mut finished: impl FnMut(usize, &[[u8; CHANNELS]]),
    ) {
        let (source, _) = source.as_chunks::<CHANNELS>();
        let (target, _) = target.as_chunks_mut::<CHANNELS>();
        target.fill([0; CHANNELS]);
        let (width, height) = self.target_size();
        let mut taken = 0;
        for row in 0..height {
            for run in self.validity.runs(row) {
                let taps = taken..taken + (run.end - run.start);
                taken = taps.end;
                let start = row * width + run.start;
                let run = &mut target[start..row * width + run.end];
                self.resample_run(source, &self.indices[taps.clone()], &self.weights[taps], run);
                finished(start, run);
            }
        }
    }

    fn resample_run<const CHANNELS: usize>(
        &self,
        source: &[[u8; CHANNELS]],
        indices: &[u32],
        weights: &[Weights],
        target: &mut [[u8; CHANNELS]],
    ) {
        // A source one pixel wide or high has no neighbour on that side; the weight there is 0.
        let right = usize::from(self.source_width > 1);
        let below = if self.source_height > 1 { self.source_width } else { 0 };
        for ((out, &index), weights) in target.iter_mut().zip(indices).zip(weights) {
            let index = index as usize;
            let upper = [&source[index], &source[index + right]];
            let lower = [&source[index + below], &source[index + below + right]];
            let [w_above, w_below, w_left, w_right] = weights.map(u32::from);
            for (channel, value) in out.iter_mut().enumerate() {
                let above = u32::from(upper[0][channel]) * w_left + u32::from(upper[1][channel]) * w_right;
                let beneath = u32::from(lower[0][channel]) * w_left + u32::from(lower[1][channel]) * w_right;
                // At most 255 * 1024 before the shift, so the result fits 8 bits.
                *value = ((above * w_above + beneath * w_below + HALF) >> WEIGHT_BITS) as u8;
            }
        }
    }
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

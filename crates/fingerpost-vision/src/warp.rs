//! Resampling a picture through a table that is built once.
//!
//! Each target pixel holds the place in the source picture that it shows. The table keeps that place in steps of 1/32
//! pixel and interpolates bilinearly between the four pixels around it in integers, so that the result is the same on
//! every machine. A target pixel whose place lies outside the source is *unseen*: 0 in the validity mask and in every
//! warped picture.

use crate::error::{PictureError, check_size};
use crate::picture::{Plane, RgbImage};

/// Steps a pixel in which a place in the source is kept: fine enough that rounding costs at most 1/64 pixel, and the
/// weights of the four neighbours are exact integers.
const STEPS_PER_PX: u32 = 32;
/// Sum of the four neighbours' weights, `STEPS_PER_PX` squared, as a power of two.
const WEIGHT_BITS: u32 = 10;
const HALF: u32 = 1 << (WEIGHT_BITS - 1);

/// Where one target pixel looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Tap {
    /// Index of the upper left of the four source pixels.
    index: u32,
    /// Weight of the right column, steps.
    right: u8,
    /// Weight of the lower row, steps.
    below: u8,
}

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
/// assert_eq!(table.validity().as_slice(), &[1, 1, 0]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WarpTable {
    source_width: usize,
    source_height: usize,
    taps: Vec<Tap>,
    validity: Plane<u8>,
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
        let unseen = Tap { index: 0, right: 0, below: 0 };
        let mut taps = vec![unseen; target_width * target_height];
        let mut validity = Plane::new(target_width, target_height, 0_u8);
        for row in 0..target_height {
            for col in 0..target_width {
                let place = source_from_target(col, row)
                    .and_then(|[u, v]| Some((split(u, source_width)?, split(v, source_height)?)));
                if let Some(((x, right), (y, below))) = place {
                    // The check above keeps every source index within 32 bits.
                    taps[row * target_width + col] =
                        Tap { index: (y * source_width + x) as u32, right, below };
                    validity.row_mut(row)[col] = 1;
                }
            }
        }
        Ok(Self { source_width, source_height, taps, validity })
    }

    /// 1 where a target pixel shows the source, 0 where it shows nothing.
    #[must_use]
    pub fn validity(&self) -> &Plane<u8> {
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
        self.resample::<3>(source.as_slice(), target.as_mut_slice());
        Ok(())
    }

    /// Resamples a grey picture into `target`; unseen pixels become 0.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when either picture has not the table's size.
    pub fn warp_grey(&self, source: &Plane<u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
        check_size("warp source", self.source_size(), source.size())?;
        check_size("warp target", self.target_size(), target.size())?;
        self.resample::<1>(source.as_slice(), target.as_mut_slice());
        Ok(())
    }

    fn resample<const CHANNELS: usize>(&self, source: &[u8], target: &mut [u8]) {
        // A source one pixel wide or high has no neighbour on that side; the weight there is 0.
        let right = usize::from(self.source_width > 1);
        let below = if self.source_height > 1 { self.source_width } else { 0 };
        let (source, _) = source.as_chunks::<CHANNELS>();
        let (target, _) = target.as_chunks_mut::<CHANNELS>();
        for ((out, tap), &seen) in target.iter_mut().zip(&self.taps).zip(self.validity.as_slice()) {
            if seen == 0 {
                *out = [0; CHANNELS];
                continue;
            }
            let index = tap.index as usize;
            let upper = [&source[index], &source[index + right]];
            let lower = [&source[index + below], &source[index + below + right]];
            let (w_right, w_below) = (u32::from(tap.right), u32::from(tap.below));
            let (w_left, w_above) = (STEPS_PER_PX - w_right, STEPS_PER_PX - w_below);
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
    let (pixel, step) = (steps / STEPS_PER_PX as usize, steps % STEPS_PER_PX as usize);
    if pixel == last && last > 0 {
        // The last pixel is the upper one of the last pair, so that the pair stays inside.
        return Some((pixel - 1, STEPS_PER_PX as u8));
    }
    Some((pixel, step as u8))
}

//! Histogram back-projection: how probable each pixel belongs to a surface, from the surface's colours.
//!
//! M. J. Swain and D. H. Ballard, "Indexing via color histograms", 1992: the surface's histogram divided by the picture's,
//! at most 1, is looked up for every pixel and convolved with a small disc. Here the convolution is the mean over those
//! pixels under the disc that are seen, so that the edge of the ground view does not darken the road beside it. Everything
//! after the look-up table is integer arithmetic.

use crate::error::{PictureError, check_size};
use crate::histogram::{Histogram, HistogramError};
use crate::picture::Plane;
use crate::span::RowSums;

/// Largest disc, pixels: 1.6 m at 0.05 m a pixel, wider than any road detail worth keeping.
pub const MAX_DISC_RADIUS_PX: u16 = 32;

/// Bits behind the point of the reciprocals of disc areas. With areas up to 3209 (radius 32) and numerators below
/// `2 * 255 * 3209 + 3209` the quotient is exact from 34 bits on: numerator times divisor must stay below it.
const RECIPROCAL_BITS: u32 = 36;

/// A back-projection that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BackProjectionError {
    /// Pictures whose sizes do not fit.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// Histograms that cannot be divided.
    #[error(transparent)]
    Histogram(#[from] HistogramError),
    /// A bin that the look-up table does not have.
    #[error(
        "the picture holds bin {bin}, but the look-up table has {count} entries; use one division into bins"
    )]
    BinOutside {
        /// Bin index found.
        bin: u16,
        /// Entries of the table.
        count: usize,
    },
    /// A disc beyond the supported size.
    #[error("a disc of {radius_px} px is too large; give 0 (none) to {MAX_DISC_RADIUS_PX} px")]
    Disc {
        /// Radius asked for, pixels.
        radius_px: u16,
    },
    /// A gain that is not a number above 0.
    #[error("a gain of {gain} cannot be used; give a finite number above 0")]
    Gain {
        /// Gain asked for.
        gain: f64,
    },
}

/// Fills `lookup` with one probability a bin, 255 standing for 1: `min(gain * surface / picture, 1)`, the ratio histogram
/// of Swain & Ballard; 0 in bins where either holds nothing.
///
/// With histograms of equal mass a `gain` of 1 gives 1 where the surface has at least the picture's share of a colour.
///
/// # Errors
/// [`BackProjectionError::Histogram`] when the histograms are over different bins; [`BackProjectionError::Gain`].
pub fn ratio_lookup(
    surface: &Histogram,
    picture: &Histogram,
    gain: f64,
    lookup: &mut Vec<u8>,
) -> Result<(), BackProjectionError> {
    surface.check_same_bins(picture)?;
    if !(gain.is_finite() && gain > 0.0) {
        return Err(BackProjectionError::Gain { gain });
    }
    lookup.clear();
    lookup.extend(surface.masses().iter().zip(picture.masses()).map(|(&surface, &picture)| {
        let ratio = if picture > 0.0 { (gain * surface / picture).min(1.0) } else { 0.0 };
        (255.0 * ratio).round() as u8
    }));
    Ok(())
}

/// Back-projection with a disc of one radius; keeps its buffers from picture to picture.
///
/// ```
/// use fingerpost_vision::{backprojection::BackProjector, picture::Plane};
/// let bin = Plane::from_vec(3, 1, vec![0_u16, 1, 1])?;
/// let validity = Plane::from_vec(3, 1, vec![1_u8, 1, 0])?;
/// let mut probability = Plane::new(3, 1, 0);
/// BackProjector::new(1)?.project(&bin, &validity, &[100, 51], &mut probability)?;
/// // Means over the seen pixels under the disc, rounded: (100 + 51) / 2 twice; the last pixel is unseen.
/// assert_eq!(probability.as_slice(), &[76, 76, 0]);
/// # Ok::<(), fingerpost_vision::backprojection::BackProjectionError>(())
/// ```
#[derive(Debug, Clone)]
pub struct BackProjector {
    /// Half widths of the disc's rows, from the top one to the bottom one, pixels.
    half_widths: Vec<usize>,
    /// For each number of seen pixels the factor that divides by twice that number.
    reciprocals: Vec<u64>,
    looked_up: Plane<u8>,
    row_sums: RowSums,
    /// Sum and number of the seen pixels under the disc, for each pixel of a row.
    under_disc: Vec<u32>,
}

impl BackProjector {
    /// A back-projector that convolves with a disc of `disc_radius_px` pixels; 0 leaves the probabilities as looked up.
    ///
    /// # Errors
    /// [`BackProjectionError::Disc`] above [`MAX_DISC_RADIUS_PX`].
    pub fn new(disc_radius_px: u16) -> Result<Self, BackProjectionError> {
        if disc_radius_px > MAX_DISC_RADIUS_PX {
            return Err(BackProjectionError::Disc { radius_px: disc_radius_px });
        }
        let radius = i32::from(disc_radius_px);
        let half_widths: Vec<usize> = (-radius..=radius)
            .map(|dy| (radius * radius - dy * dy).unsigned_abs().isqrt() as usize)
            .collect();
        let area: usize = half_widths.iter().map(|half| 2 * half + 1).sum();
        let reciprocals =
            (0..=area as u64).map(|seen| (1_u64 << RECIPROCAL_BITS).div_ceil(2 * seen.max(1))).collect();
        Ok(Self {
            half_widths,
            reciprocals,
            looked_up: Plane::default(),
            row_sums: RowSums::default(),
            under_disc: Vec::new(),
        })
    }

    /// Fills `probability` (255 is 1) from the bin index of each pixel and `lookup`, one probability a bin; pixels whose
    /// `validity` is 0 are unseen: they become 0 and count in no mean.
    ///
    /// # Errors
    /// [`BackProjectionError::Picture`] when the pictures differ in size; [`BackProjectionError::BinOutside`] when a seen
    /// pixel's bin has no entry in `lookup`.
    pub fn project(
        &mut self,
        bin: &Plane<u16>,
        validity: &Plane<u8>,
        lookup: &[u8],
        probability: &mut Plane<u8>,
    ) -> Result<(), BackProjectionError> {
        check_size("validity mask", bin.size(), validity.size())?;
        check_size("probability plane", bin.size(), probability.size())?;
        let (width, height) = bin.size();
        self.looked_up.reset(width, height, 0);
        let pixels = bin.as_slice().iter().zip(validity.as_slice());
        for (out, (&bin, &valid)) in self.looked_up.as_mut_slice().iter_mut().zip(pixels) {
            if valid != 0 {
                let count = lookup.len();
                *out = *lookup.get(usize::from(bin)).ok_or(BackProjectionError::BinOutside { bin, count })?;
            }
        }
        if self.half_widths.len() == 1 {
            probability.as_mut_slice().copy_from_slice(self.looked_up.as_slice());
            return Ok(());
        }
        self.row_sums.rebuild(self.looked_up.view(), validity.view())?;
        for y in 0..height {
            self.sum_under_disc(y);
            let (sums, _) = self.under_disc.as_chunks::<2>();
            let pixels = probability.row_mut(y).iter_mut().zip(validity.row(y));
            for ((out, &valid), &[sum, seen]) in pixels.zip(sums) {
                // Rounded mean: (2 sum + seen) / (2 seen); at most 255, since no probability is more.
                let numerator = u64::from(2 * sum + seen);
                let mean = (numerator * self.reciprocals[seen as usize]) >> RECIPROCAL_BITS;
                *out = if valid == 0 { 0 } else { mean as u8 };
            }
        }
        Ok(())
    }

    fn sum_under_disc(&mut self, y: usize) {
        let (width, height) = self.row_sums.size();
        let radius = self.half_widths.len() / 2;
        self.under_disc.clear();
        self.under_disc.resize(2 * width, 0);
        for (index, &half) in self.half_widths.iter().enumerate() {
            let Some(row) = (y + index).checked_sub(radius).filter(|&row| row < height) else { continue };
            let pairs = self.row_sums.row_pairs(row);
            // Pixel x takes the prefix sums at min(x + half + 1, width) minus those at max(x - half, 0).
            let ends = &pairs[2 * (half + 1).min(width)..];
            let (inner, beyond) = self.under_disc.split_at_mut(ends.len().min(2 * width));
            inner.iter_mut().zip(ends).for_each(|(sum, &end)| *sum += end);
            let (total, _) = pairs[2 * width..].as_chunks::<2>();
            let (beyond, _) = beyond.as_chunks_mut::<2>();
            beyond.iter_mut().for_each(|sum| *sum = [sum[0] + total[0][0], sum[1] + total[0][1]]);
            let behind = &mut self.under_disc[2 * half.min(width)..];
            behind.iter_mut().zip(pairs).for_each(|(sum, &start)| *sum -= start);
        }
    }
}

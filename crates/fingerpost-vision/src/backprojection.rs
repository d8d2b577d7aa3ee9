//! Histogram back-projection: how probable each pixel belongs to a surface, from the surface's colours.
//!
//! M. J. Swain and D. H. Ballard, "Indexing via color histograms", 1992: the surface's histogram divided by the picture's,
//! at most 1, is looked up for every pixel and convolved with a small disc. Here the convolution is the mean over those
//! pixels under the disc that are seen, so that the edge of the ground view does not darken the road beside it. Everything
//! after the look-up table is integer arithmetic.

mod disc;
mod disc_mean;
mod lookup;

use disc_mean::DiscMean;
use lookup::BinLookup;

use crate::error::{PictureError, check_size};
use crate::histogram::{Histogram, HistogramError};
use crate::picture::{Plane, ValidityMask};
use crate::simd::{CodePath, simd_kernel};

/// Largest disc, pixels: 1.6 m at 0.05 m a pixel, wider than any road detail worth keeping.
pub const MAX_DISC_RADIUS_PX: u16 = 32;

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
    lookup.resize(surface.masses().len(), 0);
    tabulate_ratios(CodePath::fastest(), surface.masses(), picture.masses(), gain, lookup);
    Ok(())
}

simd_kernel! {
    fn tabulate_ratios(surface: &[f64], picture: &[f64], gain: f64, lookup: &mut [u8]) {
        for ((out, &surface), &picture) in lookup.iter_mut().zip(surface).zip(picture) {
            let ratio = if picture > 0.0 { (gain * surface / picture).min(1.0) } else { 0.0 };
            *out = (255.0 * ratio).round() as u8;
        }
    }
}

/// Back-projection with a disc of one radius; keeps its buffers from picture to picture.
///
/// What the validity mask alone decides is worked out when it is another than the last time.
///
/// ```
/// use fingerpost_vision::{backprojection::BackProjector, picture::{Plane, ValidityMask}};
/// let bin = Plane::from_vec(3, 1, vec![0_u16, 1, 1])?;
/// let validity = ValidityMask::from_plane(Plane::from_vec(3, 1, vec![1_u8, 1, 0])?);
/// let mut probability = Plane::new(3, 1, 0);
/// BackProjector::new(1)?.project(&bin, &validity, &[100, 51], &mut probability)?;
/// // Means over the seen pixels under the disc, rounded: (100 + 51) / 2 twice; the last pixel is unseen.
/// assert_eq!(probability.as_slice(), &[76, 76, 0]);
/// # Ok::<(), fingerpost_vision::backprojection::BackProjectionError>(())
/// ```
#[derive(Debug, Clone)]
pub struct BackProjector {
    validity: ValidityMask,
    lookup: BinLookup,
    disc_mean: DiscMean,
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
        let mut disc_mean = DiscMean::new(usize::from(disc_radius_px));
        let validity = ValidityMask::default();
        disc_mean.prepare(&validity);
        Ok(Self { validity, lookup: BinLookup::new(), disc_mean })
    }

    /// Fills `probability` (255 is 1) from the bin index of each pixel and `lookup`, one probability a bin; pixels that
    /// `validity` does not show are unseen: they become 0 and count in no mean.
    ///
    /// # Errors
    /// [`BackProjectionError::Picture`] when the pictures differ in size; [`BackProjectionError::BinOutside`] when a seen
    /// pixel's bin has no entry in `lookup`.
    pub fn project(
        &mut self,
        bin: &Plane<u16>,
        validity: &ValidityMask,
        lookup: &[u8],
        probability: &mut Plane<u8>,
    ) -> Result<(), BackProjectionError> {
        self.project_on(CodePath::fastest(), bin, validity, lookup, probability)
    }

    fn project_on(
        &mut self,
        path: CodePath,
        bin: &Plane<u16>,
        validity: &ValidityMask,
        lookup: &[u8],
        probability: &mut Plane<u8>,
    ) -> Result<(), BackProjectionError> {
        check_size("validity mask", bin.size(), validity.size())?;
        check_size("probability plane", bin.size(), probability.size())?;
        if self.validity != *validity {
            self.disc_mean.prepare(validity);
            self.validity = validity.clone();
        }
        self.lookup.set(lookup);
        for y in 0..bin.height() {
            let values = self.disc_mean.row_mut(y);
            for run in validity.runs(y) {
                let bins = &bin.row(y)[run.start..run.end];
                self.lookup
                    .apply(path, bins, &mut values[run.start..run.end])
                    .map_err(|bin| BackProjectionError::BinOutside { bin, count: lookup.len() })?;
            }
        }
        self.disc_mean.take(path, probability);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values without a pattern.
    fn noise(index: usize) -> usize {
        (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23) as usize
    }

    #[test]
    fn every_path_projects_alike() {
        let (width, height) = (203, 37);
        for count in [1, 130, 1024, 5000] {
            let lookup: Vec<u8> = (0..count).map(|bin| noise(bin) as u8).collect();
            let bins = (0..width * height).map(|index| (noise(index) % count) as u16).collect();
            let bin = Plane::from_vec(width, height, bins).unwrap();
            let mut seen = Plane::new(width, height, 1);
            (0..height).for_each(|y| seen.row_mut(y)[100 - y..100 + 2 * y].fill(0));
            let validity = ValidityMask::from_plane(seen);
            for radius in [0, 1, 2, 9, 20] {
                let projected = |path| {
                    let mut probability = Plane::new(width, height, 7);
                    let mut projector = BackProjector::new(radius).unwrap();
                    projector.project_on(path, &bin, &validity, &lookup, &mut probability).unwrap();
                    probability
                };
                let expected = projected(CodePath::PORTABLE);
                for path in CodePath::available() {
                    assert_eq!(projected(path), expected, "{path:?}, {count} bins, radius {radius}");
                }
            }
        }
    }

    #[test]
    fn a_bin_outside_is_found_wherever_it_is_and_only_where_it_is_seen() {
        let mut validity = Plane::new(150, 2, 1);
        validity.row_mut(1)[149] = 0;
        let validity = ValidityMask::from_plane(validity);
        let mut projector = BackProjector::new(2).unwrap();
        let mut probability = Plane::new(150, 2, 0);
        for path in CodePath::available() {
            for place in 0..150 {
                let mut bin = Plane::new(150, 2, 999_u16);
                bin.row_mut(1)[place] = 1000;
                let lookup = [1; 1000];
                let result = projector.project_on(path, &bin, &validity, &lookup, &mut probability);
                let expected = Err(BackProjectionError::BinOutside { bin: 1000, count: 1000 });
                assert_eq!(result, if place == 149 { Ok(()) } else { expected }, "{path:?}, column {place}");
            }
        }
    }
}

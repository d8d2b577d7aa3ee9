//! Histograms of a picture's colours over hue and saturation.
//!
//! The surface model of paper 1, IV-B: a histogram of a region in front of the vehicle, averaged over a few frames (M. J.
//! Swain and D. H. Ballard, "Indexing via color histograms", 1992). Masses are `f64`, in which counts are exact.

use crate::colour::{ColourError, HueSaturationBins};
use crate::error::{PictureError, check_size};
use crate::filter::gaussian_taps;
use crate::picture::PlaneView;
use crate::span::SpanMask;

/// A histogram that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HistogramError {
    /// The numbers of bins cannot be used.
    #[error(transparent)]
    Bins(#[from] ColourError),
    /// Pictures whose sizes do not fit.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A bin index that the histogram does not have.
    #[error(
        "the picture holds bin {bin}, but the histogram has {count} bins; use one division into bins for both"
    )]
    BinOutside {
        /// Bin index found.
        bin: u16,
        /// Number of bins.
        count: usize,
    },
    /// Histograms over different bins cannot be combined.
    #[error("histograms over {left:?} and {right:?} cannot be combined; use one division into bins for all")]
    BinsDiffer {
        /// Bins of the first.
        left: HueSaturationBins,
        /// Bins of the other.
        right: HueSaturationBins,
    },
    /// A width of smoothing that makes no sense.
    #[error("smoothing by {sigma_bins} bins is not possible; give 0 (none) to {MAX_SIGMA_BINS}")]
    Sigma {
        /// Standard deviation asked for, bins.
        sigma_bins: f64,
    },
}

/// Widest smoothing, bins: a wider one would leave nothing of 180 hues' order.
pub const MAX_SIGMA_BINS: f64 = 60.0;
/// Standard deviations to either side at which the Gaussian is cut off; what lies beyond is below 0.3 % of it.
const REACH_SIGMAS: f64 = 3.0;

/// A mass for every bin of hue and saturation.
///
/// ```
/// use fingerpost_vision::{colour::HueSaturationBins, histogram::Histogram, picture::{Plane, Rect}, span::SpanMask};
/// let bin = Plane::from_vec(3, 1, vec![0_u16, 3, 3])?;
/// let validity = Plane::new(3, 1, 1);
/// let mut histogram = Histogram::new(HueSaturationBins { hue: 2, saturation: 2 })?;
/// let region = SpanMask::from_rect(Rect { x: 0, y: 0, width: 3, height: 1 });
/// histogram.count(bin.view(), validity.view(), &region)?;
/// assert_eq!(histogram.masses(), &[1.0, 0.0, 0.0, 2.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    bins: HueSaturationBins,
    masses: Vec<f64>,
}

impl Histogram {
    /// An empty histogram.
    ///
    /// # Errors
    /// [`HistogramError::Bins`] when the numbers of bins cannot be used.
    pub fn new(bins: HueSaturationBins) -> Result<Self, HistogramError> {
        bins.check()?;
        Ok(Self { bins, masses: vec![0.0; bins.count()] })
    }

    /// The division into bins.
    #[must_use]
    pub fn bins(&self) -> HueSaturationBins {
        self.bins
    }

    /// The mass of each bin, by bin index.
    #[must_use]
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Sum of all masses; the number of pixels after counting, 1 after [`Histogram::normalise`].
    #[must_use]
    pub fn total(&self) -> f64 {
        self.masses.iter().sum()
    }

    /// Empties the histogram, keeping its memory.
    pub fn clear(&mut self) {
        self.masses.fill(0.0);
    }

    /// Adds 1 to the bin of every pixel of `bin` that is valid (not 0) and inside `region`; the part of the region
    /// outside the picture counts for nothing.
    ///
    /// # Errors
    /// [`HistogramError::Picture`] when the two pictures differ in size; [`HistogramError::BinOutside`] when a pixel's
    /// bin is not one of the histogram's, the pixels before it being counted.
    pub fn count(
        &mut self,
        bin: PlaneView<'_, u16>,
        validity: PlaneView<'_, u8>,
        region: &SpanMask,
    ) -> Result<(), HistogramError> {
        check_size("validity mask", bin.size(), validity.size())?;
        let (width, height) = bin.size();
        for span in region.spans() {
            let Ok(row) = usize::try_from(span.row) else { continue };
            let start = usize::try_from(span.start).unwrap_or(0).min(width);
            let end = usize::try_from(span.end).unwrap_or(0).min(width);
            if row >= height || start >= end {
                continue;
            }
            for (&bin, &valid) in bin.row(row)[start..end].iter().zip(&validity.row(row)[start..end]) {
                if valid == 0 {
                    continue;
                }
                let count = self.masses.len();
                let mass =
                    self.masses.get_mut(usize::from(bin)).ok_or(HistogramError::BinOutside { bin, count })?;
                *mass += 1.0;
            }
        }
        Ok(())
    }

    /// Scales the masses to a sum of 1; an empty histogram stays empty.
    pub fn normalise(&mut self) {
        let total = self.total();
        if total > 0.0 {
            self.masses.iter_mut().for_each(|mass| *mass /= total);
        }
    }

    /// Mean of several histograms, bin by bin, or `None` of none.
    ///
    /// # Errors
    /// [`HistogramError::BinsDiffer`] when they are over different bins.
    pub fn mean_of<'a>(
        histograms: impl IntoIterator<Item = &'a Self>,
    ) -> Result<Option<Self>, HistogramError> {
        let mut histograms = histograms.into_iter();
        let Some(mut mean) = histograms.next().cloned() else { return Ok(None) };
        let mut count = 1.0;
        for other in histograms {
            mean.check_same_bins(other)?;
            mean.masses.iter_mut().zip(&other.masses).for_each(|(sum, mass)| *sum += mass);
            count += 1.0;
        }
        mean.masses.iter_mut().for_each(|mass| *mass /= count);
        Ok(Some(mean))
    }

    /// Spreads each bin's mass over its neighbours by Gaussians with the given standard deviations in bins, round the
    /// circle in hue and reflected at the ends in saturation, so that the total stays; 0 leaves a direction as it is.
    ///
    /// # Errors
    /// [`HistogramError::Sigma`] when a standard deviation is not 0 to [`MAX_SIGMA_BINS`].
    pub fn smooth(&mut self, hue_sigma_bins: f64, saturation_sigma_bins: f64) -> Result<(), HistogramError> {
        for sigma_bins in [hue_sigma_bins, saturation_sigma_bins] {
            // Written so that NaN is refused.
            if !(0.0..=MAX_SIGMA_BINS).contains(&sigma_bins) {
                return Err(HistogramError::Sigma { sigma_bins });
            }
        }
        let (hues, saturations) = (usize::from(self.bins.hue), usize::from(self.bins.saturation));
        self.spread(hue_sigma_bins, |index, offset| {
            let hue = (index / saturations) as isize + offset;
            hue.rem_euclid(hues as isize) as usize * saturations + index % saturations
        });
        self.spread(saturation_sigma_bins, |index, offset| {
            let saturation = reflect((index % saturations) as isize + offset, saturations);
            index / saturations * saturations + saturation
        });
        Ok(())
    }

    fn spread(&mut self, sigma_bins: f64, neighbour: impl Fn(usize, isize) -> usize) {
        if sigma_bins <= 0.0 {
            return;
        }
        let radius = (REACH_SIGMAS * sigma_bins).ceil() as usize;
        let taps = gaussian_taps(sigma_bins, radius);
        let mut spread = vec![0.0; self.masses.len()];
        for (index, &mass) in self.masses.iter().enumerate() {
            if mass > 0.0 {
                for (tap, &weight) in taps.iter().enumerate() {
                    spread[neighbour(index, tap as isize - radius as isize)] += mass * weight;
                }
            }
        }
        self.masses = spread;
    }

    pub(crate) fn check_same_bins(&self, other: &Self) -> Result<(), HistogramError> {
        if self.bins == other.bins {
            Ok(())
        } else {
            Err(HistogramError::BinsDiffer { left: self.bins, right: other.bins })
        }
    }
}

/// Folds an index back into `0..length` by mirrors before the first and behind the last element.
fn reflect(index: isize, length: usize) -> usize {
    let folded = index.rem_euclid(2 * length as isize) as usize;
    if folded < length { folded } else { 2 * length - 1 - folded }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Plane, Rect};
    use crate::span::Span;

    const BINS: HueSaturationBins = HueSaturationBins { hue: 6, saturation: 4 };

    fn single(bin: usize) -> Histogram {
        let mut histogram = Histogram::new(BINS).unwrap();
        histogram.masses[bin] = 8.0;
        histogram
    }

    #[test]
    fn only_valid_pixels_inside_region_and_picture_count() {
        let bin = Plane::from_vec(4, 2, vec![0_u16, 1, 2, 3, 4, 5, 6, 7]).unwrap();
        let mut validity = Plane::new(4, 2, 1_u8);
        validity.row_mut(1)[2] = 0;
        let region = SpanMask::from_spans(vec![
            Span { row: -1, start: 0, end: 4 },
            Span { row: 0, start: -5, end: 1 },
            Span { row: 1, start: 1, end: 9 },
            Span { row: 2, start: 0, end: 4 },
        ]);
        let mut histogram = Histogram::new(BINS).unwrap();
        histogram.count(bin.view(), validity.view(), &region).unwrap();
        let counted: Vec<usize> = (0..24).filter(|&bin| histogram.masses()[bin] > 0.0).collect();
        assert_eq!(counted, vec![0, 5, 7]);
        histogram.normalise();
        assert!((histogram.total() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn smoothing_keeps_the_total_and_wraps_in_hue_only() {
        let mut histogram = single(0);
        histogram.smooth(0.8, 0.0).unwrap();
        assert!((histogram.total() - 8.0).abs() < 1e-12);
        // Hue bins 1 and 5 are both neighbours of hue bin 0; saturation stays.
        assert!(histogram.masses()[4] > 0.5);
        assert!((histogram.masses()[4] - histogram.masses()[20]).abs() < 1e-12);
        assert!(histogram.masses()[1] <= 0.0);
        let mut histogram = single(0);
        histogram.smooth(0.0, 0.8).unwrap();
        assert!((histogram.total() - 8.0).abs() < 1e-12);
        assert!(histogram.masses()[1] > 0.5 && histogram.masses()[3] < histogram.masses()[1]);
        assert!(histogram.masses()[4] <= 0.0);
    }

    #[test]
    fn the_mean_is_taken_bin_by_bin() {
        let mean = Histogram::mean_of([&single(3), &single(5)]).unwrap().unwrap();
        assert!((mean.masses()[3] - 4.0).abs() < 1e-12 && (mean.masses()[5] - 4.0).abs() < 1e-12);
        assert!(Histogram::mean_of([]).unwrap().is_none());
    }

    #[test]
    fn bad_input_is_an_error() {
        assert!(Histogram::new(HueSaturationBins { hue: 0, saturation: 4 }).is_err());
        assert!(Histogram::new(HueSaturationBins { hue: 181, saturation: 4 }).is_err());
        let mut histogram = single(0);
        for sigma_bins in [-1.0, f64::NAN, 1e9] {
            assert!(matches!(histogram.smooth(sigma_bins, 0.0), Err(HistogramError::Sigma { .. })));
        }
        let bin = Plane::new(2, 2, 24_u16);
        let region = SpanMask::from_rect(Rect { x: 0, y: 0, width: 2, height: 2 });
        assert!(matches!(
            histogram.count(bin.view(), Plane::new(2, 2, 1).view(), &region),
            Err(HistogramError::BinOutside { bin: 24, count: 24 })
        ));
        assert!(histogram.count(bin.view(), Plane::new(2, 1, 1).view(), &region).is_err());
        let other = Histogram::new(HueSaturationBins { hue: 4, saturation: 6 }).unwrap();
        assert!(matches!(Histogram::mean_of([&histogram, &other]), Err(HistogramError::BinsDiffer { .. })));
    }
}

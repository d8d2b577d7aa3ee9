//! Histograms of a picture's colours over hue and saturation.
//!
//! The surface model of paper 1, IV-B: a histogram of a region in front of the vehicle, averaged over a few frames (M. J.
//! Swain and D. H. Ballard, "Indexing via color histograms", 1992). Masses are `f64`, in which counts are exact.
//!
//! A [`BinCounter`] counts pixels into a [`Histogram`], a [`Smoothing`] spreads its masses; both keep their buffers, so that
//! a frame needs no new memory.

mod counter;
mod smoothing;

pub use counter::BinCounter;
pub use smoothing::{MAX_SIGMA_BINS, Smoothing};

use crate::colour::{ColourError, HueSaturationBins};
use crate::error::PictureError;
use crate::picture::check_length;

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

/// A mass for every bin of hue and saturation. `clone_from` reuses the memory.
///
/// ```
/// use fingerpost_vision::{colour::HueSaturationBins, histogram::{BinCounter, Histogram}};
/// use fingerpost_vision::{picture::{Plane, Rect, ValidityMask}, span::SpanMask};
/// let bin = Plane::from_vec(3, 1, vec![0_u16, 3, 3])?;
/// let bins = HueSaturationBins { hue: 2, saturation: 2 };
/// let mut histogram = Histogram::new(bins)?;
/// let region = SpanMask::from_rect(Rect { x: 0, y: 0, width: 3, height: 1 });
/// BinCounter::default().count(bin.view(), &ValidityMask::all_seen(3, 1), &region, &mut histogram)?;
/// assert_eq!(histogram.masses(), &[1.0, 0.0, 0.0, 2.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, PartialEq)]
pub struct Histogram {
    bins: HueSaturationBins,
    masses: Vec<f64>,
}

impl Clone for Histogram {
    fn clone(&self) -> Self {
        Self { bins: self.bins, masses: self.masses.clone() }
    }

    fn clone_from(&mut self, source: &Self) {
        self.bins = source.bins;
        self.masses.clone_from(&source.masses);
    }
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

    /// A histogram with these masses, by bin index.
    ///
    /// # Errors
    /// [`HistogramError::Bins`] when the numbers of bins cannot be used; [`HistogramError::Picture`] when there is not one mass
    /// for each.
    pub fn from_masses(bins: HueSaturationBins, masses: Vec<f64>) -> Result<Self, HistogramError> {
        bins.check()?;
        check_length(usize::from(bins.saturation), usize::from(bins.hue), 1, masses.len())?;
        Ok(Self { bins, masses })
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

    /// Scales the masses to a sum of 1; an empty histogram stays empty.
    pub fn normalise(&mut self) {
        let total = self.total();
        if total > 0.0 {
            self.masses.iter_mut().for_each(|mass| *mass /= total);
        }
    }

    /// Moves each mass by `share` (0 to 1) of the way to that of `other`; a histogram over other bins changes nothing.
    pub fn blend(&mut self, other: &Self, share: f64) {
        if self.bins == other.bins {
            self.masses
                .iter_mut()
                .zip(&other.masses)
                .for_each(|(mass, other)| *mass += share * (other - *mass));
        }
    }

    /// Sets each bin to the mean of its masses in several histograms; of none the mean is empty.
    ///
    /// # Errors
    /// [`HistogramError::BinsDiffer`] when one is over other bins, those before it being added up.
    pub fn set_to_mean<'a>(
        &mut self,
        histograms: impl IntoIterator<Item = &'a Self>,
    ) -> Result<(), HistogramError> {
        self.clear();
        let mut count = 0.0;
        for other in histograms {
            self.check_same_bins(other)?;
            self.masses.iter_mut().zip(&other.masses).for_each(|(sum, mass)| *sum += mass);
            count += 1.0;
        }
        if count > 0.0 {
            self.masses.iter_mut().for_each(|mass| *mass /= count);
        }
        Ok(())
    }

    pub(crate) fn check_same_bins(&self, other: &Self) -> Result<(), HistogramError> {
        if self.bins == other.bins {
            Ok(())
        } else {
            Err(HistogramError::BinsDiffer { left: self.bins, right: other.bins })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINS: HueSaturationBins = HueSaturationBins { hue: 6, saturation: 4 };

    fn single(bin: usize) -> Histogram {
        let mut histogram = Histogram::new(BINS).unwrap();
        histogram.masses[bin] = 8.0;
        histogram
    }

    #[test]
    fn the_mean_is_taken_bin_by_bin() {
        let mut mean = single(2);
        mean.set_to_mean([&single(3), &single(5)]).unwrap();
        assert!((mean.masses()[3] - 4.0).abs() < 1e-12 && (mean.masses()[5] - 4.0).abs() < 1e-12);
        assert!((mean.total() - 8.0).abs() < 1e-12);
        mean.normalise();
        assert!((mean.masses()[3] - 0.5).abs() < 1e-12);
        mean.set_to_mean([]).unwrap();
        mean.normalise();
        assert!(mean.total() <= 0.0);
    }

    #[test]
    fn masses_are_taken_over_and_blended() {
        let mut histogram = Histogram::from_masses(BINS, vec![1.0; 24]).unwrap();
        histogram.blend(&single(2), 0.25);
        assert!((histogram.masses()[2] - 2.75).abs() < 1e-12 && (histogram.masses()[3] - 0.75).abs() < 1e-12);
        histogram.blend(&Histogram::new(HueSaturationBins { hue: 4, saturation: 6 }).unwrap(), 0.5);
        assert!((histogram.masses()[3] - 0.75).abs() < 1e-12, "other bins");
        assert!(Histogram::from_masses(BINS, vec![1.0; 23]).is_err());
    }

    #[test]
    fn bins_that_cannot_be_used_are_errors() {
        assert!(Histogram::new(HueSaturationBins { hue: 0, saturation: 4 }).is_err());
        assert!(Histogram::new(HueSaturationBins { hue: 181, saturation: 4 }).is_err());
        let other = Histogram::new(HueSaturationBins { hue: 4, saturation: 6 }).unwrap();
        assert!(matches!(
            single(0).set_to_mean([&single(1), &other]),
            Err(HistogramError::BinsDiffer { .. })
        ));
        let mut histogram = other.clone();
        histogram.clone_from(&single(0));
        assert_eq!(histogram, single(0));
    }
}

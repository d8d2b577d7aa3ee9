//! Spreading the masses of a histogram over neighbouring bins.

use super::{Histogram, HistogramError};
use crate::colour::HueSaturationBins;
use crate::filter::gaussian_taps;
use crate::simd::{CodePath, simd_kernel};

/// Widest smoothing, bins: a wider one would leave nothing of 180 hues' order.
pub const MAX_SIGMA_BINS: f64 = 60.0;
/// Standard deviations to either side at which the Gaussian is cut off; what lies beyond is below 0.3 % of it.
const REACH_SIGMAS: f64 = 3.0;

/// Spreads each bin's mass over its neighbours by Gaussians, round the circle in hue and reflected at the ends in saturation,
/// so that the total stays. Keeps its buffers from histogram to histogram.
///
/// ```
/// use fingerpost_vision::{colour::HueSaturationBins, histogram::{BinCounter, Histogram, Smoothing}};
/// use fingerpost_vision::{picture::{Plane, Rect, ValidityMask}, span::SpanMask};
/// let bins = HueSaturationBins { hue: 4, saturation: 1 };
/// let (mut histogram, region) = (Histogram::new(bins)?, Rect { x: 0, y: 0, width: 1, height: 1 });
/// let pixel = Plane::new(1, 1, 0_u16);
/// let (seen, region) = (ValidityMask::all_seen(1, 1), SpanMask::from_rect(region));
/// BinCounter::default().count(pixel.view(), &seen, &region, &mut histogram)?;
/// Smoothing::new(bins, 0.3, 0.0)?.apply(&mut histogram)?;
/// // Of a whole pixel in hue bin 0 the neighbours on the circle, bins 1 and 3, get a little.
/// let masses = histogram.masses();
/// assert!(masses[0] > 0.98 && masses[1] > 0.003 && masses[3] == masses[1] && masses[2] == 0.0);
/// # Ok::<(), fingerpost_vision::histogram::HistogramError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Smoothing {
    bins: HueSaturationBins,
    hue: Spread,
    saturation: Spread,
    /// The masses, hue by hue or saturation by saturation.
    masses: Vec<f64>,
    spread: Vec<f64>,
}

/// How the rows of a table spread to other rows.
#[derive(Debug, Clone)]
struct Spread {
    weights: Vec<f64>,
    /// For each row and each weight the row that gets that share of it.
    targets: Vec<usize>,
}

impl Spread {
    fn new(sigma_bins: f64, rows: u16, fold: impl Fn(isize, isize) -> isize) -> Result<Self, HistogramError> {
        // Written so that NaN is refused.
        if !(0.0..=MAX_SIGMA_BINS).contains(&sigma_bins) {
            return Err(HistogramError::Sigma { sigma_bins });
        }
        let radius = (REACH_SIGMAS * sigma_bins).ceil() as isize;
        let weights = gaussian_taps(sigma_bins, radius.unsigned_abs());
        let rows = isize::try_from(rows).unwrap_or(1);
        let targets = (0..rows)
            .flat_map(|row| (-radius..=radius).map(move |offset| row + offset))
            .map(|row| fold(row, rows).unsigned_abs())
            .collect();
        Ok(Self { weights, targets })
    }
}

impl Smoothing {
    /// A smoothing of histograms over `bins` with the given standard deviations in bins; 0 leaves a direction as it is.
    ///
    /// # Errors
    /// [`HistogramError::Bins`] when the numbers of bins cannot be used; [`HistogramError::Sigma`] when a standard deviation
    /// is not 0 to [`MAX_SIGMA_BINS`].
    pub fn new(
        bins: HueSaturationBins,
        hue_sigma_bins: f64,
        saturation_sigma_bins: f64,
    ) -> Result<Self, HistogramError> {
        bins.check()?;
        let on_circle = |row: isize, rows: isize| row.rem_euclid(rows);
        // Mirrors before the first and behind the last row.
        let reflected = |row: isize, rows: isize| {
            let folded = row.rem_euclid(2 * rows);
            folded.min(2 * rows - 1 - folded)
        };
        Ok(Self {
            bins,
            hue: Spread::new(hue_sigma_bins, bins.hue, on_circle)?,
            saturation: Spread::new(saturation_sigma_bins, bins.saturation, reflected)?,
            masses: vec![0.0; bins.count()],
            spread: vec![0.0; bins.count()],
        })
    }

    /// Smooths `histogram`.
    ///
    /// # Errors
    /// [`HistogramError::BinsDiffer`] when it is over other bins.
    pub fn apply(&mut self, histogram: &mut Histogram) -> Result<(), HistogramError> {
        self.apply_on(CodePath::fastest(), histogram)
    }

    fn apply_on(&mut self, path: CodePath, histogram: &mut Histogram) -> Result<(), HistogramError> {
        if self.bins != histogram.bins {
            return Err(HistogramError::BinsDiffer { left: self.bins, right: histogram.bins });
        }
        let (hues, saturations) = (usize::from(self.bins.hue), usize::from(self.bins.saturation));
        spread_rows(path, &self.hue, &histogram.masses, &mut self.spread);
        transpose(&self.spread, saturations, &mut self.masses);
        spread_rows(path, &self.saturation, &self.masses, &mut self.spread);
        transpose(&self.spread, hues, &mut histogram.masses);
        Ok(())
    }
}

simd_kernel! {
    /// Spreads the rows of a table of masses; shares are added in the order of the rows they come from.
    fn spread_rows(spread: &Spread, masses: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let columns = masses.len() * spread.weights.len() / spread.targets.len();
        let targets = spread.targets.chunks_exact(spread.weights.len());
        for (masses, targets) in masses.chunks_exact(columns).zip(targets) {
            for (&target, &weight) in targets.iter().zip(&spread.weights) {
                let out = &mut out[target * columns..(target + 1) * columns];
                out.iter_mut().zip(masses).for_each(|(sum, &mass)| *sum += mass * weight);
            }
        }
    }
}

/// Makes the columns of a table with `columns` columns the rows of another.
fn transpose(table: &[f64], columns: usize, transposed: &mut [f64]) {
    let rows = table.len() / columns;
    for (column, out) in transposed.chunks_exact_mut(rows).enumerate() {
        out.iter_mut().zip(table[column..].iter().step_by(columns)).for_each(|(out, &value)| *out = value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINS: HueSaturationBins = HueSaturationBins { hue: 6, saturation: 4 };

    fn smoothed(bin: usize, hue_sigma_bins: f64, saturation_sigma_bins: f64) -> Histogram {
        let mut histogram = Histogram::new(BINS).unwrap();
        histogram.masses[bin] = 8.0;
        Smoothing::new(BINS, hue_sigma_bins, saturation_sigma_bins).unwrap().apply(&mut histogram).unwrap();
        histogram
    }

    #[test]
    fn smoothing_keeps_the_total_and_wraps_in_hue_only() {
        let histogram = smoothed(0, 0.8, 0.0);
        assert!((histogram.total() - 8.0).abs() < 1e-12);
        // Hue bins 1 and 5 are both neighbours of hue bin 0; saturation stays.
        assert!(histogram.masses()[4] > 0.5);
        assert!((histogram.masses()[4] - histogram.masses()[20]).abs() < 1e-12);
        assert!(histogram.masses()[1] <= 0.0);
        let histogram = smoothed(0, 0.0, 0.8);
        assert!((histogram.total() - 8.0).abs() < 1e-12);
        assert!(histogram.masses()[1] > 0.5 && histogram.masses()[3] < histogram.masses()[1]);
        assert!(histogram.masses()[4] <= 0.0);
    }

    #[test]
    fn every_path_spreads_like_the_plain_sum() {
        for (bins, sigmas) in [
            (HueSaturationBins { hue: 32, saturation: 32 }, [1.2, 1.2]),
            (HueSaturationBins { hue: 7, saturation: 3 }, [5.0, 60.0]),
            (HueSaturationBins { hue: 1, saturation: 1 }, [0.4, 2.0]),
        ] {
            let mut histogram = Histogram::new(bins).unwrap();
            let noise = |index: usize| ((index * index * 7919) % 97) as f64;
            histogram.masses.iter_mut().enumerate().for_each(|(index, mass)| *mass = noise(index));
            let expected = plain(&histogram, sigmas);
            let mut smoothing = Smoothing::new(bins, sigmas[0], sigmas[1]).unwrap();
            for path in CodePath::available() {
                let mut found = histogram.clone();
                smoothing.apply_on(path, &mut found).unwrap();
                let bits = |masses: &[f64]| masses.iter().map(|mass| mass.to_bits()).collect::<Vec<u64>>();
                assert_eq!(bits(&found.masses), bits(&expected), "{path:?}, {bins:?}");
            }
        }
    }

    /// Every bin's shares added to its neighbours', bin by bin.
    fn plain(histogram: &Histogram, sigmas: [f64; 2]) -> Vec<f64> {
        let (hues, saturations) =
            (usize::from(histogram.bins.hue) as isize, usize::from(histogram.bins.saturation) as isize);
        let mut masses = histogram.masses.clone();
        for (axis, sigma) in sigmas.into_iter().enumerate() {
            let radius = (REACH_SIGMAS * sigma).ceil() as isize;
            let weights = gaussian_taps(sigma, radius as usize);
            let mut spread = vec![0.0; masses.len()];
            for (index, mass) in masses.iter().enumerate() {
                for offset in -radius..=radius {
                    let (mut hue, mut saturation) =
                        (index as isize / saturations, index as isize % saturations);
                    if axis == 0 {
                        hue = (hue + offset).rem_euclid(hues);
                    } else {
                        saturation = (saturation + offset).rem_euclid(2 * saturations);
                        saturation = saturation.min(2 * saturations - 1 - saturation);
                    }
                    spread[(hue * saturations + saturation) as usize] +=
                        mass * weights[(offset + radius) as usize];
                }
            }
            masses = spread;
        }
        masses
    }

    #[test]
    fn bad_input_is_an_error() {
        for sigma_bins in [-1.0, f64::NAN, 1e9] {
            for [hue, saturation] in [[sigma_bins, 0.0], [0.0, sigma_bins]] {
                let refused = Smoothing::new(BINS, hue, saturation);
                assert!(matches!(refused, Err(HistogramError::Sigma { .. })));
            }
        }
        assert!(Smoothing::new(HueSaturationBins { hue: 6, saturation: 0 }, 1.0, 1.0).is_err());
        let mut other = Histogram::new(HueSaturationBins { hue: 4, saturation: 6 }).unwrap();
        let refused = Smoothing::new(BINS, 1.0, 1.0).unwrap().apply(&mut other);
        assert!(matches!(refused, Err(HistogramError::BinsDiffer { .. })));
    }
}

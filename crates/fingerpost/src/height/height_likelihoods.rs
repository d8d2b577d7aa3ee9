//! Log-likelihoods of each height at each place of the view, by a sweep's correlations.

use fingerpost_vision::parallax::{LikelihoodLines, NOT_SEEN, log_likelihoods};
use fingerpost_vision::picture::Plane;

use super::height_map::{HEIGHTS, height_m};
use super::sweep::{Correlations, SWEPT_ROWS};
use super::texture_noise::{EXPECTED, ExpectedCorrelation, log_likelihood_ratio_by_r};

/// Units of a height's log-likelihood.
pub(super) const UNIT: f32 = 8.0;
/// Pairs of a window's cells that are independent witnesses, over the cells of the map that a window covers.
const WITNESSES: f32 = 1.0;

/// The log-likelihoods, in rows as far apart as the swept ones.
#[derive(Debug)]
pub(super) struct HeightLikelihoods {
    columns: usize,
    rows: usize,
    /// Those of the lowest height first.
    of_heights: Vec<i8>,
    offset: Plane<f32>,
    slope: Plane<f32>,
    /// At a correlation of 0, and for each more, by the correlation that is expected.
    by_expected: [[f32; 2]; EXPECTED],
}

impl Default for HeightLikelihoods {
    fn default() -> Self {
        let by_expected = std::array::from_fn(|expected| {
            log_likelihood_ratio_by_r(expected as f32 / EXPECTED as f32).map(|ratio| UNIT * WITNESSES * ratio)
        });
        Self {
            columns: 0,
            rows: 0,
            of_heights: Vec::new(),
            offset: Plane::default(),
            slope: Plane::default(),
            by_expected,
        }
    }
}

impl HeightLikelihoods {
    /// Takes in the scales of the windows of the view, and so what correlation is expected of each.
    pub(super) fn expect(&mut self, of_window: &ExpectedCorrelation, scales: &Plane<f32>) {
        let rows = SWEPT_ROWS.of(scales.height());
        (self.columns, self.rows) = (scales.width(), rows.len());
        for lines in [&mut self.offset, &mut self.slope] {
            if lines.size() != (self.columns, self.rows) {
                lines.reset(self.columns, self.rows, 0.0);
            }
        }
        for (line, row) in rows.enumerate() {
            let (offset, slope) = (self.offset.row_mut(line), self.slope.row_mut(line));
            for ((offset, slope), &scale) in offset.iter_mut().zip(slope).zip(scales.row(row)) {
                let expected = self.by_expected.get(usize::from(of_window.of(scale)));
                [*offset, *slope] = expected.copied().unwrap_or_default();
            }
        }
    }

    /// Takes in the correlations of every height; whether the sweep has them all.
    pub(super) fn update<'a>(&mut self, at_height: impl Fn(f64) -> Option<Correlations<'a>>) -> bool {
        self.of_heights.resize(HEIGHTS * self.columns * self.rows, NOT_SEEN);
        if self.of_heights.is_empty() {
            return false;
        }
        let Self { columns, rows, of_heights, offset, slope, .. } = self;
        for (height, out) in of_heights.chunks_exact_mut(*columns * *rows).enumerate() {
            let Some(Correlations { below, above, share }) = at_height(height_m(height)) else {
                return false;
            };
            for (line, out) in out.chunks_exact_mut(*columns).enumerate() {
                let row = SWEPT_ROWS.first + line * SWEPT_ROWS.step;
                let lines = LikelihoodLines { offset: offset.row(line), slope: slope.row(line) };
                log_likelihoods([below.row(row), above.row(row)], share, lines, out);
            }
        }
        true
    }

    /// Those of each height, the lowest first.
    pub(super) fn of_heights(&self) -> impl Iterator<Item = OfHeight<'_>> {
        let heights = self.of_heights.chunks_exact((self.columns * self.rows).max(1));
        heights.map(|places| OfHeight { places, columns: self.columns })
    }
}

/// Those of one height.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfHeight<'a> {
    places: &'a [i8],
    columns: usize,
}

impl OfHeight<'_> {
    /// At a place of the view, whose column is one of it; none where nothing is seen.
    #[inline]
    pub(super) fn at(&self, column: usize, row: usize) -> Option<i8> {
        let log_likelihood = *self.places.get(row / SWEPT_ROWS.step * self.columns + column)?;
        (log_likelihood != NOT_SEEN).then_some(log_likelihood)
    }
}

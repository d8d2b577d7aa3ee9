//! Correlations of two views over small windows, one shifted against the other.

use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Half the sides of a window, cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HalfWindow {
    /// Columns to each side.
    pub columns: usize,
    /// Rows above and below.
    pub rows: usize,
}

impl HalfWindow {
    /// Cells of a whole window.
    #[must_use]
    pub const fn cells(self) -> usize {
        (2 * self.columns + 1) * (2 * self.rows + 1)
    }
}

/// Every so many rows, from one of them on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows {
    /// The first.
    pub first: usize,
    /// How many rows on the next one is, at least 1.
    pub step: usize,
}

impl Rows {
    /// All rows.
    pub const ALL: Self = Self { first: 0, step: 1 };

    /// Those of them that a view of this height has.
    pub fn of(self, height: usize) -> impl ExactSizeIterator<Item = usize> {
        (self.first..height).step_by(self.step.max(1))
    }

    fn contain(self, row: usize) -> bool {
        row.checked_sub(self.first).is_some_and(|rows| rows.is_multiple_of(self.step.max(1)))
    }
}

/// Sums over windows, with their memory.
#[derive(Debug, Default)]
pub struct Correlation {
    /// Sums along the columns, with a window's half at each side.
    columns: Vec<i32>,
    across: Vec<i32>,
}

impl Correlation {
    /// One over the root of the sum of squares in each window of `detrended`; 0 where its mean square is at most `noise` (square
    /// steps).
    pub fn scales(
        &mut self,
        detrended: &Plane<i16>,
        window: HalfWindow,
        noise: f32,
        scales: &mut Plane<f32>,
    ) {
        let (width, height) = detrended.size();
        if scales.size() != (width, height) {
            scales.reset(width, height, 0.0);
        }
        let least = noise * window.cells() as f32;
        self.sums(detrended, detrended, [0, 0], (window, Rows::ALL), |path, row, sums| {
            scale_row(path, sums, least, scales.row_mut(row));
        });
    }

    /// The correlation, -1 to 1, of each place's window in `view` with that in `other` `shift` rows farther up and columns farther
    /// left, both detrended and of one size; 0 where either has no scale. Only `rows` of `correlation` are written.
    pub fn at_shift(
        &mut self,
        (view, scales): (&Plane<i16>, &Plane<f32>),
        (other, other_scales): (&Plane<i16>, &Plane<f32>),
        [up, left]: [isize; 2],
        (window, rows): (HalfWindow, Rows),
        correlation: &mut Plane<f32>,
    ) {
        let (width, height) = view.size();
        if correlation.size() != (width, height) {
            correlation.reset(width, height, 0.0);
        }
        if [other.size(), scales.size(), other_scales.size()] != [view.size(); 3] {
            correlation.as_mut_slice().fill(0.0);
            return;
        }
        self.sums(view, other, [up, left], (window, rows), |path, row, sums| {
            let out = correlation.row_mut(row);
            out.fill(0.0);
            let Some(other_row) = row.checked_add_signed(-up).filter(|&row| row < height) else { return };
            let (to, from) = overlap(width, left);
            let count = width - to.max(from);
            correlate_row(
                path,
                &sums[to..to + count],
                &scales.row(row)[to..to + count],
                &other_scales.row(other_row)[from..from + count],
                &mut out[to..to + count],
            );
        });
    }

    /// Calls `finish` with the sums of products over the windows of each of `rows`.
    fn sums(
        &mut self,
        view: &Plane<i16>,
        other: &Plane<i16>,
        [up, left]: [isize; 2],
        (window, rows): (HalfWindow, Rows),
        mut finish: impl FnMut(CodePath, usize, &[i32]),
    ) {
        let (width, height) = view.size();
        let path = CodePath::fastest();
        self.columns.clear();
        self.columns.resize(width + 2 * window.columns, 0);
        self.across.clear();
        self.across.resize(width, 0);
        let (to, from) = overlap(width, left);
        let count = width - to.max(from);
        let products = |row: usize| {
            let other_row = row.checked_add_signed(-up).filter(|&row| row < height)?;
            Some((&view.row(row)[to..to + count], &other.row(other_row)[from..from + count]))
        };
        let first = window.columns + to;
        for row in 0..height + window.rows {
            if row < height
                && let Some((a, b)) = products(row)
            {
                add_products(path, a, b, 1, &mut self.columns[first..first + count]);
            }
            if row < window.rows {
                continue;
            }
            let middle = row - window.rows;
            if middle > window.rows
                && let Some((a, b)) = products(middle - window.rows - 1)
            {
                add_products(path, a, b, -1, &mut self.columns[first..first + count]);
            }
            if rows.contain(middle) {
                sum_across(path, &self.columns, window.columns, &mut self.across);
                finish(path, middle, &self.across);
            }
        }
    }
}

/// Where a row begins to have a partner `left` columns farther left, and where that one's row does.
const fn overlap(width: usize, left: isize) -> (usize, usize) {
    let by = left.unsigned_abs();
    let by = if by < width { by } else { width };
    if left >= 0 { (by, 0) } else { (0, by) }
}

simd_kernel! {
    pub(super) fn add_products(a: &[i16], b: &[i16], sign: i32, sums: &mut [i32]) {
        for ((a, b), sum) in a.iter().zip(b).zip(sums) {
            *sum += sign * i32::from(*a) * i32::from(*b);
        }
    }
}

simd_kernel! {
    pub(super) fn sum_across(columns: &[i32], half: usize, out: &mut [i32]) {
        let width = out.len();
        out.copy_from_slice(&columns[..width]);
        for start in 1..=2 * half {
            for (out, column) in out.iter_mut().zip(&columns[start..start + width]) {
                *out += *column;
            }
        }
    }
}

simd_kernel! {
    pub(super) fn scale_row(sums: &[i32], least: f32, out: &mut [f32]) {
        for (sum, out) in sums.iter().zip(out) {
            let sum = *sum as f32;
            *out = if sum > least { 1.0 / sum.sqrt() } else { 0.0 };
        }
    }
}

simd_kernel! {
    pub(super) fn correlate_row(sums: &[i32], scales: &[f32], other: &[f32], out: &mut [f32]) {
        for (((sum, scale), other), out) in sums.iter().zip(scales).zip(other).zip(out) {
            *out = *sum as f32 * *scale * *other;
        }
    }
}

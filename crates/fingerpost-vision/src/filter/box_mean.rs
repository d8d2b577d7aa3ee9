//! The mean over a square window.

use crate::error::{PictureError, check_size};
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// The mean over a square window, at a cost that hardly depends on the window.
///
/// Beyond its edges the picture is continued by its edge pixels.
#[derive(Debug, Clone)]
pub struct BoxMean {
    window: RowWindow,
    column_sums: ColumnSums,
    row: Vec<f32>,
}

impl BoxMean {
    /// A mean over `2 * radius_px + 1` pixels each way.
    #[must_use]
    pub fn new(radius_px: usize) -> Self {
        Self { window: RowWindow::new(radius_px), column_sums: ColumnSums::new(radius_px), row: Vec::new() }
    }

    /// Fills `target` with the means of `source`.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: &Plane<f32>, target: &mut Plane<f32>) -> Result<(), PictureError> {
        check_size("box target", source.size(), target.size())?;
        self.average(CodePath::fastest(), source, target);
        Ok(())
    }

    pub(super) fn average(&mut self, path: CodePath, source: &Plane<f32>, target: &mut Plane<f32>) {
        let (width, height) = source.size();
        if width == 0 || height == 0 {
            return;
        }
        self.row.resize(width, 0.0);
        self.column_sums.start(path, width, |row| source.row(row.min(height - 1)));
        for y in 0..height {
            self.column_sums.next(path, y, |row| source.row(row.min(height - 1)), &mut self.row);
            self.window.means(path, &self.row, target.row_mut(y));
        }
    }
}

/// Sums along columns over the rows of a window that moves down a picture of any number of columns.
#[derive(Debug, Clone)]
pub(crate) struct ColumnSums {
    radius: usize,
    /// One over the pixels of the window.
    scale: f64,
    /// `f64` keeps what is added and taken away again from leaving a trace that matters.
    sums: Vec<f64>,
}

impl ColumnSums {
    pub(crate) fn new(radius: usize) -> Self {
        let side = (2 * radius + 1) as f64;
        Self { radius, scale: 1.0 / (side * side), sums: Vec::new() }
    }

    /// Sums the window of the first row. `row` gives the picture's rows of `width` values, and its last one for any below.
    pub(crate) fn start<'a>(&mut self, path: CodePath, width: usize, row: impl Fn(usize) -> &'a [f32]) {
        self.sums.clear();
        self.sums.resize(width, 0.0);
        add_weighted(path, &mut self.sums, row(0), (self.radius + 1) as f64);
        (1..=self.radius).for_each(|y| add_weighted(path, &mut self.sums, row(y), 1.0));
    }

    /// Writes the sums of row `y`, divided by the pixels of the window, and moves the window to the next row; rows are taken in turn from the first.
    pub(crate) fn next<'a>(
        &mut self,
        path: CodePath,
        y: usize,
        row: impl Fn(usize) -> &'a [f32],
        out: &mut [f32],
    ) {
        let (entering, leaving) = (row(y + self.radius + 1), row(y.saturating_sub(self.radius)));
        slide(path, &mut self.sums, self.scale, entering, leaving, out);
    }
}

simd_kernel! {
    fn add_weighted(sums: &mut [f64], row: &[f32], weight: f64) {
        for (sum, &value) in sums.iter_mut().zip(row) {
            *sum += weight * f64::from(value);
        }
    }
}

simd_kernel! {
    fn slide(sums: &mut [f64], scale: f64, entering: &[f32], leaving: &[f32], out: &mut [f32]) {
        for (((sum, &new), &old), out) in sums.iter_mut().zip(entering).zip(leaving).zip(out) {
            *out = (scale * *sum) as f32;
            *sum += f64::from(new) - f64::from(old);
        }
    }
}

/// Means of a square window from its sums along columns, which [`ColumnSums`] has divided by the window's pixels.
///
/// A window of n columns is covered by pieces of about the square root of n, each summed once for every place: nothing is
/// taken away again, so `f32` suffices, and neighbouring pixels do not wait for one another as running sums do.
#[derive(Debug, Clone)]
pub(crate) struct RowWindow {
    radius: usize,
    /// The row continued beyond both ends.
    padded: Vec<f32>,
    /// Sums over a piece that starts at each column.
    pieces: Vec<f32>,
}

impl RowWindow {
    pub(crate) fn new(radius: usize) -> Self {
        Self { radius, padded: Vec::new(), pieces: Vec::new() }
    }

    /// Fills `out` with means over the window from `sums` along the columns of one row, which is not empty.
    pub(crate) fn means(&mut self, path: CodePath, sums: &[f32], out: &mut [f32]) {
        self.padded.resize(sums.len() + 2 * self.radius, 0.0);
        self.pieces.resize(self.padded.len(), 0.0);
        window_means(path, self.radius, sums, &mut self.padded, &mut self.pieces, out);
    }
}

simd_kernel! {
    fn window_means(radius: usize, sums: &[f32], padded: &mut [f32], pieces: &mut [f32], out: &mut [f32]) {
        let width = sums.len();
        padded[..radius].fill(sums[0]);
        padded[radius..radius + width].copy_from_slice(sums);
        padded[radius + width..].fill(sums[width - 1]);
        let window = 2 * radius + 1;
        let piece = window.isqrt();
        let whole = window / piece;
        let places = padded.len() + 1 - piece;
        sum_shifted(&mut pieces[..places], padded, 1, piece);
        sum_shifted(out, pieces, piece, whole);
        add_shifted(out, &padded[whole * piece..], 1, window - whole * piece);
    }
}

/// Fills `out` with sums of `count` values, `step` apart.
#[inline(always)]
fn sum_shifted(out: &mut [f32], values: &[f32], step: usize, count: usize) {
    let length = out.len();
    let at = |shift: usize| &values[shift * step..][..length];
    match count {
        1 | 2 => {
            out.copy_from_slice(at(0));
            add_shifted(out, &values[step..], step, count - 1);
        }
        3 | 4 => {
            let (a, b, c) = (at(0), at(1), at(2));
            for i in 0..length {
                out[i] = a[i] + b[i] + c[i];
            }
            add_shifted(out, &values[3 * step..], step, count - 3);
        }
        _ => {
            let (a, b, c, d, e) = (at(0), at(1), at(2), at(3), at(4));
            for i in 0..length {
                out[i] = a[i] + b[i] + c[i] + d[i] + e[i];
            }
            add_shifted(out, &values[5 * step..], step, count - 5);
        }
    }
}

/// Adds to `out` sums of `count` values, `step` apart.
#[inline(always)]
fn add_shifted(out: &mut [f32], values: &[f32], step: usize, count: usize) {
    for shift in 0..count {
        let row = &values[shift * step..][..out.len()];
        out.iter_mut().zip(row).for_each(|(sum, &value)| *sum += value);
    }
}

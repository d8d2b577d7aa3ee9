//! Displacements from pairs of polynomials.

use super::FlowField;
use super::expansion::{PIXEL_VALUES, PixelExpansion, RowExpansion};
use crate::filter::{ColumnSums, RowWindow};
use crate::simd::{CodePath, simd_kernel};

/// Weights of pixels near the edge by their distance from it: polynomials there rest on continued pixels. The values are
/// those of OpenCV's implementation.
const EDGE_WEIGHTS: [f32; 5] = [0.14, 0.14, 0.4472, 0.4472, 0.4472];
/// Added to the determinant of each window's equations, in their units (grey levels per square pixel, to the fourth power),
/// so that a window without texture gives no displacement instead of any. The value is that of OpenCV's implementation.
const DETERMINANT_FLOOR: f32 = 1e-3;
/// The least `f32` from which on there are no fractions, 2^23, and the bits that hold a mantissa.
const WHOLE: f32 = 8_388_608.0;
const MANTISSA: u32 = 0x7f_ffff;
/// Values of a pixel's equations: `A^T A` (xx, xy, yy) and `A^T b` (x, y).
const EQUATIONS: usize = 5;

/// Refines a flow by one step of windowed least squares (Farneback 2003).
///
/// Rows are set up just before the window reaches them, so that few of them are kept.
#[derive(Debug, Clone)]
pub(super) struct DisplacementSolver {
    radius: usize,
    column_sums: ColumnSums,
    window: RowWindow,
    /// Equations of the last rows, as many as the window has and one more; each row has its five values one after the
    /// other.
    recent: Vec<f32>,
    /// Sums along columns, and their means over the window, in the same order.
    sums: Vec<f32>,
    means: Vec<f32>,
    places: Places,
    /// The other picture's polynomials at the places of a row.
    there: Vec<[f32; PIXEL_VALUES]>,
    /// Weights of the columns.
    edge_weights: Vec<f32>,
}

/// Where the pixels of a row are found in the other picture.
#[derive(Debug, Clone, Default)]
struct Places {
    /// Column and row of the upper left of the four pixels around the place, clamped into the picture.
    columns: Vec<u32>,
    rows: Vec<u32>,
    /// How far the place lies to the right of it and below it, pixels.
    right: Vec<f32>,
    below: Vec<f32>,
    /// Share of the other picture's polynomial: a half, or nothing where not all four pixels exist.
    share: Vec<f32>,
}

impl DisplacementSolver {
    pub(super) fn new(window_radius_px: usize) -> Self {
        Self {
            radius: window_radius_px,
            column_sums: ColumnSums::new(window_radius_px),
            window: RowWindow::new(window_radius_px),
            recent: Vec::new(),
            sums: Vec::new(),
            means: Vec::new(),
            places: Places::default(),
            there: Vec::new(),
            edge_weights: Vec::new(),
        }
    }

    /// Replaces `flow` by the displacements that its own values, as a first guess, lead to. All have one size.
    pub(super) fn refine(
        &mut self,
        path: CodePath,
        from: &RowExpansion,
        to: &PixelExpansion,
        flow: &mut FlowField,
    ) {
        let (width, height) = from.size();
        let (length, rows) = (EQUATIONS * width, 2 * self.radius + 2);
        self.reserve(width, rows);
        let slot =
            |row: usize| row.min(height - 1) % rows * length..(row.min(height - 1) % rows + 1) * length;
        for row in 0..=self.radius.min(height - 1) {
            self.set_up(path, from, to, flow, row, slot(row));
        }
        self.column_sums.start(path, length, |row| &self.recent[slot(row)]);
        for y in 0..height {
            let next = y + self.radius + 1;
            if next < height {
                self.set_up(path, from, to, flow, next, slot(next));
            }
            self.column_sums.next(path, y, |row| &self.recent[slot(row)], &mut self.sums);
            for (sums, means) in self.sums.chunks_exact(width).zip(self.means.chunks_exact_mut(width)) {
                self.window.means(path, sums, means);
            }
            solve(path, &self.means, flow.dx.row_mut(y), flow.dy.row_mut(y));
        }
    }

    fn reserve(&mut self, width: usize, rows: usize) {
        self.recent.resize(rows * EQUATIONS * width, 0.0);
        self.sums.resize(EQUATIONS * width, 0.0);
        self.means.resize(EQUATIONS * width, 0.0);
        self.there.resize(width, [0.0; PIXEL_VALUES]);
        if self.edge_weights.len() != width {
            self.edge_weights.clear();
            self.edge_weights.extend((0..width).map(|x| edge_weight(x, width)));
        }
        let Places { columns, rows, right, below, share } = &mut self.places;
        [columns, rows].into_iter().for_each(|values| values.resize(width, 0));
        [right, below].into_iter().for_each(|values| values.resize(width, 0.0));
        share.clear();
        share.resize(width, 0.0);
    }

    /// Writes the equations of row `y` into their place among the recent rows.
    fn set_up(
        &mut self,
        path: CodePath,
        from: &RowExpansion,
        to: &PixelExpansion,
        flow: &FlowField,
        y: usize,
        slot: std::ops::Range<usize>,
    ) {
        let (width, height) = from.size();
        let (dx, dy) = (flow.dx.row(y), flow.dy.row(y));
        let Places { columns, rows, right, below, share } = &mut self.places;
        // Where there are no four pixels around any place, the shares stay nothing.
        if width > 1 && height > 1 {
            place(path, width, height, y, dx, dy, columns, rows, right, below, share);
            sample(path, &to.pixels, width, columns, rows, right, below, &mut self.there);
        }
        let (xx, rest) = self.recent[slot].split_at_mut(width);
        let (xy, rest) = rest.split_at_mut(width);
        let (yy, rest) = rest.split_at_mut(width);
        let (bx, by) = rest.split_at_mut(width);
        let (row_weight, weights) = (edge_weight(y, height), &self.edge_weights);
        equations(path, from.row(y), &self.there, share, dx, dy, row_weight, weights, xx, xy, yy, bx, by);
    }
}

fn edge_weight(index: usize, length: usize) -> f32 {
    let from = |distance: usize| EDGE_WEIGHTS.get(distance).copied().unwrap_or(1.0);
    from(index) * from(length - 1 - index)
}

simd_kernel! {
    fn place(
        width: usize, height: usize, y: usize, dx: &[f32], dy: &[f32],
        columns: &mut [u32], rows: &mut [u32], right: &mut [f32], below: &mut [f32], share: &mut [f32],
    ) {
        let (dx, dy) = (&dx[..width], &dy[..width]);
        let (columns, rows) = (&mut columns[..width], &mut rows[..width]);
        let (right, below, share) = (&mut right[..width], &mut below[..width], &mut share[..width]);
        let (last_column, last_row, y) = ((width - 1) as f32, (height - 1) as f32, y as f32);
        for x in 0..width {
            let (u, v) = (x as i32 as f32 + dx[x], y + dy[x]);
            let is_inside = (u >= 0.0) & (u < last_column) & (v >= 0.0) & (v < last_row);
            share[x] = if is_inside { 0.5 } else { 0.0 };
            // What is not a number goes to 0.
            let (u, v) = (if u > 0.0 { u } else { 0.0 }, if v > 0.0 { v } else { 0.0 });
            let (u, v) = (if u < last_column { u } else { last_column }, if v < last_row { v } else { last_row });
            let (column, left) = whole_part(if u < last_column - 1.0 { u } else { last_column - 1.0 });
            let (row, upper) = whole_part(if v < last_row - 1.0 { v } else { last_row - 1.0 });
            columns[x] = column;
            rows[x] = row;
            right[x] = u - left;
            below[x] = v - upper;
        }
    }
}

/// The whole number at or below `value`, which is from 0 to below [`WHOLE`], as an index and as it is.
///
/// Sums with [`WHOLE`] have no room for fractions, and hold their whole part in the mantissa's bits. A conversion by `as`
/// guards against numbers that do not fit, one pixel at a time, which takes five times as long.
#[inline(always)]
fn whole_part(value: f32) -> (u32, f32) {
    let nearest = (value + WHOLE) - WHOLE;
    let whole = if nearest > value { nearest - 1.0 } else { nearest };
    ((whole + WHOLE).to_bits() & MANTISSA, whole)
}

simd_kernel! {
    fn sample(
        pixels: &[[f32; PIXEL_VALUES]], width: usize,
        columns: &[u32], rows: &[u32], right: &[f32], below: &[f32], there: &mut [[f32; PIXEL_VALUES]],
    ) {
        let count = there.len();
        let (columns, rows) = (&columns[..count], &rows[..count]);
        let (right, below) = (&right[..count], &below[..count]);
        for (i, out) in there.iter_mut().enumerate() {
            let at = rows[i] as usize * width + columns[i] as usize;
            let (upper, lower) = (&pixels[at..at + 2], &pixels[at + width..at + width + 2]);
            let (right, below) = (right[i], below[i]);
            for value in 0..PIXEL_VALUES {
                let from = upper[0][value] + below * (lower[0][value] - upper[0][value]);
                let to = upper[1][value] + below * (lower[1][value] - upper[1][value]);
                out[value] = from + right * (to - from);
            }
        }
    }
}

simd_kernel! {
    fn equations(
        here: &[f32], there: &[[f32; PIXEL_VALUES]], share: &[f32], dx: &[f32], dy: &[f32],
        row_weight: f32, weights: &[f32],
        xx: &mut [f32], xy: &mut [f32], yy: &mut [f32], bx: &mut [f32], by: &mut [f32],
    ) {
        let width = xx.len();
        let (there, share, weights) = (&there[..width], &share[..width], &weights[..width]);
        let (dx, dy) = (&dx[..width], &dy[..width]);
        let (here_x, here_y) = (&here[..width], &here[width..][..width]);
        let (here_xx, here_yy) = (&here[2 * width..][..width], &here[3 * width..][..width]);
        let here_xy = &here[4 * width..][..width];
        let (xy, yy, bx, by) = (&mut xy[..width], &mut yy[..width], &mut bx[..width], &mut by[..width]);
        for x in 0..width {
            let [q_x, q_y, q_xx, q_yy, q_xy, ..] = there[x];
            // A is the mean of both, b half the difference of the slopes, plus what the displacement so far accounts for.
            // Where the other picture shows nothing, this one's A stands alone.
            let (share, own) = (share[x], 1.0 - share[x]);
            let weight = row_weight * weights[x];
            let a_xx = own * here_xx[x] + share * q_xx;
            let a_yy = own * here_yy[x] + share * q_yy;
            let a_xy = 0.5 * (own * here_xy[x] + share * q_xy);
            let b_x = 0.5 * here_x[x] - share * q_x + a_xx * dx[x] + a_xy * dy[x];
            let b_y = 0.5 * here_y[x] - share * q_y + a_xy * dx[x] + a_yy * dy[x];
            let (a_xx, a_yy, a_xy) = (weight * a_xx, weight * a_yy, weight * a_xy);
            let (b_x, b_y) = (weight * b_x, weight * b_y);
            xx[x] = a_xx * a_xx + a_xy * a_xy;
            xy[x] = (a_xx + a_yy) * a_xy;
            yy[x] = a_yy * a_yy + a_xy * a_xy;
            bx[x] = a_xx * b_x + a_xy * b_y;
            by[x] = a_xy * b_x + a_yy * b_y;
        }
    }
}

simd_kernel! {
    /// Solves the equations of a row.
    fn solve(means: &[f32], dx: &mut [f32], dy: &mut [f32]) {
        let width = dx.len();
        let dy = &mut dy[..width];
        let (xx, xy, yy) = (&means[..width], &means[width..][..width], &means[2 * width..][..width]);
        let (bx, by) = (&means[3 * width..][..width], &means[4 * width..][..width]);
        for x in 0..width {
            let inverse = 1.0 / (xx[x] * yy[x] - xy[x] * xy[x] + DETERMINANT_FLOOR);
            dx[x] = (yy[x] * bx[x] - xy[x] * by[x]) * inverse;
            dy[x] = (xx[x] * by[x] - xy[x] * bx[x]) * inverse;
        }
    }
}

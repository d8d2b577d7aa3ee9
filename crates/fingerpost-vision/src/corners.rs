//! Corners: pixels that can be told from their surroundings in every direction, spread over the picture.
//!
//! J. Shi and C. Tomasi, "Good features to track", 1994: a window can be tracked as well as the smaller eigenvalue of its
//! gradients' second moments says. At most one corner is taken a cell of a grid, the strongest, so that a single tree does
//! not have them all.

use crate::picture::PlaneView;
use crate::simd::{CodePath, simd_kernel};

/// Pixels that the window of the second moments reaches to either side.
const REACH: usize = 2;
/// Side of that window.
const SIDE: usize = 2 * REACH + 1;
/// Pixels at the picture's edges without a whole window of gradients.
const EDGE: usize = REACH + 1;

/// A corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Column, pixels.
    pub x: usize,
    /// Row, pixels.
    pub y: usize,
    /// Smaller eigenvalue of the gradients' mean second moments, square grey levels a square pixel.
    pub strength: f32,
}

/// Second moments of the gradient: x x, y y and x y.
type Moments = [Vec<i32>; 3];

/// Finds corners, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::{corners::CornerFinder, picture::Plane};
/// let mut picture = Plane::new(32, 32, 50_u8);
/// for y in 16..32 {
///     picture.row_mut(y)[16..].fill(200);
/// }
/// let mut corners = Vec::new();
/// CornerFinder::default().find(picture.view(), 32, 1.0, &mut corners);
/// assert!(corners[0].x.abs_diff(16) <= 1 && corners[0].y.abs_diff(16) <= 1);
/// ```
#[derive(Debug, Clone, Default)]
pub struct CornerFinder {
    /// Moments of the last [`SIDE`] rows, and their sums over those rows.
    rows: [Moments; SIDE],
    sums: Moments,
    strength: Vec<f32>,
}

impl CornerFinder {
    /// Puts the strongest corner of each cell of `cell` x `cell` pixels into `corners`, in place of what was there, cell by
    /// cell from the top; cells without a corner of `least` strength have none. Corners lie at least 3 pixels inside.
    pub fn find(&mut self, grey: PlaneView<'_, u8>, cell: usize, least: f32, corners: &mut Vec<Corner>) {
        self.find_on(CodePath::fastest(), grey, cell, least, corners);
    }

    fn find_on(
        &mut self,
        path: CodePath,
        grey: PlaneView<'_, u8>,
        cell: usize,
        least: f32,
        corners: &mut Vec<Corner>,
    ) {
        corners.clear();
        let (width, height) = grey.size();
        if cell == 0 || width <= 2 * EDGE || height <= 2 * EDGE {
            return;
        }
        let inner = width - 2;
        for moments in self.rows.iter_mut().chain([&mut self.sums]) {
            for moment in moments {
                moment.clear();
                moment.resize(inner, 0);
            }
        }
        self.strength.clear();
        self.strength.resize(width - 2 * EDGE, 0.0);
        let mut first_of_band = 0;
        for y in 1..height - 1 {
            let oldest = &mut self.rows[y % SIDE];
            add_row(path, [grey.row(y - 1), grey.row(y), grey.row(y + 1)], oldest, &mut self.sums);
            let Some(middle) = (y + 1).checked_sub(SIDE).map(|top| top + REACH).filter(|_| y >= SIDE) else {
                continue;
            };
            if (middle - EDGE).is_multiple_of(cell) {
                first_of_band = corners.len();
                let cells = self.strength.len().div_ceil(cell);
                corners.extend((0..cells).map(|_| Corner { x: 0, y: 0, strength: 0.0 }));
            }
            strengths(path, &self.sums, &mut self.strength);
            for (best, (index, strengths)) in
                corners[first_of_band..].iter_mut().zip(self.strength.chunks(cell).enumerate())
            {
                let strongest = strongest(path, strengths);
                if strongest > best.strength && strongest >= least {
                    let column = strengths.iter().position(|&strength| strength >= strongest);
                    let x = EDGE + index * cell + column.unwrap_or(0);
                    *best = Corner { x, y: middle, strength: strongest };
                }
            }
        }
        corners.retain(|corner| corner.strength > 0.0);
    }
}

simd_kernel! {
    /// Puts the moments of the middle row in place of those of the row that leaves the window, and into the sums.
    fn add_row(rows: [&[u8]; 3], moments: &mut Moments, sums: &mut Moments) {
        let [xx, yy, xy] = moments;
        let inner = xx.len();
        let ([sum_xx, sum_yy, sum_xy], yy, xy) = (sums, &mut yy[..inner], &mut xy[..inner]);
        let (sum_xx, sum_yy, sum_xy) =
            (&mut sum_xx[..inner], &mut sum_yy[..inner], &mut sum_xy[..inner]);
        let (left, right) = (&rows[1][..inner], &rows[1][2..][..inner]);
        let (above, below) = (&rows[0][1..][..inner], &rows[2][1..][..inner]);
        for i in 0..inner {
            let dx = i32::from(right[i]) - i32::from(left[i]);
            let dy = i32::from(below[i]) - i32::from(above[i]);
            let new = [dx * dx, dy * dy, dx * dy];
            sum_xx[i] += new[0] - xx[i];
            sum_yy[i] += new[1] - yy[i];
            sum_xy[i] += new[2] - xy[i];
            xx[i] = new[0];
            yy[i] = new[1];
            xy[i] = new[2];
        }
    }
}

simd_kernel! {
    fn strengths(sums: &Moments, strength: &mut [f32]) {
        let count = strength.len();
        let [xx, yy, xy] = sums;
        let (xx, yy, xy) = (shifted(xx, count), shifted(yy, count), shifted(xy, count));
        for i in 0..count {
            let sum = |of: &[&[i32]; SIDE]| (of[0][i] + of[1][i] + of[2][i] + of[3][i] + of[4][i]) as f32;
            strength[i] = smaller_eigenvalue(sum(&xx), sum(&xy), sum(&yy));
        }
    }
}

/// The first `count` values, those from the second on, and so on.
#[inline(always)]
fn shifted(values: &[i32], count: usize) -> [&[i32]; SIDE] {
    [
        &values[..count],
        &values[1..][..count],
        &values[2..][..count],
        &values[3..][..count],
        &values[4..][..count],
    ]
}

/// Smaller eigenvalue of the mean second moments, from their sums over the window; a central difference is twice the slope.
#[inline(always)]
fn smaller_eigenvalue(xx: f32, xy: f32, yy: f32) -> f32 {
    const SCALE: f32 = 1.0 / (4 * SIDE * SIDE) as f32;
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    SCALE * (mean - (half * half + xy * xy).sqrt())
}

simd_kernel! {
    fn strongest(strengths: &[f32]) -> f32 {
        strengths.iter().fold(0.0_f32, |most, &strength| if strength > most { strength } else { most })
    }
}

#[cfg(test)]
mod tests;

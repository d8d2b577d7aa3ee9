//! Where single places of one picture are in the next: pyramidal Lucas-Kanade.
//!
//! B. Lucas and T. Kanade, "An iterative image registration technique", 1981; the pyramid after J.-Y. Bouguet, "Pyramidal
//! implementation of the Lucas Kanade feature tracker", 2000; the inverse compositional step after S. Baker and I. Matthews,
//! "Lucas-Kanade 20 years on", 2004: slopes and their second moments are those of the older picture, so that a step takes
//! one look at the newer one. The mean of the slopes is taken out of them, so that a change of the light does not count as
//! motion.
//!
//! Limits: a window moves as a whole, without turning or growing; a place is lost when its window leaves the picture.

use crate::picture::Plane;
use crate::pyramid::GreyPyramid;
use crate::simd::{CodePath, simd_kernel};

/// Side of the window, pixels.
pub const WINDOW: usize = 13;
/// Pixels that the window reaches to either side of its middle.
const REACH: f32 = (WINDOW / 2) as f32;
/// Columns that are computed at a time; those beyond the window have no weight.
const LANES: usize = 16;
/// Rows with a row of slopes' neighbours above and below.
const ROWS: usize = WINDOW + 2;
/// Steps shorter than this end the search at the last level, pixels, and at those before it, which the next one mends.
const SHORT_PX: f32 = 0.01;
const COARSE_SHORT_PX: f32 = 0.1;
/// Steps that may be left when the search ends, pixels: a longer one shows a place that is not found.
const SETTLED_PX: f32 = 0.1;

type Lanes = [f32; LANES];

/// Where a place of the older picture is in the newer one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Track {
    /// Place in the older picture, pixels of its largest level, right and down.
    pub from: [f32; 2],
    /// The same in the newer one.
    pub to: [f32; 2],
    /// Root mean square of the grey difference that is left over the window, without its mean, levels.
    pub residual: f32,
}

/// Settings of the tracking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LucasKanade {
    /// Most steps at each level.
    pub iterations: usize,
    /// Smaller eigenvalue of the window's mean second moments below which it cannot be tracked, square grey levels a square
    /// pixel.
    pub least_strength: f32,
}

impl Default for LucasKanade {
    fn default() -> Self {
        Self { iterations: 10, least_strength: 1.0 }
    }
}

impl LucasKanade {
    /// Follows `from` and the displacement that it is expected to have, both in pixels of the largest level, from one pyramid
    /// to the other, from the coarsest level that holds its window down to the level `finest`. None when it is lost: its
    /// window left the picture, has no texture in both directions, or was not found.
    #[must_use]
    pub fn track(
        &self,
        previous: &GreyPyramid,
        current: &GreyPyramid,
        finest: usize,
        from: [f32; 2],
        expected: [f32; 2],
    ) -> Option<Track> {
        self.track_on(CodePath::fastest(), (previous, current), finest, from, expected)
    }

    fn track_on(
        &self,
        path: CodePath,
        (previous, current): (&GreyPyramid, &GreyPyramid),
        finest: usize,
        from: [f32; 2],
        expected: [f32; 2],
    ) -> Option<Track> {
        let levels = previous.levels().len().min(current.levels().len());
        let mut moved = expected;
        let mut found = None;
        for level in (finest..levels).rev() {
            let scale = 1.0 / (1_u32 << level) as f32;
            let at = from.map(|place| place * scale);
            let guess = [at[0] + moved[0] * scale, at[1] + moved[1] * scale];
            let pictures = [&previous.levels()[level], &current.levels()[level]];
            let short_px = if level == finest { SHORT_PX } else { COARSE_SHORT_PX };
            let fit = follow(path, pictures, at, guess, self.iterations, short_px, self.least_strength);
            found = fit;
            if let Some((to, _)) = fit {
                moved = [(to[0] - at[0]) / scale, (to[1] - at[1]) / scale];
            }
        }
        let (_, residual) = found?;
        Some(Track { from, to: [from[0] + moved[0], from[1] + moved[1]], residual })
    }
}

/// The pixel before a place and how far it lies beyond it; none where rows of `LANES + 1` pixels and `rows + 1` rows from there
/// are not inside.
#[inline(always)]
fn corner(picture: &Plane<u8>, place: [f32; 2], rows: usize) -> Option<([usize; 2], [f32; 2])> {
    let (width, height) = picture.size();
    let inside = place[0] >= 0.0
        && place[1] >= 0.0
        && place[0] + (LANES + 1) as f32 <= width as f32
        && place[1] + (rows + 1) as f32 <= height as f32;
    if !inside {
        return None;
    }
    let (x, y) = (place[0] as usize, place[1] as usize);
    Some(([x, y], [place[0] - x as f32, place[1] - y as f32]))
}

/// The row `y`, from a column between `x` and `x + 1` on.
#[inline(always)]
fn row_from(picture: &Plane<u8>, [x, y]: [usize; 2], right: f32) -> Option<Lanes> {
    let pixels = picture.row(y).get(x..)?.first_chunk::<{ LANES + 1 }>()?;
    let mut row = [0.0; LANES];
    for i in 0..LANES {
        let (a, b) = (f32::from(pixels[i]), f32::from(pixels[i + 1]));
        row[i] = a + (b - a) * right;
    }
    Some(row)
}

/// A row that lies between two others.
#[inline(always)]
fn between(upper: &Lanes, under: &Lanes, lower: f32) -> Lanes {
    let mut row = [0.0; LANES];
    for i in 0..LANES {
        row[i] = upper[i] + (under[i] - upper[i]) * lower;
    }
    row
}

/// The sum of the lanes, by halves: the same on every path.
#[inline(always)]
fn total(lanes: &Lanes) -> f32 {
    let mut lanes = *lanes;
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}

simd_kernel! {
    /// Place and residual of the window about `at` in the second picture, searched for from `guess`.
    fn follow(
        pictures: [&Plane<u8>; 2],
        at: [f32; 2],
        guess: [f32; 2],
        iterations: usize,
        short_px: f32,
        least_strength: f32,
    ) -> Option<([f32; 2], f32)> {
        const AREA: f32 = (WINDOW * WINDOW) as f32;
        let [previous, current] = pictures;
        let (first, shares) = corner(previous, [at[0] - REACH - 1.0, at[1] - REACH - 1.0], ROWS)?;
        let mut rows = [[0.0_f32; LANES + 2]; ROWS];
        let mut upper = row_from(previous, first, shares[0])?;
        for (dy, row) in rows.iter_mut().enumerate() {
            let under = row_from(previous, [first[0], first[1] + dy + 1], shares[0])?;
            row[..LANES].copy_from_slice(&between(&upper, &under, shares[1]));
            upper = under;
        }
        // The template and its slopes; lanes beyond the window have neither.
        let mut template = [[0.0_f32; LANES]; WINDOW];
        let (mut slope_x, mut slope_y) = ([[0.0_f32; LANES]; WINDOW], [[0.0_f32; LANES]; WINDOW]);
        let (mut sum_x, mut sum_y) = ([0.0_f32; LANES], [0.0_f32; LANES]);
        for dy in 0..WINDOW {
            for i in 0..LANES {
                let inside = if i < WINDOW { 0.5 } else { 0.0 };
                template[dy][i] = rows[dy + 1][i + 1];
                slope_x[dy][i] = inside * (rows[dy + 1][i + 2] - rows[dy + 1][i]);
                slope_y[dy][i] = inside * (rows[dy + 2][i + 1] - rows[dy][i + 1]);
                sum_x[i] += slope_x[dy][i];
                sum_y[i] += slope_y[dy][i];
            }
        }
        let (mean_x, mean_y) = (total(&sum_x) / AREA, total(&sum_y) / AREA);
        let (mut xx, mut xy, mut yy) = ([0.0_f32; LANES], [0.0_f32; LANES], [0.0_f32; LANES]);
        for dy in 0..WINDOW {
            for i in 0..LANES {
                let inside = if i < WINDOW { 1.0 } else { 0.0 };
                let (dx, dy_) = (slope_x[dy][i] - inside * mean_x, slope_y[dy][i] - inside * mean_y);
                slope_x[dy][i] = dx;
                slope_y[dy][i] = dy_;
                xx[i] += dx * dx;
                xy[i] += dx * dy_;
                yy[i] += dy_ * dy_;
            }
        }
        let (xx, xy, yy) = (total(&xx), total(&xy), total(&yy));
        let smaller = 0.5 * (xx + yy) - (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        let determinant = xx * yy - xy * xy;
        if !(smaller >= least_strength * AREA && determinant > 0.0) {
            return None;
        }

        let mut to = guess;
        let (mut step_px, mut variance) = (f32::INFINITY, 0.0);
        for _ in 0..iterations {
            let (first, shares) = corner(current, [to[0] - REACH, to[1] - REACH], WINDOW)?;
            let (mut by_x, mut by_y) = ([0.0_f32; LANES], [0.0_f32; LANES]);
            let (mut sum, mut squares) = ([0.0_f32; LANES], [0.0_f32; LANES]);
            let mut upper = row_from(current, first, shares[0])?;
            for dy in 0..WINDOW {
                let under = row_from(current, [first[0], first[1] + dy + 1], shares[0])?;
                let row = between(&upper, &under, shares[1]);
                upper = under;
                for i in 0..LANES {
                    let inside = if i < WINDOW { 1.0 } else { 0.0 };
                    let difference = inside * (row[i] - template[dy][i]);
                    by_x[i] += slope_x[dy][i] * difference;
                    by_y[i] += slope_y[dy][i] * difference;
                    sum[i] += difference;
                    squares[i] += difference * difference;
                }
            }
            let (by_x, by_y) = (total(&by_x), total(&by_y));
            let mean = total(&sum) / AREA;
            variance = total(&squares) / AREA - mean * mean;
            let step = [(yy * by_x - xy * by_y) / determinant, (xx * by_y - xy * by_x) / determinant];
            to = [to[0] - step[0], to[1] - step[1]];
            step_px = (step[0] * step[0] + step[1] * step[1]).sqrt();
            if step_px < short_px {
                break;
            }
        }
        (step_px <= SETTLED_PX).then_some((to, if variance > 0.0 { variance.sqrt() } else { 0.0 }))
    }
}

#[cfg(test)]
mod tests;

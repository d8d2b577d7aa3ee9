//! Polynomial expansion: a quadratic polynomial around every pixel.

use crate::filter::gaussian_taps;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Coefficients of a polynomial, its constant not among them: x, y, xx, yy, xy, with `x` to the right and `y` down.
pub(super) const COEFFICIENTS: usize = 5;
/// Values a pixel of [`PixelExpansion`]: the coefficients, filled up so that one vector holds a pixel.
pub(super) const PIXEL_VALUES: usize = 8;

/// The polynomials around all pixels of a picture; each row has its five coefficients one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct RowExpansion {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl RowExpansion {
    /// Width and height, pixels.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The coefficients of row `y`, `width` values each.
    pub(super) fn row(&self, y: usize) -> &[f32] {
        let length = COEFFICIENTS * self.width;
        &self.values[y * length..][..length]
    }
}

/// The polynomials around all pixels of a picture, each pixel's coefficients side by side: for places in no order.
#[derive(Debug, Clone, Default)]
pub(super) struct PixelExpansion {
    pub(super) pixels: Vec<[f32; PIXEL_VALUES]>,
}

/// Fits polynomials by Gaussian-weighted least squares (Farneback 2003).
///
/// With a symmetric separable weight `w(x) w(y)` of sum 1, the normal equations fall apart. With `b = sum w x^2` and `c =
/// sum w x^4`, and `m` for the weighted moments of the picture: `r_x = m_x / b`, `r_xx = (m_xx - b m_1) / (c - b^2)`, `r_xy
/// = m_xy / b^2`, and the same for y.
#[derive(Debug, Clone)]
pub(super) struct Expander {
    radius: usize,
    normal: NormalEquations,
    /// Weights at distances from 1 on, and these times the distance and its square.
    weights: Vec<[f32; 3]>,
    /// Moments along the columns of a row, continued beyond both ends.
    columns: [Vec<f32>; 3],
    /// The coefficients of a row on its way into a [`PixelExpansion`].
    row: Vec<f32>,
}

/// The solution of the normal equations, and the weight of the middle.
#[derive(Debug, Clone, Copy)]
struct NormalEquations {
    middle: f32,
    /// `b` of the normal equations.
    second_moment: f32,
    inverse_first: f32,
    inverse_second: f32,
    inverse_mixed: f32,
}

impl Expander {
    pub(super) fn new(radius: usize, sigma_px: f64) -> Self {
        let taps = gaussian_taps(sigma_px, radius);
        let offsets = || (0..taps.len()).map(|tap| tap as f64 - radius as f64);
        let moment = |power| taps.iter().zip(offsets()).map(|(w, x)| w * x.powi(power)).sum::<f64>();
        let (second, fourth) = (moment(2), moment(4));
        let weights = taps.iter().zip(offsets()).skip(radius + 1);
        Self {
            radius,
            normal: NormalEquations {
                middle: taps[radius] as f32,
                second_moment: second as f32,
                inverse_first: (1.0 / second) as f32,
                inverse_second: (1.0 / (fourth - second * second)) as f32,
                inverse_mixed: (1.0 / (second * second)) as f32,
            },
            weights: weights.map(|(&w, x)| [w as f32, (w * x) as f32, (w * x * x) as f32]).collect(),
            columns: Default::default(),
            row: Vec::new(),
        }
    }

    /// Expands `picture`, which beyond its edges is continued by its edge pixels.
    pub(super) fn expand_rows(&mut self, path: CodePath, picture: &Plane<f32>, expansion: &mut RowExpansion) {
        (expansion.width, expansion.height) = picture.size();
        let length = COEFFICIENTS * expansion.width;
        expansion.values.resize(length * expansion.height, 0.0);
        for (y, row) in expansion.values.chunks_exact_mut(length.max(1)).enumerate() {
            self.expand_row(path, picture, y, row);
        }
    }

    /// As [`Expander::expand_rows`], into another order.
    pub(super) fn expand_pixels(
        &mut self,
        path: CodePath,
        picture: &Plane<f32>,
        expansion: &mut PixelExpansion,
    ) {
        let (width, height) = picture.size();
        expansion.pixels.resize(width * height, [0.0; PIXEL_VALUES]);
        let mut row = std::mem::take(&mut self.row);
        row.resize(COEFFICIENTS * width, 0.0);
        for (y, pixels) in expansion.pixels.chunks_exact_mut(width.max(1)).enumerate() {
            self.expand_row(path, picture, y, &mut row);
            interleave(path, &row, pixels);
        }
        self.row = row;
    }

    fn expand_row(&mut self, path: CodePath, picture: &Plane<f32>, y: usize, out: &mut [f32]) {
        // Radii between these are taken as the next one, with weights of zero.
        match self.radius {
            0..=5 => self.expand_row_within::<5>(path, picture, y, out),
            6..=7 => self.expand_row_within::<7>(path, picture, y, out),
            8..=15 => self.expand_row_within::<15>(path, picture, y, out),
            _ => self.expand_row_within::<31>(path, picture, y, out),
        }
    }

    fn expand_row_within<const REACH: usize>(
        &mut self,
        path: CodePath,
        picture: &Plane<f32>,
        y: usize,
        out: &mut [f32],
    ) {
        let (width, height) = picture.size();
        let mut weights = [[0.0; 3]; REACH];
        weights.iter_mut().zip(&self.weights).for_each(|(to, from)| *to = *from);
        let (mut above, mut below) = ([picture.row(y); REACH], [picture.row(y); REACH]);
        for (distance, (above, below)) in (1..).zip(above.iter_mut().zip(&mut below)) {
            *above = picture.row(y.saturating_sub(distance));
            *below = picture.row((y + distance).min(height - 1));
        }
        self.columns.iter_mut().for_each(|column| column.resize(width + 2 * REACH, 0.0));
        let inner = REACH..REACH + width;
        let [even, first, second] = &mut self.columns;
        sum_columns::<REACH>(
            path,
            self.normal.middle,
            &weights,
            picture.row(y),
            &above,
            &below,
            &mut even[inner.clone()],
            &mut first[inner.clone()],
            &mut second[inner],
        );
        for column in [&mut *even, &mut *first, &mut *second] {
            let (left, right) = (column[REACH], column[REACH + width - 1]);
            column[..REACH].fill(left);
            column[REACH + width..].fill(right);
        }
        let (x, rest) = out.split_at_mut(width);
        let (y, rest) = rest.split_at_mut(width);
        let (xx, rest) = rest.split_at_mut(width);
        let (yy, xy) = rest.split_at_mut(width);
        sum_rows::<REACH>(path, self.normal, &weights, even, first, second, x, y, xx, yy, xy);
    }
}

simd_kernel! {
    fn sum_columns<const REACH: usize>(
        middle: f32, weights: &[[f32; 3]; REACH],
        row: &[f32], above: &[&[f32]; REACH], below: &[&[f32]; REACH],
        even: &mut [f32], first: &mut [f32], second: &mut [f32],
    ) {
        let width = row.len();
        let (even, first, second) = (&mut even[..width], &mut first[..width], &mut second[..width]);
        let (mut above, mut below) = (*above, *below);
        for distance in 0..REACH {
            above[distance] = &above[distance][..width];
            below[distance] = &below[distance][..width];
        }
        for i in 0..width {
            let (mut sum, mut sum_x, mut sum_xx) = (middle * row[i], 0.0, 0.0);
            for distance in 0..REACH {
                let [w, wx, wxx] = weights[distance];
                let both = above[distance][i] + below[distance][i];
                sum += w * both;
                sum_x += wx * (below[distance][i] - above[distance][i]);
                sum_xx += wxx * both;
            }
            even[i] = sum;
            first[i] = sum_x;
            second[i] = sum_xx;
        }
    }
}

simd_kernel! {
    fn sum_rows<const REACH: usize>(
        normal: NormalEquations, weights: &[[f32; 3]; REACH],
        even: &[f32], first: &[f32], second: &[f32],
        x: &mut [f32], y: &mut [f32], xx: &mut [f32], yy: &mut [f32], xy: &mut [f32],
    ) {
        let width = x.len();
        let (y, xx, yy, xy) = (&mut y[..width], &mut xx[..width], &mut yy[..width], &mut xy[..width]);
        let mut left = [[even, first, second]; REACH];
        let mut right = left;
        for distance in 0..REACH {
            for moment in 0..3 {
                left[distance][moment] = &left[distance][moment][REACH - 1 - distance..][..width];
                right[distance][moment] = &right[distance][moment][REACH + 1 + distance..][..width];
            }
        }
        let (even, first, second) = (&even[REACH..][..width], &first[REACH..][..width], &second[REACH..][..width]);
        for i in 0..width {
            let (mut m, mut m_x, mut m_xx) = (normal.middle * even[i], 0.0, 0.0);
            let (mut m_y, mut m_xy, mut m_yy) = (normal.middle * first[i], 0.0, normal.middle * second[i]);
            for distance in 0..REACH {
                let [w, wx, wxx] = weights[distance];
                let [[l, l_y, l_yy], [r, r_y, r_yy]] = [
                    [left[distance][0][i], left[distance][1][i], left[distance][2][i]],
                    [right[distance][0][i], right[distance][1][i], right[distance][2][i]],
                ];
                m += w * (l + r);
                m_x += wx * (r - l);
                m_xx += wxx * (l + r);
                m_y += w * (l_y + r_y);
                m_xy += wx * (r_y - l_y);
                m_yy += w * (l_yy + r_yy);
            }
            let mean = normal.second_moment * m;
            x[i] = m_x * normal.inverse_first;
            y[i] = m_y * normal.inverse_first;
            xx[i] = (m_xx - mean) * normal.inverse_second;
            yy[i] = (m_yy - mean) * normal.inverse_second;
            xy[i] = m_xy * normal.inverse_mixed;
        }
    }
}

simd_kernel! {
    fn interleave(row: &[f32], pixels: &mut [[f32; PIXEL_VALUES]]) {
        let width = pixels.len();
        let (x, y, xx) = (&row[..width], &row[width..][..width], &row[2 * width..][..width]);
        let (yy, xy) = (&row[3 * width..][..width], &row[4 * width..][..width]);
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = [x[i], y[i], xx[i], yy[i], xy[i], 0.0, 0.0, 0.0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expand(expander: &mut Expander, picture: &Plane<f32>) -> Vec<[f32; PIXEL_VALUES]> {
        let (mut rows, mut pixels) = (RowExpansion::default(), PixelExpansion::default());
        let (width, height) = picture.size();
        for path in CodePath::available() {
            expander.expand_rows(path, picture, &mut rows);
            let before = pixels.pixels.clone();
            expander.expand_pixels(path, picture, &mut pixels);
            assert!(before.is_empty() || before == pixels.pixels, "{path:?}");
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let in_row: Vec<f32> = (0..COEFFICIENTS).map(|c| rows.row(y)[c * width + x]).collect();
                assert_eq!(in_row, pixels.pixels[y * width + x][..COEFFICIENTS], "{path:?}");
            }
        }
        pixels.pixels
    }

    #[test]
    fn a_quadratic_picture_gives_its_own_coefficients() {
        let at = |x: f32, y: f32| 3.0 + 0.5 * x - 0.25 * y + 0.125 * x * x - 0.0625 * y * y + 0.03 * x * y;
        let values =
            (0..31 * 25).map(|index| at((index % 31) as f32 - 15.0, (index / 31) as f32 - 12.0)).collect();
        let picture = Plane::from_vec(31, 25, values).unwrap();
        for (radius, tolerance) in [(3, 1e-4), (5, 1e-4), (6, 1e-4), (7, 1e-4), (9, 1e-3)] {
            let expansion = expand(&mut Expander::new(radius, 1.2), &picture);
            let centre = expansion[12 * 31 + 15];
            for (found, expected) in centre.iter().zip([0.5, -0.25, 0.125, -0.0625, 0.03]) {
                assert!((found - expected).abs() < tolerance, "radius {radius}: {centre:?}");
            }
        }
        // Six pixels to the right and three down the slope is another.
        let [x, y, ..] = expand(&mut Expander::new(5, 1.2), &picture)[15 * 31 + 21];
        assert!((x - (0.5 + 2.0 * 0.125 * 6.0 + 0.03 * 3.0)).abs() < 1e-4);
        assert!((y - (-0.25 - 2.0 * 0.0625 * 3.0 + 0.03 * 6.0)).abs() < 1e-4);
    }

    #[test]
    fn a_flat_picture_has_no_slope_even_at_its_edges() {
        for pixel in expand(&mut Expander::new(7, 1.5), &Plane::new(5, 3, 200.0)) {
            assert!(pixel.iter().all(|value| value.abs() < 1e-3), "{pixel:?}");
        }
    }
}

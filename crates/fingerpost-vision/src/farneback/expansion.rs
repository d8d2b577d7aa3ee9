//! Polynomial expansion: a quadratic polynomial around every pixel.

use crate::filter::gaussian_taps;
use crate::picture::Plane;

/// Coefficients of the polynomial around one pixel, `x` to the right and `y` down from it; its constant is not needed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Quadratic {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) xx: f32,
    pub(super) yy: f32,
    pub(super) xy: f32,
}

/// The polynomials around all pixels of a picture.
#[derive(Debug, Clone, Default)]
pub(super) struct Expansion {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) quadratics: Vec<Quadratic>,
}

/// Fits polynomials by Gaussian-weighted least squares (Farneback 2003).
///
/// With a symmetric separable weight `w(x) w(y)` of sum 1, the normal equations fall apart. With `b = sum w x^2` and `c =
/// sum w x^4`, and `m` for the weighted moments of the picture: `r_x = m_x / b`, `r_xx = (m_xx - b m_1) / (c - b^2)`, `r_xy
/// = m_xy / b^2`, and the same for y.
#[derive(Debug, Clone)]
pub(super) struct Expander {
    radius: usize,
    /// Weights at distances 0 to radius, and these times the distance and its square.
    weights: Vec<[f32; 3]>,
    /// `b` of the normal equations.
    second_moment: f32,
    inverse_first: f32,
    inverse_second: f32,
    inverse_mixed: f32,
    /// Moments along a column for each pixel of a row, with `radius` more on either side.
    columns: [Vec<f32>; 3],
    /// Moments of a row's pixels: 1, x, y, xx, yy, xy.
    moments: [Vec<f32>; 6],
}

impl Expander {
    pub(super) fn new(radius: usize, sigma_px: f64) -> Self {
        let taps = gaussian_taps(sigma_px, radius);
        let offsets = || (0..taps.len()).map(|tap| tap as f64 - radius as f64);
        let moment = |power| taps.iter().zip(offsets()).map(|(w, x)| w * x.powi(power)).sum::<f64>();
        let (second, fourth) = (moment(2), moment(4));
        let weights = taps[radius..]
            .iter()
            .enumerate()
            .map(|(distance, &w)| {
                let x = distance as f64;
                [w as f32, (w * x) as f32, (w * x * x) as f32]
            })
            .collect();
        Self {
            radius,
            weights,
            second_moment: second as f32,
            inverse_first: (1.0 / second) as f32,
            inverse_second: (1.0 / (fourth - second * second)) as f32,
            inverse_mixed: (1.0 / (second * second)) as f32,
            columns: Default::default(),
            moments: Default::default(),
        }
    }

    /// Expands `picture`, which beyond its edges is continued by its edge pixels.
    pub(super) fn expand(&mut self, picture: &Plane<f32>, expansion: &mut Expansion) {
        let (width, height) = picture.size();
        (expansion.width, expansion.height) = (width, height);
        expansion.quadratics.resize(width * height, Quadratic::default());
        self.columns.iter_mut().for_each(|column| column.resize(width + 2 * self.radius, 0.0));
        self.moments.iter_mut().for_each(|moment| moment.resize(width, 0.0));
        for y in 0..height {
            self.sum_columns(picture, y);
            self.sum_rows();
            let row = &mut expansion.quadratics[y * width..(y + 1) * width];
            let [m1, mx, my, mxx, myy, mxy] = &self.moments;
            for (x, quadratic) in row.iter_mut().enumerate() {
                let mean = self.second_moment * m1[x];
                *quadratic = Quadratic {
                    x: mx[x] * self.inverse_first,
                    y: my[x] * self.inverse_first,
                    xx: (mxx[x] - mean) * self.inverse_second,
                    yy: (myy[x] - mean) * self.inverse_second,
                    xy: mxy[x] * self.inverse_mixed,
                };
            }
        }
    }

    fn sum_columns(&mut self, picture: &Plane<f32>, y: usize) {
        let (width, height) = picture.size();
        let radius = self.radius;
        let [even, first, second] = &mut self.columns;
        let inner = radius..radius + width;
        let (even_row, first_row, second_row) =
            (&mut even[inner.clone()], &mut first[inner.clone()], &mut second[inner]);
        let w0 = self.weights[0][0];
        even_row.iter_mut().zip(picture.row(y)).for_each(|(sum, &value)| *sum = w0 * value);
        first_row.fill(0.0);
        second_row.fill(0.0);
        for (distance, &[w, wx, wxx]) in self.weights.iter().enumerate().skip(1) {
            let above = picture.row(y.saturating_sub(distance));
            let below = picture.row((y + distance).min(height - 1));
            let sums = even_row.iter_mut().zip(&mut *first_row).zip(&mut *second_row);
            for (((even, first), second), (&above, &below)) in sums.zip(above.iter().zip(below)) {
                let both = above + below;
                *even += w * both;
                *first += wx * (below - above);
                *second += wxx * both;
            }
        }
        for column in &mut self.columns {
            let (left, right) = (column[radius], column[radius + width - 1]);
            column[..radius].fill(left);
            column[radius + width..].fill(right);
        }
    }

    fn sum_rows(&mut self) {
        let radius = self.radius;
        let [even, first, second] = &self.columns;
        let [m1, mx, my, mxx, myy, mxy] = &mut self.moments;
        let width = m1.len();
        let w0 = self.weights[0][0];
        let scale = |out: &mut [f32], source: &[f32]| {
            out.iter_mut().zip(source).for_each(|(out, &value)| *out = w0 * value);
        };
        scale(m1, &even[radius..]);
        scale(my, &first[radius..]);
        scale(myy, &second[radius..]);
        mx.fill(0.0);
        mxx.fill(0.0);
        mxy.fill(0.0);
        for (distance, &[w, wx, wxx]) in self.weights.iter().enumerate().skip(1) {
            let left = radius - distance..radius - distance + width;
            let right = radius + distance..radius + distance + width;
            for (((m1, mx), mxx), (&l, &r)) in m1
                .iter_mut()
                .zip(&mut *mx)
                .zip(&mut *mxx)
                .zip(even[left.clone()].iter().zip(&even[right.clone()]))
            {
                *m1 += w * (l + r);
                *mx += wx * (r - l);
                *mxx += wxx * (l + r);
            }
            for ((my, mxy), (&l, &r)) in
                my.iter_mut().zip(&mut *mxy).zip(first[left.clone()].iter().zip(&first[right.clone()]))
            {
                *my += w * (l + r);
                *mxy += wx * (r - l);
            }
            for (myy, (&l, &r)) in myy.iter_mut().zip(second[left].iter().zip(&second[right])) {
                *myy += w * (l + r);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_picture_gives_its_own_coefficients() {
        let at = |x: f32, y: f32| 3.0 + 0.5 * x - 0.25 * y + 0.125 * x * x - 0.0625 * y * y + 0.03 * x * y;
        let values =
            (0..31 * 25).map(|index| at((index % 31) as f32 - 15.0, (index / 31) as f32 - 12.0)).collect();
        let picture = Plane::from_vec(31, 25, values).unwrap();
        let mut expansion = Expansion::default();
        Expander::new(5, 1.2).expand(&picture, &mut expansion);
        let centre = expansion.quadratics[12 * 31 + 15];
        let expected = Quadratic { x: 0.5, y: -0.25, xx: 0.125, yy: -0.0625, xy: 0.03 };
        for (found, expected) in [
            (centre.x, expected.x),
            (centre.y, expected.y),
            (centre.xx, expected.xx),
            (centre.yy, expected.yy),
            (centre.xy, expected.xy),
        ] {
            assert!((found - expected).abs() < 1e-4, "{centre:?}");
        }
        // Six pixels to the right and three down the slope is another.
        let moved = expansion.quadratics[15 * 31 + 21];
        assert!((moved.x - (0.5 + 2.0 * 0.125 * 6.0 + 0.03 * 3.0)).abs() < 1e-4);
        assert!((moved.y - (-0.25 - 2.0 * 0.0625 * 3.0 + 0.03 * 6.0)).abs() < 1e-4);
    }

    #[test]
    fn a_flat_picture_has_no_slope_even_at_its_edges() {
        let mut expansion = Expansion::default();
        Expander::new(7, 1.5).expand(&Plane::new(5, 3, 200.0), &mut expansion);
        for q in expansion.quadratics {
            assert!([q.x, q.y, q.xx, q.yy, q.xy].iter().all(|value| value.abs() < 1e-3), "{q:?}");
        }
    }
}

//! A cubic through points that never overshoots them.
//!
//! F. N. Fritsch and R. E. Carlson, "Monotone piecewise cubic interpolation", SIAM J. Numer. Anal. 17(2), 1980, with the
//! slopes of F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984: where the points rise, the curve rises;
//! where they turn, it is flat. Paper 3's shape-preserving spline.

/// A spline through points with rising abscissae.
///
/// ```
/// use fingerpost_geometry::Pchip;
/// let mut spline = Pchip::default();
/// spline.fit(&[[0.0, 0.0], [1.0, 1.0], [2.0, 1.0]]);
/// assert_eq!(spline.at(1.0), Some(1.0));
/// // Between level points it is level: no overshoot.
/// assert_eq!(spline.at(1.5), Some(1.0));
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pchip {
    points: Vec<[f64; 2]>,
    slopes: Vec<f64>,
}

impl Pchip {
    /// Lays the spline through `points` (abscissa, ordinate). Those that are not finite, or whose abscissa does not lie
    /// beyond the one before, are left out.
    pub fn fit(&mut self, points: &[[f64; 2]]) {
        self.points.clear();
        for &[x, y] in points {
            let beyond = self.points.last().is_none_or(|last| x > last[0]);
            if beyond && x.is_finite() && y.is_finite() {
                self.points.push([x, y]);
            }
        }
        self.slopes.clear();
        match self.points.len() {
            0 => {}
            1 => self.slopes.push(0.0),
            2 => self.slopes.resize(2, self.chord(0)),
            count => {
                self.slopes.push(self.end_slope([0, 1]));
                for i in 1..count - 1 {
                    self.slopes.push(self.inner_slope(i));
                }
                self.slopes.push(self.end_slope([count - 2, count - 3]));
            }
        }
    }

    /// The ordinate at `x`; none before the first point and beyond the last.
    #[must_use]
    pub fn at(&self, x: f64) -> Option<f64> {
        let (first, last) = (self.points.first()?, self.points.last()?);
        if !(first[0]..=last[0]).contains(&x) {
            return None;
        }
        let after = self.points.partition_point(|p| p[0] <= x).min(self.points.len() - 1);
        let Some(before) = after.checked_sub(1) else { return Some(first[1]) };
        let ([x0, y0], [x1, y1]) = (self.points[before], self.points[after]);
        let h = x1 - x0;
        let t = (x - x0) / h;
        let (m0, m1) = (h * self.slopes[before], h * self.slopes[after]);
        let (t2, t3) = (t * t, t * t * t);
        Some(
            (2.0 * t3 - 3.0 * t2 + 1.0) * y0
                + (t3 - 2.0 * t2 + t) * m0
                + (3.0 * t2 - 2.0 * t3) * y1
                + (t3 - t2) * m1,
        )
    }

    /// The points that the spline goes through.
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    fn step(&self, i: usize) -> f64 {
        self.points[i + 1][0] - self.points[i][0]
    }

    fn chord(&self, i: usize) -> f64 {
        (self.points[i + 1][1] - self.points[i][1]) / self.step(i)
    }

    /// The harmonic mean of the chords on either side, weighted by their lengths; 0 where they turn.
    fn inner_slope(&self, i: usize) -> f64 {
        let (before, after) = (self.chord(i - 1), self.chord(i));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (h0, h1) = (self.step(i - 1), self.step(i));
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        (w0 + w1) / (w0 / before + w1 / after)
    }

    /// The slope at an end, by three points; kept from turning against its chord and from more than three times it.
    fn end_slope(&self, chords: [usize; 2]) -> f64 {
        let [near, next] = chords.map(|i| self.chord(i));
        let [h0, h1] = chords.map(|i| self.step(i));
        let slope = ((2.0 * h0 + h1) * near - h0 * next) / (h0 + h1);
        if slope * near <= 0.0 {
            0.0
        } else if near * next <= 0.0 && slope.abs() > 3.0 * near.abs() {
            3.0 * near
        } else {
            slope
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy 1.17's `PchipInterpolator` on the same points.
    #[test]
    fn it_agrees_with_scipy() {
        let mut spline = Pchip::default();
        spline.fit(&[[0.0, 1.0], [1.0, 2.5], [3.0, 2.0], [4.0, 2.0], [6.5, 7.0]]);
        for (x, expected) in SCIPY {
            assert!((spline.at(x).unwrap() - expected).abs() < 1e-12, "{x}: {:?}", spline.at(x));
        }
    }

    const SCIPY: [(f64, f64); 5] =
        [(0.5, 2.0104166666666665), (1.5, 2.421875), (2.9, 2.003625), (3.5, 2.0), (6.0, 5.3828571428571435)];

    #[test]
    fn few_and_bad_points_are_survived() {
        let mut spline = Pchip::default();
        assert_eq!(spline.at(0.0), None);
        spline.fit(&[[1.0, 5.0]]);
        assert_eq!((spline.at(1.0), spline.at(1.1)), (Some(5.0), None));
        spline.fit(&[[0.0, 0.0], [f64::NAN, 3.0], [0.0, 9.0], [2.0, 4.0]]);
        assert_eq!(spline.at(1.0), Some(2.0));
    }
}

//! How an edge runs beside the lane's curve.
//!
//! Roads are uneven and lines are not painted straight: for some metres an edge lies a centimetre or two beside the curve
//! that both edges share. What its paint shows of that holds for the places near it, and the less the farther they are:
//! Gaussian process regression (C. E. Rasmussen and C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT Press
//! 2006, algorithm 2.1) with the Matérn covariance of order 3/2, whose curves have a direction that goes on for a while as
//! well. So the end of a dash says where the line goes on below it, more so than the median of a stretch would.

/// How far an edge runs beside the lane's curve, standard deviation, metres, and how long the road is over which that stays
/// alike, metres: a dash with a gap on either side.
const UNEVEN_M: f64 = 0.02;
const ALIKE_M: f64 = 8.0;
/// How ragged paint is, metres.
const RAGGED_M: f64 = 0.004;
/// Places beyond this many of their standard deviations lose weight (Cauchy).
const OUTLIER_SIGMAS: f64 = 2.0;

/// A place at which paint was seen.
#[derive(Debug, Clone, Copy)]
struct Seen {
    ahead_m: f64,
    /// How far left of the lane's curve it lies, metres.
    left_m: f64,
    variance_m2: f64,
}

/// How an edge runs beside the lane's curve, with the buffers that it needs.
#[derive(Debug, Default)]
pub(super) struct Unevenness {
    seen: Vec<Seen>,
    /// Covariances of the places without their own variances, the lower triangle row by row.
    covariances: Vec<f64>,
    /// Lower triangle of the factor of the covariance, row by row.
    factor: Vec<f64>,
    /// What each place adds to another by their covariance, 1/m.
    pulls: Vec<f64>,
}

impl Unevenness {
    /// Forgets what was seen.
    pub(super) fn clear(&mut self) {
        self.seen.clear();
        self.covariances.clear();
        self.factor.clear();
        self.pulls.clear();
    }

    /// Makes room for so many places, so that none is made while frames are taken in.
    pub(super) fn make_room(&mut self, places: usize) {
        self.seen.reserve(places);
        self.covariances.reserve(places * (places + 1) / 2);
        self.factor.reserve(places * (places + 1) / 2);
        self.pulls.reserve(places);
    }

    /// Notes paint that lies left of the lane's curve, with the standard deviation of that.
    pub(super) fn note(&mut self, ahead_m: f64, left_m: f64, sigma_m: f64) {
        self.seen.push(Seen { ahead_m, left_m, variance_m2: sigma_m * sigma_m + RAGGED_M * RAGGED_M });
    }

    /// Takes what was noted together: once as it is, and again with less of what does not fit.
    pub(super) fn fit(&mut self) {
        let Self { seen, covariances, .. } = self;
        covariances.clear();
        for (i, at) in seen.iter().enumerate() {
            covariances.extend(seen[..=i].iter().map(|other| covariance_m2(at.ahead_m - other.ahead_m)));
        }
        self.solve();
        for index in 0..self.seen.len() {
            let off_m = self.seen[index].left_m - self.left_of_m(index);
            self.seen[index].variance_m2 += off_m * off_m / (OUTLIER_SIGMAS * OUTLIER_SIGMAS);
        }
        self.solve();
    }

    /// How far left of the lane's curve the edge is at a place at which paint was seen, metres.
    fn left_of_m(&self, index: usize) -> f64 {
        let row = triangle(index);
        let before = &self.covariances[row..row + index];
        let from = (index..self.seen.len()).map(|other| &self.covariances[triangle(other) + index]);
        before.iter().chain(from).zip(&self.pulls).map(|(covariance_m2, pull)| covariance_m2 * pull).sum()
    }

    /// How far left of the lane's curve the edge is so far ahead, metres.
    pub(super) fn left_m(&self, ahead_m: f64) -> f64 {
        self.seen
            .iter()
            .zip(&self.pulls)
            .map(|(seen, pull)| covariance_m2(seen.ahead_m - ahead_m) * pull)
            .sum()
    }

    /// Solves for the pulls by a Cholesky factor; the variances keep it positive.
    fn solve(&mut self) {
        let Self { seen, covariances, factor, pulls } = self;
        factor.clear();
        pulls.clear();
        for (i, at) in seen.iter().enumerate() {
            let row = factor.len();
            let mut pull = at.left_m;
            for (j, covariance_m2) in covariances[row..=row + i].iter().enumerate() {
                let before = triangle(j);
                let mut value = *covariance_m2;
                value -= dot(&factor[row..row + j], &factor[before..before + j]);
                if j < i {
                    value /= factor[before + j];
                    pull -= value * pulls[j];
                } else {
                    value = (value + at.variance_m2).max(RAGGED_M * RAGGED_M).sqrt();
                    pull /= value;
                }
                factor.push(value);
            }
            pulls.push(pull);
        }
        for i in (0..pulls.len()).rev() {
            let row = triangle(i);
            pulls[i] /= factor[row + i];
            let pull = pulls[i];
            for (earlier, value) in pulls[..i].iter_mut().zip(&factor[row..row + i]) {
                *earlier -= value * pull;
            }
        }
    }
}

/// Where a row of a lower triangle begins.
const fn triangle(row: usize) -> usize {
    row * (row + 1) / 2
}

/// How alike two places are that lie so far apart, square metres.
fn covariance_m2(apart_m: f64) -> f64 {
    let lengths = 3.0_f64.sqrt() / ALIKE_M * apart_m.abs();
    UNEVEN_M * UNEVEN_M * (1.0 + lengths) * libm::exp(-lengths)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitted(places: impl Iterator<Item = (f64, f64)>) -> Unevenness {
        let mut unevenness = Unevenness::default();
        places.for_each(|(ahead_m, left_m)| unevenness.note(ahead_m, left_m, 0.004));
        unevenness.fit();
        unevenness
    }

    /// A dash of 3 m from `from_m` on whose paint lies beside the curve by `left_m`.
    fn dash(from_m: f64, left_m: impl Fn(f64) -> f64) -> Unevenness {
        fitted((0..=12).map(|i| from_m + 0.25 * f64::from(i)).map(|ahead_m| (ahead_m, left_m(ahead_m))))
    }

    #[test]
    fn nothing_seen_is_nothing_beside_the_curve() {
        assert!(fitted(std::iter::empty()).left_m(8.0).abs() < 1e-12);
    }

    #[test]
    fn the_edge_runs_where_its_paint_is_and_goes_on_that_way() {
        let slanting = dash(9.0, |ahead_m| 0.006 * (ahead_m - 10.5));
        assert!((slanting.left_m(9.0) - -0.009).abs() < 2e-3, "{}", slanting.left_m(9.0));
        assert!((slanting.left_m(12.0) - 0.009).abs() < 2e-3, "{}", slanting.left_m(12.0));
        // Below the dash it goes on, less far than a straight line would.
        assert!((-0.021..-0.010).contains(&slanting.left_m(7.0)), "{}", slanting.left_m(7.0));
    }

    #[test]
    fn what_is_far_from_all_paint_is_the_curve_itself() {
        let beside = dash(9.0, |_| 0.02);
        assert!((beside.left_m(10.0) - 0.02).abs() < 2e-3);
        assert!(beside.left_m(60.0).abs() < 1e-3);
        assert!((0.0..0.02).contains(&beside.left_m(5.0)));
    }

    #[test]
    fn a_stray_place_moves_it_little() {
        let places = (0..=12).map(|i| (9.0 + 0.25 * f64::from(i), if i == 6 { 0.08 } else { 0.0 }));
        assert!(fitted(places).left_m(10.5).abs() < 5e-3);
    }
}

//! The road's plane as two ground views show it: what displaces level ground between them.
//!
//! Two views that are superimposed by the ego-motion and the camera's attitude do not agree quite even on level road. An
//! error of the way driven displaces all of it alike; one of the pitch, which is both views', by 2 x d / h a radian at a place x
//! ahead after a way d, seen from a height h; a change of pitch between them by x^2 / h; roll, or a road that falls to one side, by
//! y d / h, and a change of it by x y / h. So the displacement is a + b x + c x^2 + (e + f x) y, fitted to what blocks of the road ahead
//! show, with what is known of motion and attitude as the prior.

use nalgebra::{SMatrix, SVector};

/// Standard deviation of the way driven, share of it, and metres.
const WAY_SIGMA: [f64; 2] = [0.015, 0.03];
/// Of the pitch that both views share, and of its change between them, radians.
const PITCH_SIGMA_RAD: f64 = 0.006;
const PITCH_CHANGE_SIGMA_RAD: f64 = 0.004;
/// Of the roll, or of the road's fall to one side; and of its change.
const ROLL_SIGMA_RAD: f64 = 0.015;
const ROLL_CHANGE_SIGMA_RAD: f64 = 0.003;
/// What blocks scatter by beside their own uncertainty, metres: roads are not planes.
const UNEVEN_M: f64 = 0.02;
/// A block farther off than about this counts little, standard deviations (Cauchy's weight).
const FAR_OFF_SIGMAS: f64 = 2.0;
/// Times that weights and fit are computed.
const ROUNDS: usize = 5;

/// What one block of road shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Displaced {
    /// Ahead of the camera's foot and left of it, metres.
    pub(super) place: [f64; 2],
    /// Displacement along the way, metres.
    pub(super) by_m: f64,
    pub(super) sigma_m: f64,
}

/// Displacement of level ground, metres: coefficients of 1, x, x^2, y and x y.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PlaneFit {
    coefficients: [f64; 5],
    /// Root mean square of what the blocks that count leave, metres.
    pub(super) residual_m: f64,
    /// Blocks, by their weight.
    pub(super) blocks: f64,
}

impl PlaneFit {
    /// Fits to `blocks`, for views `way_m` apart from a camera of this height. Displacements are counted from `before`.
    pub(super) fn of(blocks: &[Displaced], before: &Self, way_m: f64, camera_height_m: f64) -> Self {
        let h = camera_height_m;
        let sigmas = [
            WAY_SIGMA[0] * way_m + WAY_SIGMA[1],
            2.0 * way_m * PITCH_SIGMA_RAD / h,
            PITCH_CHANGE_SIGMA_RAD / h,
            ROLL_SIGMA_RAD * way_m / h,
            ROLL_CHANGE_SIGMA_RAD / h,
        ];
        let prior = SVector::<f64, 5>::from(sigmas.map(|sigma| 1.0 / (sigma * sigma)));
        let mut fit = *before;
        for _ in 0..ROUNDS {
            let mut information = SMatrix::<f64, 5, 5>::from_diagonal(&prior);
            let mut vector = SVector::<f64, 5>::zeros();
            let (mut weights, mut squares) = (0.0, 0.0);
            for block in blocks {
                let row = terms(block.place);
                let by_m = block.by_m + before.at(block.place);
                let off_m = by_m - fit.at(block.place);
                let variance = block.sigma_m * block.sigma_m + UNEVEN_M * UNEVEN_M;
                let far = off_m / (FAR_OFF_SIGMAS * variance.sqrt());
                let weight = 1.0 / (1.0 + far * far);
                information += row * row.transpose() * (weight / variance);
                vector += row * (by_m * weight / variance);
                weights += weight;
                squares += weight * off_m * off_m;
            }
            let Some(solved) = information.cholesky() else { return *before };
            fit.coefficients = solved.solve(&vector).into();
            (fit.blocks, fit.residual_m) = (weights, (squares / weights.max(1.0)).sqrt());
        }
        fit
    }

    /// Displacement at a place ahead of the camera's foot and left of it, metres.
    fn at(&self, place: [f64; 2]) -> f64 {
        terms(place).dot(&SVector::from(self.coefficients))
    }

    /// At x metres ahead: that at y = 0, and by how much it grows with each metre to the left.
    pub(super) fn along_row(&self, x: f64) -> [f64; 2] {
        let [a, b, c, e, f] = self.coefficients;
        [a + x * (b + x * c), e + f * x]
    }
}

fn terms([x, y]: [f64; 2]) -> SVector<f64, 5> {
    SVector::from([1.0, x, x * x, y, x * y])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pitch_and_roll_come_out_of_the_strip_and_a_pavement_beside_it_does_not_count() {
        let (way_m, height_m, pitch_rad, roll_rad) = (4.0, 1.5, 0.004, 0.01);
        let level = |x: f64, y: f64| {
            (2.0 * x * way_m + way_m * way_m) * pitch_rad / height_m - y * way_m * roll_rad / height_m
        };
        let raised_m = way_m * 0.12 / (height_m - 0.12);
        let places =
            (0..12).flat_map(|i| (0..7).map(move |j| [4.0 + 0.6 * f64::from(i), 0.5 * f64::from(j) - 1.5]));
        let blocks: Vec<Displaced> = places
            .map(|[x, y]| {
                let by_m = level(x, y) + if y > 1.2 { raised_m } else { 0.0 };
                Displaced { place: [x, y], by_m, sigma_m: 0.01 }
            })
            .collect();
        let fit = PlaneFit::of(&blocks, &PlaneFit::default(), way_m, height_m);
        for [x, y] in [[5.0, 0.0], [10.0, 0.0], [7.0, 1.0], [7.0, -1.0]] {
            let off_m = fit.at([x, y]) - level(x, y);
            assert!(off_m.abs() < 0.02, "{x}, {y}: {off_m}");
        }
        let [at_axis, to_left] = fit.along_row(7.0);
        assert!((at_axis + to_left - fit.at([7.0, 1.0])).abs() < 1e-12);
    }
}

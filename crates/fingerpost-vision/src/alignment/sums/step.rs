//! The sums of a Gauss-Newton step over the points.

use super::{LANES, Lanes, UNKNOWNS};
use crate::simd::simd_kernel;

/// Entries of a symmetric matrix of the unknowns.
pub(super) const PRODUCTS: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;
/// Rows and columns of those entries.
pub(super) const ENTRIES: [(usize, usize); PRODUCTS] = {
    let (mut entries, mut next, mut row) = ([(0, 0); PRODUCTS], 0, 0);
    while row < UNKNOWNS {
        let mut column = row;
        while column < UNKNOWNS {
            entries[next] = (row, column);
            (next, column) = (next + 1, column + 1);
        }
        row += 1;
    }
    entries
};

/// What the sums of a step are taken over.
pub(super) struct StepPoints<'a> {
    pub(super) descent: [&'a [Lanes]; UNKNOWNS],
    pub(super) residuals: &'a [Lanes],
    pub(super) weights: &'a [Lanes],
    pub(super) trust: &'a [Lanes],
}

/// The sums of a step, lane by lane: of the weighted products of the steepest-descent images, entry by entry, of those with
/// the residuals, and of the first one's squares.
pub(super) struct StepSums {
    pub(super) products: [Lanes; PRODUCTS],
    pub(super) gradient: [Lanes; UNKNOWNS],
    pub(super) unweighted: Lanes,
}

simd_kernel! {
    pub(super) fn accumulate(points: &StepPoints<'_>) -> StepSums {
        let StepPoints { descent, residuals, weights, trust } = *points;
        let groups = residuals.len();
        let (descent, weights) = (descent.map(|lanes| &lanes[..groups]), &weights[..groups]);
        let trust = &trust[..groups];
        let mut products = [[0.0_f32; LANES]; PRODUCTS];
        let mut gradient = [[0.0_f32; LANES]; UNKNOWNS];
        let mut unweighted = [0.0_f32; LANES];
        for group in 0..groups {
            let (weights, residuals) = (&weights[group], &residuals[group]);
            let mut weighted = [[0.0_f32; LANES]; UNKNOWNS];
            for i in 0..UNKNOWNS {
                for lane in 0..LANES {
                    weighted[i][lane] = weights[lane] * descent[i][group][lane];
                    gradient[i][lane] += weighted[i][lane] * residuals[lane];
                }
            }
            for lane in 0..LANES {
                let slope = descent[0][group][lane];
                let trusted = if weights[lane] > 0.0 { trust[group][lane] } else { 0.0 };
                unweighted[lane] += trusted * (slope * slope);
            }
            for (sum, (row, column)) in products.iter_mut().zip(ENTRIES) {
                let slopes = &descent[column][group];
                for lane in 0..LANES {
                    sum[lane] += weighted[row][lane] * slopes[lane];
                }
            }
        }
        StepSums { products, gradient, unweighted }
    }
}

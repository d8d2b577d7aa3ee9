//! What the whole picture says to each of its places: the mean of the smallest level, through a layer, added to all of them.

use super::dense::Places;
use super::requantising::{RECTIFIED, rounded};
use super::tensor::Tensor;
use super::weights::Context;
use crate::simd::{CodePath, simd_kernel};

/// Memory for a context.
#[derive(Debug, Clone)]
pub(super) struct ContextRows {
    sums: Vec<u32>,
    mean: Vec<u8>,
    context: Vec<u8>,
}

impl ContextRows {
    pub(super) fn new(channels: usize) -> Self {
        Self { sums: vec![0; channels], mean: vec![0; channels], context: vec![0; channels] }
    }

    /// Adds the context to `level`.
    pub(super) fn add(&mut self, path: CodePath, weights: &Context, level: &mut Tensor) {
        self.sums.fill(0);
        for y in 0..level.height() {
            sum_up(path, level.row(y), &mut self.sums);
        }
        for (mean, &sum) in self.mean.iter_mut().zip(&self.sums) {
            *mean = rounded(sum as f32 * weights.mean_scale, RECTIFIED) as u8;
        }
        let channels = self.mean.len();
        let place = Places { rows: [&self.mean], length: channels, step: channels };
        weights.pointwise.apply::<1, RECTIFIED>(path, place, None, &mut self.context);
        for y in 0..level.height() {
            add(path, &self.context, [weights.place_scale, weights.context_scale], level.row_mut(y));
        }
    }
}

simd_kernel! {
    fn sum_up(row: &[u8], sums: &mut [u32]) {
        for place in row.chunks_exact(sums.len()) {
            for (sum, &value) in sums.iter_mut().zip(place) {
                *sum += u32::from(value);
            }
        }
    }
}

simd_kernel! {
    fn add(context: &[u8], scales: [f32; 2], row: &mut [u8]) {
        for place in row.chunks_exact_mut(context.len()) {
            for (value, &context) in place.iter_mut().zip(context) {
                let sum = f32::from(*value) * scales[0] + f32::from(context) * scales[1];
                *value = rounded(sum, RECTIFIED) as u8;
            }
        }
    }
}

//! Sixteen channels at a time, from left to right.

use std::arch::x86_64::*;

use super::super::requantising::avx2::{add_products, halves, scaled, store, widened};
use super::super::requantising::{LANES, RECTIFIED};
use super::{Block, SIDE, Windows};

/// What [`super::apply`] does.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn apply(blocks: &[Block], windows: Windows<'_>, out: &mut [u8]) {
    let channels = blocks.len() * LANES;
    for (index, block) in blocks.iter().enumerate() {
        let channel = index * LANES;
        let weights = [0, 1, 2].map(|column| halves(&block.weights[column]));
        let bias = halves(&block.bias);
        let column = |at: usize| together(windows.column(at, channel, channels));
        let mut columns: [[__m256i; 2]; SIDE] = [column(0), column(1), column(2)];
        for (place, out) in out.chunks_exact_mut(channels).enumerate() {
            if place > 0 {
                let first = place * windows.step;
                columns = match windows.step {
                    1 => [columns[1], columns[2], column(first + 2)],
                    _ => [columns[2], column(first + 1), column(first + 2)],
                };
            }
            let mut sums = bias;
            for (column, weights) in columns.iter().zip(&weights) {
                sums = [0, 1].map(|half| add_products(sums[half], column[half], weights[half]));
            }
            if let Some(out) = out[channel..].first_chunk_mut() {
                store::<RECTIFIED>(scaled(sums, &block.multiplier), out);
            }
        }
    }
}

/// The places of a column in one lane: upper, middle, lower, 0.
#[inline]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn together(column: [&[u8; LANES]; SIDE]) -> [__m256i; 2] {
    let [upper, middle, lower] = column.map(|bytes| widened(bytes));
    [0, 1].map(|half| {
        let lower = _mm256_or_si256(_mm256_slli_epi32::<16>(lower[half]), upper[half]);
        _mm256_or_si256(_mm256_slli_epi32::<8>(middle[half]), lower)
    })
}

//! Sixteen channels at a time, from left to right.

use std::arch::x86_64::*;

use super::super::requantising::avx512::{scaled, store, whole, widened};
use super::super::requantising::{LANES, RECTIFIED};
use super::{Block, SIDE, Windows};

/// What [`super::apply`] does.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx512vnni,avx2")]
pub(super) fn apply(blocks: &[Block], windows: Windows<'_>, out: &mut [u8]) {
    let channels = blocks.len() * LANES;
    for (index, block) in blocks.iter().enumerate() {
        let channel = index * LANES;
        let weights = [0, 1, 2].map(|column| whole(&block.weights[column]));
        let bias = whole(&block.bias);
        let column = |at: usize| together(windows.column(at, channel, channels));
        let mut columns: [__m512i; SIDE] = [column(0), column(1), column(2)];
        for (place, out) in out.chunks_exact_mut(channels).enumerate() {
            if place > 0 {
                let first = place * windows.step;
                columns = match windows.step {
                    1 => [columns[1], columns[2], column(first + 2)],
                    _ => [columns[2], column(first + 1), column(first + 2)],
                };
            }
            let mut sum = bias;
            for (column, weights) in columns.iter().zip(&weights) {
                sum = _mm512_dpbusd_epi32(sum, *column, *weights);
            }
            if let Some(out) = out[channel..].first_chunk_mut() {
                store::<RECTIFIED>(scaled(sum, &block.multiplier), out);
            }
        }
    }
}

/// The places of a column in one lane: upper, middle, lower, 0.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx512vnni,avx2")]
fn together(column: [&[u8; LANES]; SIDE]) -> __m512i {
    let [upper, middle, lower] = column.map(|bytes| widened(bytes));
    let lower = _mm512_or_si512(_mm512_slli_epi32::<16>(lower), upper);
    _mm512_or_si512(_mm512_slli_epi32::<8>(middle), lower)
}

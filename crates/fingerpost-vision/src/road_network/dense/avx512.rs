//! The products of eight places with a block's weights at a time, which are loaded once for all of them.

use std::arch::x86_64::*;

use super::super::requantising::avx512::{scaled, store, whole, widened};
use super::{Added, Block, GROUP, LANES, Places, lanes_of};

/// Places whose sums are under way together: as many as hide how long one takes.
const TOGETHER: usize = 8;

/// What [`super::apply`] does.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx512vnni,avx2")]
pub(super) fn apply<const ROWS: usize, const LOW: i32>(
    blocks: &[Block],
    places: Places<'_, ROWS>,
    added: Option<Added<'_>>,
    out: &mut [u8],
) {
    let outputs = blocks.len() * LANES;
    let count = out.len() / outputs;
    let all = count - count % TOGETHER;
    for (index, block) in blocks.iter().enumerate() {
        for first in (0..all).step_by(TOGETHER) {
            together::<ROWS, TOGETHER, LOW>(block, places, added, first, (index * LANES, outputs), out);
        }
        for place in all..count {
            together::<ROWS, 1, LOW>(block, places, added, place, (index * LANES, outputs), out);
        }
    }
}

/// A block's outputs of `COUNT` neighbouring places.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx512vnni,avx2")]
fn together<const ROWS: usize, const COUNT: usize, const LOW: i32>(
    block: &Block,
    places: Places<'_, ROWS>,
    added: Option<Added<'_>>,
    first: usize,
    (channel, outputs): (usize, usize),
    out: &mut [u8],
) {
    let mut sums = [whole(&block.bias); COUNT];
    let inputs: [[&[[u8; GROUP]]; ROWS]; COUNT] = std::array::from_fn(|at| places.place(first + at));
    let mut rest = &block.weights[..];
    for row in 0..ROWS {
        let inputs: [&[[u8; GROUP]]; COUNT] = std::array::from_fn(|at| inputs[at][row]);
        let groups = inputs[0].len();
        let (weights, further) = rest.split_at(groups);
        rest = further;
        // Of one length, so that no index is checked in the loop.
        let inputs = inputs.map(|input| &input[..groups]);
        for (group, weights) in weights.iter().enumerate() {
            let weights = whole(weights);
            for (sum, input) in sums.iter_mut().zip(inputs) {
                let four = _mm512_set1_epi32(i32::from_le_bytes(input[group]));
                *sum = _mm512_dpbusd_epi32(*sum, four, weights);
            }
        }
    }
    for (at, sum) in sums.into_iter().enumerate() {
        let index = (first + at) * outputs + channel;
        let mut scaled = scaled(sum, &block.multiplier);
        if let Some(added) = added {
            let bytes = _mm512_cvtepi32_ps(widened(added.lanes(index)));
            scaled = _mm512_add_ps(scaled, _mm512_mul_ps(bytes, _mm512_set1_ps(added.factor)));
        }
        if let Some(out) = lanes_of(out, index) {
            store::<LOW>(scaled, out);
        }
    }
}

//! The products of four places with a block's weights at a time, which are loaded once for all of them.

use std::arch::x86_64::*;

use super::super::requantising::avx2::{add_products, halves, scaled, store, widened};
use super::{Added, Block, GROUP, LANES, Places, lanes_of};

/// Places whose sums fit the registers beside the weights.
const TOGETHER: usize = 4;

/// What [`super::apply`] does.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn apply<const ROWS: usize, const LOW: i32>(
    blocks: &[Block],
    places: Places<'_, ROWS>,
    added: Option<Added<'_>>,
    out: &mut [u8],
) {
    let outputs = blocks.len() * LANES;
    let count = out.len() / outputs;
    let whole = count - count % TOGETHER;
    for (index, block) in blocks.iter().enumerate() {
        for first in (0..whole).step_by(TOGETHER) {
            together::<ROWS, TOGETHER, LOW>(block, places, added, first, (index * LANES, outputs), out);
        }
        for place in whole..count {
            together::<ROWS, 1, LOW>(block, places, added, place, (index * LANES, outputs), out);
        }
    }
}

/// A block's outputs of `COUNT` neighbouring places.
#[inline]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn together<const ROWS: usize, const COUNT: usize, const LOW: i32>(
    block: &Block,
    places: Places<'_, ROWS>,
    added: Option<Added<'_>>,
    first: usize,
    (channel, outputs): (usize, usize),
    out: &mut [u8],
) {
    let mut sums = [halves(&block.bias); COUNT];
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
            let weights = halves(weights);
            for (sums, input) in sums.iter_mut().zip(inputs) {
                let four = _mm256_set1_epi32(i32::from_le_bytes(input[group]));
                *sums = [0, 1].map(|half| add_products(sums[half], four, weights[half]));
            }
        }
    }
    for (at, sums) in sums.into_iter().enumerate() {
        let index = (first + at) * outputs + channel;
        let mut scaled = scaled(sums, &block.multiplier);
        if let Some(added) = added {
            let bytes = widened(added.lanes(index));
            let factor = _mm256_set1_ps(added.factor);
            scaled = [0, 1].map(|half| {
                _mm256_add_ps(scaled[half], _mm256_mul_ps(_mm256_cvtepi32_ps(bytes[half]), factor))
            });
        }
        if let Some(out) = lanes_of(out, index) {
            store::<LOW>(scaled, out);
        }
    }
}

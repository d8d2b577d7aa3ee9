//! Products of places with a matrix: pointwise convolutions, and the full one of the stem, whose nine places are one long one.
//!
//! Weights are kept in blocks of sixteen outputs; of each block those of four neighbouring inputs stand together, as
//! instructions take them that sum up four products at once.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

use super::requantising::{LANES, Lanes, rounded};
use super::weights::Layer;
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;
use crate::simd::{CodePath, simd_kernel};

/// Inputs whose products are summed up at once.
const GROUP: usize = 4;

/// A matrix with biases and multipliers.
#[derive(Debug, Clone)]
pub(super) struct Dense {
    inputs: usize,
    blocks: Vec<Block>,
}

/// Sixteen outputs; those that a layer does not have are 0.
#[derive(Debug, Clone)]
struct Block {
    weights: Vec<Lanes<[i8; GROUP]>>,
    bias: Lanes<i32>,
    multiplier: Lanes<f32>,
}

/// What a row of places is read from: the inputs of a place are `length` bytes of each of `rows`, those of the next place begin
/// `step` bytes further.
#[derive(Clone, Copy)]
pub(super) struct Places<'a, const ROWS: usize> {
    pub(super) rows: [&'a [u8]; ROWS],
    pub(super) length: usize,
    pub(super) step: usize,
}

/// What is added to scaled sums: bytes of the outputs' places and channels, and their factor.
#[derive(Clone, Copy)]
pub(super) struct Added<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) factor: f32,
}

impl Dense {
    /// A layer with `inputs` inputs, a multiple of four.
    pub(super) fn new(inputs: usize, layer: &Layer<'_>) -> Self {
        let blocks = (0..layer.bias.len().div_ceil(LANES)).map(|block| {
            let lane = |lane: usize| block * LANES + lane;
            let weights = (0..inputs / GROUP).map(|group| {
                Lanes(std::array::from_fn(|at| {
                    let weights = layer.weights.get(lane(at) * inputs + group * GROUP..);
                    let four = weights.and_then(<[u8]>::first_chunk::<GROUP>).copied();
                    four.unwrap_or_default().map(u8::cast_signed)
                }))
            });
            Block {
                weights: weights.collect(),
                bias: Lanes(std::array::from_fn(|at| layer.bias.get(lane(at)).copied().unwrap_or(0))),
                multiplier: Lanes(std::array::from_fn(|at| {
                    layer.multiplier.get(lane(at)).copied().unwrap_or(0.0)
                })),
            }
        });
        Self { inputs, blocks: blocks.collect() }
    }

    /// Inputs of a place.
    pub(super) fn inputs(&self) -> usize {
        self.inputs
    }

    /// Outputs of a place, filled up to whole blocks.
    pub(super) fn outputs(&self) -> usize {
        self.blocks.len() * LANES
    }

    /// Takes from every bias what a zero point of `zero` adds to the sums.
    pub(super) fn fold_zero_point(&mut self, zero: i32) {
        for block in &mut self.blocks {
            for (lane, bias) in block.bias.0.iter_mut().enumerate() {
                let of_lane = block.weights.iter().flat_map(|group| group.0[lane]);
                *bias -= zero * of_lane.map(i32::from).sum::<i32>();
            }
        }
    }

    /// Fills a row with the outputs of its places, from `LOW` to 127: [`Dense::outputs`] bytes each. There are as many places as
    /// fit `out`.
    pub(super) fn apply<const ROWS: usize, const LOW: i32>(
        &self,
        path: CodePath,
        places: Places<'_, ROWS>,
        added: Option<Added<'_>>,
        out: &mut [u8],
    ) {
        debug_assert_eq!(ROWS * places.length, self.inputs);
        match path.instruction_set() {
            // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
            // Benefit: see the function.
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            InstructionSet::Avx2 => unsafe { avx2::apply::<ROWS, LOW>(&self.blocks, places, added, out) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            InstructionSet::Avx512 => unsafe {
                avx512::apply::<ROWS, LOW>(&self.blocks, places, added, out);
            },
            _ => apply::<ROWS, LOW>(path, &self.blocks, places, added, out),
        }
    }
}

impl<'a, const ROWS: usize> Places<'a, ROWS> {
    /// The inputs of a place, in groups of four a row.
    #[inline(always)]
    fn place(&self, place: usize) -> [&'a [[u8; GROUP]]; ROWS] {
        let start = place * self.step;
        self.rows.map(|row| row[start..start + self.length].as_chunks().0)
    }
}

impl<'a> Added<'a> {
    /// Sixteen bytes at the outputs' index.
    #[inline(always)]
    fn lanes(&self, index: usize) -> &'a [u8; LANES] {
        self.bytes[index..].first_chunk().unwrap_or(&[0; LANES])
    }
}

/// Sixteen outputs at their index.
#[inline(always)]
fn lanes_of(out: &mut [u8], index: usize) -> Option<&mut [u8; LANES]> {
    out[index..].first_chunk_mut()
}

simd_kernel! {
    fn apply<const ROWS: usize, const LOW: i32>(
        blocks: &[Block], places: Places<'_, ROWS>, added: Option<Added<'_>>, out: &mut [u8],
    ) {
        let outputs = blocks.len() * LANES;
        for (place, out) in out.chunks_exact_mut(outputs).enumerate() {
            let inputs = places.place(place);
            for (index, (block, out)) in blocks.iter().zip(out.as_chunks_mut::<LANES>().0).enumerate() {
                let mut sums = block.bias.0;
                let mut rest = &block.weights[..];
                for row in inputs {
                    let (weights, further) = rest.split_at(row.len());
                    rest = further;
                    for (four, weights) in row.iter().zip(weights) {
                        let four = four.map(i32::from);
                        for (sum, weights) in sums.iter_mut().zip(&weights.0) {
                            let w = weights.map(i32::from);
                            *sum += (four[0] * w[0] + four[1] * w[1]) + (four[2] * w[2] + four[3] * w[3]);
                        }
                    }
                }
                let mut scaled = [0.0_f32; LANES];
                for lane in 0..LANES {
                    scaled[lane] = sums[lane] as f32 * block.multiplier.0[lane];
                }
                if let Some(added) = added {
                    let bytes = added.lanes(place * outputs + index * LANES);
                    for (scaled, &byte) in scaled.iter_mut().zip(bytes) {
                        *scaled += f32::from(byte) * added.factor;
                    }
                }
                for (out, scaled) in out.iter_mut().zip(scaled) {
                    *out = rounded(scaled, LOW) as u8;
                }
            }
        }
    }
}

//! Depthwise 3 x 3 convolutions: each channel with nine weights of its own.
//!
//! The weights of a column stand together, upper, middle, lower and 0, as instructions take them that sum up four products at
//! once. Columns are put together the same way, and kept for the places beside theirs.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

use super::requantising::{LANES, Lanes, RECTIFIED, rounded};
use super::weights::Layer;
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;
use crate::simd::{CodePath, simd_kernel};

/// Rows and columns of a window.
const SIDE: usize = 3;

/// The weights of all channels.
#[derive(Debug, Clone)]
pub(super) struct Depthwise {
    blocks: Vec<Block>,
}

/// Sixteen channels.
#[derive(Debug, Clone)]
struct Block {
    /// Column by column.
    weights: [Lanes<[i8; 4]>; SIDE],
    bias: Lanes<i32>,
    multiplier: Lanes<f32>,
}

/// What a row is made from: three rows of places, with one place more to either side. The middle of a place's window lies `step`
/// places beyond that of the one before it.
#[derive(Clone, Copy)]
pub(super) struct Windows<'a> {
    pub(super) rows: [&'a [u8]; SIDE],
    pub(super) step: usize,
}

impl Depthwise {
    /// A layer of a multiple of sixteen channels.
    pub(super) fn new(layer: &Layer<'_>) -> Self {
        let of_channel = layer.weights.as_chunks::<{ SIDE * SIDE }>().0;
        let blocks = of_channel.as_chunks::<LANES>().0.iter();
        let numbers = layer.bias.as_chunks::<LANES>().0.iter().zip(layer.multiplier.as_chunks::<LANES>().0);
        let blocks = blocks.zip(numbers).map(|(weights, (&bias, &multiplier))| Block {
            weights: std::array::from_fn(|column| {
                Lanes(weights.map(|nine| {
                    let at = |row: usize| nine[row * SIDE + column].cast_signed();
                    [at(0), at(1), at(2), 0]
                }))
            }),
            bias: Lanes(bias),
            multiplier: Lanes(multiplier),
        });
        Self { blocks: blocks.collect() }
    }

    /// Channels of a place.
    pub(super) fn channels(&self) -> usize {
        self.blocks.len() * LANES
    }

    /// Fills a row with as many places as fit it.
    pub(super) fn apply(&self, path: CodePath, windows: Windows<'_>, out: &mut [u8]) {
        match path.instruction_set() {
            // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
            // Benefit: see the function.
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            InstructionSet::Avx2 => unsafe { avx2::apply(&self.blocks, windows, out) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            InstructionSet::Avx512 => unsafe { avx512::apply(&self.blocks, windows, out) },
            _ => apply(path, &self.blocks, windows, out),
        }
    }
}

impl<'a> Windows<'a> {
    /// Sixteen channels of the three places in a column; a column is a place of the rows.
    #[inline(always)]
    fn column(&self, column: usize, channel: usize, channels: usize) -> [&'a [u8; LANES]; SIDE] {
        let start = column * channels + channel;
        self.rows.map(|row| row[start..].first_chunk().unwrap_or(&[0; LANES]))
    }
}

simd_kernel! {
    fn apply(blocks: &[Block], windows: Windows<'_>, out: &mut [u8]) {
        let channels = blocks.len() * LANES;
        for (place, out) in out.chunks_exact_mut(channels).enumerate() {
            for (index, (block, out)) in blocks.iter().zip(out.as_chunks_mut::<LANES>().0).enumerate() {
                let mut sums = block.bias.0;
                for (at, weights) in block.weights.iter().enumerate() {
                    let column = windows.column(place * windows.step + at, index * LANES, channels);
                    for (lane, sum) in sums.iter_mut().enumerate() {
                        let product = |row: usize| i32::from(column[row][lane]) * i32::from(weights.0[lane][row]);
                        *sum += product(0) + product(1) + product(2);
                    }
                }
                for lane in 0..LANES {
                    out[lane] = rounded(sums[lane] as f32 * block.multiplier.0[lane], RECTIFIED) as u8;
                }
            }
        }
    }
}

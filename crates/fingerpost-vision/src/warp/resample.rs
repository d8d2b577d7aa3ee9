//! The bilinear sums of a warp, run by run.

use crate::simd::CodePath;
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;

/// Bits of the four weights' sum, [`super::STEPS_PER_PX`] squared.
pub(super) const WEIGHT_BITS: u32 = 10;
pub(super) const HALF: u32 = 1 << (WEIGHT_BITS - 1);

/// Weights of the upper and the lower row and of the left and the right column, steps; each pair sums to
/// [`super::STEPS_PER_PX`].
pub(super) type Weights = [u8; 4];

/// How far apart the four source pixels lie, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Neighbours {
    /// From a pixel to the one on its right; 0 in a source one pixel wide, where the right weight is 0.
    pub(super) right: usize,
    /// From a pixel to the one below it; 0 in a source one pixel high, where the lower weight is 0.
    pub(super) below: usize,
}

/// Where the pixels of a run look, and with which weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taps<'a> {
    pub(super) indices: &'a [u32],
    pub(super) weights: &'a [Weights],
}

impl<'a> Taps<'a> {
    /// The taps of the first `count` pixels, and the others.
    pub(super) fn split_at(self, count: usize) -> (Self, Self) {
        let (indices, other_indices) = self.indices.split_at(count);
        let (weights, other_weights) = self.weights.split_at(count);
        (Self { indices, weights }, Self { indices: other_indices, weights: other_weights })
    }

    /// The taps of `count` pixels from `start` on.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn part(self, start: usize, count: usize) -> Self {
        let part = start..start + count;
        Self { indices: &self.indices[part.clone()], weights: &self.weights[part] }
    }
}

/// Resamples one run of colour pixels.
pub(super) fn resample_rgb(
    path: CodePath,
    source: &[[u8; 3]],
    neighbours: Neighbours,
    taps: Taps<'_>,
    target: &mut [[u8; 3]],
) {
    match path.instruction_set() {
        // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
        // Benefit: 7.2 times as fast as the plain loop on Zen 4 at 960 x 540 to 512 x 512.
        #[cfg(target_arch = "x86_64")]
        #[allow(unsafe_code)]
        InstructionSet::Avx2 => unsafe { super::avx2::resample_rgb(source, neighbours, taps, target) },
        // SAFETY: as above. Benefit: 8.1 times as fast as the plain loop.
        #[cfg(target_arch = "x86_64")]
        #[allow(unsafe_code)]
        InstructionSet::Avx512 => unsafe { super::avx512::resample_rgb(source, neighbours, taps, target) },
        _ => resample(source, neighbours, taps, target),
    }
}

/// Resamples one run of grey pixels.
pub(super) fn resample_grey(
    path: CodePath,
    source: &[u8],
    neighbours: Neighbours,
    taps: Taps<'_>,
    target: &mut [u8],
) {
    match path.instruction_set() {
        // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
        // Benefit: see the function.
        #[cfg(target_arch = "x86_64")]
        #[allow(unsafe_code)]
        InstructionSet::Avx512 => unsafe { super::windows::resample_grey(source, neighbours, taps, target) },
        _ => resample(source.as_chunks::<1>().0, neighbours, taps, target.as_chunks_mut::<1>().0),
    }
}

/// Resamples one run.
pub(super) fn resample<const CHANNELS: usize>(
    source: &[[u8; CHANNELS]],
    neighbours: Neighbours,
    taps: Taps<'_>,
    target: &mut [[u8; CHANNELS]],
) {
    let Neighbours { right, below } = neighbours;
    for ((out, &index), weights) in target.iter_mut().zip(taps.indices).zip(taps.weights) {
        let index = index as usize;
        let upper = [&source[index], &source[index + right]];
        let lower = [&source[index + below], &source[index + below + right]];
        let [w_above, w_below, w_left, w_right] = weights.map(u32::from);
        for (channel, value) in out.iter_mut().enumerate() {
            let above = u32::from(upper[0][channel]) * w_left + u32::from(upper[1][channel]) * w_right;
            let beneath = u32::from(lower[0][channel]) * w_left + u32::from(lower[1][channel]) * w_right;
            // At most 255 * 1024 before the shift, so the result fits 8 bits.
            *value = ((above * w_above + beneath * w_below + HALF) >> WEIGHT_BITS) as u8;
        }
    }
}

/// Where the blocks of `PIXELS` pixels begin that cover a run of `length` pixels; the last overlaps the one before it
/// where the length is no multiple. None where the run is shorter than a block.
#[cfg(target_arch = "x86_64")]
pub(super) fn block_starts<const PIXELS: usize>(length: usize) -> impl Iterator<Item = usize> {
    let last = (length >= PIXELS && !length.is_multiple_of(PIXELS)).then(|| length - PIXELS);
    (0..length / PIXELS).map(|block| block * PIXELS).chain(last)
}

/// Whether three whole pixels can be read from every index on, and in the row below it: eight bytes are read where two
/// pixels need six.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(super) fn wide_reads_fit(source: &[[u8; 3]], neighbours: Neighbours, taps: Taps<'_>) -> bool {
    let farthest = taps.indices.iter().fold(0, |farthest, &index| index.max(farthest));
    farthest as usize + neighbours.below + 3 <= source.len()
}

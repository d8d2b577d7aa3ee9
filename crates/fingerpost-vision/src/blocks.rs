//! Rows cut into blocks that fill vector registers, and kept where these are quickly stored.

use std::ops::Range;

use crate::simd::{CodePath, InstructionSet};

/// Pixels that a kernel computes together: two of the widest vector registers of 16-bit numbers, and a whole number of
/// every other.
pub(crate) const BLOCK: usize = 64;

/// Rows whose columns are worked on before their rows are: as many as keep a processor from reading what it has not yet
/// written (1.6x over one row at a time in a 3 x 3 dilation at 512x512 on Zen 4), and few enough to stay in its fastest
/// cache.
pub(crate) const BAND_ROWS: usize = 8;

/// The fastest path of kernels that do little but load and store. Rows of pictures start anywhere, so that every access of
/// 512 bits lies across two cache lines, and of 256 bits one in two: AVX2 is 1.1 to 1.25x faster than AVX-512 in Sobel's
/// gradient at 512x512 on Zen 4.
pub(crate) fn fastest_for_unaligned_rows() -> CodePath {
    let set = CodePath::fastest().instruction_set().min(InstructionSet::Avx2);
    CodePath::with(set).unwrap_or(CodePath::PORTABLE)
}

/// Where the blocks start that cover a row of `width` pixels: none in a row that is narrower than a block, and else the
/// last one overlaps the one before it where the row is no whole number of blocks.
#[inline(always)]
pub(crate) fn block_starts(width: usize) -> impl Iterator<Item = usize> {
    let count = if width < BLOCK { 0 } else { width.div_ceil(BLOCK) };
    (0..count).map(move |index| (index * BLOCK).min(width - BLOCK))
}

/// The same for two blocks at once, in a row of two or more.
#[inline(always)]
pub(crate) fn double_block_starts(width: usize) -> impl Iterator<Item = usize> {
    let count = if width < 2 * BLOCK { 0 } else { width.div_ceil(2 * BLOCK) };
    (0..count).map(move |index| (2 * index * BLOCK).min(width - 2 * BLOCK))
}

/// The pixels of a row of `width` pixels that no block covers.
#[inline(always)]
pub(crate) fn single_pixels(width: usize) -> Range<usize> {
    0..if width < BLOCK { width } else { 0 }
}

/// What processors with vectors of 512 bits load and store at once.
const CACHE_LINE_BYTES: usize = 64;

/// Intermediate rows of a kernel, with room for values beyond either end. The first value that is not beyond starts a cache
/// line, as a store across two lines takes twice as long.
#[derive(Debug, Clone, Default)]
pub(crate) struct PaddedRows<T> {
    values: Vec<T>,
    /// Index of the first row's first value.
    start: usize,
    /// Values from one row's start to the next one's.
    pitch: usize,
    width: usize,
    reach: usize,
}

impl<T: Copy + Default> PaddedRows<T> {
    /// Makes `count` rows of `width` values with `reach` more at either end, all of them zero.
    pub(crate) fn reset(&mut self, width: usize, reach: usize, count: usize) {
        let line = CACHE_LINE_BYTES / size_of::<T>();
        (self.width, self.reach) = (width, reach);
        self.pitch = (width + 2 * reach).next_multiple_of(line);
        self.values.clear();
        self.values.resize(self.pitch * count + line, T::default());
        let first_inner = self.values.as_ptr().wrapping_add(reach);
        // Where alignment cannot be had, results are the same.
        self.start = first_inner.align_offset(CACHE_LINE_BYTES).min(line);
    }

    /// A row with the `reach` values that were asked for at either end.
    pub(crate) fn row(&self, number: usize, reach: usize) -> &[T] {
        &self.values[self.start + number * self.pitch + self.reach - reach..][..self.width + 2 * reach]
    }

    /// A row without what is beyond its ends, to be changed.
    pub(crate) fn inner_mut(&mut self, number: usize) -> &mut [T] {
        &mut self.values[self.start + number * self.pitch + self.reach..][..self.width]
    }

    /// A row without what is beyond its ends, and the next one to be changed.
    pub(crate) fn inner_and_next(&mut self, number: usize) -> (&[T], &mut [T]) {
        let next = self.start + (number + 1) * self.pitch;
        let (before, after) = self.values.split_at_mut(next);
        (&before[next - self.pitch + self.reach..][..self.width], &mut after[self.reach..][..self.width])
    }

    /// Makes the first row equal to another one.
    pub(crate) fn copy_first_from(&mut self, number: usize) {
        let from = self.start + number * self.pitch;
        self.values.copy_within(from..from + self.pitch, self.start);
    }
}

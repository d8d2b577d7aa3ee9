//! Rows cut into blocks that fill vector registers.

use std::ops::Range;

/// Pixels that a kernel computes together: two of the widest vector registers of 16-bit numbers, and a whole number of
/// every other.
pub(crate) const BLOCK: usize = 64;

/// Where the blocks start that cover a row of `width` pixels: none in a row that is narrower than a block, and else the
/// last one overlaps the one before it where the row is no whole number of blocks.
#[inline(always)]
pub(crate) fn block_starts(width: usize) -> impl Iterator<Item = usize> {
    let count = if width < BLOCK { 0 } else { width.div_ceil(BLOCK) };
    (0..count).map(move |index| (index * BLOCK).min(width - BLOCK))
}

/// The pixels of a row of `width` pixels that no block covers.
#[inline(always)]
pub(crate) fn single_pixels(width: usize) -> Range<usize> {
    0..if width < BLOCK { width } else { 0 }
}

//! Rows of pixels to quantised coefficients.

use super::quantiser::{Quantiser, ZIGZAG};
use super::{BLOCK, BLOCK_VALUES};
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;
use crate::simd::{CodePath, simd_kernel};

/// Blocks that are transformed at once: their rows fill the widest registers and stay in the first cache.
const TILE: usize = 8;
/// Columns of them.
pub(super) const COLUMNS: usize = TILE * BLOCK;

/// Bits behind the point in the first pass, whose errors the second adds up.
const FINER: u32 = 3;

/// One array a row.
type Rows = [[i16; COLUMNS]; BLOCK];

/// The coefficients of a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// In the order in which they are coded.
    pub(super) values: [i16; BLOCK_VALUES],
    /// Which of them are not 0, the first in the lowest bit.
    pub(super) mask: u64,
}

/// Sets `to` to the coefficients of a row of blocks, whose eight rows of pixels lie one behind the other.
pub(super) fn transform(path: CodePath, pixels: &[u8], quantiser: &Quantiser, to: &mut Vec<Block>) {
    to.resize(pixels.len() / BLOCK_VALUES, Block { values: [0; BLOCK_VALUES], mask: 0 });
    transform_blocks(path, pixels, quantiser, to);
    match path.instruction_set() {
        // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
        // Benefit: stated at the function.
        #[cfg(target_arch = "x86_64")]
        #[allow(unsafe_code)]
        InstructionSet::Avx512 => unsafe { x86::order_avx512(to) },
        _ => order(path, to),
    }
}

/// Where a coefficient of the order of coding lies when a horizontal frequency is a row.
const FROM: [u16; BLOCK_VALUES] = {
    let mut from = [0; BLOCK_VALUES];
    let mut at = 0;
    while at < BLOCK_VALUES {
        from[at] = (ZIGZAG[at] % 8 * 8 + ZIGZAG[at] / 8) as u16;
        at += 1;
    }
    from
};

simd_kernel! {
    fn transform_blocks(pixels: &[u8], quantiser: &Quantiser, blocks: &mut [Block]) {
        let width = BLOCK * blocks.len();
        let Quantiser { half, reciprocal, scale, .. } = quantiser;
        let (mut rows, mut turned) = ([[0; COLUMNS]; BLOCK], [[0; COLUMNS]; BLOCK]);
        for (index, tile) in blocks.chunks_mut(TILE).enumerate() {
            let first = index * COLUMNS;
            let columns = BLOCK * tile.len();
            for (y, row) in rows.iter_mut().enumerate() {
                let from = y * width + first;
                match pixels.get(from..from + COLUMNS).filter(|_| columns == COLUMNS) {
                    Some(pixels) => row.iter_mut().zip(pixels).for_each(|(value, &pixel)| *value = (i16::from(pixel) - 128) << FINER),
                    None => {
                        let pixels = pixels.get(from..from + columns).unwrap_or_default();
                        row.iter_mut().zip(pixels).for_each(|(value, &pixel)| *value = (i16::from(pixel) - 128) << FINER);
                    }
                }
            }
            transform_columns(&mut rows);
            for row in &mut rows {
                row.iter_mut().for_each(|value| *value = (*value + (1 << (FINER - 1))) >> FINER);
            }
            transpose_blocks(&rows, &mut turned);
            transform_columns(&mut turned);
            for (frequency, row) in turned.iter_mut().enumerate() {
                quantise(row, [&half[frequency], &reciprocal[frequency], &scale[frequency]]);
            }
            for (block, to) in tile.iter_mut().enumerate() {
                let (to, _) = to.values.as_chunks_mut::<BLOCK>();
                for (to, row) in to.iter_mut().zip(&turned) {
                    *to = row.as_chunks::<BLOCK>().0[block];
                }
            }
        }
    }
}

/// The transform along every column, scaled.
#[inline(always)]
fn transform_columns(rows: &mut Rows) {
    for x in 0..COLUMNS {
        let [d0, d1, d2, d3, d4, d5, d6, d7] = std::array::from_fn(|row| rows[row][x]);
        let (s07, s16, s25, s34) = (d0 + d7, d1 + d6, d2 + d5, d3 + d4);
        let (t07, t16, t25, t34) = (d0 - d7, d1 - d6, d2 - d5, d3 - d4);
        let (outer, inner) = (s07 + s34, s16 + s25);
        let outer_less = s07 - s34;
        let even = times(s16 - s25 + outer_less, HALF_ROOT);
        let (low, middle, high) = (t34 + t25, t25 + t16, t16 + t07);
        let both = times(low - high, COS_3_8);
        let low = times(low, COS_DIFFERENCE) + both;
        let high = high + times(high, COS_SUM_LESS_1) + both;
        let middle = times(middle, HALF_ROOT);
        let (sum, difference) = (t07 + middle, t07 - middle);
        let frequencies = [
            outer + inner,
            sum + high,
            outer_less + even,
            difference - low,
            outer - inner,
            difference + low,
            outer_less - even,
            sum - high,
        ];
        for (row, value) in rows.iter_mut().zip(frequencies) {
            row[x] = value;
        }
    }
}

/// The root of a half, cos(3 pi / 8), cos(pi / 8) - cos(3 pi / 8), and cos(pi / 8) + cos(3 pi / 8) less 1, times 2^15.
const HALF_ROOT: i16 = 23_170;
const COS_3_8: i16 = 12_540;
const COS_DIFFERENCE: i16 = 17_734;
const COS_SUM_LESS_1: i16 = 10_045;

/// A product with a factor of 15 bits behind the point. Values here are below 2^14: pixels reach 2^7, finer ones 2^10 in the first
/// pass, whose outputs reach 1434 in the second, and eight of either are added up before a product at the most.
#[inline(always)]
fn times(value: i16, factor: i16) -> i16 {
    ((i32::from(value.wrapping_mul(2)) * i32::from(factor)) >> 16) as i16
}

/// Rows of a block become its columns.
#[inline(always)]
fn transpose_blocks(rows: &Rows, turned: &mut Rows) {
    for block in 0..TILE {
        let mut values = [[0; BLOCK]; BLOCK];
        for (values, row) in values.iter_mut().zip(rows) {
            *values = row.as_chunks::<BLOCK>().0[block];
        }
        for (row, values) in turned.iter_mut().zip(transposed(values)) {
            row.as_chunks_mut::<BLOCK>().0[block] = values;
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn transposed(rows: [[i16; BLOCK]; BLOCK]) -> [[i16; BLOCK]; BLOCK] {
    std::array::from_fn(|column| rows.map(|row| row[column]))
}

#[cfg(target_arch = "x86_64")]
use x86::transposed;

/// Divides by the steps and rounds, halves away from zero.
#[inline(always)]
fn quantise(row: &mut [i16; COLUMNS], [half, reciprocal, scale]: [&[u16; COLUMNS]; 3]) {
    for x in 0..COLUMNS {
        let sign = row[x] >> 15;
        let magnitude = ((row[x] ^ sign) - sign) as u16 + half[x];
        let scaled = upper(magnitude, reciprocal[x]);
        row[x] = (upper(scaled, scale[x]) as i16 ^ sign) - sign;
    }
}

/// The upper half of a product.
#[inline(always)]
fn upper(a: u16, b: u16) -> u16 {
    ((u32::from(a) * u32::from(b)) >> 16) as u16
}

simd_kernel! {
    /// Puts coefficients in the order of coding, and notes which are not 0.
    fn order(blocks: &mut [Block]) {
        for Block { values, mask } in blocks {
            let ordered = FROM.map(|from| values[usize::from(from)]);
            *mask = ordered.iter().rev().fold(0, |mask, &value| mask << 1 | u64::from(value != 0));
            *values = ordered;
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{BLOCK, Block, FROM};

    /// Rows become columns. Every x86-64 processor has these instructions.
    /// Benefit: compilers move the 64 values one by one.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub(super) fn transposed(rows: [[i16; BLOCK]; BLOCK]) -> [[i16; BLOCK]; BLOCK] {
        let [r0, r1, r2, r3, r4, r5, r6, r7] = rows;
        // SAFETY: eight numbers of 16 bits are a register, and any bits are numbers; x86-64 has SSE2.
        unsafe {
            let register = |row| std::mem::transmute::<[i16; BLOCK], __m128i>(row);
            let numbers = |register| std::mem::transmute::<__m128i, [i16; BLOCK]>(register);
            let pairs = |a, b| {
                let (a, b) = (register(a), register(b));
                (_mm_unpacklo_epi16(a, b), _mm_unpackhi_epi16(a, b))
            };
            let ((a0, a1), (b0, b1)) = (pairs(r0, r1), pairs(r2, r3));
            let ((c0, c1), (d0, d1)) = (pairs(r4, r5), pairs(r6, r7));
            let fours = |a, b| (_mm_unpacklo_epi32(a, b), _mm_unpackhi_epi32(a, b));
            let ((e0, e1), (e2, e3)) = (fours(a0, b0), fours(a1, b1));
            let ((f0, f1), (f2, f3)) = (fours(c0, d0), fours(c1, d1));
            let eights = |e, f| (numbers(_mm_unpacklo_epi64(e, f)), numbers(_mm_unpackhi_epi64(e, f)));
            let ((t0, t1), (t2, t3)) = (eights(e0, f0), eights(e1, f1));
            let ((t4, t5), (t6, t7)) = (eights(e2, f2), eights(e3, f3));
            [t0, t1, t2, t3, t4, t5, t6, t7]
        }
    }

    /// The same as `order`.
    /// Benefit: 64 values are two registers, and one permutation of both gives a half of them; compilers move them one by one.
    #[target_feature(enable = "avx512f,avx512bw")]
    #[allow(unsafe_code)]
    pub(super) fn order_avx512(blocks: &mut [Block]) {
        // SAFETY: 64 numbers of 16 bits are two registers, and any bits are numbers.
        unsafe {
            let [first, last] = [0, 32].map(|at| _mm512_loadu_si512(FROM.as_ptr().add(at).cast()));
            for Block { values: block, mask } in blocks {
                let [low, high] = [0, 32].map(|at| _mm512_loadu_si512(block.as_ptr().add(at).cast()));
                let low_ordered = _mm512_permutex2var_epi16(low, first, high);
                let high_ordered = _mm512_permutex2var_epi16(low, last, high);
                _mm512_storeu_si512(block.as_mut_ptr().cast(), low_ordered);
                _mm512_storeu_si512(block.as_mut_ptr().add(32).cast(), high_ordered);
                let set = |values| u64::from(_mm512_test_epi16_mask(values, values));
                *mask = set(high_ordered) << 32 | set(low_ordered);
            }
        }
    }
}

//! The bilinear sums of eight pixels at a time: AVX2.
//!
//! Two neighbours' six bytes are read as eight; half of a register holds those of one target pixel, the upper row's and
//! the lower row's. Vertical and horizontal weights are then one multiply-and-add of pairs each.

use std::arch::x86_64::*;

use super::resample::{HALF, Neighbours, Taps, WEIGHT_BITS, block_starts, resample, wide_reads_fit};

/// Pixels in a block.
const PIXELS: usize = 8;

/// [`resample`] for colour.
#[target_feature(enable = "avx2")]
#[allow(unsafe_code)]
pub(super) fn resample_rgb(
    source: &[[u8; 3]],
    neighbours: Neighbours,
    taps: Taps<'_>,
    target: &mut [[u8; 3]],
) {
    if target.len() < PIXELS || !wide_reads_fit(source, neighbours, taps) {
        return resample(source, neighbours, taps, target);
    }
    // Without the fourth byte of each pixel: first in each half of the register, then over the whole.
    let packed = _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
    let packed = _mm256_broadcastsi128_si256(packed);
    let closed = _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 7, 7);
    for start in block_starts::<PIXELS>(target.len()) {
        let part = taps.part(start, PIXELS);
        let block = &mut target[start..start + PIXELS];
        let (Some(indices), Some(weights)) =
            (part.indices.first_chunk(), part.weights.first_chunk::<PIXELS>())
        else {
            return;
        };
        // SAFETY: an array of 32 bytes.
        let weight = unsafe { _mm256_loadu_si256(weights.as_ptr().cast()) };
        // SAFETY: wide reads fit.
        let [a, b, c, d] = unsafe {
            [
                sums::<0>(source, neighbours, indices, weight),
                sums::<1>(source, neighbours, indices, weight),
                sums::<2>(source, neighbours, indices, weight),
                sums::<3>(source, neighbours, indices, weight),
            ]
        };
        let rgb0 = _mm256_packus_epi16(_mm256_packus_epi32(a, b), _mm256_packus_epi32(c, d));
        let rgb = _mm256_permutevar8x32_epi32(_mm256_shuffle_epi8(rgb0, packed), closed);
        // SAFETY: 16 and then 8 bytes are written, and `block` is 8 pixels of 3 bytes.
        unsafe {
            let bytes = block.as_flattened_mut().as_mut_ptr();
            _mm_storeu_si128(bytes.cast(), _mm256_castsi256_si128(rgb));
            _mm_storel_epi64(bytes.add(16).cast(), _mm256_extracti128_si256(rgb, 1));
        }
    }
}

/// The values of every fourth pixel of a block from the `FIRST` on, a 32-bit lane a channel and one of 0: packing those
/// of the four `FIRST`s puts the pixels back in order.
///
/// # Safety
/// [`wide_reads_fit`].
#[inline]
#[target_feature(enable = "avx2")]
#[allow(unsafe_code)]
unsafe fn sums<const FIRST: usize>(
    source: &[[u8; 3]],
    neighbours: Neighbours,
    indices: &[u32; PIXELS],
    weight: __m256i,
) -> __m256i {
    // SAFETY: the caller's promise.
    let pixels = unsafe {
        _mm256_set_m128i(
            four_pixels(source, neighbours, indices[FIRST + 4]),
            four_pixels(source, neighbours, indices[FIRST]),
        )
    };
    let pixels = _mm256_shuffle_epi8(pixels, _mm256_broadcastsi128_si256(channel_pairs()));
    let rows = _mm256_shuffle_epi8(weight, _mm256_broadcastsi128_si256(row_weights::<FIRST>()));
    let columns = _mm256_shuffle_epi8(weight, _mm256_broadcastsi128_si256(column_weights::<FIRST>()));
    // At most 255 * 32, which fits 16 bits.
    let sums = _mm256_madd_epi16(_mm256_maddubs_epi16(pixels, rows), columns);
    _mm256_srli_epi32(_mm256_add_epi32(sums, _mm256_set1_epi32(HALF as i32)), WEIGHT_BITS as i32)
}

/// Picks from [`four_pixels`] the channels as pairs of one above the other, each followed by the pair on its right.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn channel_pairs() -> __m128i {
    _mm_setr_epi8(0, 8, 3, 11, 1, 9, 4, 12, 2, 10, 5, 13, -1, -1, -1, -1)
}

/// Picks the `PIXEL`-th of four pixels' weights above and below, for bytes.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn row_weights<const PIXEL: usize>() -> __m128i {
    let at = 4 * PIXEL as i16;
    _mm_set1_epi16(at | (at + 1) << 8)
}

/// Picks the `PIXEL`-th of four pixels' weights left and right, for 16-bit sums.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn column_weights<const PIXEL: usize>() -> __m128i {
    // -1 makes the upper byte of a 16-bit weight 0.
    let [left, right] = [2, 3].map(|weight| (4 * PIXEL as i16 + weight) & 0xff | -0x100);
    _mm_setr_epi16(left, right, left, right, left, right, left, right)
}

/// The pixel at `index`, its right neighbour and two bytes more, and then those below them.
///
/// # Safety
/// [`wide_reads_fit`] for `index`.
#[inline]
#[target_feature(enable = "avx2")]
#[allow(unsafe_code)]
pub(super) unsafe fn four_pixels(source: &[[u8; 3]], neighbours: Neighbours, index: u32) -> __m128i {
    // SAFETY: three whole pixels, 9 bytes, from `index` and from `below` behind it on lie in the source.
    unsafe {
        // Written so that the two rows differ in their base alone.
        let upper = source.as_ptr().add(index as usize);
        let lower = source.as_ptr().add(neighbours.below).add(index as usize);
        _mm_castpd_si128(_mm_loadh_pd(_mm_castsi128_pd(_mm_loadl_epi64(upper.cast())), lower.cast()))
    }
}

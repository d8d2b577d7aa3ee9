//! The bilinear sums of sixteen pixels at a time: AVX-512.
//!
//! Two neighbours' six bytes are read as eight; a quarter of a register holds those of one target pixel, the upper row's
//! and the lower row's. Vertical and horizontal weights are then one multiply-and-add of pairs each.

use std::arch::x86_64::*;

use super::avx2::{channel_pairs, column_weights, four_pixels, row_weights};
use super::resample::{HALF, Neighbours, Taps, WEIGHT_BITS, block_starts, resample, wide_reads_fit};

/// Pixels in a block.
const PIXELS: usize = 16;

/// Where in 16 lanes each of 48 packed bytes comes from: all but each lane's highest byte.
const PACKED: [u8; 64] = {
    let mut from = [0; 64];
    let mut byte = 0;
    while byte < 3 * PIXELS {
        from[byte] = (byte / 3 * 4 + byte % 3) as u8;
        byte += 1;
    }
    from
};

/// [`resample`] for colour.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
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
    // SAFETY: an array of 64 bytes.
    let packed = unsafe { _mm512_loadu_si512(PACKED.as_ptr().cast()) };
    for start in block_starts::<PIXELS>(target.len()) {
        let part = taps.part(start, PIXELS);
        let block = &mut target[start..start + PIXELS];
        let (Some(indices), Some(weights)) =
            (part.indices.first_chunk(), part.weights.first_chunk::<PIXELS>())
        else {
            return;
        };
        // SAFETY: an array of 64 bytes.
        let weight = unsafe { _mm512_loadu_si512(weights.as_ptr().cast()) };
        // SAFETY: wide reads fit.
        let [a, b, c, d] = unsafe {
            [
                sums::<0>(source, neighbours, indices, weight),
                sums::<1>(source, neighbours, indices, weight),
                sums::<2>(source, neighbours, indices, weight),
                sums::<3>(source, neighbours, indices, weight),
            ]
        };
        let rgb0 = _mm512_packus_epi16(_mm512_packus_epi32(a, b), _mm512_packus_epi32(c, d));
        let rgb = _mm512_permutexvar_epi8(packed, rgb0);
        // SAFETY: 32 and then 16 bytes are written, and `block` is 16 pixels of 3 bytes.
        unsafe {
            let bytes = block.as_flattened_mut().as_mut_ptr();
            _mm256_storeu_si256(bytes.cast(), _mm512_castsi512_si256(rgb));
            _mm_storeu_si128(bytes.add(32).cast(), _mm512_extracti32x4_epi32(rgb, 2));
        }
    }
}

/// The values of every fourth pixel of a block from the `FIRST` on, a 32-bit lane a channel and one of 0: packing those
/// of the four `FIRST`s puts the pixels back in order.
///
/// # Safety
/// [`wide_reads_fit`].
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
#[allow(unsafe_code)]
unsafe fn sums<const FIRST: usize>(
    source: &[[u8; 3]],
    neighbours: Neighbours,
    indices: &[u32; PIXELS],
    weight: __m512i,
) -> __m512i {
    // SAFETY: the caller's promise.
    let pixels = unsafe {
        let lower = _mm256_set_m128i(
            four_pixels(source, neighbours, indices[FIRST + 4]),
            four_pixels(source, neighbours, indices[FIRST]),
        );
        let upper = _mm256_set_m128i(
            four_pixels(source, neighbours, indices[FIRST + 12]),
            four_pixels(source, neighbours, indices[FIRST + 8]),
        );
        _mm512_inserti64x4(_mm512_castsi256_si512(lower), upper, 1)
    };
    let pixels = _mm512_shuffle_epi8(pixels, _mm512_broadcast_i32x4(channel_pairs()));
    let rows = _mm512_shuffle_epi8(weight, _mm512_broadcast_i32x4(row_weights::<FIRST>()));
    let columns = _mm512_shuffle_epi8(weight, _mm512_broadcast_i32x4(column_weights::<FIRST>()));
    // At most 255 * 32, which fits 16 bits.
    let sums = _mm512_madd_epi16(_mm512_maddubs_epi16(pixels, rows), columns);
    _mm512_srli_epi32(_mm512_add_epi32(sums, _mm512_set1_epi32(HALF as i32)), WEIGHT_BITS)
}

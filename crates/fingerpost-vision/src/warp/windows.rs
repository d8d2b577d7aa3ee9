//! The bilinear sums of sixteen grey pixels at a time: AVX-512.
//!
//! Neighbours in the target mostly look at neighbours in the source. So two windows of 64 source pixels, one below the
//! other, are read into registers, and a permutation picks from them what the sixteen need. Where they look farther apart,
//! the plain loop takes them.

use std::arch::x86_64::*;

use super::resample::{HALF, Neighbours, Taps, WEIGHT_BITS, block_starts, resample};
use crate::avx512::{BYTES, load};

/// Pixels in a block.
const PIXELS: usize = 16;
/// Where the four source pixels lie in the windows from the place of the first: it, the one below it, and the two on
/// their right.
const CORNERS: i32 = i32::from_le_bytes([0, BYTES as u8, 1, BYTES as u8 + 1]);

/// [`resample`] for grey. Block by block it takes a fifth of the plain loop's time on Zen 4 at 240 x 110 to 512 x 512.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
pub(super) fn resample_grey(source: &[u8], neighbours: Neighbours, taps: Taps<'_>, target: &mut [u8]) {
    let (plain_source, _) = source.as_chunks::<1>();
    if target.len() < PIXELS {
        return resample(plain_source, neighbours, taps, target.as_chunks_mut::<1>().0);
    }
    for start in block_starts::<PIXELS>(target.len()) {
        let taps = taps.part(start, PIXELS);
        let (block, _) = target[start..].as_chunks_mut::<PIXELS>();
        let (Some(indices), Some(weights), Some(block)) =
            (taps.indices.first_chunk(), taps.weights.first_chunk::<PIXELS>(), block.first_mut())
        else {
            return;
        };
        if !block_from_windows(source, neighbours, indices, load(weights.as_flattened(), 0), block) {
            resample(plain_source, neighbours, taps, block.as_chunks_mut::<1>().0);
        }
    }
}

/// Resamples a block from two windows; `false` where it does not lie in them.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
fn block_from_windows(
    source: &[u8],
    neighbours: Neighbours,
    indices: &[u32; PIXELS],
    weights: __m512i,
    block: &mut [u8; PIXELS],
) -> bool {
    // Places mostly run one way. Where they do not, one may lie before the window, and becomes one far behind it.
    let first = indices[0].min(indices[PIXELS - 1]);
    let places = _mm512_sub_epi32(load(indices, 0), _mm512_set1_epi32(first.cast_signed()));
    let last_place = _mm512_set1_epi32(BYTES as i32 - 2);
    if _mm512_cmpgt_epu32_mask(places, last_place) != 0 {
        return false;
    }
    let upper = load(source, first as usize);
    // A source one pixel wide or high has no right or lower neighbours: what is taken for them has a weight of 0.
    let lower = load(source, first as usize + neighbours.below);
    let every_lane = |lane: __m128i| _mm512_broadcast_i32x4(lane);
    let of_each = |bytes: [i32; 4]| every_lane(_mm_setr_epi32(bytes[0], bytes[1], bytes[2], bytes[3]));
    let lowest = of_each([0, 0x0404_0404, 0x0808_0808, 0x0c0c_0c0c]);
    let corners = _mm512_add_epi8(_mm512_shuffle_epi8(places, lowest), _mm512_set1_epi32(CORNERS));
    let pixels = _mm512_permutex2var_epi8(upper, corners, lower);
    let rows = _mm512_shuffle_epi8(weights, of_each([0x0100_0100, 0x0504_0504, 0x0908_0908, 0x0d0c_0d0c]));
    // Bytes of 0x80 become 0.
    let columns = of_each([0x8003_8002, 0x8007_8006, 0x800b_800a, 0x800f_800e].map(u32::cast_signed));
    let columns = _mm512_shuffle_epi8(weights, columns);
    // At most 255 * 32, which fits 16 bits.
    let sums = _mm512_madd_epi16(_mm512_maddubs_epi16(pixels, rows), columns);
    let means = _mm512_srli_epi32(_mm512_add_epi32(sums, _mm512_set1_epi32(HALF as i32)), WEIGHT_BITS);
    // SAFETY: an array of 16 bytes.
    #[allow(unsafe_code)]
    unsafe {
        _mm_storeu_si128(block.as_mut_ptr().cast(), _mm512_cvtepi32_epi8(means));
    }
    true
}

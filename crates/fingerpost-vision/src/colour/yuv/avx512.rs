//! Sixty-four pixels at a time: AVX-512.

use std::arch::x86_64::*;

use super::{BLOCK, DIFFERENCE_SHIFT, Factors, HALF_BLOCK, LUMA_SHIFT, NEUTRAL, ROUNDING, SUM_BITS};

/// For each register of interleaved colour, where its bytes come from: red and green from two registers, and then those
/// and blue.
const INTERLEAVED: [[[u8; BLOCK]; 2]; 3] = {
    let mut from = [[[0; BLOCK]; 2]; 3];
    let mut at = 0;
    while at < 3 * BLOCK {
        let (register, byte, pixel, channel) = (at / BLOCK, at % BLOCK, at / 3, at % 3);
        let second = BLOCK as u8;
        if channel == 2 {
            from[register][1][byte] = second + pixel as u8;
        } else {
            from[register][0][byte] = second * channel as u8 + pixel as u8;
            from[register][1][byte] = byte as u8;
        }
        at += 1;
    }
    from
};

/// The plain conversion's sums, pixel for pixel.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
#[allow(unsafe_code)]
pub(super) fn convert_blocks(
    y: &[[u8; BLOCK]],
    u: &[[u8; HALF_BLOCK]],
    v: &[[u8; HALF_BLOCK]],
    factors: &Factors,
    rgb: &mut [[[u8; 3]; BLOCK]],
) {
    let black = _mm512_set1_epi16(factors.black);
    let neutral = _mm512_set1_epi16(NEUTRAL);
    for (((y, u), v), rgb) in y.iter().zip(u).zip(v).zip(rgb) {
        // SAFETY: arrays of 64, 32 and 32 bytes.
        let (y, u, v) = unsafe {
            (
                _mm512_loadu_si512(y.as_ptr().cast()),
                _mm256_loadu_si256(u.as_ptr().cast()),
                _mm256_loadu_si256(v.as_ptr().cast()),
            )
        };
        let [u, v] = [u, v].map(|half| {
            _mm512_slli_epi16::<DIFFERENCE_SHIFT>(_mm512_sub_epi16(_mm512_cvtepu8_epi16(half), neutral))
        });
        let product = |left, factor| _mm512_mulhi_epi16(left, _mm512_set1_epi16(factor));
        let red = product(v, factors.red_of_v);
        let green = _mm512_add_epi16(product(u, factors.green_of_u), product(v, factors.green_of_v));
        let blue = product(u, factors.blue_of_u);
        // Unpacking and packing take each quarter of a register for itself, so that the one undoes the other.
        let zero = _mm512_setzero_si512();
        let [lower, upper] = [_mm512_unpacklo_epi8(y, zero), _mm512_unpackhi_epi8(y, zero)].map(|y| {
            let luma = product(_mm512_slli_epi16::<LUMA_SHIFT>(_mm512_sub_epi16(y, black)), factors.luma);
            _mm512_add_epi16(luma, _mm512_set1_epi16(ROUNDING))
        });
        let [red, green, blue] = [red, green, blue].map(|offset| {
            let lower = _mm512_add_epi16(lower, _mm512_unpacklo_epi16(offset, offset));
            let upper = _mm512_add_epi16(upper, _mm512_unpackhi_epi16(offset, offset));
            _mm512_packus_epi16(_mm512_srai_epi16::<SUM_BITS>(lower), _mm512_srai_epi16::<SUM_BITS>(upper))
        });
        let (bytes, _) = rgb.as_flattened_mut().as_chunks_mut::<BLOCK>();
        for (bytes, [of_two, of_both]) in bytes.iter_mut().zip(&INTERLEAVED) {
            // SAFETY: three arrays of 64 bytes.
            unsafe {
                let of_two = _mm512_loadu_si512(of_two.as_ptr().cast());
                let of_both = _mm512_loadu_si512(of_both.as_ptr().cast());
                let two = _mm512_permutex2var_epi8(red, of_two, green);
                let all = _mm512_permutex2var_epi8(two, of_both, blue);
                _mm512_storeu_si512(bytes.as_mut_ptr().cast(), all);
            }
        }
    }
}

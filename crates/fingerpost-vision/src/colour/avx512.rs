//! Grey and hue-saturation bins of sixty-four pixels at a time: AVX-512.
//!
//! What is the same for all channels is done on bytes, sixty-four to a register; only the quotients need 32 bits. Each
//! unpacking takes every quarter of a register for itself, and the packing that follows undoes it.

use std::arch::x86_64::*;

use super::{BinDivision, HUES, LUMA, LUMA_BITS, WHOLE};

/// Pixels in a block.
pub(super) const BLOCK: usize = 64;

/// For each channel, where its bytes come from: from the first two of three registers, and then from those and the third.
const PLANAR: [[[u8; BLOCK]; 2]; 3] = {
    let mut from = [[[0; BLOCK]; 2]; 3];
    let mut at = 0;
    while at < 3 * BLOCK {
        let (pixel, channel) = (at / 3, at % 3);
        if at < 2 * BLOCK {
            from[channel][0][pixel] = at as u8;
            from[channel][1][pixel] = pixel as u8;
        } else {
            from[channel][1][pixel] = (at - BLOCK) as u8;
        }
        at += 1;
    }
    from
};

/// `WHOLE` and half of it more, so that small negative quotients are rounded like positive ones.
const SIGNED_WHOLE: f32 = 1.5 * WHOLE;

/// [`super::grey_of`] and [`BinDivision::bin_of`] of whole blocks.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
#[allow(unsafe_code)]
pub(super) fn grey_and_bins_blocks(
    rgb: &[[[u8; 3]; BLOCK]],
    division: &BinDivision,
    grey: &mut [[u8; BLOCK]],
    bin: &mut [[u16; BLOCK]],
) {
    // Which eights of a block's bins lie in the lower and the upper halves of the quarters.
    let first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    let second = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    for ((rgb, grey), bin) in rgb.iter().zip(grey).zip(bin) {
        let rgb = planes(rgb);
        let [lower, upper] = bins(hue_and_saturation(rgb), division);
        // SAFETY: an array of 64 bytes and one of 128.
        unsafe {
            _mm512_storeu_si512(grey.as_mut_ptr().cast(), luma(rgb));
            let bin = bin.as_mut_ptr();
            _mm512_storeu_si512(bin.cast(), _mm512_permutex2var_epi64(lower, first, upper));
            _mm512_storeu_si512(bin.add(BLOCK / 2).cast(), _mm512_permutex2var_epi64(lower, second, upper));
        }
    }
}

/// [`super::grey_of`] of whole blocks.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
#[allow(unsafe_code)]
pub(super) fn grey_blocks(rgb: &[[[u8; 3]; BLOCK]], grey: &mut [[u8; BLOCK]]) {
    for (rgb, grey) in rgb.iter().zip(grey) {
        // SAFETY: an array of 64 bytes.
        unsafe { _mm512_storeu_si512(grey.as_mut_ptr().cast(), luma(planes(rgb))) };
    }
}

/// Red, green and blue of a block.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
#[allow(unsafe_code)]
fn planes(rgb: &[[u8; 3]; BLOCK]) -> [__m512i; 3] {
    let bytes = rgb.as_flattened().as_ptr();
    // SAFETY: 64 bytes each of the 192 of 64 pixels, and arrays of 64 bytes.
    unsafe {
        let load = |from: *const u8| _mm512_loadu_si512(from.cast());
        let [a, b, c] = [load(bytes), load(bytes.add(BLOCK)), load(bytes.add(2 * BLOCK))];
        let plane = |[of_two, of_both]: &[[u8; BLOCK]; 2]| {
            let two = _mm512_permutex2var_epi8(a, load(of_two.as_ptr()), b);
            _mm512_permutex2var_epi8(two, load(of_both.as_ptr()), c)
        };
        [plane(&PLANAR[0]), plane(&PLANAR[1]), plane(&PLANAR[2])]
    }
}

/// Luma of a block, 8 bits each.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn luma([r, g, b]: [__m512i; 3]) -> __m512i {
    let pair = |low: i32, high: i32| _mm512_set1_epi32(high << 16 | low);
    // Half a step, to round, is the weight of a fourth channel that is 1.
    let (of_red_green, of_blue_one) = (pair(LUMA[0], LUMA[1]), pair(LUMA[2], 1 << (LUMA_BITS - 1)));
    let sum = |red_green, blue_one| {
        let sum = _mm512_add_epi32(
            _mm512_madd_epi16(red_green, of_red_green),
            _mm512_madd_epi16(blue_one, of_blue_one),
        );
        _mm512_srli_epi32::<LUMA_BITS>(sum)
    };
    let one = _mm512_set1_epi8(1);
    let half = |red_green, blue_one| {
        let ([rg, rg_next], [b1, b1_next]) = (words(red_green), words(blue_one));
        _mm512_packus_epi32(sum(rg, b1), sum(rg_next, b1_next))
    };
    _mm512_packus_epi16(
        half(_mm512_unpacklo_epi8(r, g), _mm512_unpacklo_epi8(b, one)),
        half(_mm512_unpackhi_epi8(r, g), _mm512_unpackhi_epi8(b, one)),
    )
}

/// Hue and saturation of a block, 8 bits each.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn hue_and_saturation([r, g, b]: [__m512i; 3]) -> [__m512i; 2] {
    let value = _mm512_max_epu8(_mm512_max_epu8(r, g), b);
    let spread = _mm512_sub_epi8(value, _mm512_min_epu8(_mm512_min_epu8(r, g), b));
    let red = _mm512_cmpeq_epi8_mask(value, r);
    let green = _mm512_cmpeq_epi8_mask(value, g) & !red;
    let choose = |of_red, of_green, of_blue| {
        _mm512_mask_mov_epi8(_mm512_mask_mov_epi8(of_blue, green, of_green), red, of_red)
    };
    let (plus, minus) = (choose(g, b, r), choose(b, r, g));
    let middle = choose(_mm512_setzero_si512(), _mm512_set1_epi8(60), _mm512_set1_epi8(120));

    // Thirty times the difference of the two other channels.
    let factors = _mm512_set1_epi16(i16::from_le_bytes([30, 30_u8.wrapping_neg()]));
    let difference = [_mm512_unpacklo_epi8(plus, minus), _mm512_unpackhi_epi8(plus, minus)]
        .map(|pairs| _mm512_maddubs_epi16(pairs, factors));
    let not_zero = words(_mm512_max_epu8(spread, _mm512_set1_epi8(1)));
    let value = words(value);
    let half = |half: usize| {
        let [difference, spread, value] =
            [scaled(difference[half]), scaled(not_zero[half]), scaled(value[half])];
        let quotients = |quarter: usize| quotients(difference[quarter], spread[quarter], value[quarter]);
        let [[hue, saturation], [hue_next, saturation_next]] = [quotients(0), quotients(1)];
        [_mm512_packus_epi32(hue, hue_next), _mm512_packus_epi32(saturation, saturation_next)]
    };
    let [[hue, saturation], [hue_next, saturation_next]] = [half(0), half(1)];
    let hue = _mm512_add_epi8(_mm512_packus_epi16(hue, hue_next), middle);
    let circle = _mm512_set1_epi8((HUES as u8).cast_signed());
    let hue = _mm512_mask_add_epi8(hue, _mm512_cmpge_epu8_mask(hue, circle), hue, circle);
    // Greys were given a spread of 1.
    let saturation = _mm512_maskz_mov_epi8(
        _mm512_test_epi8_mask(spread, spread),
        _mm512_packus_epi16(saturation, saturation_next),
    );
    [hue, saturation]
}

/// The lowest 8 bits of hue's and saturation's rounded quotients; all three are given times 2^16.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn quotients(difference: __m512i, spread: __m512i, value: __m512i) -> [__m512i; 2] {
    let spread = _mm512_cvtepi32_ps(spread);
    let hue = _mm512_div_ps(_mm512_cvtepi32_ps(difference), spread);
    let saturation = _mm512_div_ps(_mm512_mul_ps(spread, _mm512_set1_ps(255.0)), _mm512_cvtepi32_ps(value));
    [hue, saturation].map(|quotient| {
        let whole = _mm512_castps_si512(_mm512_add_ps(quotient, _mm512_set1_ps(SIGNED_WHOLE)));
        _mm512_and_si512(whole, _mm512_set1_epi32(0xff))
    })
}

/// Bin indices of a block, 16 bits each: those of the lower and of the upper eight pixels of every sixteen.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn bins([hue, saturation]: [__m512i; 2], division: &BinDivision) -> [__m512i; 2] {
    // At most 2^15 and 2^8: both are taken as 16 bits without a sign.
    let factor = _mm512_set1_epi16((division.hue_factor as u16).cast_signed());
    let saturations = _mm512_set1_epi16(division.bins.saturation.cast_signed());
    let (hue, saturation) = (words(hue), words(saturation));
    let half = |half: usize| {
        let hue_bin = _mm512_mulhi_epu16(_mm512_add_epi16(hue[half], hue[half]), factor);
        let saturation_bin = _mm512_srli_epi16::<8>(_mm512_mullo_epi16(saturation[half], saturations));
        _mm512_add_epi16(_mm512_mullo_epi16(hue_bin, saturations), saturation_bin)
    };
    [half(0), half(1)]
}

/// The bytes of a register's lower and upper halves of quarters as 16 bits each.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn words(bytes: __m512i) -> [__m512i; 2] {
    let zero = _mm512_setzero_si512();
    [_mm512_unpacklo_epi8(bytes, zero), _mm512_unpackhi_epi8(bytes, zero)]
}

/// The 16-bit values of a register's lower and upper halves of quarters as 32 bits each, times 2^16: so a sign stays.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn scaled(words: __m512i) -> [__m512i; 2] {
    let zero = _mm512_setzero_si512();
    [_mm512_unpacklo_epi16(zero, words), _mm512_unpackhi_epi16(zero, words)]
}

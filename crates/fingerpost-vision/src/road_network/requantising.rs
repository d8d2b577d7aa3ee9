//! From sums of 32 bits back to activations of 7: scaled, rounded to the nearest (ties to even) and clamped.
//!
//! A sum is below 2^24 and a scale at most 64, so that no result leaves 32 bits, and vectors may round first and clamp by
//! saturation. Products are never fused with sums.

/// Channels that are worked on together.
pub(super) const LANES: usize = 16;
/// Largest activation.
pub(super) const MOST: i32 = 127;
/// Smallest activation of layers that end in a rectifier.
pub(super) const RECTIFIED: i32 = 0;
/// Smallest activation of the others, whose bytes are those of `i8`.
pub(super) const SIGNED: i32 = -127;

/// A number for each of so many channels, in a cache line of its own where it has four bytes.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub(super) struct Lanes<T>(pub(super) [T; LANES]);

/// 1.5 times 2 to the 23rd: a small number added to it is rounded to the nearest whole one, which is then in the lowest bits.
const ROUNDER: f32 = 12_582_912.0;

/// The nearest whole number (ties to even) from `low` to [`MOST`].
#[inline(always)]
pub(super) fn rounded(value: f32, low: i32) -> i32 {
    let (low, most) = (low as f32, MOST as f32);
    let value = if value > low { value } else { low };
    let value = if value < most { value } else { most };
    (value + ROUNDER).to_bits() as i32 - ROUNDER.to_bits() as i32
}

/// With AVX2.
#[cfg(target_arch = "x86_64")]
pub(super) mod avx2 {
    use std::arch::x86_64::*;

    use super::{LANES, Lanes, MOST};

    /// Both halves of sixteen numbers.
    #[inline]
    #[target_feature(enable = "avx2")]
    #[allow(unsafe_code)]
    pub(in super::super) fn halves<T: Copy>(lanes: &Lanes<T>) -> [__m256i; 2] {
        const { assert!(size_of::<T>() == 4) };
        let halves: *const __m256i = std::ptr::from_ref(lanes).cast();
        // SAFETY: 64 bytes, aligned to 64, and any bytes are a register.
        unsafe { [_mm256_load_si256(halves), _mm256_load_si256(halves.add(1))] }
    }

    /// Adds the products of four activations and four weights in each lane to its sum: two pairs of at most 2 * 127 * 128 each,
    /// which fits 16 bits.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(in super::super) fn add_products(sum: __m256i, activations: __m256i, weights: __m256i) -> __m256i {
        let pairs = _mm256_maddubs_epi16(activations, weights);
        _mm256_add_epi32(sum, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)))
    }

    /// Stores sixteen scaled sums, rounded and clamped.
    #[inline]
    #[target_feature(enable = "avx2")]
    #[allow(unsafe_code)]
    pub(in super::super) fn store<const LOW: i32>(scaled: [__m256; 2], out: &mut [u8; LANES]) {
        let [first, second] = scaled.map(|scaled| _mm256_cvtps_epi32(scaled));
        // Packing takes halves of registers by turns.
        let words = _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_packs_epi32(first, second));
        let (lower, upper) = (_mm256_castsi256_si128(words), _mm256_extracti128_si256::<1>(words));
        let bytes = if LOW < 0 {
            _mm_max_epi8(_mm_packs_epi16(lower, upper), _mm_set1_epi8(LOW as i8))
        } else {
            _mm_min_epu8(_mm_packus_epi16(lower, upper), _mm_set1_epi8(MOST as i8))
        };
        // SAFETY: an array of 16 bytes.
        unsafe { _mm_storeu_si128(out.as_mut_ptr().cast(), bytes) };
    }

    /// Sums times multipliers.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(in super::super) fn scaled(sums: [__m256i; 2], multiplier: &Lanes<f32>) -> [__m256; 2] {
        let factor = halves(multiplier);
        [0, 1].map(|half| _mm256_mul_ps(_mm256_cvtepi32_ps(sums[half]), _mm256_castsi256_ps(factor[half])))
    }

    /// Sixteen bytes as lanes of 32 bits.
    #[inline]
    #[target_feature(enable = "avx2")]
    #[allow(unsafe_code)]
    pub(in super::super) fn widened(bytes: &[u8; LANES]) -> [__m256i; 2] {
        let at = bytes.as_ptr();
        // SAFETY: 8 bytes each of an array of 16.
        unsafe {
            [
                _mm256_cvtepu8_epi32(_mm_loadl_epi64(at.cast())),
                _mm256_cvtepu8_epi32(_mm_loadl_epi64(at.add(LANES / 2).cast())),
            ]
        }
    }
}

/// With AVX-512 and its sums of products.
#[cfg(target_arch = "x86_64")]
pub(super) mod avx512 {
    use std::arch::x86_64::*;

    use super::{LANES, Lanes, MOST};

    /// Sixteen numbers.
    #[inline]
    #[target_feature(enable = "avx512f")]
    #[allow(unsafe_code)]
    pub(in super::super) fn whole<T: Copy>(lanes: &Lanes<T>) -> __m512i {
        const { assert!(size_of::<T>() == 4) };
        // SAFETY: 64 bytes, aligned to 64, and any bytes are a register.
        unsafe { _mm512_load_si512(std::ptr::from_ref(lanes).cast()) }
    }

    /// Stores sixteen scaled sums, rounded and clamped.
    #[inline]
    #[target_feature(enable = "avx512f")]
    #[allow(unsafe_code)]
    pub(in super::super) fn store<const LOW: i32>(scaled: __m512, out: &mut [u8; LANES]) {
        let whole = _mm512_cvtps_epi32(scaled);
        let clamped =
            _mm512_min_epi32(_mm512_max_epi32(whole, _mm512_set1_epi32(LOW)), _mm512_set1_epi32(MOST));
        // SAFETY: an array of 16 bytes.
        unsafe { _mm_storeu_si128(out.as_mut_ptr().cast(), _mm512_cvtepi32_epi8(clamped)) };
    }

    /// Sums times multipliers.
    #[inline]
    #[target_feature(enable = "avx512f")]
    pub(in super::super) fn scaled(sums: __m512i, multiplier: &Lanes<f32>) -> __m512 {
        _mm512_mul_ps(_mm512_cvtepi32_ps(sums), _mm512_castsi512_ps(whole(multiplier)))
    }

    /// Sixteen bytes as lanes of 32 bits.
    #[inline]
    #[target_feature(enable = "avx512f")]
    #[allow(unsafe_code)]
    pub(in super::super) fn widened(bytes: &[u8; LANES]) -> __m512i {
        // SAFETY: an array of 16 bytes.
        unsafe { _mm512_cvtepu8_epi32(_mm_loadu_si128(bytes.as_ptr().cast())) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_even_and_clamped() {
        for step in -4_000..4_000 {
            let value = step as f32 * 0.125;
            let expected = |low: i32| value.round_ties_even().clamp(low as f32, 127.0) as i32;
            assert_eq!(rounded(value, RECTIFIED), expected(RECTIFIED), "{value}");
            assert_eq!(rounded(value, SIGNED), expected(SIGNED), "{value}");
        }
        assert_eq!([rounded(1e9, 0), rounded(-1e9, 0), rounded(-1e9, SIGNED)], [127, 0, -127]);
    }
}

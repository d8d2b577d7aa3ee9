//! Interleaved colour unpacked to one 32-bit lane a pixel, the form in which whole vectors of colours are computed.

use crate::simd::CodePath;
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;

/// Fills as many of `lanes` as `rgb` has pixels, with red in the lowest byte, then green, blue and one of no meaning, and
/// returns them; `lanes` is at least as long.
///
/// Compilers load interleaved colours byte by byte; the vector paths here take whole registers.
pub(crate) fn unpack<'a>(path: CodePath, rgb: &[[u8; 3]], lanes: &'a mut [u32]) -> &'a [u32] {
    let lanes = &mut lanes[..rgb.len()];
    let done = match path.instruction_set() {
        // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
        // Benefit: luma of a 512 x 512 picture 2.9 times as fast on Zen 4 as with lanes filled by a plain loop.
        #[cfg(target_arch = "x86_64")]
        #[allow(unsafe_code)]
        InstructionSet::Avx2 => unsafe { x86::unpack_avx2(rgb, lanes) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        #[allow(unsafe_code)]
        InstructionSet::Avx512 => unsafe { x86::unpack_avx512(rgb, lanes) },
        _ => 0,
    };
    let ((fours, rest), (lane_fours, lane_rest)) = (rgb[done..].as_chunks(), lanes[done..].as_chunks_mut());
    for (lanes, four) in lane_fours.iter_mut().zip(fours) {
        *lanes = unpack_four(four);
    }
    for (lane, &[r, g, b]) in lane_rest.iter_mut().zip(rest) {
        *lane = u32::from_le_bytes([r, g, b, 0]);
    }
    lanes
}

/// Four pixels by two loads, where one by one takes twelve.
#[inline(always)]
fn unpack_four(rgb: &[[u8; 3]; 4]) -> [u32; 4] {
    let mut bytes = [0; 16];
    bytes[..12].copy_from_slice(rgb.as_flattened());
    let all = u128::from_le_bytes(bytes);
    [all, all >> 24, all >> 48, all >> 72].map(|lane| lane as u32)
}

/// The vector paths return the number of pixels that they have done: the multiple of their width in the shorter slice.
#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    /// Where in 48 packed bytes each byte of 16 lanes comes from; the highest of a lane does not matter.
    const FROM: [u8; 64] = {
        let mut from = [0; 64];
        let mut byte = 0;
        while byte < from.len() {
            from[byte] = (byte / 4 * 3 + byte % 4) as u8;
            byte += 1;
        }
        from
    };

    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
    #[allow(unsafe_code)]
    pub(super) fn unpack_avx512(rgb: &[[u8; 3]], lanes: &mut [u32]) -> usize {
        const PIXELS: usize = 16;
        /// The bytes of a register that a block of pixels fills.
        const PACKED: __mmask64 = (1 << (3 * PIXELS)) - 1;
        /// All but the highest byte of each lane.
        const COLOURS: __mmask64 = 0x7777_7777_7777_7777;
        // SAFETY: an array of 64 bytes.
        let from = unsafe { _mm512_loadu_si512(FROM.as_ptr().cast()) };
        let ((rgb, _), (lanes, _)) = (rgb.as_chunks::<PIXELS>(), lanes.as_chunks_mut::<PIXELS>());
        for (rgb, lanes) in rgb.iter().zip(&mut *lanes) {
            // SAFETY: the mask lets 48 bytes be read, and `rgb` is 16 pixels of 3 bytes; `lanes` is 64 bytes.
            unsafe {
                let packed = _mm512_maskz_loadu_epi8(PACKED, rgb.as_ptr().cast());
                let lane = _mm512_maskz_permutexvar_epi8(COLOURS, from, packed);
                _mm512_storeu_si512(lanes.as_mut_ptr().cast(), lane);
            }
        }
        PIXELS * rgb.len().min(lanes.len())
    }

    #[target_feature(enable = "avx2")]
    #[allow(unsafe_code)]
    pub(super) fn unpack_avx2(rgb: &[[u8; 3]], lanes: &mut [u32]) -> usize {
        const PIXELS: usize = 8;
        // The upper half of the register holds bytes 8 to 23, so that its four pixels begin at its byte 4.
        #[rustfmt::skip]
        let from = _mm256_setr_epi8(
            0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1,
            4, 5, 6, -1, 7, 8, 9, -1, 10, 11, 12, -1, 13, 14, 15, -1,
        );
        let ((rgb, _), (lanes, _)) = (rgb.as_chunks::<PIXELS>(), lanes.as_chunks_mut::<PIXELS>());
        for (rgb, lanes) in rgb.iter().zip(&mut *lanes) {
            let bytes = rgb.as_flattened().as_ptr();
            // SAFETY: bytes 0 to 15 and 8 to 23 are read, and `rgb` is 8 pixels of 3 bytes; `lanes` is 32 bytes.
            unsafe {
                let packed = _mm256_loadu2_m128i(bytes.add(8).cast(), bytes.cast());
                _mm256_storeu_si256(lanes.as_mut_ptr().cast(), _mm256_shuffle_epi8(packed, from));
            }
        }
        PIXELS * rgb.len().min(lanes.len())
    }
}

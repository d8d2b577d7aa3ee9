//! Rows of pixels in AVX-512 registers: blocks of them loaded and stored once, and shifted inside the registers.
//!
//! A window's pixels are those of a block shifted to either side. Loaded from memory again, every shifted block lies across
//! two cache lines, which takes twice as long as a block that does not; a permutation of two neighbouring blocks takes no
//! load at all.

use std::arch::x86_64::*;

/// Bytes in a register.
pub(crate) const BYTES: usize = 64;

/// 0, 1, 2, ... as bytes.
pub(crate) const COUNTING: [u8; BYTES] = {
    let mut counting = [0; BYTES];
    let mut at = 0;
    while at < BYTES {
        counting[at] = at as u8;
        at += 1;
    }
    counting
};

/// Numbers of which any bytes are some.
pub(crate) trait Number: Copy {}
impl Number for u8 {}
impl Number for u16 {}
impl Number for u32 {}
impl Number for f32 {}

/// The pixels of `row` from `x` on, and 0 where it has none.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
#[allow(unsafe_code)]
pub(crate) fn load<T: Number>(row: &[T], x: usize) -> __m512i {
    match row.get(x..x + BYTES / size_of::<T>()) {
        // SAFETY: 64 bytes.
        Some(block) => unsafe { _mm512_loadu_si512(block.as_ptr().cast()) },
        None => {
            let rest = row.get(x..).unwrap_or_default();
            // SAFETY: only the bytes of `rest`, fewer than 64, are read.
            unsafe { _mm512_maskz_loadu_epi8(first_lanes(size_of_val(rest)), rest.as_ptr().cast()) }
        }
    }
}

/// Stores a block as the pixels of `row` from `x` on, without those that the row does not have.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
#[allow(unsafe_code)]
pub(crate) fn store<T: Number>(row: &mut [T], x: usize, block: __m512i) {
    match row.get_mut(x..x + BYTES / size_of::<T>()) {
        // SAFETY: 64 bytes, and any are numbers.
        Some(pixels) => unsafe { _mm512_storeu_si512(pixels.as_mut_ptr().cast(), block) },
        None => {
            let rest = row.get_mut(x..).unwrap_or_default();
            // SAFETY: only the bytes of `rest`, fewer than 64, are written, and any are numbers.
            unsafe {
                _mm512_mask_storeu_epi8(rest.as_mut_ptr().cast(), first_lanes(size_of_val(rest)), block);
            }
        }
    }
}

/// The first `count` of 64 lanes, fewer than all.
fn first_lanes(count: usize) -> u64 {
    (1 << count) - 1
}

/// Where the bytes of a block come from in that and the one before it, when they are shifted by `distance` to the right;
/// for [`_mm512_permutex2var_epi8`].
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
pub(crate) fn right_by(distance: usize) -> __m512i {
    left_by(BYTES - distance)
}

/// Where the bytes of a block come from in that and the next one, when they are shifted by `distance` to the left.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
pub(crate) fn left_by(distance: usize) -> __m512i {
    _mm512_add_epi8(load(&COUNTING, 0), _mm512_set1_epi8(distance as i8))
}

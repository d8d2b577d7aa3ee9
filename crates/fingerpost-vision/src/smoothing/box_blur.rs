//! The mean over a square window of an 8-bit picture, rounded to the nearest level (never a tie: the window is odd).
//!
//! Sums of columns run down the picture, a row entering and one leaving. Up to [`WIDEST_16_BIT_PX`] a window's sum fits 16
//! bits; there the columns of each window are summed afresh, many windows at a time, and the division is a product.
//! Beyond, sums run along the row too. Up to there, too, wide pictures have a twin by hand for AVX-512.

#[cfg(target_arch = "x86_64")]
mod avx512;

use super::{SmoothingError, check_window};
use crate::blocks::{BAND_ROWS, BLOCK, PaddedRows, block_starts, single_pixels};
use crate::border::Border;
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;
use crate::simd::{CodePath, simd_kernel};

/// Widest odd window whose sum of 8-bit pixels fits 16 bits: 15 * 15 * 255, and half the divisor for rounding.
const WIDEST_16_BIT_PX: usize = 15;

/// A box blur of 8-bit pictures, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::picture::Plane;
/// use fingerpost_vision::smoothing::BoxBlur;
/// let mut spot = Plane::new(5, 5, 0_u8);
/// spot.row_mut(2)[2] = 90;
/// let mut blurred = Plane::new(5, 5, 0);
/// BoxBlur::new(3)?.apply(spot.view(), &mut blurred)?;
/// assert_eq!(blurred.row(1), &[0, 10, 10, 10, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct BoxBlur {
    size_px: usize,
    /// Sums of the columns of a band of rows, each row mirrored at both ends. Above them is the row before the band's.
    band: PaddedRows<u16>,
}

impl BoxBlur {
    /// A blur over a window of `size_px` x `size_px` pixels.
    ///
    /// # Errors
    /// [`SmoothingError`] when the window is even or wider than [`super::MAX_SIZE_PX`].
    pub fn new(size_px: usize) -> Result<Self, SmoothingError> {
        check_window(size_px)?;
        Ok(Self { size_px, band: PaddedRows::default() })
    }

    /// Blurs `source` into `target`.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: PlaneView<'_, u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
        self.apply_on(CodePath::fastest(), source, target)
    }

    fn apply_on(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        target: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        check_size("blurred picture", source.size(), target.size())?;
        let (width, height) = source.size();
        if width == 0 || height == 0 {
            return Ok(());
        }
        #[cfg(target_arch = "x86_64")]
        if path.instruction_set() == InstructionSet::Avx512 && avx512::can_blur(width, self.size_px) {
            // SAFETY: a `CodePath` exists only where the processor has its instruction set. Benefit: see the function.
            #[allow(unsafe_code)]
            unsafe {
                avx512::blur(self.size_px, source, target, &mut self.band);
            }
            return Ok(());
        }
        let reach = self.size_px / 2;
        self.band.reset(width, reach, BAND_ROWS + 1);
        let row = |y: usize, offset: isize| source.row(Border::Mirror.inside(y as isize + offset, height));
        // The sums of a row above the first one, so that the first is reached by a step like any other.
        let (first_offset, last_offset) = (-(reach as isize), reach as isize);
        for offset in first_offset - 1..last_offset {
            add(path, self.band.inner_mut(0), row(0, offset));
        }
        for band_start in (0..height).step_by(BAND_ROWS) {
            let band = band_start..height.min(band_start + BAND_ROWS);
            for (number, y) in band.clone().enumerate() {
                let (last, next) = self.band.inner_and_next(number);
                step_down(path, last, row(y, last_offset), row(y, first_offset - 1), next);
                self.band.pad(number + 1, Border::Mirror);
            }
            for (number, y) in band.enumerate() {
                let sums = self.band.row(number + 1, reach);
                match self.size_px {
                    1 => target.row_mut(y).copy_from_slice(source.row(y)),
                    3 => window_means::<3>(path, sums, 3, target.row_mut(y)),
                    5 => window_means::<5>(path, sums, 5, target.row_mut(y)),
                    size_px if size_px <= WIDEST_16_BIT_PX => {
                        window_means::<ANY_SIZE>(path, sums, size_px, target.row_mut(y));
                    }
                    size_px => running_means(sums, size_px, target.row_mut(y)),
                }
            }
            self.band.copy_first_from(BAND_ROWS);
        }
        Ok(())
    }
}

/// Stands for a size that a kernel is not compiled for.
const ANY_SIZE: usize = 0;

/// A factor and a shift that divide by `divisor`, a square up to [`WIDEST_16_BIT_PX`]² but not 1: of a dividend below 256
/// divisors, the product's bits from 16 + shift on are the quotient.
fn division_by(divisor: u16) -> (u16, u32) {
    let shift = divisor.ilog2();
    let factor = (1_u32 << (16 + shift)).div_ceil(u32::from(divisor));
    (factor as u16, shift)
}

/// The sums of the `N` windows from `x` on.
#[inline(always)]
fn window_sums<const SIZE: usize, const N: usize>(sums: &[u16], size: usize, x: usize) -> [u16; N] {
    let size = if SIZE == ANY_SIZE { size } else { SIZE };
    let mut windows = [0; N];
    for start in x..x + size {
        for (window, &sum) in windows.iter_mut().zip(&sums[start..start + N]) {
            *window += sum;
        }
    }
    windows
}

simd_kernel! {
    fn window_means<const SIZE: usize>(sums: &[u16], size: usize, out: &mut [u8]) {
        let area = (size * size) as u16;
        let (factor, shift) = division_by(area);
        let mean = |sum: u16| {
            let upper = ((u32::from(sum + area / 2) * u32::from(factor)) >> 16) as u16;
            (upper >> shift) as u8
        };
        for x in block_starts(out.len()) {
            let windows = window_sums::<SIZE, BLOCK>(sums, size, x);
            out[x..x + BLOCK].copy_from_slice(&windows.map(mean));
        }
        for x in single_pixels(out.len()) {
            [out[x]] = window_sums::<SIZE, 1>(sums, size, x).map(mean);
        }
    }
}

/// Means of windows of any size, by a sum that runs along the row.
fn running_means(sums: &[u16], size: usize, out: &mut [u8]) {
    let area = (size * size) as u32;
    // Of a sum below 2^18 and an area below 2^10, the product with this is exact in its bits from 32 on.
    let factor = (1_u64 << 32).div_ceil(u64::from(area));
    let mut sum: u32 = sums[..size - 1].iter().map(|&sum| u32::from(sum)).sum();
    for ((out, &entering), &leaving) in out.iter_mut().zip(&sums[size - 1..]).zip(sums) {
        sum += u32::from(entering);
        *out = ((u64::from(sum + area / 2) * factor) >> 32) as u8;
        sum -= u32::from(leaving);
    }
}

simd_kernel! {
    fn add(sums: &mut [u16], row: &[u8]) {
        for (sum, &pixel) in sums.iter_mut().zip(row) {
            *sum += u16::from(pixel);
        }
    }
}

simd_kernel! {
    /// The sums of columns that one row enters and one leaves.
    fn step_down(last: &[u16], entering: &[u8], leaving: &[u8], next: &mut [u16]) {
        for (((next, &last), &entering), &leaving) in next.iter_mut().zip(last).zip(entering).zip(leaving) {
            *next = last + u16::from(entering) - u16::from(leaving);
        }
    }
}

#[cfg(test)]
mod tests;

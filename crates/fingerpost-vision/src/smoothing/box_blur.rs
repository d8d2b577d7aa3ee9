//! The mean over a square window of an 8-bit picture, rounded to the nearest level (never a tie: the window is odd).
//!
//! Sums of columns run down the picture, a row entering and one leaving. Up to [`WIDEST_16_BIT_PX`] a window's sum fits 16
//! bits; there the columns of each window are summed afresh, many windows at a time, and the division is a product. Sums of
//! even and of odd columns are kept apart: two neighbouring windows then share all but two of their columns, and their bytes
//! are the halves of 16-bit numbers. Beyond, sums run along the row too. Windows up to 11 pixels have a twin by hand for AVX-512 in
//! wide pictures.

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

/// Widest window whose columns are added up without a loop. Compilers that know how many there are unroll longer sums too, and
/// then keep them in memory (2x slower with AVX2).
const WIDEST_UNROLLED_PX: usize = 7;

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
    /// Sums of the columns of a band of rows, in each row those of the even columns before those of the odd ones. Above them is
    /// the row before the band's.
    band: PaddedRows<u16>,
    /// Those of one row as they follow each other.
    ordered: Vec<u16>,
    columns: Columns,
}

impl BoxBlur {
    /// A blur over a window of `size_px` x `size_px` pixels.
    ///
    /// # Errors
    /// [`SmoothingError`] when the window is even or wider than [`super::MAX_SIZE_PX`].
    pub fn new(size_px: usize) -> Result<Self, SmoothingError> {
        check_window(size_px)?;
        let (band, ordered) = (PaddedRows::default(), Vec::new());
        Ok(Self { size_px, band, ordered, columns: Columns::default() })
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
        let Self { columns, band: sums, ordered, .. } = self;
        columns.set(width, reach);
        // Worked out where the compiler does not know the window's size: where it does, it shifts the products themselves, in
        // 32 bits. The factor it must know, to be sure that it fits 16.
        let (_, shift) = division_by((self.size_px * self.size_px) as u16);
        sums.reset(2 * columns.half, 0, BAND_ROWS + 1);
        let row = |y: usize, offset: isize| source.row(Border::Mirror.inside(y as isize + offset, height));
        // The sums of a row above the first one, so that the first is reached by a step like any other.
        let (first_offset, last_offset) = (-(reach as isize), reach as isize);
        for offset in first_offset - 1..last_offset {
            let (evens, odds) = columns.inner_mut(sums.inner_mut(0));
            add(path, row(0, offset), evens, odds);
        }
        for band_start in (0..height).step_by(BAND_ROWS) {
            let band = band_start..height.min(band_start + BAND_ROWS);
            for (number, y) in band.clone().enumerate() {
                let (last, next) = sums.inner_and_next(number);
                let (evens, odds) = last.split_at(columns.half);
                let (next_evens, next_odds) = columns.inner_mut(next);
                let (entering, leaving) = (row(y, last_offset), row(y, first_offset - 1));
                step_down(path, &evens[BEYOND..], &odds[BEYOND..], entering, leaving, next_evens, next_odds);
                columns.continue_by_a_mirror(next);
            }
            for (number, y) in band.enumerate() {
                let (sums, out) = (sums.row(number + 1, 0), target.row_mut(y));
                match self.size_px {
                    1 => out.copy_from_slice(source.row(y)),
                    3 => columns.means::<3>(path, sums, shift, out),
                    5 => columns.means::<5>(path, sums, shift, out),
                    7 => columns.means::<7>(path, sums, shift, out),
                    9 => columns.means::<9>(path, sums, shift, out),
                    11 => columns.means::<11>(path, sums, shift, out),
                    13 => columns.means::<13>(path, sums, shift, out),
                    WIDEST_16_BIT_PX => columns.means::<WIDEST_16_BIT_PX>(path, sums, shift, out),
                    size_px => {
                        ordered.clear();
                        ordered.extend(columns.in_order(sums));
                        running_means(ordered, size_px, out);
                    }
                }
            }
            sums.copy_first_from(BAND_ROWS);
        }
        Ok(())
    }
}

/// A factor and a shift that divide by `divisor`, a square up to [`WIDEST_16_BIT_PX`]² but not 1: of a dividend below 256
/// divisors, the product's bits from 16 + shift on are the quotient.
fn division_by(divisor: u16) -> (u16, u32) {
    let shift = divisor.ilog2();
    let factor = (1_u32 << (16 + shift)).div_ceil(u32::from(divisor));
    (factor as u16, shift)
}

/// Sums of either half before that of its first column: more than any window reaches, and as many as fill a cache line.
const BEYOND: usize = 32;

/// Where the sums of a row's columns stand: the even columns', and `half` sums later the odd ones', both with [`BEYOND`] more at
/// either end.
#[derive(Debug, Clone, Default)]
struct Columns {
    width: usize,
    reach: usize,
    half: usize,
    /// Where the columns begin that a window of the first pair's first pixel has, and the one of its second pixel besides.
    starts: Vec<usize>,
    /// Where sums beyond the row's ends stand, and those that they are equal to.
    mirrored: Vec<[usize; 2]>,
}

impl Columns {
    /// Takes rows of another width where it is another.
    fn set(&mut self, width: usize, reach: usize) {
        if self.width == width {
            return;
        }
        (self.width, self.reach) = (width, reach);
        self.half = (width.div_ceil(2) + 2 * BEYOND).next_multiple_of(BEYOND);
        let reach = reach as isize;
        self.starts = (-reach..=reach + 1).map(|column| self.place(column)).collect();
        self.mirrored.clear();
        for distance in 1..=reach {
            for beyond in [-distance, width as isize - 1 + distance] {
                let inside = Border::Mirror.inside(beyond, width) as isize;
                self.mirrored.push([beyond, inside].map(|column| self.place(column)));
            }
        }
    }

    /// Where the sum of a column stands.
    fn place(&self, column: isize) -> usize {
        let half = if column.rem_euclid(2) == 0 { 0 } else { self.half };
        (half + BEYOND).saturating_add_signed(column.div_euclid(2))
    }

    /// The even and the odd columns of a row and what is beyond their end.
    fn inner_mut<'r>(&self, row: &'r mut [u16]) -> (&'r mut [u16], &'r mut [u16]) {
        let (evens, odds) = row.split_at_mut(self.half);
        (&mut evens[BEYOND..], &mut odds[BEYOND..])
    }

    fn continue_by_a_mirror(&self, row: &mut [u16]) {
        for &[beyond, inside] in &self.mirrored {
            row[beyond] = row[inside];
        }
    }

    /// Means of windows of `SIZE` columns. Two neighbours have all columns in common but the first of the one and the last of
    /// the other.
    fn means<const SIZE: usize>(&self, path: CodePath, sums: &[u16], shift: u32, out: &mut [u8]) {
        let mut window = [&[][..]; WIDEST_16_BIT_PX + 1];
        for (columns, &start) in window.iter_mut().zip(&self.starts) {
            *columns = &sums[start..];
        }
        let size = if SIZE <= WIDEST_UNROLLED_PX { SIZE } else { 2 * self.reach + 1 };
        let (window, next) = (&window[..size], window[size]);
        let (pairs, last) = out.as_chunks_mut::<2>();
        pair_means::<SIZE>(path, window, next, shift, pairs);
        if let [last] = last {
            let sum = window.iter().map(|columns| columns[pairs.len()]).sum();
            *last = mean::<SIZE>(sum, shift) as u8;
        }
    }

    /// The sums of a row's columns one after the other, with those that a window reaches beyond its ends.
    fn in_order(&self, sums: &[u16]) -> impl Iterator<Item = u16> {
        let reach = self.reach as isize;
        (-reach..self.width as isize + reach).map(|column| sums[self.place(column)])
    }
}

/// The rounded mean of a window of `SIZE` columns whose pixels sum up to `sum`.
#[inline(always)]
fn mean<const SIZE: usize>(sum: u16, shift: u32) -> u16 {
    let area = (SIZE * SIZE) as u16;
    let (factor, _) = division_by(area);
    (((u32::from(sum + area / 2) * u32::from(factor)) >> 16) as u16) >> shift
}

/// The sums of `N` pairs of columns from one on, each added to what is there.
#[inline(always)]
fn raise<const N: usize>(mut sums: [u16; N], columns: &[u16], pair: usize) -> [u16; N] {
    for (sum, &column) in sums.iter_mut().zip(&columns[pair..pair + N]) {
        *sum += column;
    }
    sums
}

/// The means of the windows about `N` pairs of pixels from one on.
#[inline(always)]
fn means_of<const SIZE: usize, const N: usize>(
    window: &[&[u16]],
    next: &[u16],
    shift: u32,
    pair: usize,
    out: &mut [[u8; 2]],
) {
    let mut common = [0; N];
    for columns in &window[1..] {
        common = raise(common, columns, pair);
    }
    let (evens, odds) = (raise(common, window[0], pair), raise(common, next, pair));
    for ((out, &even), &odd) in out[pair..pair + N].iter_mut().zip(&evens).zip(&odds) {
        *out = (mean::<SIZE>(even, shift) | mean::<SIZE>(odd, shift) << 8).to_le_bytes();
    }
}

simd_kernel! {
    /// Means of the windows about pairs of pixels: `window` has the columns of each one's first, beginning with the leftmost,
    /// and `next` the column that the second one's window has besides.
    fn pair_means<const SIZE: usize>(
        window: &[&[u16]], next: &[u16], shift: u32, out: &mut [[u8; 2]],
    ) {
        for pair in block_starts(out.len()) {
            means_of::<SIZE, BLOCK>(window, next, shift, pair, out);
        }
        for pair in single_pixels(out.len()) {
            means_of::<SIZE, 1>(window, next, shift, pair, out);
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
    fn add(row: &[u8], evens: &mut [u16], odds: &mut [u16]) {
        let (pairs, last) = row.as_chunks::<2>();
        for ((even, odd), &pair) in evens.iter_mut().zip(odds).zip(pairs) {
            let pair = u16::from_le_bytes(pair);
            *even += pair & 0xff;
            *odd += pair >> 8;
        }
        if let [last] = last {
            evens[pairs.len()] += u16::from(*last);
        }
    }
}

simd_kernel! {
    /// The sums of columns that one row enters and one leaves.
    fn step_down(
        even: &[u16], odd: &[u16], entering: &[u8], leaving: &[u8], next_even: &mut [u16], next_odd: &mut [u16],
    ) {
        let ((entering, last_entering), (leaving, last_leaving)) =
            (entering.as_chunks::<2>(), leaving.as_chunks::<2>());
        let nexts = next_even.iter_mut().zip(next_odd.iter_mut()).zip(even.iter().zip(odd));
        for (((next_even, next_odd), (&even, &odd)), (&entering, &leaving)) in
            nexts.zip(entering.iter().zip(leaving))
        {
            let (entering, leaving) = (u16::from_le_bytes(entering), u16::from_le_bytes(leaving));
            *next_even = even + (entering & 0xff) - (leaving & 0xff);
            *next_odd = odd + (entering >> 8) - (leaving >> 8);
        }
        if let ([last_entering], [last_leaving]) = (last_entering, last_leaving) {
            let pair = entering.len();
            next_even[pair] = even[pair] + u16::from(*last_entering) - u16::from(*last_leaving);
        }
    }
}

#[cfg(test)]
mod tests;

//! Gaussian blur in 8-bit fixed point.
//!
//! The weights along each axis are whole 256ths that sum to 256, so a pixel is an exact integer convolution, rounded once.
//! Where all weights are whole 16ths (the binomial windows of 3 and 5 pixels) its sum fits 16 bits. Otherwise the sums of
//! columns are split into their upper and lower byte, and rows are summed of either: 16 bits again hold every sum, and
//! twice as many pixels fit a vector register as with 32.

use super::{MAX_SIZE_PX, SmoothingError, check_window};
use crate::border::Border;
use crate::error::{PictureError, check_size};
use crate::filter::gaussian_taps;
use crate::picture::{Plane, PlaneView};
use crate::simd::{CodePath, simd_kernel};

/// What the weights along an axis sum to: OpenCV's 8 fractional bits.
const ONE: u16 = 256;
/// Weights that are multiples of this are divided by it; sums over the window are then below 2^16.
const COARSE: u16 = 16;
/// Pixels that a kernel computes together: two of the widest vector registers, and a whole number of every other.
const BLOCK: usize = 64;

/// A Gaussian blur of 8-bit pictures, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::picture::Plane;
/// use fingerpost_vision::smoothing::GaussianBlur;
/// let mut spot = Plane::new(5, 5, 0_u8);
/// spot.row_mut(2)[2] = 160;
/// let mut blurred = Plane::new(5, 5, 0);
/// GaussianBlur::new(3, 0.0)?.apply(spot.view(), &mut blurred)?;
/// assert_eq!(blurred.row(2), &[0, 20, 40, 20, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct GaussianBlur {
    /// Weights from the window's middle outwards.
    weights: Vec<u16>,
    /// What the weights along an axis sum to: [`ONE`], or [`ONE`] / [`COARSE`].
    total: u16,
    /// Sums of columns of one row, mirrored at both ends: as they are, or their upper bytes.
    sums: Vec<u16>,
    /// The lower bytes of the sums where they are split.
    lower: Vec<u16>,
}

impl GaussianBlur {
    /// A blur over a window of `size_px` x `size_px` pixels, with the standard deviation `sigma_px`, pixels; 0 takes the
    /// one that OpenCV derives from the window, 0.3 ((size - 1) / 2 - 1) + 0.8, and its own weights up to 7 pixels.
    ///
    /// # Errors
    /// [`SmoothingError`] when the window is even or wider than [`MAX_SIZE_PX`], or the deviation negative or no number.
    pub fn new(size_px: usize, sigma_px: f64) -> Result<Self, SmoothingError> {
        check_window(size_px)?;
        if !(sigma_px.is_finite() && sigma_px >= 0.0) {
            return Err(SmoothingError::Sigma { sigma_px });
        }
        let mut weights = fixed_point_weights(size_px, sigma_px);
        let mut total = ONE;
        if weights.iter().all(|weight| weight.is_multiple_of(COARSE)) {
            weights.iter_mut().for_each(|weight| *weight /= COARSE);
            total /= COARSE;
        }
        Ok(Self { weights, total, sums: Vec::new(), lower: Vec::new() })
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
        if width == 0 {
            return Ok(());
        }
        let reach = self.weights.len() - 1;
        let padded = reach..reach + width;
        self.sums.resize(width + 2 * reach, 0);
        self.lower.resize(width + 2 * reach, 0);
        let mut rows = [&[][..]; MAX_SIZE_PX];
        let rows = &mut rows[..2 * reach + 1];
        for y in 0..height {
            for (tap, row) in rows.iter_mut().enumerate() {
                *row = source.row(Border::Mirror.inside((y + tap) as isize - reach as isize, height));
            }
            let out = target.row_mut(y);
            if self.total == ONE {
                let (upper, lower) = (&mut self.sums[padded.clone()], &mut self.lower[padded.clone()]);
                split_column_sums(path, rows, &self.weights, upper, lower);
                Border::Mirror.pad(&mut self.sums, reach);
                Border::Mirror.pad(&mut self.lower, reach);
                split_row_sums(path, &self.sums, &self.lower, &self.weights, out);
            } else {
                column_sums(path, rows, &self.weights, &mut self.sums[padded.clone()]);
                Border::Mirror.pad(&mut self.sums, reach);
                row_sums(path, &self.sums, &self.weights, out);
            }
        }
        Ok(())
    }
}

/// Weights in 256ths from the middle outwards. Rounding errors are carried inwards from weight to weight, and the middle
/// takes what is missing to 256, as OpenCV does.
fn fixed_point_weights(size_px: usize, sigma_px: f64) -> Vec<u16> {
    let reach = size_px / 2;
    let taps = match size_px {
        3 if sigma_px <= 0.0 => vec![0.25, 0.5, 0.25],
        5 if sigma_px <= 0.0 => vec![0.0625, 0.25, 0.375, 0.25, 0.0625],
        7 if sigma_px <= 0.0 => vec![0.03125, 0.109375, 0.21875, 0.28125, 0.21875, 0.109375, 0.03125],
        _ if sigma_px <= 0.0 => gaussian_taps(0.3 * (reach as f64 - 1.0) + 0.8, reach),
        _ => gaussian_taps(sigma_px, reach),
    };
    let mut missing = ONE;
    let mut carried = 0.0;
    let mut weights: Vec<u16> = taps[..reach]
        .iter()
        .map(|tap| {
            let exact = tap * f64::from(ONE) + carried;
            let weight = exact.round_ties_even();
            carried = exact - weight;
            missing -= 2 * weight as u16;
            weight as u16
        })
        .collect();
    weights.push(missing);
    weights.reverse();
    weights
}

/// The weighted sums of `N` columns from `x` on; `rows` are those of the window, `weights` from its middle outwards.
#[inline(always)]
fn column_block<const N: usize>(rows: &[&[u8]], weights: &[u16], x: usize) -> [u16; N] {
    let reach = weights.len() - 1;
    let mut sums = [0; N];
    for (sum, &pixel) in sums.iter_mut().zip(&rows[reach][x..x + N]) {
        *sum = weights[0] * u16::from(pixel);
    }
    for (distance, &weight) in weights.iter().enumerate().skip(1) {
        let (above, below) = (&rows[reach - distance][x..x + N], &rows[reach + distance][x..x + N]);
        for ((sum, &above), &below) in sums.iter_mut().zip(above).zip(below) {
            *sum += weight * (u16::from(above) + u16::from(below));
        }
    }
    sums
}

/// The weighted sums along `row` of the `N` windows that start at `x`.
#[inline(always)]
fn row_block<const N: usize>(row: &[u16], weights: &[u16], x: usize) -> [u16; N] {
    let middle = x + weights.len() - 1;
    let mut sums = [0; N];
    for (sum, &value) in sums.iter_mut().zip(&row[middle..middle + N]) {
        *sum = weights[0] * value;
    }
    for (distance, &weight) in weights.iter().enumerate().skip(1) {
        let (left, right) = (&row[middle - distance..][..N], &row[middle + distance..][..N]);
        for ((sum, &left), &right) in sums.iter_mut().zip(left).zip(right) {
            *sum += weight * (left + right);
        }
    }
    sums
}

simd_kernel! {
    fn column_sums(rows: &[&[u8]], weights: &[u16], sums: &mut [u16]) {
        let (blocks, rest) = sums.as_chunks_mut::<BLOCK>();
        let blocks_end = blocks.len() * BLOCK;
        for (index, block) in blocks.iter_mut().enumerate() {
            *block = column_block(rows, weights, index * BLOCK);
        }
        for (index, sum) in rest.iter_mut().enumerate() {
            [*sum] = column_block(rows, weights, blocks_end + index);
        }
    }
}

simd_kernel! {
    fn split_column_sums(rows: &[&[u8]], weights: &[u16], upper: &mut [u16], lower: &mut [u16]) {
        let (upper_blocks, upper_rest) = upper.as_chunks_mut::<BLOCK>();
        let (lower_blocks, lower_rest) = lower.as_chunks_mut::<BLOCK>();
        let blocks_end = upper_blocks.len() * BLOCK;
        for (index, (upper, lower)) in upper_blocks.iter_mut().zip(lower_blocks).enumerate() {
            let sums: [u16; BLOCK] = column_block(rows, weights, index * BLOCK);
            *upper = sums.map(|sum| sum >> 8);
            *lower = sums.map(|sum| sum & 0xff);
        }
        for (index, (upper, lower)) in upper_rest.iter_mut().zip(lower_rest).enumerate() {
            let [sum] = column_block(rows, weights, blocks_end + index);
            (*upper, *lower) = (sum >> 8, sum & 0xff);
        }
    }
}

simd_kernel! {
    fn row_sums(sums: &[u16], weights: &[u16], out: &mut [u8]) {
        let round = |sum: u16| ((sum + 128) >> 8) as u8;
        let (blocks, rest) = out.as_chunks_mut::<BLOCK>();
        let blocks_end = blocks.len() * BLOCK;
        for (index, block) in blocks.iter_mut().enumerate() {
            *block = row_block::<BLOCK>(sums, weights, index * BLOCK).map(round);
        }
        for (index, out) in rest.iter_mut().enumerate() {
            [*out] = row_block::<1>(sums, weights, blocks_end + index).map(round);
        }
    }
}

simd_kernel! {
    fn split_row_sums(upper: &[u16], lower: &[u16], weights: &[u16], out: &mut [u8]) {
        // 256 upper + lower + 2^15 over 2^16, rounded down; 2^15 is a multiple of 256, so the lower part's own remainder
        // never matters.
        let round = |upper: u16, lower: u16| ((upper + 128 + (lower >> 8)) >> 8) as u8;
        let (blocks, rest) = out.as_chunks_mut::<BLOCK>();
        let blocks_end = blocks.len() * BLOCK;
        for (index, block) in blocks.iter_mut().enumerate() {
            let upper: [u16; BLOCK] = row_block(upper, weights, index * BLOCK);
            let lower: [u16; BLOCK] = row_block(lower, weights, index * BLOCK);
            for ((out, &upper), &lower) in block.iter_mut().zip(&upper).zip(&lower) {
                *out = round(upper, lower);
            }
        }
        for (index, out) in rest.iter_mut().enumerate() {
            let x = blocks_end + index;
            let ([upper], [lower]) = (row_block(upper, weights, x), row_block(lower, weights, x));
            *out = round(upper, lower);
        }
    }
}

#[cfg(test)]
mod tests;

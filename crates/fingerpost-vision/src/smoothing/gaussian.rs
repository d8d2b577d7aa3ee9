//! Gaussian blur in 8-bit fixed point.
//!
//! The weights along each axis are whole 256ths that sum to 256, so a pixel is an exact integer convolution, rounded once.
//! Where all weights are whole 16ths (the binomial windows of 3 and 5 pixels) its sum fits 16 bits. Otherwise the sums of
//! columns are split into their upper and lower byte, and rows are summed of either: 16 bits again hold every sum, and
//! twice as many pixels fit a vector register as with 32.

use super::{MAX_SIZE_PX, SmoothingError, check_window};
use crate::blocks::{BLOCK, block_starts, single_pixels};
use crate::border::Border;
use crate::error::{PictureError, check_size};
use crate::filter::gaussian_taps;
use crate::picture::{Plane, PlaneView};
use crate::simd::{CodePath, simd_kernel};

/// What the weights along an axis sum to: OpenCV's 8 fractional bits.
const ONE: u16 = 256;
/// Weights that are multiples of this are divided by it; sums over the window are then below 2^16.
const COARSE: u16 = 16;
/// Stands for a reach that a kernel is not compiled for.
const ANY_REACH: usize = usize::MAX;

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
    /// Sums of columns of one row, mirrored at both ends.
    sums: Vec<u16>,
    /// The same as upper and lower bytes, where they are split.
    bytes: [Vec<u8>; 2],
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
        Ok(Self { weights, total, sums: Vec::new(), bytes: [Vec::new(), Vec::new()] })
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
        if source.width() == 0 {
            return Ok(());
        }
        match self.weights.len() - 1 {
            1 => self.apply_with::<1>(path, source, target),
            2 => self.apply_with::<2>(path, source, target),
            3 => self.apply_with::<3>(path, source, target),
            _ => self.apply_with::<ANY_REACH>(path, source, target),
        }
        Ok(())
    }

    fn apply_with<const REACH: usize>(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        target: &mut Plane<u8>,
    ) {
        let (width, height) = source.size();
        let (weights, sums, [upper, lower]) = (&self.weights, &mut self.sums, &mut self.bytes);
        let reach = weights.len() - 1;
        sums.resize(width + 2 * reach, 0);
        upper.resize(width + 2 * reach, 0);
        lower.resize(width + 2 * reach, 0);
        let inner = reach..reach + width;
        let mut rows = [&[][..]; MAX_SIZE_PX];
        let rows = &mut rows[..2 * reach + 1];
        for y in 0..height {
            for (tap, row) in rows.iter_mut().enumerate() {
                *row = source.row(Border::Mirror.inside((y + tap) as isize - reach as isize, height));
            }
            let out = target.row_mut(y);
            if self.total == ONE {
                let (inner_upper, inner_lower) = (&mut upper[inner.clone()], &mut lower[inner.clone()]);
                split_column_sums::<REACH>(path, rows, weights, inner_upper, inner_lower);
                Border::Mirror.pad(upper, reach);
                Border::Mirror.pad(lower, reach);
                split_row_sums::<REACH>(path, upper, lower, weights, out);
            } else {
                column_sums::<REACH>(path, rows, weights, &mut sums[inner.clone()]);
                Border::Mirror.pad(sums, reach);
                row_sums::<REACH>(path, sums, weights, out);
            }
        }
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

/// The weighted sums of `N` windows from `x` on. `shifted` gives the values that a tap of the window falls on, `weights`
/// are from the window's middle outwards. `REACH` is how far it reaches, [`ANY_REACH`] if that is not known beforehand.
#[inline(always)]
fn block<'a, const REACH: usize, const N: usize, T: Copy + Into<u16> + 'a>(
    shifted: impl Fn(usize) -> &'a [T],
    weights: &[u16],
    x: usize,
) -> [u16; N] {
    let reach = if REACH == ANY_REACH { weights.len() - 1 } else { REACH };
    let mut sums = [0; N];
    for (sum, &value) in sums.iter_mut().zip(&shifted(reach)[x..x + N]) {
        *sum = weights[0] * value.into();
    }
    #[allow(
        clippy::needless_range_loop,
        reason = "unrolled, unlike a loop over the slice (1.8x at 5 pixels, Zen 4)"
    )]
    for distance in 1..=reach {
        let weight = weights[distance];
        let (before, after) = (&shifted(reach - distance)[x..x + N], &shifted(reach + distance)[x..x + N]);
        for ((sum, &before), &after) in sums.iter_mut().zip(before).zip(after) {
            *sum += weight * (before.into() + after.into());
        }
    }
    sums
}

simd_kernel! {
    fn column_sums<const REACH: usize>(rows: &[&[u8]], weights: &[u16], sums: &mut [u16]) {
        let shifted = |tap: usize| rows[tap];
        for x in block_starts(sums.len()) {
            sums[x..x + BLOCK].copy_from_slice(&block::<REACH, BLOCK, _>(shifted, weights, x));
        }
        for x in single_pixels(sums.len()) {
            [sums[x]] = block::<REACH, 1, _>(shifted, weights, x);
        }
    }
}

simd_kernel! {
    fn split_column_sums<const REACH: usize>(
        rows: &[&[u8]], weights: &[u16], upper: &mut [u8], lower: &mut [u8]
    ) {
        let shifted = |tap: usize| rows[tap];
        for x in block_starts(upper.len()) {
            let sums = block::<REACH, BLOCK, _>(shifted, weights, x);
            let (upper, lower) = (&mut upper[x..x + BLOCK], &mut lower[x..x + BLOCK]);
            for ((upper, lower), sum) in upper.iter_mut().zip(lower).zip(sums) {
                (*upper, *lower) = ((sum >> 8) as u8, sum as u8);
            }
        }
        for x in single_pixels(upper.len()) {
            let [sum] = block::<REACH, 1, _>(shifted, weights, x);
            (upper[x], lower[x]) = ((sum >> 8) as u8, sum as u8);
        }
    }
}

simd_kernel! {
    fn row_sums<const REACH: usize>(sums: &[u16], weights: &[u16], out: &mut [u8]) {
        let shifted = |tap: usize| &sums[tap..];
        let round = |sum: u16| ((sum + 128) >> 8) as u8;
        for x in block_starts(out.len()) {
            let sums = block::<REACH, BLOCK, _>(shifted, weights, x);
            out[x..x + BLOCK].copy_from_slice(&sums.map(round));
        }
        for x in single_pixels(out.len()) {
            [out[x]] = block::<REACH, 1, _>(shifted, weights, x).map(round);
        }
    }
}

simd_kernel! {
    fn split_row_sums<const REACH: usize>(upper: &[u8], lower: &[u8], weights: &[u16], out: &mut [u8]) {
        // (256 upper + lower + 2^15) / 2^16, rounded down; 2^15 is a multiple of 256, so what the lower part leaves over
        // after its division by 256 never matters.
        let round = |upper: u16, lower: u16| ((upper + 128 + (lower >> 8)) >> 8) as u8;
        let (upper, lower) = (|tap: usize| &upper[tap..], |tap: usize| &lower[tap..]);
        for x in block_starts(out.len()) {
            let upper = block::<REACH, BLOCK, _>(upper, weights, x);
            let lower = block::<REACH, BLOCK, _>(lower, weights, x);
            for ((out, upper), lower) in out[x..x + BLOCK].iter_mut().zip(upper).zip(lower) {
                *out = round(upper, lower);
            }
        }
        for x in single_pixels(out.len()) {
            let [upper] = block::<REACH, 1, _>(upper, weights, x);
            let [lower] = block::<REACH, 1, _>(lower, weights, x);
            out[x] = round(upper, lower);
        }
    }
}

#[cfg(test)]
mod tests;

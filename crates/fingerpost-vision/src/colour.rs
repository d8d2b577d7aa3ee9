//! Grey, hue and saturation of 8-bit colour, in integers.
//!
//! Grey is the luma of ITU-R BT.601 (the former CCIR 601). Hue and saturation are those of the hexcone model (A. R.
//! Smith, "Color gamut transform pairs", SIGGRAPH 1978) in the ranges that are usual for 8-bit pictures: hue in half
//! degrees, 0 to 179 with red at 0, and saturation 0 to 255.

#[cfg(target_arch = "x86_64")]
mod avx512;
mod kernel;
pub(crate) mod lanes;
#[cfg(test)]
mod tests;
mod yuv;

pub(crate) use kernel::{grey_and_bins_of_all, grey_of_all as luma_of_row};
pub use yuv::{Yuv420, YuvCoding, YuvMatrix, YuvRange, rgb_from_yuv420};

use crate::error::{PictureError, check_size};
use crate::picture::{Plane, RgbImage};
use crate::simd::CodePath;

/// Number of hues: half degrees of the colour circle.
pub const HUES: u16 = 180;
/// Number of saturations.
pub const SATURATIONS: u16 = 256;

/// Bits behind the point of the luma weights: with 15 the weights and half a step still fit 16 bits with their sign, so that
/// vectors can multiply and add them in pairs.
const LUMA_BITS: u32 = 15;
/// Luma weights 0.299, 0.587 and 0.114 of red, green and blue, times 2^15; they sum to 2^15, so white stays 255.
const LUMA: [i32; 3] = [9_798, 19_235, 3_735];

/// Largest quotient of [`rounded_quotient`] is below this power of two, from which on the whole numbers are the `f32`s.
const WHOLE: f32 = 8_388_608.0;

/// Luma of one colour, 0 to 255.
///
/// ```
/// use fingerpost_vision::colour::grey_of;
/// assert_eq!(grey_of([255, 255, 255]), 255);
/// assert_eq!(grey_of([255, 0, 0]), 76); // 0.299 * 255 = 76.2
/// ```
#[must_use]
#[inline(always)]
pub fn grey_of(rgb: [u8; 3]) -> u8 {
    let [r, g, b] = rgb.map(i32::from);
    ((r * LUMA[0] + g * LUMA[1] + b * LUMA[2] + (1 << (LUMA_BITS - 1))) >> LUMA_BITS) as u8
}

/// Hue in half degrees, 0 to 179, and saturation, 0 to 255, of one colour, rounded, ties to the even number; both are 0
/// for greys.
///
/// ```
/// use fingerpost_vision::colour::hue_saturation_of;
/// assert_eq!(hue_saturation_of([0, 255, 0]), (60, 255)); // green: 120 degrees
/// assert_eq!(hue_saturation_of([90, 90, 90]), (0, 0));
/// ```
#[must_use]
#[inline(always)]
pub fn hue_saturation_of(rgb: [u8; 3]) -> (u8, u8) {
    let [r, g, b] = rgb.map(i32::from);
    let value = r.max(g).max(b);
    let spread = value - r.min(g).min(b);
    let saturation = rounded_quotient(255 * spread, value.max(1));
    // Which channel is largest names the third of the circle; the other two say how far from its middle, a sixth of the
    // circle at most. A whole circle more keeps the quotient positive.
    let (middle, difference) = if value == r {
        (180, g - b)
    } else if value == g {
        (240, b - r)
    } else {
        (300, r - g)
    };
    let hue = rounded_quotient(30 * difference + middle * spread, spread.max(1));
    let hue = if hue >= i32::from(HUES) { hue - i32::from(HUES) } else { hue };
    (hue as u8, saturation as u8)
}

/// The whole number nearest to `numerator / divisor`, ties to the even one.
///
/// Numerators here are below 2^17 and divisors below 2^8, so both are exact in `f32`. A quotient that is no tie is at least
/// 1/510 from one, and `f32` rounds a quotient below 2^9 by 2^-16 at most, so none is rounded to or beyond a tie; a tie is
/// exact. Adding 2^23 then leaves the nearest whole number in the lowest bits.
#[inline(always)]
fn rounded_quotient(numerator: i32, divisor: i32) -> i32 {
    let quotient = numerator as f32 / divisor as f32;
    ((quotient + WHOLE).to_bits() & 0x3ff) as i32
}

/// A division of hue and saturation into bins of equal width.
///
/// A colour's bin index is `hue_bin * saturation + saturation_bin`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HueSaturationBins {
    /// Bins over hue, 1 to 180.
    pub hue: u16,
    /// Bins over saturation, 1 to 256.
    pub saturation: u16,
}

/// A division of hue and saturation that cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ColourError {
    /// A number of bins is zero or larger than the number of values.
    #[error(
        "{hue} hue bins and {saturation} saturation bins; choose 1 to 180 hue bins and 1 to 256 saturation bins"
    )]
    Bins {
        /// Bins over hue asked for.
        hue: u16,
        /// Bins over saturation asked for.
        saturation: u16,
    },
}

impl HueSaturationBins {
    /// Checks the numbers of bins.
    ///
    /// # Errors
    /// [`ColourError::Bins`] when one is 0, `hue` is above 180 or `saturation` above 256.
    pub fn check(self) -> Result<(), ColourError> {
        if (1..=HUES).contains(&self.hue) && (1..=SATURATIONS).contains(&self.saturation) {
            Ok(())
        } else {
            Err(ColourError::Bins { hue: self.hue, saturation: self.saturation })
        }
    }

    /// Number of bins.
    #[must_use]
    pub fn count(self) -> usize {
        usize::from(self.hue) * usize::from(self.saturation)
    }

    /// Bin index of a hue in half degrees and a saturation; hues from 180 on count as 179.
    #[must_use]
    pub fn bin_of(self, hue: u8, saturation: u8) -> usize {
        let hue = usize::from(hue).min(usize::from(HUES) - 1);
        let hue_bin = hue * usize::from(self.hue) / usize::from(HUES);
        let saturation_bin =
            usize::from(saturation) * usize::from(self.saturation) / usize::from(SATURATIONS);
        hue_bin * usize::from(self.saturation) + saturation_bin
    }
}

/// A checked [`HueSaturationBins`], ready to number the bins of whole pictures.
///
/// ```
/// use fingerpost_vision::colour::{BinDivision, HueSaturationBins};
/// let division = BinDivision::new(HueSaturationBins { hue: 6, saturation: 4 })?;
/// assert_eq!(division.bin_of(60, 255), 2 * 4 + 3);
/// # Ok::<(), fingerpost_vision::colour::ColourError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BinDivision {
    bins: HueSaturationBins,
    /// Hue bins a hue, times 2^[`HUE_BIN_BITS`], rounded up.
    hue_factor: u32,
}

/// Bits behind the point of a factor that makes hue bins of hues. A factor is less than 2^-15 too large, so that the
/// largest hue's bin is less than 179/32768 too large before it is cut: less than the 1/180 by which a quotient of a whole
/// number by 180 can fall short of the next whole number.
const HUE_BIN_BITS: u32 = 15;

impl BinDivision {
    /// Checks the numbers of bins.
    ///
    /// # Errors
    /// [`ColourError::Bins`] as [`HueSaturationBins::check`].
    pub fn new(bins: HueSaturationBins) -> Result<Self, ColourError> {
        bins.check()?;
        let hue_factor = (u32::from(bins.hue) << HUE_BIN_BITS).div_ceil(u32::from(HUES));
        Ok(Self { bins, hue_factor })
    }

    /// The division into bins.
    #[must_use]
    pub const fn bins(&self) -> HueSaturationBins {
        self.bins
    }

    /// Bin index of a hue in half degrees, 0 to 179, and a saturation: that of [`HueSaturationBins::bin_of`].
    #[must_use]
    #[inline(always)]
    pub fn bin_of(&self, hue: u8, saturation: u8) -> u16 {
        let hue_bin = (u32::from(hue) * self.hue_factor) >> HUE_BIN_BITS;
        let saturations = u32::from(self.bins.saturation);
        let saturation_bin = (u32::from(saturation) * saturations) / u32::from(SATURATIONS);
        // At most 180 * 256 bins, so an index fits 16 bits.
        (hue_bin * saturations + saturation_bin) as u16
    }
}

/// Fills `grey` with the luma of `image`.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the two differ in size.
pub fn grey(image: &RgbImage, grey: &mut Plane<u8>) -> Result<(), PictureError> {
    check_size("grey picture", image.size(), grey.size())?;
    kernel::grey_of_all(CodePath::fastest(), image.pixels(), grey.as_mut_slice());
    Ok(())
}

/// Fills `grey` with the luma of as many rows of `image` as it has, from `first_row` on.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the widths differ or the rows do not lie inside the picture.
pub fn grey_of_rows(image: &RgbImage, first_row: usize, grey: &mut Plane<u8>) -> Result<(), PictureError> {
    let rows = image.height().saturating_sub(first_row).min(grey.height());
    check_size("grey rows", (image.width(), rows), grey.size())?;
    let from = first_row * image.width();
    let pixels = &image.pixels()[from..from + rows * image.width()];
    kernel::grey_of_all(CodePath::fastest(), pixels, grey.as_mut_slice());
    Ok(())
}

/// Fills `hue` (half degrees, 0 to 179) and `saturation` (0 to 255) with those of `image`.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the three differ in size.
pub fn hue_saturation(
    image: &RgbImage,
    hue: &mut Plane<u8>,
    saturation: &mut Plane<u8>,
) -> Result<(), PictureError> {
    check_size("hue picture", image.size(), hue.size())?;
    check_size("saturation picture", image.size(), saturation.size())?;
    let (hue, saturation) = (hue.as_mut_slice(), saturation.as_mut_slice());
    kernel::hue_saturation_of_all(CodePath::fastest(), image.pixels(), hue, saturation);
    Ok(())
}

/// Fills `grey` with the luma and `bin` with the hue-saturation bin index of each pixel of `image`, in one pass.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the pictures differ in size.
pub fn grey_and_bins(
    image: &RgbImage,
    division: &BinDivision,
    grey: &mut Plane<u8>,
    bin: &mut Plane<u16>,
) -> Result<(), PictureError> {
    check_size("grey picture", image.size(), grey.size())?;
    check_size("bin picture", image.size(), bin.size())?;
    let (grey, bin) = (grey.as_mut_slice(), bin.as_mut_slice());
    grey_and_bins_of_all(CodePath::fastest(), image.pixels(), division, grey, bin);
    Ok(())
}

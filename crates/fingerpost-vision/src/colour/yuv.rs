//! Colour from luma and two colour differences, as video decoders give it.
//!
//! Recommendations ITU-R BT.601-7 (2.5.1 to 2.5.3) and BT.709-6 (3.2 to 3.5): with luma weights Kr, Kg and Kb that sum to
//! 1, luma Y and colour differences Cb and Cr,
//!
//! ```text
//! R = Y + 2 (1 - Kr) Cr
//! G = Y - 2 (1 - Kb) Kb / Kg Cb - 2 (1 - Kr) Kr / Kg Cr
//! B = Y + 2 (1 - Kb) Cb
//! ```
//!
//! A colour difference is sampled once for two by two pixels and serves all four as it is (nearest neighbour). Limits: 8
//! bits, and no notice of where between its pixels a colour difference was sampled, which is half a pixel at most.

use crate::error::{PictureError, check_size};
use crate::picture::{RgbImage, check_length};
use crate::simd::{CodePath, simd_kernel};

/// The luma weights of a video.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YuvMatrix {
    /// ITU-R BT.601: standard definition, JPEG.
    Bt601,
    /// ITU-R BT.709: high definition.
    Bt709,
}

/// Which of the 8-bit values stand for black and white.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YuvRange {
    /// Luma 16 to 235, colour differences 16 to 240: nearly all video.
    Limited,
    /// All 256 values, as in JPEG.
    Full,
}

/// How a video codes colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct YuvCoding {
    /// The luma weights.
    pub matrix: YuvMatrix,
    /// The range of values.
    pub range: YuvRange,
}

/// A picture as luma and colour differences at half its size: planar YUV 4:2:0, tightly packed.
#[derive(Debug, Clone, Copy)]
pub struct Yuv420<'a> {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Luma, `width * height`.
    pub y: &'a [u8],
    /// Blue difference, half of `width` times half of `height`, each rounded up.
    pub u: &'a [u8],
    /// Red difference, of the same size.
    pub v: &'a [u8],
}

/// Bits behind the point of the sums: the largest, white with the largest red or blue difference, still saturates to
/// white in 16 bits.
const SUM_BITS: u32 = 6;
/// Luma is multiplied as luma times 2^7, so that 255 fits 16 bits and a factor of 1.16 does too.
const LUMA_SHIFT: u32 = 7;
/// A colour difference is multiplied as itself times 2^8, so that -128 fits 16 bits and a factor of 2.11 does too.
const DIFFERENCE_SHIFT: u32 = 8;
/// A product is cut by this many bits, rounded.
const PRODUCT_BITS: u32 = 15;
/// Value of no colour difference.
const NEUTRAL: i16 = 128;

/// Factors of the conversion in 16 bits.
#[derive(Debug, Clone, Copy)]
struct Factors {
    black: i16,
    luma: i16,
    red_of_v: i16,
    green_of_u: i16,
    green_of_v: i16,
    blue_of_u: i16,
}

impl Factors {
    fn new(coding: YuvCoding) -> Self {
        let (red, blue) = match coding.matrix {
            YuvMatrix::Bt601 => (0.299, 0.114),
            YuvMatrix::Bt709 => (0.2126, 0.0722),
        };
        let green = 1.0 - red - blue;
        // 219 steps of luma and 224 of a colour difference make the limited range.
        let (black, luma, difference) = match coding.range {
            YuvRange::Limited => (16, 255.0 / 219.0, 255.0 / 224.0),
            YuvRange::Full => (0, 1.0, 1.0),
        };
        let whole = |factor: f64, shift: u32| {
            (factor * f64::from(1_u32 << (PRODUCT_BITS + SUM_BITS - shift))).round() as i16
        };
        let of_difference = |factor: f64| whole(2.0 * factor * difference, DIFFERENCE_SHIFT);
        Self {
            black,
            luma: whole(luma, LUMA_SHIFT),
            red_of_v: of_difference(1.0 - red),
            green_of_u: of_difference(-(1.0 - blue) * blue / green),
            green_of_v: of_difference(-(1.0 - red) * red / green),
            blue_of_u: of_difference(1.0 - blue),
        }
    }
}

/// Converts a picture to red, green and blue.
///
/// The sum is kept in steps of 1/64 of a grey level; each product is rounded to such a step, so that the result is the
/// rounded exact one or, where that is within 3/128 of a tie, its neighbour.
///
/// ```
/// use fingerpost_vision::colour::{Yuv420, YuvCoding, YuvMatrix, YuvRange, rgb_from_yuv420};
/// use fingerpost_vision::picture::RgbImage;
/// let coding = YuvCoding { matrix: YuvMatrix::Bt601, range: YuvRange::Limited };
/// let planes = Yuv420 { width: 2, height: 1, y: &[16, 235], u: &[128], v: &[128] };
/// let mut image = RgbImage::new(2, 1);
/// rgb_from_yuv420(planes, coding, &mut image)?;
/// assert_eq!(image.as_slice(), &[0, 0, 0, 255, 255, 255]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
///
/// # Errors
/// [`PictureError::BufferLength`] when a plane has not its size, [`PictureError::SizeMismatch`] when `image` has not the
/// picture's.
pub fn rgb_from_yuv420(
    planes: Yuv420<'_>,
    coding: YuvCoding,
    image: &mut RgbImage,
) -> Result<(), PictureError> {
    convert(CodePath::fastest(), planes, coding, image)
}

fn convert(
    path: CodePath,
    planes: Yuv420<'_>,
    coding: YuvCoding,
    image: &mut RgbImage,
) -> Result<(), PictureError> {
    let Yuv420 { width, height, y, u, v } = planes;
    let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
    check_length(width, height, 1, y.len())?;
    check_length(half_width, half_height, 1, u.len())?;
    check_length(half_width, half_height, 1, v.len())?;
    check_size("picture to convert into", (width, height), image.size())?;
    let factors = Factors::new(coding);
    for row in 0..height {
        let half = row / 2 * half_width..(row / 2 + 1) * half_width;
        convert_row(
            path,
            &y[row * width..(row + 1) * width],
            &u[half.clone()],
            &v[half],
            &factors,
            image.row_mut(row),
        );
    }
    Ok(())
}

simd_kernel! {
    fn convert_row(y: &[u8], u: &[u8], v: &[u8], factors: &Factors, rgb: &mut [u8]) {
        let (pixels, _) = rgb.as_chunks_mut::<3>();
        for (x, (out, &y)) in pixels.iter_mut().zip(y).enumerate() {
            *out = rgb_of([y, u[x / 2], v[x / 2]], factors);
        }
    }
}

#[inline(always)]
fn rgb_of([y, u, v]: [u8; 3], factors: &Factors) -> [u8; 3] {
    let luma = product((i16::from(y) - factors.black) << LUMA_SHIFT, factors.luma);
    let (u, v) = (difference(u), difference(v));
    let red = product(v, factors.red_of_v);
    let green = product(u, factors.green_of_u) + product(v, factors.green_of_v);
    let blue = product(u, factors.blue_of_u);
    [red, green, blue].map(|offset| level(luma.saturating_add(offset)))
}

#[inline(always)]
fn difference(value: u8) -> i16 {
    (i16::from(value) - NEUTRAL) << DIFFERENCE_SHIFT
}

#[inline(always)]
fn product(left: i16, right: i16) -> i16 {
    let exact = i32::from(left) * i32::from(right);
    (((exact >> (PRODUCT_BITS - 1)) + 1) >> 1) as i16
}

/// The grey level of a sum.
#[inline(always)]
fn level(sum: i16) -> u8 {
    let half = 1 << (SUM_BITS - 1);
    (sum.saturating_add(half) >> SUM_BITS).clamp(0, 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    const CODINGS: [YuvCoding; 4] = [
        YuvCoding { matrix: YuvMatrix::Bt601, range: YuvRange::Limited },
        YuvCoding { matrix: YuvMatrix::Bt601, range: YuvRange::Full },
        YuvCoding { matrix: YuvMatrix::Bt709, range: YuvRange::Limited },
        YuvCoding { matrix: YuvMatrix::Bt709, range: YuvRange::Full },
    ];

    /// The equations of the recommendations.
    fn exact([y, u, v]: [u8; 3], coding: YuvCoding) -> [f64; 3] {
        let (kr, kb) = match coding.matrix {
            YuvMatrix::Bt601 => (0.299, 0.114),
            YuvMatrix::Bt709 => (0.2126, 0.0722),
        };
        let kg = 1.0 - kr - kb;
        let (y, u, v) = match coding.range {
            YuvRange::Limited => (
                (f64::from(y) - 16.0) / 219.0,
                (f64::from(u) - 128.0) / 224.0,
                (f64::from(v) - 128.0) / 224.0,
            ),
            YuvRange::Full => {
                (f64::from(y) / 255.0, (f64::from(u) - 128.0) / 255.0, (f64::from(v) - 128.0) / 255.0)
            }
        };
        let red = y + 2.0 * (1.0 - kr) * v;
        let blue = y + 2.0 * (1.0 - kb) * u;
        let green = (y - kr * red - kb * blue) / kg;
        [red, green, blue].map(|value| (255.0 * value).clamp(0.0, 255.0))
    }

    #[test]
    fn every_colour_is_the_exact_one_but_for_ties() {
        for coding in CODINGS {
            let factors = Factors::new(coding);
            for y in 0..=255 {
                for u in (0..=255).step_by(3) {
                    for v in (0..=255).step_by(5) {
                        let found = rgb_of([y, u, v], &factors);
                        for (found, exact) in found.into_iter().zip(exact([y, u, v], coding)) {
                            let apart = (f64::from(found) - exact).abs();
                            assert!(apart <= 0.53, "{coding:?} {y} {u} {v}: {found}, not {exact}");
                        }
                    }
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 60,
            rng_seed: RngSeed::Fixed(25),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn pictures_are_converted_pixel_by_pixel_on_every_path(
            (width, height) in (0..150_usize, 0..6_usize),
            values in prop::collection::vec(any::<u8>(), 150 * 6 * 2),
            coding in 0..4_usize,
        ) {
            let half = width.div_ceil(2) * height.div_ceil(2);
            let (y, rest) = values.split_at(width * height);
            let (u, rest) = rest.split_at(half);
            let planes = Yuv420 { width, height, y, u, v: &rest[..half] };
            let factors = Factors::new(CODINGS[coding]);
            for path in CodePath::available() {
                let mut image = RgbImage::new(width, height);
                convert(path, planes, CODINGS[coding], &mut image).unwrap();
                for row in 0..height {
                    for col in 0..width {
                        let at = row / 2 * width.div_ceil(2) + col / 2;
                        let expected = rgb_of([y[row * width + col], u[at], planes.v[at]], &factors);
                        prop_assert_eq!(image.get(col, row), Some(expected), "{:?} ({}, {})", path, col, row);
                    }
                }
            }
        }
    }

    #[test]
    fn planes_of_wrong_sizes_are_refused() {
        let coding = CODINGS[0];
        let planes = Yuv420 { width: 3, height: 3, y: &[9; 9], u: &[1; 4], v: &[1; 4] };
        let mut image = RgbImage::new(3, 3);
        rgb_from_yuv420(planes, coding, &mut image).unwrap();
        for wrong in [
            Yuv420 { y: &[9; 8], ..planes },
            Yuv420 { u: &[1; 3], ..planes },
            Yuv420 { v: &[1; 5], ..planes },
            Yuv420 { width: usize::MAX, ..planes },
        ] {
            assert!(matches!(
                rgb_from_yuv420(wrong, coding, &mut image),
                Err(PictureError::BufferLength { .. })
            ));
        }
        let refused = rgb_from_yuv420(planes, coding, &mut RgbImage::new(3, 2));
        assert!(matches!(refused, Err(PictureError::SizeMismatch { .. })));
    }
}

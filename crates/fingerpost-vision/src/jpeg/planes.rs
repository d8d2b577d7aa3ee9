//! Luma and chroma in whole units.

use super::{BLOCK, MOST_SIDE};
use crate::colour::lanes::unpack;
use crate::colour::luma_of_row;
use crate::picture::{Plane, RgbImage};
use crate::simd::{CodePath, simd_kernel};

/// How many values of chroma are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChromaSampling {
    /// One for two by two pixels (4:2:0), as cameras have it.
    Halved,
    /// One a pixel (4:4:4), for lines and letters in colours.
    Full,
}

impl ChromaSampling {
    /// Blocks of luma that a minimum coded unit has across, and as many down; it has one block of each chroma.
    pub(super) fn luma_blocks_across(self) -> usize {
        match self {
            Self::Halved => 2,
            Self::Full => 1,
        }
    }
}

/// A picture as JPEG has it: its luma and all of its colour that is kept.
#[derive(Debug, Clone)]
pub struct JpegPlanes {
    sampling: ChromaSampling,
    size: (usize, usize),
    /// Luma, blue and red difference, as large as whole units are; beyond the picture its last column and row go on.
    planes: [Plane<u8>; 3],
}

/// Bits behind the point of the chroma weights.
const BITS: u32 = 16;
/// Weights of red, green and blue in the blue and the red difference, times 2^16 (BT.601, 2.5.3, full range).
const BLUE_DIFFERENCE: [i32; 3] = [-11_059, -21_709, 32_768];
const RED_DIFFERENCE: [i32; 3] = [32_768, -27_439, -5_329];

impl JpegPlanes {
    /// Those of a picture. One that is too large for JPEG has planes without pixels, which no encoder takes.
    #[must_use]
    pub fn of(picture: &RgbImage, sampling: ChromaSampling) -> Self {
        Self::on(CodePath::fastest(), picture, sampling)
    }

    /// Width and height of the picture, pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.size
    }

    /// How many values of chroma there are.
    pub(super) fn sampling(&self) -> ChromaSampling {
        self.sampling
    }

    /// Luma, blue and red difference.
    pub(super) fn planes(&self) -> &[Plane<u8>; 3] {
        &self.planes
    }

    pub(super) fn on(path: CodePath, picture: &RgbImage, sampling: ChromaSampling) -> Self {
        let (width, height) = picture.size();
        let fits = (1..=MOST_SIDE).contains(&width) && (1..=MOST_SIDE).contains(&height);
        let across = sampling.luma_blocks_across();
        let [wide, high] =
            if fits { [width, height].map(|side| side.next_multiple_of(BLOCK * across)) } else { [0, 0] };
        let plane = |part| Plane::new(wide / part, high / part, 0);
        let [mut luma, mut blue, mut red] = [1, across, across].map(plane);
        // Rows of colours, one 32-bit lane a pixel.
        let mut lanes = [vec![0; wide], vec![0; wide]];
        for y in 0..high / across {
            for (row, lanes) in lanes.iter_mut().take(across).enumerate() {
                let (rgb, _) = picture.row((across * y + row).min(height - 1)).as_chunks();
                let row = luma.row_mut(across * y + row);
                luma_of_row(path, rgb, &mut row[..width]);
                go_on(row, width);
                unpack(path, rgb, lanes);
                go_on(lanes, width);
            }
            let [upper, lower] = lanes.each_ref();
            match sampling {
                ChromaSampling::Halved => {
                    let (upper, lower) = (upper.as_chunks().0, lower.as_chunks().0);
                    halved_chroma(path, upper, lower, blue.row_mut(y), red.row_mut(y));
                }
                ChromaSampling::Full => full_chroma(path, upper, blue.row_mut(y), red.row_mut(y)),
            }
        }
        Self { sampling, size: (width, height), planes: [luma, blue, red] }
    }
}

/// Repeats the last of the first `used` values to the end.
fn go_on<T: Copy>(row: &mut [T], used: usize) {
    let (row, beyond) = row.split_at_mut(used);
    if let Some(&last) = row.last() {
        beyond.fill(last);
    }
}

/// A difference of colours whose sums are over 2^`of_bits` pixels.
#[inline(always)]
fn difference(sums: [i32; 3], weights: [i32; 3], of_bits: u32) -> u8 {
    let weighted = sums[0] * weights[0] + sums[1] * weights[1] + sums[2] * weights[2];
    let bits = BITS + of_bits;
    // Half a step less than a whole one keeps the largest difference a byte.
    ((weighted + (128 << bits) + (1 << (bits - 1)) - 1) >> bits) as u8
}

simd_kernel! {
    fn halved_chroma(upper: &[[u32; 2]], lower: &[[u32; 2]], blue: &mut [u8], red: &mut [u8]) {
        let outs = blue.iter_mut().zip(red);
        for ((&[a, b], &[c, d]), (blue, red)) in upper.iter().zip(lower).zip(outs) {
            let sums = [0, 8, 16].map(|shift| [a, b, c, d].map(|lane| lane >> shift & 0xff).iter().sum::<u32>() as i32);
            *blue = difference(sums, BLUE_DIFFERENCE, 2);
            *red = difference(sums, RED_DIFFERENCE, 2);
        }
    }
}

simd_kernel! {
    fn full_chroma(lanes: &[u32], blue: &mut [u8], red: &mut [u8]) {
        for ((&lane, blue), red) in lanes.iter().zip(blue).zip(red) {
            let colours = [0, 8, 16].map(|shift| (lane >> shift & 0xff) as i32);
            *blue = difference(colours, BLUE_DIFFERENCE, 0);
            *red = difference(colours, RED_DIFFERENCE, 0);
        }
    }
}

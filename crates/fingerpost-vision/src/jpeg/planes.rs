//! Luma, and chroma of half the size, in whole units.

use super::{MOST_SIDE, UNIT};
use crate::colour::lanes::unpack;
use crate::colour::luma_of_row;
use crate::picture::{Plane, RgbImage};
use crate::simd::{CodePath, simd_kernel};

/// A picture as JPEG has it: half the bytes of its colours, and all that is kept of them.
#[derive(Debug, Clone, Default)]
pub struct JpegPlanes {
    size: (usize, usize),
    /// Luma, blue and red difference, as large as whole units are; beyond the picture its last column and row go on.
    planes: [Plane<u8>; 3],
    /// Two rows of colours, one 32-bit lane a pixel.
    lanes: [Vec<u32>; 2],
}

/// Bits behind the point of the chroma weights.
const BITS: u32 = 16;
/// Weights of red, green and blue in the blue and the red difference, times 2^16 (BT.601, 2.5.3, full range).
const BLUE_DIFFERENCE: [i32; 3] = [-11_059, -21_709, 32_768];
const RED_DIFFERENCE: [i32; 3] = [32_768, -27_439, -5_329];

impl JpegPlanes {
    /// Those of a picture, in memory of their own.
    #[must_use]
    pub fn of(picture: &RgbImage) -> Self {
        let mut planes = Self::default();
        planes.set(picture);
        planes
    }

    /// Width and height of the picture, pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.size
    }

    /// Luma, blue and red difference.
    pub(super) fn planes(&self) -> &[Plane<u8>; 3] {
        &self.planes
    }

    /// Takes a picture in, in the memory that there is. One that is too large for JPEG leaves planes without pixels, which no encoder takes.
    pub fn set(&mut self, picture: &RgbImage) {
        self.set_on(CodePath::fastest(), picture);
    }

    pub(super) fn set_on(&mut self, path: CodePath, picture: &RgbImage) {
        let (width, height) = picture.size();
        self.size = (width, height);
        let fits = (1..=MOST_SIDE).contains(&width) && (1..=MOST_SIDE).contains(&height);
        let [wide, high] =
            if fits { [width, height].map(|side| side.next_multiple_of(UNIT)) } else { [0, 0] };
        let Self { planes: [luma, blue, red], lanes, .. } = self;
        for (plane, part) in [(&mut *luma, 1), (&mut *blue, 2), (&mut *red, 2)] {
            if plane.size() != (wide / part, high / part) {
                plane.reset(wide / part, high / part, 0);
            }
        }
        if !fits {
            return;
        }
        lanes.iter_mut().for_each(|lanes| lanes.resize(wide, 0));
        for y in 0..high / 2 {
            for (half, lanes) in lanes.iter_mut().enumerate() {
                let (rgb, _) = picture.row((2 * y + half).min(height - 1)).as_chunks();
                let row = luma.row_mut(2 * y + half);
                luma_of_row(path, rgb, &mut row[..width]);
                go_on(row, width);
                unpack(path, rgb, lanes);
                go_on(lanes, width);
            }
            let [upper, lower] = lanes.each_ref().map(|lanes| lanes.as_chunks().0);
            chroma(path, upper, lower, blue.row_mut(y), red.row_mut(y));
        }
    }
}

/// Repeats the last of the first `used` values to the end.
fn go_on<T: Copy>(row: &mut [T], used: usize) {
    let (row, beyond) = row.split_at_mut(used);
    if let Some(&last) = row.last() {
        beyond.fill(last);
    }
}

simd_kernel! {
    fn chroma(upper: &[[u32; 2]], lower: &[[u32; 2]], blue: &mut [u8], red: &mut [u8]) {
        // Four pixels are two bits more.
        let difference = |sums: [i32; 3], of: [i32; 3]| {
            let weighted = sums[0] * of[0] + sums[1] * of[1] + sums[2] * of[2];
            // Half a step less than a whole one keeps the largest difference a byte.
            ((weighted + (128 << (BITS + 2)) + (1 << (BITS + 1)) - 1) >> (BITS + 2)) as u8
        };
        let outs = blue.iter_mut().zip(red);
        for ((&[a, b], &[c, d]), (blue, red)) in upper.iter().zip(lower).zip(outs) {
            let sums = [0, 8, 16].map(|shift| [a, b, c, d].map(|lane| lane >> shift & 0xff).iter().sum::<u32>() as i32);
            *blue = difference(sums, BLUE_DIFFERENCE);
            *red = difference(sums, RED_DIFFERENCE);
        }
    }
}

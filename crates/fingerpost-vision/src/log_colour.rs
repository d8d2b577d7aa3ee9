//! Colour as logarithms, averaged over blocks of pixels.
//!
//! A light that is twice as bright adds the same to the logarithm of every channel: differences of logarithms
//! (log-chromaticities) stay as they are, and a step in log-brightness is the same in sun and in shade. G. D. Finlayson,
//! S. D. Hordley and M. S. Drew, "Removing shadows from images", 2002. Limits: skylight is bluer than sunlight, so a
//! shadow does shift the blue-green chromaticity a little; near black, noise is all there is, which an offset damps.

use crate::elementary::ln;
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, RgbImage};
use crate::simd::{CodePath, simd_kernel};

/// Added to every channel before the logarithm, levels of 255: about the black level and noise of an 8-bit camera, below
/// which ratios mean nothing.
const NOISE_FLOOR: f32 = 4.0;

/// Log-brightness and log-chromaticities, one size.
#[derive(Debug, Clone, Default)]
pub struct LogColour {
    /// Mean logarithm of the three channels.
    pub brightness: Plane<f32>,
    /// Logarithm of red over green.
    pub red_green: Plane<f32>,
    /// Logarithm of blue over green.
    pub blue_green: Plane<f32>,
}

impl LogColour {
    /// Width and height.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.brightness.size()
    }

    /// Gives the planes another size, all of them 0.
    pub fn reset(&mut self, width: usize, height: usize) {
        for plane in [&mut self.brightness, &mut self.red_green, &mut self.blue_green] {
            plane.reset(width, height, 0.0);
        }
    }
}

/// A block of pixels that is averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Width, pixels, 1 to 64.
    pub width: usize,
    /// Height, pixels, 1 to 64.
    pub height: usize,
}

impl Block {
    /// Longest side, pixels: sums of so many rows stay within 16 bits.
    pub const MAX_SIDE_PX: usize = 64;

    /// The smallest block of which no more than `columns` x `rows` fit into a picture; shares of a block that are left
    /// over at the right and at the bottom are not counted.
    #[must_use]
    pub fn for_at_most(columns: usize, rows: usize, width: usize, height: usize) -> Self {
        let side = |full: usize, most: usize| full.div_ceil(most.max(1)).clamp(1, Self::MAX_SIDE_PX);
        Self { width: side(width, columns), height: side(height, rows) }
    }

    /// Columns and rows of whole blocks in a picture.
    #[must_use]
    pub fn grid(self, width: usize, height: usize) -> (usize, usize) {
        (width / self.width.max(1), height / self.height.max(1))
    }
}

/// Reduces colour pictures to [`LogColour`], with the buffers that it needs.
#[derive(Debug, Clone, Default)]
pub struct LogColourReducer {
    /// Sums down a block's rows, three a pixel.
    sums: Vec<u16>,
    means: [Vec<f32>; 3],
}

impl LogColourReducer {
    /// Fills `target` with the blocks of `source` from block row `first_row` on; the target's size says how many.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the target reaches beyond the picture's blocks, or its planes differ in size.
    pub fn reduce(
        &mut self,
        source: &RgbImage,
        block: Block,
        first_row: usize,
        target: &mut LogColour,
    ) -> Result<(), PictureError> {
        self.reduce_on(CodePath::fastest(), source, block, first_row, target)
    }

    fn reduce_on(
        &mut self,
        path: CodePath,
        source: &RgbImage,
        block: Block,
        first_row: usize,
        target: &mut LogColour,
    ) -> Result<(), PictureError> {
        let (width, height) = target.size();
        let (columns, rows) = block.grid(source.width(), source.height());
        check_size(
            "log-colour target",
            (width.min(columns), height.min(rows.saturating_sub(first_row))),
            (width, height),
        )?;
        check_size("log-colour target", (width, height), target.red_green.size())?;
        check_size("log-colour target", (width, height), target.blue_green.size())?;
        let used = 3 * block.width * width;
        self.sums.resize(used, 0);
        self.means.iter_mut().for_each(|means| means.resize(width, 0.0));
        let [red, green, blue] = &mut self.means;
        let scale = 1.0 / (block.width * block.height) as f32;
        for y in 0..height {
            self.sums.fill(0);
            let top = (first_row + y) * block.height;
            for row in top..top + block.height {
                add_row(path, &mut self.sums, &source.row(row)[..used]);
            }
            match block.width {
                1 => block_means::<1>(path, &self.sums, scale, red, green, blue),
                2 => block_means::<2>(path, &self.sums, scale, red, green, blue),
                3 => block_means::<3>(path, &self.sums, scale, red, green, blue),
                4 => block_means::<4>(path, &self.sums, scale, red, green, blue),
                5 => block_means::<5>(path, &self.sums, scale, red, green, blue),
                wider => wide_block_means(path, &self.sums, wider, scale, red, green, blue),
            }
            logarithms(
                path,
                red,
                green,
                blue,
                target.brightness.row_mut(y),
                target.red_green.row_mut(y),
                target.blue_green.row_mut(y),
            );
        }
        Ok(())
    }
}

simd_kernel! {
    fn add_row(sums: &mut [u16], row: &[u8]) {
        for (sum, &value) in sums.iter_mut().zip(row) {
            *sum += u16::from(value);
        }
    }
}

simd_kernel! {
    fn block_means<const WIDTH: usize>(
        sums: &[u16], scale: f32, red: &mut [f32], green: &mut [f32], blue: &mut [f32],
    ) {
        let pixels = sums.as_chunks::<3>().0.as_chunks::<WIDTH>().0;
        for (((block, red), green), blue) in pixels.iter().zip(red).zip(green).zip(blue) {
            [*red, *green, *blue] = total(block).map(|total| total as f32 * scale);
        }
    }
}

simd_kernel! {
    fn wide_block_means(
        sums: &[u16], width: usize, scale: f32, red: &mut [f32], green: &mut [f32], blue: &mut [f32],
    ) {
        let pixels = sums.as_chunks::<3>().0.chunks_exact(width);
        for (((block, red), green), blue) in pixels.zip(red).zip(green).zip(blue) {
            [*red, *green, *blue] = total(block).map(|total| total as f32 * scale);
        }
    }
}

#[inline(always)]
fn total(pixels: &[[u16; 3]]) -> [u32; 3] {
    let mut total = [0; 3];
    for pixel in pixels {
        (0..3).for_each(|channel| total[channel] += u32::from(pixel[channel]));
    }
    total
}

simd_kernel! {
    fn logarithms(
        red: &[f32], green: &[f32], blue: &[f32],
        brightness: &mut [f32], red_green: &mut [f32], blue_green: &mut [f32],
    ) {
        let width = brightness.len();
        let (red, green, blue) = (&red[..width], &green[..width], &blue[..width]);
        let (red_green, blue_green) = (&mut red_green[..width], &mut blue_green[..width]);
        for x in 0..width {
            let [r, g, b] = [red[x], green[x], blue[x]].map(|mean| ln(mean + NOISE_FLOOR));
            brightness[x] = (r + g + b) * (1.0 / 3.0);
            red_green[x] = r - g;
            blue_green[x] = b - g;
        }
    }
}

#[cfg(test)]
mod tests;

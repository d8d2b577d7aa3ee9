//! What the network sees of a picture, eight numbers a pixel: its colours against those of the strip just ahead, so that what road
//! looks like today comes from the picture itself; chromaticity; brightness against the strip's; the row; brightness.
//!
//! What depends on one level or on the sum of the three alone is looked up.

use super::INPUT_CHANNELS;
use super::requantising::{LANES, SIGNED, rounded};
use super::tensor::Tensor;
use super::weights::Strip;
use crate::picture::RgbImage;
use crate::simd::{CodePath, simd_kernel};

/// What stands for 0.
pub(super) const ZERO: u8 = 64;
/// Steps on either side of it.
const STEPS: f32 = 63.0;

/// Sums of three levels.
const SUMS: usize = 3 * 255 + 1;
/// Where the numbers of a pixel stand: in their order, red's of the first three and of the two of chromaticity first.
const CHROMA: usize = 3;
const BRIGHTNESS_AGAINST_STRIP: usize = 5;
const ROW: usize = 6;
const BRIGHTNESS: usize = 7;
/// Largest sizes of the numbers, as the network was trained.
const AGAINST_LIMIT: f32 = 3.0;
const CHROMA_LIMIT: f32 = 2.0;
const LOG_LIMIT: f32 = 2.0;
const ROW_LIMIT: f32 = 1.0;
const BRIGHTNESS_LIMIT: f32 = 0.5;

/// The eight numbers of a pixel, the first in the lowest byte.
type Pixel = u64;

/// Makes inputs of pictures.
#[derive(Debug, Clone)]
pub(super) struct InputMaker {
    strip: Strip,
    /// Logarithm of the brightness by the sum of the levels.
    log_brightness: Vec<f32>,
    /// What a level of each colour gives against the strip, this frame.
    of_level: [Vec<Pixel>; 3],
    /// What a sum of levels gives, this frame.
    of_sum: Vec<Pixel>,
}

impl Strip {
    /// Its columns and rows in a picture of `width` x `height` pixels.
    pub(super) fn pixels(&self, (width, height): (usize, usize)) -> [std::ops::Range<usize>; 2] {
        let at = |share: f32, side: usize| (share * side as f32).floor() as usize;
        [at(self.left, width)..at(self.right, width), at(self.top, height)..at(self.bottom, height)]
    }
}

impl InputMaker {
    pub(super) fn new(strip: Strip) -> Self {
        let log_brightness = (0..SUMS).map(|sum| log(brightness(sum))).collect();
        let of_level = [(); 3].map(|()| vec![0; 256]);
        Self { strip, log_brightness, of_level, of_sum: vec![0; SUMS] }
    }

    /// Fills `input`, which has the picture's size.
    pub(super) fn fill(&mut self, path: CodePath, picture: &RgbImage, input: &mut Tensor) {
        let (mean, spread) = self.measure_strip(picture);
        for (channel, table) in self.of_level.iter_mut().enumerate() {
            let deviation = 4.0 * (spread[channel] + 0.03);
            for (level, pixel) in (0_u8..=255).zip(table) {
                *pixel =
                    byte(channel, (share(usize::from(level)) - mean[channel]) / deviation, AGAINST_LIMIT);
            }
        }
        let log_of_strip = log((mean[0] + mean[1] + mean[2]) / 3.0);
        for (sum, (pixel, log)) in self.of_sum.iter_mut().zip(&self.log_brightness).enumerate() {
            *pixel = byte(BRIGHTNESS_AGAINST_STRIP, log - log_of_strip, LOG_LIMIT)
                | byte(BRIGHTNESS, brightness(sum) - 0.5, BRIGHTNESS_LIMIT);
        }
        let last = picture.height().saturating_sub(1).max(1) as f32;
        let [red, green, blue] = self.of_level.each_ref().map(Vec::as_slice);
        for y in 0..input.height() {
            let row = byte(ROW, -1.0 + 2.0 * y as f32 / last, ROW_LIMIT);
            let tables = Tables { of_level: [red, green, blue], of_sum: &self.of_sum, row };
            let pixels = picture.row(y).as_chunks::<{ RgbImage::CHANNELS }>().0;
            fill_row(path, tables, pixels, input.row_mut(y).as_chunks_mut().0);
        }
    }

    /// Mean and standard deviation of each colour over the strip, 1 being the highest level.
    fn measure_strip(&self, picture: &RgbImage) -> ([f32; 3], [f32; 3]) {
        let [columns, rows] = self.strip.pixels(picture.size());
        let count = (columns.len() * rows.len()) as f64;
        let (mut sums, mut squares) = ([0_u64; 3], [0_u64; 3]);
        for y in rows {
            for pixel in &picture.row(y).as_chunks::<{ RgbImage::CHANNELS }>().0[columns.clone()] {
                for (channel, &level) in pixel.iter().enumerate() {
                    sums[channel] += u64::from(level);
                    squares[channel] += u64::from(level) * u64::from(level);
                }
            }
        }
        let mean = sums.map(|sum| sum as f64 / count);
        let variance = |channel: usize| squares[channel] as f64 / count - mean[channel] * mean[channel];
        let spread = [0, 1, 2].map(|channel| (variance(channel).max(0.0).sqrt() / 255.0) as f32);
        (mean.map(|mean| (mean / 255.0) as f32), spread)
    }
}

/// What is looked up.
#[derive(Clone, Copy)]
struct Tables<'a> {
    of_level: [&'a [Pixel]; 3],
    of_sum: &'a [Pixel],
    row: Pixel,
}

/// A level or a sum of levels, 1 being the highest level.
#[inline(always)]
fn share(levels: usize) -> f32 {
    levels as f32 / 255.0
}

fn brightness(sum: usize) -> f32 {
    share(sum) / 3.0
}

fn log(brightness: f32) -> f32 {
    libm::log(f64::from(brightness + 0.02)) as f32
}

/// A number in 127 steps.
#[inline(always)]
fn quantised(value: f32, limit: f32) -> u8 {
    let value = if value > -limit { value } else { -limit };
    let value = if value < limit { value } else { limit };
    (i32::from(ZERO) + rounded(value * STEPS / limit, SIGNED)) as u8
}

fn byte(channel: usize, value: f32, limit: f32) -> Pixel {
    let mut bytes = [0; INPUT_CHANNELS];
    bytes[channel] = quantised(value, limit);
    Pixel::from_le_bytes(bytes)
}

simd_kernel! {
    fn fill_row(tables: Tables<'_>, pixels: &[[u8; RgbImage::CHANNELS]], out: &mut [[u8; INPUT_CHANNELS]]) {
        let [of_red, of_green, of_blue] = tables.of_level.map(|table| table.first_chunk::<256>().unwrap_or(&[0; 256]));
        let of_sum = tables.of_sum.first_chunk::<SUMS>().unwrap_or(&[0; SUMS]);
        // Rows are whole multiples of sixteen pixels long.
        let blocks = pixels.as_chunks::<LANES>().0.iter().zip(out.as_chunks_mut::<LANES>().0);
        for (pixels, out) in blocks {
            let mut sum = [0_i32; LANES];
            let mut chroma = [[0_i32; LANES]; 2];
            for lane in 0..LANES {
                let [red, green, blue] = pixels[lane].map(i32::from);
                sum[lane] = red + green + blue;
                chroma[0][lane] = red;
                chroma[1][lane] = green;
            }
            let mut whole = [0.0_f32; LANES];
            for lane in 0..LANES {
                whole[lane] = sum[lane] as f32 / 255.0 + 0.05;
            }
            for chroma in &mut chroma {
                for lane in 0..LANES {
                    let of_sum = (chroma[lane] as f32 / 255.0 + 0.016) / whole[lane];
                    chroma[lane] = i32::from(quantised((of_sum - 0.333) * 4.0, CHROMA_LIMIT));
                }
            }
            for lane in 0..LANES {
                let [red, green, blue] = pixels[lane];
                let looked_up = of_red[usize::from(red)] | of_green[usize::from(green)] | of_blue[usize::from(blue)];
                let [of_red, of_green] = [chroma[0][lane] as Pixel, chroma[1][lane] as Pixel];
                let of_chroma = of_red << (8 * CHROMA) | of_green << (8 * (CHROMA + 1));
                let pixel = looked_up | of_sum[sum[lane] as usize] | of_chroma | tables.row;
                out[lane] = pixel.to_le_bytes();
            }
        }
    }
}

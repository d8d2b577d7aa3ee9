//! Steps of the coefficients, and division by them in 16 bits.

use super::transform::COLUMNS;
use super::{BLOCK, BLOCK_VALUES};

/// Steps of luma at quality 50, row by row (T.81, table K.1).
#[rustfmt::skip]
pub(super) const LUMA_STEPS: [u8; BLOCK_VALUES] = [
    16, 11, 10, 16, 24, 40, 51, 61,
    12, 12, 14, 19, 26, 58, 60, 55,
    14, 13, 16, 24, 40, 57, 69, 56,
    14, 17, 22, 29, 51, 87, 80, 62,
    18, 22, 37, 56, 68, 109, 103, 77,
    24, 35, 55, 64, 81, 104, 113, 92,
    49, 64, 78, 87, 103, 121, 120, 101,
    72, 92, 95, 98, 112, 100, 103, 99,
];
/// Steps of chroma at quality 50 (T.81, table K.2).
#[rustfmt::skip]
pub(super) const CHROMA_STEPS: [u8; BLOCK_VALUES] = [
    17, 18, 24, 47, 99, 99, 99, 99,
    18, 21, 26, 66, 99, 99, 99, 99,
    24, 26, 56, 99, 99, 99, 99, 99,
    47, 66, 99, 99, 99, 99, 99, 99,
    99, 99, 99, 99, 99, 99, 99, 99,
    99, 99, 99, 99, 99, 99, 99, 99,
    99, 99, 99, 99, 99, 99, 99, 99,
    99, 99, 99, 99, 99, 99, 99, 99,
];

/// Where in a block, row by row, the coefficients lie in the order in which they are coded (T.81, figure A.6).
#[rustfmt::skip]
pub(super) const ZIGZAG: [u8; BLOCK_VALUES] = [
    0, 1, 8, 16, 9, 2, 3, 10,
    17, 24, 32, 25, 18, 11, 4, 5,
    12, 19, 26, 33, 40, 48, 41, 34,
    27, 20, 13, 6, 7, 14, 21, 28,
    35, 42, 49, 56, 57, 50, 43, 36,
    29, 22, 15, 23, 30, 37, 44, 51,
    58, 59, 52, 45, 38, 31, 39, 46,
    53, 60, 61, 54, 47, 55, 62, 63,
];

/// What the transform's outputs along a line are too large by, beside the root of eight: 1, and the root of two times the cosines
/// of k pi / 16.
#[rustfmt::skip]
const SCALES: [f64; BLOCK] = [
    1.0, 1.387_039_845, 1.306_562_965, 1.175_875_602, 1.0, 0.785_694_958, 0.541_196_100, 0.275_899_379,
];

/// The quantiser of a component. Its arrays have a row a horizontal frequency, as the transform leaves coefficients: eight vertical
/// ones, and the same again for every block of a tile.
#[derive(Debug, Clone)]
pub(super) struct Quantiser {
    /// Steps, row by row of the block.
    steps: [u8; BLOCK_VALUES],
    /// Half of a divisor.
    pub(super) half: [[u16; COLUMNS]; BLOCK],
    /// A divisor's reciprocal, times a power of two that makes it 16 bits long.
    pub(super) reciprocal: [[u16; COLUMNS]; BLOCK],
    /// What takes that power of two away again.
    pub(super) scale: [[u16; COLUMNS]; BLOCK],
}

impl Quantiser {
    /// Steps at quality 50 made finer or coarser by the rule of the Independent JPEG Group's library.
    pub(super) fn new(steps: &[u8; BLOCK_VALUES], quality: u8) -> Self {
        let quality = u32::from(quality.max(1));
        let percent = if quality < 50 { 5000 / quality } else { 200_u32.saturating_sub(2 * quality) };
        let steps = steps.map(|step| ((u32::from(step) * percent + 50) / 100).clamp(1, 255) as u8);
        let empty = [[0; COLUMNS]; BLOCK];
        let mut quantiser = Self { steps, half: empty, reciprocal: empty, scale: empty };
        for (across, scale_across) in SCALES.iter().enumerate() {
            for (down, scale_down) in SCALES.iter().enumerate() {
                let step = f64::from(steps[BLOCK * down + across]);
                let divisor = BLOCK as f64 * step * scale_across * scale_down;
                // The power of two below the divisor, which is 2 at the least up to the highest quality.
                let power = (1..15).rev().find(|power| f64::from(1 << power) <= divisor).unwrap_or(1);
                // A divisor that is a power of two would need one bit more.
                let reciprocal = (f64::from(1_u32 << (16 + power)) / divisor).round().min(65_535.0);
                for column in (down..COLUMNS).step_by(BLOCK) {
                    quantiser.half[across][column] = (0.5 * divisor).round() as u16;
                    quantiser.reciprocal[across][column] = reciprocal as u16;
                    quantiser.scale[across][column] = 1 << (16 - power);
                }
            }
        }
        quantiser
    }

    /// The steps as a header has them.
    pub(super) fn steps_in_zigzag(&self) -> [u8; BLOCK_VALUES] {
        ZIGZAG.map(|place| self.steps[usize::from(place)])
    }
}

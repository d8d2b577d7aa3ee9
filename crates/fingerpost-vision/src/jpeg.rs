//! Colour pictures as JPEG files: baseline, chroma of half the size or of luma's.
//!
//! Format: ITU-T T.81 (1992), baseline sequential process, with the quantisation and Huffman tables of its annex K and the
//! header of JFIF 1.02. Luma and chroma are those of [`colour`](crate::colour) at full range, chroma of half the size the mean of
//! two by two pixels. The cosine transform is that of Y. Arai, T. Agui and M. Nakajima, "A fast DCT-SQ scheme for images", Trans. IEICE
//! E71(11), 1988, in 16 bits, whose scale factors are part of the quantiser.
//!
//! Limits: qualities up to [`JpegEncoder::MOST_QUALITY`]; finer steps than those have no room in 16 bits.

mod huffman;
mod planes;
mod quantiser;
#[cfg(test)]
mod tests;
mod transform;

use self::huffman::{BitWriter, CodeTable};
use self::quantiser::Quantiser;
use self::transform::{Block, transform};
use crate::picture::{Plane, RgbImage};
use crate::simd::{CodePath, simd_kernel};

pub use self::planes::{ChromaSampling, JpegPlanes};

/// Side of a block, pixels.
const BLOCK: usize = 8;
/// Values in a block.
const BLOCK_VALUES: usize = BLOCK * BLOCK;
/// Longest side of a picture, pixels: the header has 16 bits for it.
const MOST_SIDE: usize = u16::MAX as usize;

/// A picture that JPEG has no form for.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum JpegError {
    /// A side is empty or too long.
    #[error("a picture of {width} x {height} pixels has no JPEG form; each side must have 1 to 65535 pixels")]
    Size {
        /// Width, pixels.
        width: usize,
        /// Height, pixels.
        height: usize,
    },
}

/// The JPEG file of a picture, as [`JpegEncoder::new`] makes it of this quality.
///
/// # Errors
/// [`JpegError::Size`] when a side has no or more than 65535 pixels.
pub fn jpeg_file(picture: &RgbImage, quality: u8, sampling: ChromaSampling) -> Result<Vec<u8>, JpegError> {
    let mut file = Vec::new();
    JpegEncoder::new(quality).encode(&JpegPlanes::of(picture, sampling), &mut file)?;
    Ok(file)
}

/// Makes JPEG files of pictures, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::jpeg::{ChromaSampling, JpegEncoder, JpegPlanes};
/// use fingerpost_vision::picture::RgbImage;
/// let planes = JpegPlanes::of(&RgbImage::new(40, 30), ChromaSampling::Halved);
/// let mut file = Vec::new();
/// JpegEncoder::new(85).encode(&planes, &mut file)?;
/// assert!(file.starts_with(&[0xff, 0xd8, 0xff]) && file.ends_with(&[0xff, 0xd9]));
/// # Ok::<(), fingerpost_vision::jpeg::JpegError>(())
/// ```
#[derive(Debug, Clone)]
pub struct JpegEncoder {
    luma: Component,
    chroma: Component,
    /// A row of units: luma's two rows of blocks, the second empty where chroma is as large as luma, then blue and red.
    blocks: [Vec<Block>; 4],
}

/// Tables of luma or of both chromas.
#[derive(Debug, Clone)]
struct Component {
    quantiser: Quantiser,
    dc: CodeTable,
    ac: CodeTable,
}

impl JpegEncoder {
    /// The highest quality.
    pub const MOST_QUALITY: u8 = 95;

    /// An encoder of a quality from 1 to [`JpegEncoder::MOST_QUALITY`], on the scale of the Independent JPEG Group; what lies
    /// outside is taken for the nearest.
    #[must_use]
    pub fn new(quality: u8) -> Self {
        let quality = quality.clamp(1, Self::MOST_QUALITY);
        let component = |steps, dc, ac| Component {
            quantiser: Quantiser::new(steps, quality),
            dc: CodeTable::new(dc),
            ac: CodeTable::new(ac),
        };
        Self {
            luma: component(&quantiser::LUMA_STEPS, huffman::LUMA_DC, huffman::LUMA_AC),
            chroma: component(&quantiser::CHROMA_STEPS, huffman::CHROMA_DC, huffman::CHROMA_AC),
            blocks: Default::default(),
        }
    }

    /// Appends the file of a picture to `file`.
    ///
    /// # Errors
    /// [`JpegError::Size`] when a side has no or more than 65535 pixels.
    pub fn encode(&mut self, planes: &JpegPlanes, file: &mut Vec<u8>) -> Result<(), JpegError> {
        self.encode_on(CodePath::fastest(), planes, file)
    }

    fn encode_on(
        &mut self,
        path: CodePath,
        planes: &JpegPlanes,
        file: &mut Vec<u8>,
    ) -> Result<(), JpegError> {
        let (width, height) = planes.size();
        let side = |length: usize| u16::try_from(length).ok().filter(|side| *side > 0);
        let sides = side(width).zip(side(height)).ok_or(JpegError::Size { width, height })?;
        let blocks_across = planes.sampling().luma_blocks_across();
        self.write_header(sides, blocks_across, file);
        let mut bits = BitWriter::new(file);
        let [luma, blue, red] = planes.planes();
        let mut before = [0; 3];
        let Self { luma: of_luma, chroma: of_chroma, blocks } = self;
        let [upper, lower, blues, reds] = blocks;
        lower.clear();
        for unit_row in 0..blue.height() / BLOCK {
            for (row, lumas) in [&mut *upper, &mut *lower].into_iter().take(blocks_across).enumerate() {
                transform(path, block_rows(luma, blocks_across * unit_row + row), &of_luma.quantiser, lumas);
            }
            transform(path, block_rows(blue, unit_row), &of_chroma.quantiser, blues);
            transform(path, block_rows(red, unit_row), &of_chroma.quantiser, reds);
            code_units(
                path,
                [upper, lower],
                blocks_across,
                [blues, reds],
                [of_luma, of_chroma],
                &mut before,
                &mut bits,
            );
        }
        bits.finish();
        file.extend([0xff, 0xd9]);
        Ok(())
    }

    /// Everything before the first unit.
    fn write_header(&self, (width, height): (u16, u16), luma_blocks_across: usize, file: &mut Vec<u8>) {
        file.extend([0xff, 0xd8]);
        segment(file, 0xe0, b"JFIF\0\x01\x02\x00\x00\x01\x00\x01\x00\x00");
        for (number, of) in [(0, &self.luma), (1, &self.chroma)] {
            let steps = of.quantiser.steps_in_zigzag();
            segment(file, 0xdb, &[&[number][..], &steps].concat());
        }
        let [high, low] = height.to_be_bytes();
        let [wide, narrow] = width.to_be_bytes();
        // Each component: its number, how many blocks of it a unit has across and down, and its quantiser.
        let of_luma = if luma_blocks_across == 2 { 0x22 } else { 0x11 };
        let frame = [8, high, low, wide, narrow, 3, 1, of_luma, 0, 2, 0x11, 1, 3, 0x11, 1];
        segment(file, 0xc0, &frame);
        for (number, of) in [(0, &self.luma), (1, &self.chroma)] {
            for (class, table) in [(0, &of.dc), (0x10, &of.ac)] {
                segment(file, 0xc4, &[&[class | number][..], table.lengths, table.symbols].concat());
            }
        }
        segment(file, 0xda, &[3, 1, 0x00, 2, 0x11, 3, 0x11, 0, 63, 0]);
    }
}

simd_kernel! {
    /// Appends a row of units, which have so many blocks of luma across; `before` are the first coefficients of the last blocks of
    /// luma, blue and red.
    fn code_units(
        luma_rows: [&[Block]; 2],
        luma_blocks_across: usize,
        chroma_rows: [&[Block]; 2],
        tables: [&Component; 2],
        before: &mut [i16; 3],
        bits: &mut BitWriter<'_>,
    ) {
        let [luma, chroma] = tables.map(|tables| (&tables.dc, &tables.ac));
        let [before_luma, before_blue, before_red] = before;
        let mut waiting = bits.taken_over();
        for (unit, (blue, red)) in chroma_rows[0].iter().zip(chroma_rows[1]).enumerate() {
            let first = luma_blocks_across * unit;
            for row in luma_rows {
                for block in row.get(first..first + luma_blocks_across).unwrap_or_default() {
                    waiting.block(block, before_luma, luma);
                }
            }
            waiting.block(blue, before_blue, chroma);
            waiting.block(red, before_red, chroma);
        }
        let state = waiting.state();
        bits.go_on(state);
    }
}

/// The rows of pixels that a row of blocks has, one behind the other.
fn block_rows(plane: &Plane<u8>, block_row: usize) -> &[u8] {
    let values = BLOCK * plane.width();
    plane.as_slice().get(block_row * values..(block_row + 1) * values).unwrap_or_default()
}

fn segment(file: &mut Vec<u8>, marker: u8, data: &[u8]) {
    // No segment here is longer than 200 bytes.
    let length = (data.len() + 2) as u16;
    file.extend([0xff, marker]);
    file.extend(length.to_be_bytes());
    file.extend(data);
}

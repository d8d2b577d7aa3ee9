//! The file of a road network: its sizes, and its layers in the order in which they run.

use std::ops::RangeInclusive;

use thiserror::Error;

use super::INPUT_CHANNELS;
use super::dense::Dense;
use super::depthwise::Depthwise;

/// What a file begins with.
const MAGIC: &[u8] = b"FPROAD01";
/// Longest side of the network's picture, pixels: sums over all places of the smallest level then stay below 2^24.
const MOST_SIDE_PX: u32 = 1024;
/// Both sides are whole multiples of it: the picture is halved four times.
const SIDE_STEP_PX: u32 = 16;
/// Vectors hold so many channels.
const CHANNEL_STEP: u32 = 16;
/// Products of so many inputs sum up to less than 2^22.
const MOST_CHANNELS: u32 = 256;
/// Far more than the time of a frame allows.
const MOST_BLOCKS: u32 = 64;
const MOST_OUTPUTS: u32 = 16;
/// With a bias of up to 2^23 every sum stays below 2^24, where `f32` has all whole numbers.
const MOST_BIAS: i32 = 1 << 23;
/// What sums are scaled by to 7 bits is below 1 where they are large. Up to here even a sum of 2^24 stays within 32 bits.
const MOST_SCALE: f32 = 64.0;

/// A file that is no road network, or none that can be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RoadNetworkError {
    /// The file begins with something else.
    #[error(
        "the file is no road network: it does not begin with FPROAD01; give a file of weights that was written for this program"
    )]
    NotANetwork,
    /// A number of its head is out of range.
    #[error("the road network's {what} is {found}; it must be {allowed}")]
    Size {
        /// Which number.
        what: &'static str,
        /// Its value.
        found: u32,
        /// What it may be.
        allowed: &'static str,
    },
    /// The strip has no pixel, or reaches outside the picture.
    #[error(
        "the road network's strip, rows {top} to {bottom} and columns {left} to {right} of 1, has no pixel inside the picture; its \
         sides must be shares from 0 to 1 in this order"
    )]
    Strip {
        /// Upper side, a share of the height.
        top: f32,
        /// Lower side.
        bottom: f32,
        /// Left side, a share of the width.
        left: f32,
        /// Right side.
        right: f32,
    },
    /// A bias or a scale is out of range.
    #[error(
        "the road network's {what} before byte {end} is {found}; it must be finite and at most {most} in size; write the file anew"
    )]
    Number {
        /// Which kind of number.
        what: &'static str,
        /// Its value.
        found: f32,
        /// The largest that can be used.
        most: f32,
        /// Where the number ends in the file.
        end: usize,
    },
    /// The file ends before its last layer.
    #[error(
        "the road network's file ends at byte {found}, where byte {needed} is needed; it was cut off, so copy it again"
    )]
    Short {
        /// Bytes up to the end of what was to be read.
        needed: usize,
        /// Bytes there are.
        found: usize,
    },
    /// Something follows the last layer.
    #[error(
        "the road network ends at byte {end}, but its file has {found} bytes; the sizes at its head are not those of its layers"
    )]
    Long {
        /// Bytes of the network.
        end: usize,
        /// Bytes there are.
        found: usize,
    },
}

/// A part of the picture, shares of its height and width from the top left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strip {
    pub(super) top: f32,
    pub(super) bottom: f32,
    pub(super) left: f32,
    pub(super) right: f32,
}

/// A depthwise convolution and a pointwise one; with the block's input added where it has a factor.
#[derive(Debug, Clone)]
pub(super) struct Separable {
    pub(super) depthwise: Depthwise,
    pub(super) pointwise: Dense,
    pub(super) residual: Option<f32>,
}

/// A level's way down: halving, and then blocks of the same size.
#[derive(Debug, Clone)]
pub(super) struct Down {
    pub(super) halving: Separable,
    pub(super) blocks: Vec<Separable>,
}

/// What the whole picture says to each of its places.
#[derive(Debug, Clone)]
pub(super) struct Context {
    pub(super) pointwise: Dense,
    pub(super) mean_scale: f32,
    pub(super) place_scale: f32,
    pub(super) context_scale: f32,
}

/// A level's way up: narrowed, doubled, joined with the level above it.
#[derive(Debug, Clone)]
pub(super) struct Up {
    pub(super) narrow: Dense,
    pub(super) doubled_scale: f32,
    pub(super) level_scale: f32,
    pub(super) merge: Separable,
}

/// All numbers of a network.
#[derive(Debug, Clone)]
pub(super) struct Weights {
    pub(super) size: (usize, usize),
    pub(super) strip: Strip,
    pub(super) channels: [usize; 4],
    pub(super) outputs: usize,
    pub(super) stem: Dense,
    pub(super) down: Vec<Down>,
    pub(super) context: Context,
    /// The way up from the smallest level first.
    pub(super) up: Vec<Up>,
    pub(super) head: Dense,
}

impl Weights {
    /// Reads a file.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, RoadNetworkError> {
        let Some(_) = bytes.strip_prefix(MAGIC) else { return Err(RoadNetworkError::NotANetwork) };
        let mut file = Reader { bytes, at: MAGIC.len() };
        let side = (SIDE_STEP_PX..=MOST_SIDE_PX, SIDE_STEP_PX, "a multiple of 16 up to 1024");
        let size = (file.size("width", &side)?, file.size("height", &side)?);
        let strip = file.strip(size)?;
        let channel = (CHANNEL_STEP..=MOST_CHANNELS, CHANNEL_STEP, "a multiple of 16 up to 256");
        let mut channels = [0; 4];
        for (count, what) in channels.iter_mut().zip(["c0", "c1", "c2", "c3"]) {
            *count = file.size(what, &channel)?;
        }
        let block = (0..=MOST_BLOCKS, 1, "up to 64");
        let mut blocks = [0; 3];
        for (count, what) in blocks.iter_mut().zip(["blocks1", "blocks2", "blocks3"]) {
            *count = file.size(what, &block)?;
        }
        let outputs = file.size("number of outputs", &(1..=MOST_OUTPUTS, 1, "1 to 16"))?;

        let stem = file.dense(9 * INPUT_CHANNELS, channels[0])?;
        let levels = channels.windows(2).zip(blocks);
        let down = levels.map(|(c, blocks)| file.down(c[0], c[1], blocks)).collect::<Result<_, _>>()?;
        let context = Context {
            pointwise: file.dense(channels[3], channels[3])?,
            mean_scale: file.scale()?,
            place_scale: file.scale()?,
            context_scale: file.scale()?,
        };
        let up = channels.windows(2).rev().map(|c| file.up(c[1], c[0])).collect::<Result<_, _>>()?;
        let head = file.dense(channels[0], outputs)?;
        file.end()?;
        Ok(Self { size, strip, channels, outputs, stem, down, context, up, head })
    }
}

/// Allowed values of a size: range, step, and both in words.
type Sizes = (RangeInclusive<u32>, u32, &'static str);

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], RoadNetworkError> {
        // Neither can overflow: sizes are bounded, and `at` lies in the file.
        let needed = self.at + count;
        let short = RoadNetworkError::Short { needed, found: self.bytes.len() };
        let taken = self.bytes.get(self.at..needed).ok_or(short)?;
        self.at = needed;
        Ok(taken)
    }

    fn words(&mut self, count: usize) -> Result<&'a [[u8; 4]], RoadNetworkError> {
        Ok(self.take(4 * count)?.as_chunks().0)
    }

    fn word(&mut self) -> Result<[u8; 4], RoadNetworkError> {
        Ok(self.words(1)?.first().copied().unwrap_or_default())
    }

    fn size(
        &mut self,
        what: &'static str,
        (range, step, allowed): &Sizes,
    ) -> Result<usize, RoadNetworkError> {
        let found = u32::from_le_bytes(self.word()?);
        if range.contains(&found) && found.is_multiple_of(*step) {
            return Ok(found as usize);
        }
        Err(RoadNetworkError::Size { what, found, allowed })
    }

    fn strip(&mut self, size: (usize, usize)) -> Result<Strip, RoadNetworkError> {
        let mut sides = [0.0; 4];
        for side in &mut sides {
            *side = f32::from_le_bytes(self.word()?);
        }
        let [top, bottom, left, right] = sides;
        let strip = Strip { top, bottom, left, right };
        let shares = sides.iter().all(|side| (0.0..=1.0).contains(side));
        let part = strip.pixels(size);
        if shares && !part[0].is_empty() && !part[1].is_empty() {
            return Ok(strip);
        }
        Err(RoadNetworkError::Strip { top, bottom, left, right })
    }

    fn number(&self, what: &'static str, found: f32, most: f32) -> Result<f32, RoadNetworkError> {
        // Written so that what is no number is refused.
        if found.abs() <= most {
            return Ok(found);
        }
        Err(RoadNetworkError::Number { what, found, most, end: self.at })
    }

    fn scale(&mut self) -> Result<f32, RoadNetworkError> {
        let scale = f32::from_le_bytes(self.word()?);
        self.number("scale", scale, MOST_SCALE)
    }

    /// Weights, biases and multipliers of a layer.
    fn layer(&mut self, inputs: usize, outputs: usize) -> Result<Layer<'a>, RoadNetworkError> {
        let weights = self.take(inputs * outputs)?;
        let mut bias = Vec::with_capacity(outputs);
        for _ in 0..outputs {
            let found = i32::from_le_bytes(self.word()?);
            self.number("bias", found as f32, MOST_BIAS as f32)?;
            bias.push(found);
        }
        let multiplier = (0..outputs).map(|_| self.scale()).collect::<Result<_, _>>()?;
        Ok(Layer { weights, bias, multiplier })
    }

    fn dense(&mut self, inputs: usize, outputs: usize) -> Result<Dense, RoadNetworkError> {
        Ok(Dense::new(inputs, &self.layer(inputs, outputs)?))
    }

    fn separable(
        &mut self,
        [from, to]: [usize; 2],
        with_residual: Residual,
    ) -> Result<Separable, RoadNetworkError> {
        Ok(Separable {
            depthwise: Depthwise::new(&self.layer(9, from)?),
            pointwise: self.dense(from, to)?,
            residual: match with_residual {
                Residual::Added => Some(self.scale()?),
                Residual::None => None,
            },
        })
    }

    fn down(&mut self, from: usize, to: usize, blocks: usize) -> Result<Down, RoadNetworkError> {
        Ok(Down {
            halving: self.separable([from, to], Residual::None)?,
            blocks: (0..blocks)
                .map(|_| self.separable([to, to], Residual::Added))
                .collect::<Result<_, _>>()?,
        })
    }

    fn up(&mut self, from: usize, to: usize) -> Result<Up, RoadNetworkError> {
        Ok(Up {
            narrow: self.dense(from, to)?,
            doubled_scale: self.scale()?,
            level_scale: self.scale()?,
            merge: self.separable([to, to], Residual::None)?,
        })
    }

    fn end(&self) -> Result<(), RoadNetworkError> {
        if self.at == self.bytes.len() {
            return Ok(());
        }
        Err(RoadNetworkError::Long { end: self.at, found: self.bytes.len() })
    }
}

/// Whether a block's input is added to what comes of it.
#[derive(Clone, Copy)]
enum Residual {
    Added,
    None,
}

/// A layer as it stands in the file: weights as bytes of `i8`, those of an output together.
pub(super) struct Layer<'a> {
    pub(super) weights: &'a [u8],
    pub(super) bias: Vec<i32>,
    pub(super) multiplier: Vec<f32>,
}

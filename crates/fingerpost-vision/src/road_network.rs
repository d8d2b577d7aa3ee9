//! A small convolutional network in whole numbers, which says of each place of a picture what it shows.
//!
//! Its weights come from a file, whose head has the sizes; what it computes is fixed. Activations have 7 bits, so that two of their
//! products with weights of 8 bits fit 16, and sums 32 bits: every instruction set gives the same bytes. The operations are
//! those of MobileNet (A. Howard et al., 2017): 3 x 3 convolutions of each channel by itself and pointwise ones, and besides these one
//! full 3 x 3 convolution, one mean over the picture, and bilinear doubling on the way back up, as in U-Net (O. Ronneberger et al.,
//! 2015). Quantisation follows B. Jacob et al., "Quantization and training of neural networks for efficient integer-arithmetic-only
//! inference", 2018, with scales in `f32`.
//!
//! | layer | from | to | places (256 x 144 pixels) |
//! |---|---|---|---|
//! | input | picture | 8 numbers a pixel | 256 x 144 |
//! | stem: 3 x 3, every second place | 8 | c0 | 128 x 72 |
//! | three levels: separable, every second place; then separable blocks with their input added | c0, c1, c2 | c1, c2, c3 | 64 x 36, 32 x 18, 16 x 9 |
//! | context: mean of the smallest level, pointwise, added to it | c3 | c3 | 16 x 9 |
//! | three times: pointwise, doubled, the level above added, separable | c3, c2, c1 | c2, c1, c0 | 32 x 18, 64 x 36, 128 x 72 |
//! | head: pointwise | c0 | outputs | 128 x 72 |
//!
//! Limits: the camera's picture is stretched to the network's, whatever its shape.

mod context;
mod dense;
mod depthwise;
mod doubling;
mod input;
mod requantising;
mod tensor;
#[cfg(test)]
mod tests;
mod weights;

pub use weights::RoadNetworkError;

use context::ContextRows;
use dense::{Added, Dense, Places};
use depthwise::Windows;
use doubling::{Doubling, Scales};
use input::{InputMaker, ZERO};
use requantising::{RECTIFIED, SIGNED};
use tensor::Tensor;
use weights::{Separable, Weights};

use crate::error::PictureError;
use crate::picture::{Plane, Rect, RgbImage};
use crate::resampling::Resampler;
use crate::simd::CodePath;

/// Numbers a pixel that the network sees.
const INPUT_CHANNELS: usize = 8;

/// Steps of a logit by which it grows by 1.
pub const LOGIT_STEPS: f32 = 16.0;

/// A road network with all memory that a picture takes.
#[derive(Debug, Clone)]
pub struct RoadNetwork {
    weights: Weights,
    resampler: Option<Resampler>,
    picture: RgbImage,
    input_maker: InputMaker,
    input: Tensor,
    /// The largest first.
    levels: [Level; 4],
    /// Between the levels: each narrowed for the one above it, whose index this is.
    narrowed: [Plane<u8>; 3],
    doubling: [Doubling; 3],
    context: ContextRows,
    /// A row of the widest layer between a depthwise and a pointwise convolution.
    row: Vec<u8>,
    head_row: Vec<u8>,
    logits: Vec<Plane<i8>>,
}

/// The activations of a level, and those of a step before or after.
#[derive(Debug, Clone)]
struct Level {
    current: Tensor,
    spare: Tensor,
}

impl RoadNetwork {
    /// Reads a network.
    ///
    /// A file has, little endian: `FPROAD01`; `u32` width and height; `f32` top, bottom, left and right of the strip of road just
    /// ahead, shares of the picture; `u32` c0, c1, c2, c3, blocks of the levels 1, 2 and 3, outputs; then the layers as they run,
    /// each with its weights (`i8`; depthwise by channel, row and column; pointwise by output and input; stem by output, row, column
    /// and input), biases (`i32`), multipliers (`f32`) and its own scales (`f32`): a block that of its input; the context those of its
    /// sum, of the level and of itself; a narrowing those of what is doubled, in 16ths, and of the level above.
    ///
    /// # Errors
    /// [`RoadNetworkError`] when the bytes are no such file, or one that cannot be run.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, RoadNetworkError> {
        let mut weights = Weights::read(bytes)?;
        weights.stem.fold_zero_point(i32::from(ZERO));
        let (width, height) = weights.size;
        let channels = weights.channels;
        let size = |level: usize| (width >> (level + 1), height >> (level + 1));
        let level = |level: usize| {
            let tensor = Tensor::new(size(level), channels[level], 0);
            Level { current: tensor.clone(), spare: tensor }
        };
        let narrowed = |above: usize| {
            let (width, height) = size(above + 1);
            Plane::new(width * channels[above], height, 0)
        };
        let (half_width, half_height) = size(0);
        let longest = (0..4).map(|level| size(level).0 * channels[level]).max().unwrap_or(0);
        Ok(Self {
            resampler: None,
            picture: RgbImage::new(width, height),
            input_maker: InputMaker::new(weights.strip),
            input: Tensor::new((width, height), INPUT_CHANNELS, ZERO),
            levels: [level(0), level(1), level(2), level(3)],
            narrowed: [narrowed(0), narrowed(1), narrowed(2)],
            doubling: [0, 1, 2].map(|above| Doubling::new(size(above + 1).0, channels[above])),
            context: ContextRows::new(channels[3]),
            row: vec![0; longest],
            head_row: vec![0; half_width * weights.head.outputs()],
            logits: vec![Plane::new(half_width, half_height, 0); weights.outputs],
            weights,
        })
    }

    /// Width and height of the planes of logits, pixels: half of those of the network's picture.
    #[must_use]
    pub fn logit_size(&self) -> (usize, usize) {
        (self.weights.size.0 / 2, self.weights.size.1 / 2)
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.weights.outputs
    }

    /// The logits of an output for the last picture seen, in steps of 1 / [`LOGIT_STEPS`]; `None` beyond the last output.
    #[must_use]
    pub fn logits(&self, output: usize) -> Option<&Plane<i8>> {
        self.logits.get(output)
    }

    /// What it looked at last, at its own size; twice that of the logits.
    #[must_use]
    pub fn picture(&self) -> &RgbImage {
        &self.picture
    }

    /// The part of the picture that it looked at last; of no size before the first.
    #[must_use]
    pub fn part(&self) -> Rect {
        self.resampler.as_ref().map_or(Rect { x: 0, y: 0, width: 0, height: 0 }, Resampler::part)
    }

    /// Column and row of the logits at a pixel of the picture that it looked at last, from the centre of the first; within their planes
    /// where the pixel is in [`Self::part`].
    #[must_use]
    pub fn logit_place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (part, (columns, rows)) = (self.part(), self.logit_size());
        let place = |at: f64, from: usize, length: usize, to: usize| {
            (at - from as f64 + 0.5) * to as f64 / length.max(1) as f64 - 0.5
        };
        [place(u, part.x, part.width, columns), place(v, part.y, part.height, rows)]
    }

    /// Looks at a `part` of a picture.
    ///
    /// # Errors
    /// [`PictureError::Empty`] when the part has no pixels, [`PictureError::CropOutside`] when it reaches outside the picture.
    pub fn see(&mut self, picture: &RgbImage, part: Rect) -> Result<(), PictureError> {
        self.see_on(CodePath::fastest(), picture, part)
    }

    fn see_on(&mut self, path: CodePath, picture: &RgbImage, part: Rect) -> Result<(), PictureError> {
        let fits =
            |resampler: &Resampler| resampler.source_size() == picture.size() && resampler.part() == part;
        let resampler = match self.resampler.take().filter(fits) {
            Some(resampler) => resampler,
            None => Resampler::new(picture.size(), part, self.weights.size)?,
        };
        self.resampler.insert(resampler).resample_on(path, picture, &mut self.picture)?;
        self.input_maker.fill(path, &self.picture, &mut self.input);
        self.run(path);
        Ok(())
    }

    /// From the input to the logits.
    fn run(&mut self, path: CodePath) {
        let Weights { stem, down, context, up, head, .. } = &self.weights;
        let [first, ..] = &mut self.levels;
        for y in 0..first.current.height() {
            let (length, step) = (stem.inputs() / 3, 2 * INPUT_CHANNELS);
            let places = Places { rows: self.input.window(2 * y), length, step };
            stem.apply::<3, RECTIFIED>(path, places, None, first.current.row_mut(y));
        }
        for (index, down) in down.iter().enumerate() {
            let [above, level] = neighbours(&mut self.levels, index);
            down.halving.apply(path, &above.current, 2, &mut self.row, &mut level.current);
            for block in &down.blocks {
                block.apply(path, &level.current, 1, &mut self.row, &mut level.spare);
                std::mem::swap(&mut level.current, &mut level.spare);
            }
        }
        let [.., last] = &mut self.levels;
        self.context.add(path, context, &mut last.current);
        for (index, up) in (0..up.len()).rev().zip(up) {
            let [above, level] = neighbours(&mut self.levels, index);
            let narrowed = &mut self.narrowed[index];
            for y in 0..level.current.height() {
                let row = Places::pointwise(level.current.row(y), &up.narrow);
                up.narrow.apply::<1, SIGNED>(path, row, None, narrowed.row_mut(y));
            }
            let scales = Scales { doubled: up.doubled_scale, level: up.level_scale };
            self.doubling[index].join(path, narrowed, &above.current, scales, &mut above.spare);
            up.merge.apply(path, &above.spare, 1, &mut self.row, &mut above.current);
        }
        let [first, ..] = &self.levels;
        for y in 0..first.current.height() {
            let row = Places::pointwise(first.current.row(y), head);
            head.apply::<1, SIGNED>(path, row, None, &mut self.head_row);
            for (output, logits) in self.logits.iter_mut().enumerate() {
                let of_output = self.head_row[output..].iter().step_by(head.outputs());
                logits
                    .row_mut(y)
                    .iter_mut()
                    .zip(of_output)
                    .for_each(|(logit, &byte)| *logit = byte.cast_signed());
            }
        }
    }
}

/// Two neighbouring levels, the larger first.
fn neighbours(levels: &mut [Level; 4], index: usize) -> [&mut Level; 2] {
    let (above, below) = levels.split_at_mut(index + 1);
    [&mut above[index], &mut below[0]]
}

impl<'a> Places<'a, 1> {
    /// The places of a row one by one, as a pointwise layer takes them.
    fn pointwise(row: &'a [u8], layer: &Dense) -> Self {
        Self { rows: [row], length: layer.inputs(), step: layer.inputs() }
    }
}

impl Separable {
    /// From `source`, of whose places every `step`-th along both sides is the middle of a window, to `target`; `between` is memory for
    /// a row.
    fn apply(&self, path: CodePath, source: &Tensor, step: usize, between: &mut [u8], target: &mut Tensor) {
        for y in 0..target.height() {
            let out = target.row_mut(y);
            let between = &mut between[..out.len() / self.pointwise.outputs() * self.depthwise.channels()];
            self.depthwise.apply(path, Windows { rows: source.window(step * y), step }, between);
            let added = self.residual.map(|factor| Added { bytes: source.row(y), factor });
            self.pointwise.apply::<1, RECTIFIED>(
                path,
                Places::pointwise(between, &self.pointwise),
                added,
                out,
            );
        }
    }
}

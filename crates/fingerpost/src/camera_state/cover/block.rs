//! Blocks of the thinned picture, and how each has changed.
//!
//! How much a block must change when what it shows moves is read off the block itself: moved by a sample in whatever direction, it
//! changes by the smaller eigenvalue of its gradients' second moments at least (J. Shi and C. Tomasi, "Good features to track",
//! 1994), in mean squares. A line alone, as a lane's on a straight road, may be moved along itself unseen: it has no texture.

use super::super::{BLACK_BELOW, BLOCK, LEAST_CONTRAST};
use super::{MOST_LOG_ODDS, STILL_IF_FIXED, STILL_IF_SCENE};

/// Variance of a sample over the square of the median difference of samples from the mean of their four neighbours, of white noise.
const VARIANCE_OF_NOISE: f32 = 1.0 / (1.25 * 0.6745 * 0.6745);
/// A block's second moments, or its mean square change, must be so many times those of noise to stand out from it.
const NOISE_FACTOR: f32 = 3.0;

/// How a block has changed from its reference.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) enum BlockChange {
    /// It has no texture, and did not change: that says nothing.
    #[default]
    Unknown,
    /// It changed, or moved.
    Moved,
    /// It has texture, and stayed as it was.
    Still,
    /// It is black, and stayed so.
    Black,
}

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Block {
    /// By how many samples road goes by in it at least, per metre driven, and what stands above the horizon.
    pub(super) samples_per_m: f32,
    pub(super) raised_samples_per_m: f32,
    /// Smaller eigenvalue of the mean second moments of the reference, square grey levels a square sample.
    pub(super) texture: f32,
    pub(super) has_texture: bool,
    pub(super) change_kind: BlockChange,
    /// Way since its reference, metres, and what it was when the block last added to its log-odds.
    pub(super) way_m: f32,
    pub(super) counted_at_m: f32,
    /// Whether it has added to its log-odds by being black in this look.
    pub(super) is_counted: bool,
    pub(super) log_odds: f32,
    pub(super) is_covered: bool,
    /// Mean square change of its samples from the reference.
    mean_square_change: f32,
    /// Their mean, grey levels.
    pub(super) level: f32,
}

impl Block {
    /// A block of which nothing is known but how fast road and what stands above it go by, samples a metre.
    pub(super) fn new([samples_per_m, raised_samples_per_m]: [f32; 2], log_odds: f32) -> Self {
        Self { samples_per_m, raised_samples_per_m, log_odds, ..Self::default() }
    }

    /// Adds evidence to its log-odds of being covered.
    pub(super) fn add(&mut self, likelihood_ratio: f32) {
        self.log_odds = (self.log_odds + libm::logf(likelihood_ratio)).clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS);
    }

    /// Whether it is black, and has not counted in this look.
    pub(super) fn is_black_uncounted(&self) -> bool {
        self.change_kind == BlockChange::Black && !self.is_counted
    }

    /// The same where all that it showed has gone by since it last counted.
    pub(super) fn is_black_and_replaced(&self) -> bool {
        let samples_per_m = self.samples_per_m.max(self.raised_samples_per_m);
        self.is_black_uncounted() && samples_per_m * self.way_m >= BLOCK as f32
    }

    /// Adds to its log-odds that it is black by day, up to the `most` that this can make of them.
    pub(super) fn count_black(&mut self, most: f32) {
        self.is_counted = true;
        let most = most.max(self.log_odds);
        self.add(STILL_IF_FIXED / STILL_IF_SCENE);
        self.log_odds = self.log_odds.min(most);
    }
}

/// How blocks lie in the thinned picture, row by row.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Grid {
    /// Samples in a row of the picture.
    pub(super) columns: usize,
    pub(super) across: usize,
    pub(super) down: usize,
}

impl Grid {
    /// Column and row of a block.
    pub(super) const fn place(&self, index: usize) -> (usize, usize) {
        (index % self.across, index / self.across)
    }

    /// The blocks left, right, above and below of one.
    pub(super) fn beside(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let Self { across, down, .. } = *self;
        let (column, row) = self.place(index);
        let left = (column > 0).then(|| index - 1);
        let right = (column + 1 < across).then_some(index + 1);
        let above = (row > 0).then(|| index - across);
        let below = (row + 1 < down).then_some(index + across);
        [left, right, above, below].into_iter().flatten()
    }

    /// Where the block's rows begin in the samples.
    fn rows(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (columns, (column, row)) = (self.columns, self.place(index));
        (row * BLOCK..(row + 1) * BLOCK).map(move |row| row * columns + column * BLOCK)
    }

    /// Copies a block's samples.
    pub(super) fn copy(&self, from: &[u8], to: &mut [u8], index: usize) {
        for row in self.rows(index) {
            to[row..row + BLOCK].copy_from_slice(&from[row..row + BLOCK]);
        }
    }

    /// Smaller eigenvalue of the mean second moments of a block's gradients, over two samples each, halved.
    pub(super) fn texture(&self, samples: &[u8], index: usize) -> f32 {
        let (mut xx, mut yy, mut xy) = (0_i32, 0_i32, 0_i32);
        for row in self.rows(index).skip(1).take(BLOCK - 2) {
            let [above, here, below] =
                [row - self.columns, row, row + self.columns].map(|row| &samples[row..][..BLOCK]);
            for i in 1..BLOCK - 1 {
                let right = i32::from(here[i + 1]) - i32::from(here[i - 1]);
                let down = i32::from(below[i]) - i32::from(above[i]);
                xx += right * right;
                yy += down * down;
                xy += right * down;
            }
        }
        let scale = 0.25 / ((BLOCK - 2) * (BLOCK - 2)) as f32;
        let (xx, yy, xy) = (xx as f32, yy as f32, xy as f32);
        let (half, difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        scale * (half - (difference * difference + xy * xy).sqrt())
    }
}

/// How each block has changed from its reference; `changes` is memory that is used anew.
pub(super) fn judge_changes(
    (grid, blocks): (&Grid, &mut [Block]),
    (samples, reference): (&[u8], &[u8]),
    noise: f64,
    changes: &mut Vec<f32>,
) {
    changes.clear();
    for (index, block) in blocks.iter_mut().enumerate() {
        let (mut squares, mut sum) = (0_u32, 0_u32);
        for row in grid.rows(index) {
            let (now, before) = (&samples[row..row + BLOCK], &reference[row..row + BLOCK]);
            squares += now.iter().zip(before).map(|(&a, &b)| u32::from(a.abs_diff(b)).pow(2)).sum::<u32>();
            sum += now.iter().map(|&sample| u32::from(sample)).sum::<u32>();
        }
        block.mean_square_change = squares as f32 / (BLOCK * BLOCK) as f32;
        block.level = sum as f32 / (BLOCK * BLOCK) as f32;
        if block.level >= f32::from(BLACK_BELOW) {
            changes.push(block.mean_square_change);
        }
    }
    let least = (LEAST_CONTRAST * LEAST_CONTRAST) as f32;
    let tenth = changes.len() / 10;
    // Twice the variance of the noise. Both are what it is at most: texture adds to the one, motion to the other.
    let noise = 2.0 * VARIANCE_OF_NOISE * (noise * noise) as f32;
    let noise = match changes.is_empty() {
        true => noise,
        false => noise.min(*changes.select_nth_unstable_by(tenth, f32::total_cmp).1),
    };
    for block in blocks {
        // A gradient over two samples has half a sample's variance.
        block.has_texture = block.texture > (NOISE_FACTOR * 0.25 * noise).max(least);
        block.change_kind = match block.has_texture {
            true if block.mean_square_change < block.texture => BlockChange::Still,
            true => BlockChange::Moved,
            false if block.mean_square_change > (NOISE_FACTOR * noise).max(least) => BlockChange::Moved,
            false if block.level < f32::from(BLACK_BELOW) => BlockChange::Black,
            false => BlockChange::Unknown,
        };
    }
}

//! Parts of the picture that stay as they are while the rest moves: dirt on the lens, a bonnet, a torn cover.
//!
//! Every few frames each block of the thinned picture is compared with the same block of an older frame, its reference. How
//! much a block must change when what it shows moves is read off the block itself: moved by a sample in whatever direction, it
//! changes by the smaller eigenvalue of its gradients' second moments at least (J. Shi and C. Tomasi, "Good features to track",
//! 1994), in mean squares. A line alone, as a lane's on a straight road, may be moved along itself unseen: it says nothing. When
//! textured blocks have moved all over the picture, the camera moves, and each textured block adds to its log-odds of showing what is
//! fixed to the camera (an occupancy grid's: A. Elfes, "Using occupancy grids for mobile robot perception", 1989). By how much
//! says the share of the blocks in its row that moved, and in the rows between it and the horizon, because the road goes by the
//! faster the nearer it is. Above the horizon what is still may be a cloud, or a tree far ahead: that says nothing.
//!
//! A block without texture says nothing: sky, fog and smooth asphalt do not change either, and are used. Only one that is black by day
//! does, because daylight leaves nothing black; of a picture in which what moves is dark as well, it says nothing.
//!
//! Limits: an even cover that is not black is not noticed, nor is dirt above the horizon that is not black; where less than a quarter of
//! what has texture in a third of the picture moves, the camera is held for standing. Where blocks do not fill the picture, the last
//! ones speak for what is left over at its right and lower edge: a cover that lies there alone is not noticed.

use fingerpost_vision::picture::HiddenParts;

use super::{BLACK_BELOW, BLOCK, LEAST_CONTRAST};

/// Frames between two looks: a third of a second at ten frames a second, in which the road has gone by some samples.
const LOOK_EVERY: usize = 3;
/// Share of the textured blocks that must have moved in each third of the picture: a cover may have more texture than the road.
const LEAST_MOVE: f32 = 0.25;
/// The same of a row of blocks below the horizon, by which those that have not moved are judged: most of them.
const ROW_MOVES: f32 = 0.5;
/// Fewest blocks whose share is believed.
const LEAST_BLOCKS: f32 = 8.0;
const LEAST_OF_ROW: f32 = 3.0;
/// Probability that a block is covered before anything is seen.
const COVERED_AT_FIRST: f32 = 0.01;
/// Probabilities that a block changes as little as what is fixed to the camera: where that is what it shows, but for rain, mirror
/// images and compression; and at least, where all about it moves, for what travels along with the camera, and chance.
const STILL_IF_FIXED: f32 = 0.95;
const STILL_IF_SCENE: f32 = 0.05;
/// A block is covered from these log-odds on, 99 %, until they say that it is more likely not.
const COVERED_FROM: f32 = 4.6;
const COVERED_UNTIL: f32 = 0.0;
/// Log-odds are bounded, so that dirt that is wiped off is forgotten in a few looks.
const MOST_LOG_ODDS: f32 = 6.0;
/// Part of what is known of a cover that stays when its block neither has texture nor is black any more: the cover may be off and the
/// sky behind it, which itself says nothing.
const KEPT: f32 = 0.5;
/// Variance of a sample over the square of the median difference of samples from the mean of their four neighbours, of white noise.
const VARIANCE_OF_NOISE: f32 = 1.0 / (1.25 * 0.6745 * 0.6745);
/// A block's second moments, or its mean square change, must be so many times those of noise to stand out from it.
const NOISE_FACTOR: f32 = 3.0;
/// Share of the moving blocks that may be darker than twice black on a day that leaves nothing black: a clear day has 6 %, a street's shade 13 % and
/// more, dusk 45 %, the light of headlights 40 %.
const DARK_BY_DAY: f32 = 0.1;

/// How a block has changed from its reference.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum BlockChange {
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
struct Block {
    /// Smaller eigenvalue of the mean second moments of the reference, square grey levels a square sample.
    texture: f32,
    has_texture: bool,
    /// Mean square change of its samples from the reference.
    mean_square_change: f32,
    is_black: bool,
    change_kind: BlockChange,
    log_odds: f32,
    is_covered: bool,
}

/// What has come of a look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Looked {
    /// The same parts are hidden as before.
    Same,
    /// Others are.
    Changed,
}

/// Watches which blocks of the thinned picture do not go by.
#[derive(Debug, Default)]
pub(super) struct CoverWatch {
    columns: usize,
    across: usize,
    down: usize,
    /// Row of blocks with the horizon.
    horizon: usize,
    reference: Vec<u8>,
    blocks: Vec<Block>,
    changes: Vec<f32>,
    frames: usize,
    hidden: HiddenParts,
}

impl CoverWatch {
    /// The squares that are hidden, of the picture that was thinned.
    pub(super) const fn hidden(&self) -> &HiddenParts {
        &self.hidden
    }

    /// Takes in a picture's samples, `columns` a row, thinned to every `nth`, of which the differences from neighbours
    /// have a median of `noise` grey levels; `horizon_share` is the horizon's share of the height.
    pub(super) fn look_at(
        &mut self,
        samples: &[u8],
        (columns, nth): (usize, usize),
        noise: f64,
        horizon_share: f64,
    ) -> Looked {
        let rows = samples.len().checked_div(columns).unwrap_or(0);
        let size = (columns / BLOCK, rows / BLOCK);
        if self.columns != columns || (self.across, self.down) != size {
            let (across, down) = size;
            let log_odds = log_odds(COVERED_AT_FIRST);
            let blocks = vec![Block { log_odds, ..Block::default() }; across * down];
            let horizon = (horizon_share * down as f64).clamp(0.0, down as f64) as usize;
            let hidden = HiddenParts::new(across, down, BLOCK * nth);
            let reference = Vec::with_capacity(samples.len());
            let changes = Vec::with_capacity(across * down);
            *self = Self { columns, across, down, horizon, reference, blocks, changes, frames: 0, hidden };
        }
        let frames = self.frames;
        self.frames += 1;
        if frames == 0 {
            self.refer_to(samples);
        }
        if frames == 0 || !frames.is_multiple_of(LOOK_EVERY) {
            return Looked::Same;
        }
        self.compare(samples, noise);
        if !self.weigh(samples) {
            return Looked::Same;
        }
        self.refer_to(samples);
        self.hide()
    }

    /// Makes these samples the reference.
    fn refer_to(&mut self, samples: &[u8]) {
        self.reference.clear();
        self.reference.extend_from_slice(samples);
        let Self { columns, across, reference, blocks, .. } = self;
        for (index, block) in blocks.iter_mut().enumerate() {
            block.texture = texture(reference, *columns, (index % *across, index / *across));
        }
    }

    /// What each block says, by its change from the reference.
    fn compare(&mut self, samples: &[u8], noise: f64) {
        let Self { columns, across, reference, blocks, changes, .. } = self;
        changes.clear();
        for (index, block) in blocks.iter_mut().enumerate() {
            let (x, y) = (index % *across * BLOCK, index / *across * BLOCK);
            let (mut squares, mut sum) = (0_u32, 0_u32);
            for row in y..y + BLOCK {
                let from = row * *columns + x;
                let (now, before) = (&samples[from..from + BLOCK], &reference[from..from + BLOCK]);
                squares +=
                    now.iter().zip(before).map(|(&a, &b)| u32::from(a.abs_diff(b)).pow(2)).sum::<u32>();
                sum += now.iter().map(|&sample| u32::from(sample)).sum::<u32>();
            }
            block.mean_square_change = squares as f32 / (BLOCK * BLOCK) as f32;
            block.is_black = sum < u32::from(BLACK_BELOW) * (BLOCK * BLOCK) as u32;
            if !block.is_black {
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
                false if block.is_black => BlockChange::Black,
                false => BlockChange::Unknown,
            };
        }
    }
}

fn log_odds(probability: f32) -> f32 {
    libm::logf(probability / (1.0 - probability))
}

/// How many of the textured blocks, less those that are covered, have moved, and how many there are.
fn moved_of_all<'a>(blocks: impl Iterator<Item = &'a Block>) -> (f32, f32) {
    let (mut moved, mut all) = (0.0, 0.0);
    for block in blocks.filter(|block| block.has_texture) {
        let scene = 1.0 / (1.0 + libm::expf(block.log_odds));
        all += scene;
        moved += if block.change_kind == BlockChange::Moved { scene } else { 0.0 };
    }
    (moved, all)
}

/// Smaller eigenvalue of the mean second moments of a block's gradients, over two samples each, halved.
fn texture(samples: &[u8], columns: usize, (column, row): (usize, usize)) -> f32 {
    let (x, y) = (column * BLOCK, row * BLOCK);
    let (mut xx, mut yy, mut xy) = (0_i32, 0_i32, 0_i32);
    for row in y + 1..y + BLOCK - 1 {
        let [above, here, below] = [row - 1, row, row + 1].map(|row| &samples[row * columns + x..][..BLOCK]);
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

impl CoverWatch {
    /// Adds to the log-odds what the blocks say; whether most of the picture has moved.
    fn weigh(&mut self, samples: &[u8]) -> bool {
        if !self.camera_moves() {
            return false;
        }
        let is_day = self.is_day(samples);
        let Self { across, horizon, blocks, .. } = self;
        let at_first = log_odds(COVERED_AT_FIRST);
        let mut below_horizon: f32 = 0.0;
        for (row, blocks) in blocks.chunks_exact_mut(*across).enumerate() {
            let (moved, all) = moved_of_all(blocks.iter());
            let of_row = if all < LEAST_OF_ROW { 0.0 } else { moved / all };
            if row > *horizon {
                below_horizon = below_horizon.max(of_row);
            }
            let share = below_horizon;
            let still_if_scene = (1.0 - share).max(STILL_IF_SCENE);
            for block in blocks {
                if block.change_kind == BlockChange::Unknown && block.log_odds > at_first {
                    block.log_odds = at_first + KEPT * (block.log_odds - at_first);
                }
                let likelihood_ratio = match block.change_kind {
                    BlockChange::Moved => (1.0 - STILL_IF_FIXED) / (1.0 - STILL_IF_SCENE),
                    BlockChange::Still if share >= ROW_MOVES => STILL_IF_FIXED / still_if_scene,
                    BlockChange::Black if is_day => STILL_IF_FIXED / STILL_IF_SCENE,
                    BlockChange::Still | BlockChange::Black | BlockChange::Unknown => continue,
                };
                block.log_odds =
                    (block.log_odds + libm::logf(likelihood_ratio)).clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS);
            }
        }
        true
    }

    /// Whether what has texture has moved all over the picture: in each of three parts side by side with enough of it. What passes a
    /// standing vehicle is in one or two of them.
    fn camera_moves(&self) -> bool {
        let Self { across, blocks, .. } = self;
        let mut moving_thirds = 0;
        for third in 0..3 {
            let columns = third * across / 3..(third + 1) * across / 3;
            let of_third = blocks.chunks_exact(*across).flat_map(|row| &row[columns.clone()]);
            let (moved, all) = moved_of_all(of_third);
            if all < LEAST_BLOCKS {
                continue;
            }
            if moved < LEAST_MOVE * all {
                return false;
            }
            moving_thirds += 1;
        }
        moving_thirds > 0
    }

    /// Whether hardly any block that moves is dark: then it is the light of day that makes others look black.
    fn is_day(&self, samples: &[u8]) -> bool {
        let Self { columns, across, blocks, .. } = self;
        let (mut dark, mut all) = (0, 0);
        for (index, _) in
            blocks.iter().enumerate().filter(|(_, block)| block.change_kind == BlockChange::Moved)
        {
            // The sample in its middle stands for a block.
            let (column, row) = (index % across * BLOCK + BLOCK / 2, index / across * BLOCK + BLOCK / 2);
            dark += usize::from(samples[row * columns + column] < 2 * BLACK_BELOW);
            all += 1;
        }
        (dark as f32) < DARK_BY_DAY * all as f32
    }

    /// Hides what is covered, and the blocks beside it: a block changes when a part of it does, so the cover's edge lies in them.
    fn hide(&mut self) -> Looked {
        let Self { across, down, blocks, hidden, .. } = self;
        for block in blocks.iter_mut() {
            let bound = if block.is_covered { COVERED_UNTIL } else { COVERED_FROM };
            block.is_covered = block.log_odds > bound;
        }
        let mut looked = Looked::Same;
        for row in 0..*down {
            for column in 0..*across {
                let about = (row.saturating_sub(1)..(row + 2).min(*down)).any(|row| {
                    let columns = column.saturating_sub(1)..(column + 2).min(*across);
                    blocks[row * *across..][columns].iter().any(|block| block.is_covered)
                });
                if hidden.is_hidden(column, row) != about {
                    hidden.set(column, row, about);
                    looked = Looked::Changed;
                }
            }
        }
        looked
    }
}

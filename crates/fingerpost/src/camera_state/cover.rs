//! Parts of the picture that do not go by while the vehicle drives: dirt on the lens, a bonnet, a torn cover.
//!
//! Every few frames each block of the thinned picture is compared with what it showed in an older frame, its reference, and it gets a
//! new one whenever it has changed. How far road must have gone by in a block follows from the camera and the way driven since its
//! reference (`cover/passing.rs`); what stands on the road is nearer than the road behind it, and goes by as fast at least. Where that is
//! some samples and the block stays as it was, it adds to its log-odds of showing what is fixed to the camera (an occupancy
//! grid's: A. Elfes, "Using occupancy grids for mobile robot perception", 1989). Where it is less, as far ahead, the block says
//! nothing yet: its reference ages, and the way grows.
//!
//! The way of a look is the bus's, unless the picture speaks against it, or else the one that all blocks of road with
//! texture make most likely: those where road must have moved by a sample have changed, but for covered ones, and of the others nothing is known.
//! A vehicle that stands has no way, whatever passes it, and then nothing is said.
//!
//! A block of smooth road, sky or fog does not change either: it says nothing, but for one that is black by day, because daylight leaves
//! nothing black. A cover is one thing: black blocks that lie together count together, above the horizon too. Whether it is day follows
//! from how much of the rest is dim: where light fades out much is, and by day hardly anything. The looks add to its log-odds, and a
//! black block is no surer covered than it is day.
//!
//! Limits: an even cover that is not black is not noticed, nor one less than two blocks wide or high, nor is dirt above the horizon
//! that is not black, nor a cover with more texture than the road beside it. Nothing black is noticed at dusk, at night, and in shade so
//! deep that a third of what is seen is dim. A vehicle ahead that stays in its place of the picture to a sample while a hundred metres
//! and more go by is taken for a cover. Where blocks do not fill the picture, the last ones speak for what is left over at its right
//! and lower edge: a cover that lies there alone is not noticed.

mod block;
mod passing;

use fingerpost_geometry::Camera;
use fingerpost_vision::picture::HiddenParts;

use self::block::{Block, BlockChange, Grid, judge_changes};
use self::passing::{least_samples_per_m, raised_samples_per_m};
use super::{BLACK_BELOW, BLOCK};

/// Frames between two looks: a fifth of a second at ten frames a second, in which the road near by has gone by some samples.
const LOOK_EVERY: usize = 2;
/// Ways that a look can have, metres: from a walk's in a tenth of a second to a fast car's in a second, each 1.4 times the one before.
const WAYS: usize = 18;
const SHORTEST_WAY_M: f32 = 0.1;
/// Samples by which road goes by before a block that has not changed says anything: calibration and hills may be wrong by a factor.
const STILL_SAMPLES: f32 = 3.0;
/// Probability that a block is covered before anything is seen.
const COVERED_AT_FIRST: f32 = 0.01;
/// Probabilities that a block changes as little as what is fixed to the camera: where that is what it shows, but for rain, mirror
/// images and compression; and where road goes by, for what travels along with the camera, and chance.
const STILL_IF_FIXED: f32 = 0.95;
const STILL_IF_SCENE: f32 = 0.05;
/// The same where road has not gone by far enough: what stands on it may be nearer, and the camera may have turned.
const STILL_IF_UNKNOWN: f32 = 0.8;
/// Log-odds of 99 %: a block is covered from these on, until it is more likely not; and a look has a way.
const CERTAIN: f32 = 4.6;
const COVERED_UNTIL: f32 = 0.0;
/// Log-odds are bounded, so that dirt that is wiped off is forgotten in a few looks.
const MOST_LOG_ODDS: f32 = 6.0;
/// Those of day, so that it can make a block certain that was held for open, and a tunnel is night in two looks.
const MOST_DAY_LOG_ODDS: f32 = 2.0 * MOST_LOG_ODDS;
/// Part of what is known of a cover that stays when its block neither has texture nor is black any more: the cover may be off and the
/// sky behind it, which itself says nothing.
const KEPT: f32 = 0.5;
/// Share of the blocks that are dim, of those that are not black: by day, and at dusk or in the light of headlights. Means of simulated
/// drives with and without a cover, of cameras of three sizes: by day 0.02 to 0.06, in shade 0.13; at dusk 0.67, at night 0.65.
const DIM_BY_DAY: f32 = 0.06;
const DIM_BY_NIGHT: f32 = 0.65;
/// Blocks of a look that count as independent: the share's variance by day on the same drives is that of so many.
const INDEPENDENT_BLOCKS: f32 = 7.0;

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
    grid: Grid,
    /// What each block showed when it last changed.
    reference: Vec<u8>,
    blocks: Vec<Block>,
    changes: Vec<f32>,
    /// Black blocks of the cover that is gone through.
    together: Vec<usize>,
    frames: usize,
    /// Way since the look before by the vehicle's bus, metres; none where it did not say so in every frame.
    driven_m: Option<f32>,
    /// Log-odds of day.
    day_log_odds: f32,
    hidden: HiddenParts,
}

impl CoverWatch {
    /// A watch of the pictures of `camera`, thinned to every `nth` sample.
    pub(super) fn new(camera: &Camera, nth: usize) -> Self {
        let (columns, rows) = (camera.width().div_ceil(nth), camera.height().div_ceil(nth));
        let grid = Grid { columns, across: columns / BLOCK, down: rows / BLOCK };
        let of_block = |index: usize| {
            let place = grid.place(index);
            let passing = [least_samples_per_m, raised_samples_per_m].map(|of| of(camera, nth, place));
            Block::new(passing, log_odds(COVERED_AT_FIRST))
        };
        let count = grid.across * grid.down;
        Self {
            grid,
            reference: Vec::with_capacity(columns * rows),
            blocks: (0..count).map(of_block).collect(),
            changes: Vec::with_capacity(count),
            together: Vec::with_capacity(count),
            frames: 0,
            driven_m: Some(0.0),
            day_log_odds: 0.0,
            hidden: HiddenParts::new(grid.across, grid.down, BLOCK * nth),
        }
    }

    /// The squares that are hidden, of the picture that was thinned.
    pub(super) const fn hidden(&self) -> &HiddenParts {
        &self.hidden
    }

    /// Takes in a picture's samples, of which the differences from neighbours have a median of `noise` grey levels, and the way since
    /// the frame before by the vehicle's bus.
    pub(super) fn look_at(&mut self, samples: &[u8], noise: f64, driven_m: Option<f64>) -> Looked {
        let frames = self.frames;
        self.frames += 1;
        if frames == 0 {
            self.reference.extend_from_slice(samples);
            for (index, block) in self.blocks.iter_mut().enumerate() {
                block.texture = self.grid.texture(samples, index);
            }
            return Looked::Same;
        }
        self.driven_m = self.driven_m.zip(driven_m).map(|(way_m, driven_m)| way_m + driven_m as f32);
        if samples.len() != self.reference.len() || !frames.is_multiple_of(LOOK_EVERY) {
            return Looked::Same;
        }
        let driven_m = self.driven_m.replace(0.0);
        judge_changes((&self.grid, &mut self.blocks), (samples, &self.reference), noise, &mut self.changes);
        let way_m = self.way_m(driven_m);
        if way_m > 0.0 {
            self.weigh(way_m);
        }
        self.refer_to(samples);
        self.hide()
    }

    /// The way of this look, metres: the bus's if the blocks do not speak against it, else the shortest that they make most likely;
    /// zero where none is certain.
    fn way_m(&self, driven_m: Option<f32>) -> f32 {
        let mut gains = [0.0; WAYS];
        for block in self.blocks.iter().filter(|block| block.samples_per_m > 0.0) {
            let covered = 1.0 / (1.0 + libm::expf(-block.log_odds));
            let likelihood = |of_fixed: f32, of_scene: f32| covered * of_fixed + (1.0 - covered) * of_scene;
            let gain = match block.change_kind {
                BlockChange::Still => {
                    likelihood(STILL_IF_FIXED, STILL_IF_SCENE) / likelihood(STILL_IF_FIXED, STILL_IF_UNKNOWN)
                }
                BlockChange::Moved if block.has_texture => {
                    likelihood(1.0 - STILL_IF_FIXED, 1.0 - STILL_IF_SCENE)
                        / likelihood(1.0 - STILL_IF_FIXED, 1.0 - STILL_IF_UNKNOWN)
                }
                BlockChange::Moved | BlockChange::Black | BlockChange::Unknown => continue,
            };
            // The way from which on road must have moved by a sample.
            let from_m = (1.0 / block.samples_per_m - block.way_m).max(SHORTEST_WAY_M);
            let way = (2.0 * libm::log2f(from_m / SHORTEST_WAY_M)).ceil() as usize;
            if let Some(of_way) = gains.get_mut(way) {
                *of_way += libm::logf(gain);
            }
        }
        let (mut sum, mut best, mut of_bus) = (0.0, (0.0, 0.0), 0.0);
        for (way, gain) in gains.into_iter().enumerate() {
            let way_m = SHORTEST_WAY_M * libm::exp2f(0.5 * way as f32);
            sum += gain;
            if sum > best.0 {
                best = (sum, way_m);
            }
            if driven_m.is_some_and(|driven_m| way_m <= driven_m) {
                of_bus = sum;
            }
        }
        let seen_m = if best.0 > CERTAIN { best.1 } else { 0.0 };
        driven_m.filter(|_| of_bus >= 0.0).unwrap_or(seen_m)
    }

    /// Adds to the log-odds what the blocks say after another `way_m`.
    fn weigh(&mut self, way_m: f32) {
        let at_first = log_odds(COVERED_AT_FIRST);
        for block in &mut self.blocks {
            block.way_m += way_m;
            match block.change_kind {
                BlockChange::Moved => block.add((1.0 - STILL_IF_FIXED) / (1.0 - STILL_IF_SCENE)),
                BlockChange::Still => {
                    let from_m = (STILL_SAMPLES / block.samples_per_m).max(2.0 * block.counted_at_m);
                    if block.samples_per_m > 0.0 && block.way_m >= from_m {
                        // What travels along is still again after another metre; after twice the way that is new.
                        block.counted_at_m = block.way_m;
                        block.add(STILL_IF_FIXED / STILL_IF_SCENE);
                    }
                }
                BlockChange::Unknown if block.log_odds > at_first => {
                    block.log_odds = at_first + KEPT * (block.log_odds - at_first);
                }
                BlockChange::Black | BlockChange::Unknown => {}
            }
        }
        self.weigh_day();
        self.weigh_black();
    }

    /// Adds to the log-odds of black blocks, of each that lie together where one of them ought to show something else by now.
    fn weigh_black(&mut self) {
        // Whatever stays black does so at night: of a block that is black however often, the odds grow by one over night's probability.
        let most = log_odds(COVERED_AT_FIRST) + libm::log1pf(libm::expf(self.day_log_odds));
        let Self { grid, blocks, together, .. } = self;
        for first in 0..blocks.len() {
            if !blocks[first].is_black_and_replaced() {
                continue;
            }
            together.clear();
            together.push(first);
            blocks[first].count_black(most);
            let mut done = 0;
            while let Some(&index) = together.get(done) {
                done += 1;
                for beside in grid.beside(index) {
                    if blocks[beside].is_black_uncounted() {
                        blocks[beside].count_black(most);
                        together.push(beside);
                    }
                }
            }
        }
    }

    /// Adds to the log-odds of day what the share of dim blocks says.
    fn weigh_day(&mut self) {
        let (mut dim, mut all) = (0.0, 0.0);
        for block in
            self.blocks.iter().filter(|block| block.level >= f32::from(BLACK_BELOW) && !block.is_covered)
        {
            dim += f32::from(u8::from(block.level < f32::from(2 * BLACK_BELOW)));
            all += 1.0;
        }
        if all > 0.0 {
            let of_dim = dim / all * libm::logf(DIM_BY_DAY / DIM_BY_NIGHT);
            let of_bright = (1.0 - dim / all) * libm::logf((1.0 - DIM_BY_DAY) / (1.0 - DIM_BY_NIGHT));
            let log_odds = self.day_log_odds + INDEPENDENT_BLOCKS * (of_dim + of_bright);
            self.day_log_odds = log_odds.clamp(-MOST_DAY_LOG_ODDS, MOST_DAY_LOG_ODDS);
        }
    }

    /// Makes these samples the reference of all blocks but those that have stayed as they were.
    fn refer_to(&mut self, samples: &[u8]) {
        let Self { grid, reference, blocks, .. } = self;
        for (index, block) in blocks.iter_mut().enumerate() {
            let stays = match block.change_kind {
                BlockChange::Still => true,
                BlockChange::Black => !std::mem::take(&mut block.is_counted),
                BlockChange::Moved | BlockChange::Unknown => false,
            };
            if !stays {
                grid.copy(samples, reference, index);
                block.texture = grid.texture(samples, index);
                (block.way_m, block.counted_at_m) = (0.0, 0.0);
            }
        }
    }

    /// Hides what is covered and the blocks about it: a block changes when a part of it does, so the cover's edge lies in them. What is
    /// so near the lens is out of focus, and larger than a block: only four that are covered side by side count.
    fn hide(&mut self) -> Looked {
        let Self { grid: Grid { across, down, .. }, blocks, hidden, .. } = self;
        let mut is_any = false;
        for block in blocks.iter_mut() {
            let bound = if block.is_covered { COVERED_UNTIL } else { CERTAIN };
            block.is_covered = block.log_odds > bound;
            is_any |= block.is_covered;
        }
        if !is_any && hidden.is_empty() {
            return Looked::Same;
        }
        let is_covered = |column: usize, row: usize| {
            [0, 1].iter().all(|below| {
                blocks[(row + below) * *across + column..][..2].iter().all(|block| block.is_covered)
            })
        };
        let mut looked = Looked::Same;
        for row in 0..*down {
            for column in 0..*across {
                // The squares of four that hold this block or one beside it.
                let about = (row.saturating_sub(2)..(row + 2).min(down.saturating_sub(1))).any(|row| {
                    (column.saturating_sub(2)..(column + 2).min(across.saturating_sub(1)))
                        .any(|column| is_covered(column, row))
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

fn log_odds(probability: f32) -> f32 {
    libm::logf(probability / (1.0 - probability))
}

//! Neighbouring poses scored together.
//!
//! Poses that share drawn masks and a row of pixels read neighbouring prefix sums, 64 places at once
//! ([`RowSums::covers`]): that is what makes an exhaustive local search cheap (paper 2, section 7.2).
//!
//! [`RowSums::covers`]: fingerpost_vision::span::RowSums::covers

use fingerpost_vision::span::Cover;

use super::{LaidSurface, Participation};
use crate::feature_masks::{FeatureMasks, SubMask};

/// Places whose covers are read at once, pixels.
const BLOCK_PX: usize = 64;
/// From this many poses in a block on, reading the whole block is faster than each pose on its own.
const POSES_THAT_PAY: usize = 4;

/// Columns of the feature's node at poses in one row of pixels, and what was found of them; its memory is reused.
#[derive(Debug, Default)]
pub(crate) struct PoseRun {
    columns: Vec<i32>,
    scores: Vec<Score>,
    covers: Vec<Cover>,
}

/// What the sub-masks so far say about a pose.
#[derive(Debug, Clone, Copy)]
struct Score {
    least: f64,
    told: bool,
}

impl PoseRun {
    /// Takes all poses out.
    pub(crate) fn clear(&mut self) {
        self.columns.clear();
    }

    /// Adds a pose.
    pub(crate) fn push(&mut self, column: i32) {
        self.columns.push(column);
    }

    /// First column and number of columns from there to the last, where reading all of them pays.
    fn block(&self) -> Option<(i32, usize)> {
        let (first, last) = (*self.columns.iter().min()?, *self.columns.iter().max()?);
        let width = usize::try_from(i64::from(last) - i64::from(first) + 1).ok()?;
        (self.columns.len() >= POSES_THAT_PAY * width.div_ceil(BLOCK_PX)).then_some((first, width))
    }
}

impl LaidSurface<'_> {
    /// [`LaidSurface::score`] of each pose of `run` in `row`: P(F), or none below `at_least`, or where no arm takes part
    /// that would tell the feature from a plain road.
    pub(crate) fn score_run<'r>(
        &self,
        masks: &FeatureMasks,
        row: i32,
        run: &'r mut PoseRun,
        at_least: f64,
    ) -> impl Iterator<Item = Option<f64>> + use<'r> {
        let block = run.block();
        let PoseRun { columns, scores, covers } = run;
        scores.clear();
        scores.resize(columns.len(), Score { least: f64::INFINITY, told: false });
        // The arms that tell a feature are the ones that most poses miss.
        let (telling, others) = (
            masks.subs.iter().filter(|sub| sub.leaves_the_line),
            masks.subs.iter().filter(|sub| !sub.leaves_the_line),
        );
        for sub in telling.chain(others) {
            let mut alive =
                scores.iter_mut().zip(&*columns).filter(|(score, _)| score.least >= at_least).peekable();
            if alive.peek().is_none() {
                break;
            }
            match block {
                Some((first, width)) => {
                    covers.resize(width, Cover::default());
                    self.sums.covers(&sub.spans, first, row, covers);
                    alive.for_each(|(score, column)| {
                        self.take(sub, &covers[column.abs_diff(first) as usize], score)
                    });
                }
                None => {
                    alive.for_each(|(score, column)| {
                        self.take(sub, &self.sums.cover(&sub.spans, *column, row), score)
                    });
                }
            }
        }
        scores.iter().map(move |score| {
            (score.told && score.least.is_finite() && score.least >= at_least).then_some(score.least)
        })
    }

    /// Takes what a sub-mask covers into the score of its pose.
    fn take(&self, sub: &SubMask, cover: &Cover, score: &mut Score) {
        if self.participation(sub, cover) == Participation::TakesPart {
            score.told |= sub.leaves_the_line;
            score.least = score.least.min(cover.probability().unwrap_or(0.0));
        }
    }
}

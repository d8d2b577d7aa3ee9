//! What the paint of an edge looks like, and what does not look like it.

use super::{INNER_ROWS, Reading, Tracer, WEAK_SHARE};
use crate::Side;

/// Steps weaker than this share of the edge's strong ones are something else: a seam, worn rubber, what an old line left.
const FAINT_SHARE: f64 = 0.33;
/// How fast the memory of the strong steps fades, per frame.
const STRENGTH_KEPT: f64 = 0.97;
/// How much of a frame's width of the paint enters its memory.
const WIDTH_SHARE: f64 = 0.1;
/// Widths that paint has against its usual one; what is narrower or wider is something else.
const WIDTHS: [f64; 2] = [0.5, 1.8];
/// Share of the steps that are not among the strong ones.
const STRONG_QUANTILE: f64 = 0.75;
/// Share of the rows with paint that must show a second line for a marking to be double, and below which it is none, where
/// there are so many.
const DOUBLE_SHARE: f64 = 0.25;
const SINGLE_SHARE: f64 = 0.1;
const SINGLE_ROWS: usize = 8;

/// What the paint of an edge looks like.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct PaintLook {
    /// How much brighter than the road its clearer rows are, levels.
    pub(crate) step: f64,
    /// Width of its line, metres; 0 before any has been seen.
    pub(crate) width_m: f64,
    /// How far outside its inner edge that of a second line runs, metres, where there is one.
    pub(crate) second_m: Option<f64>,
}

impl Tracer {
    /// What the paint of a side looks like, given how it looked in the frame before.
    pub(crate) fn look(&mut self, side: Side, before: PaintLook) -> PaintLook {
        let readings = &self.readings[side.index()];
        self.steps.clear();
        self.steps.extend(readings.iter().filter_map(|reading| Some(reading.paint?.step)));
        let mut look = PaintLook { step: STRENGTH_KEPT * before.step, ..before };
        if self.steps.is_empty() {
            return look;
        }
        let rank = (STRONG_QUANTILE * (self.steps.len() - 1) as f64) as usize;
        let (_, strong, _) = self.steps.select_nth_unstable_by(rank, f64::total_cmp);
        look.step = strong.max(look.step);
        self.steps.clear();
        let strong = readings.iter().filter_map(|reading| {
            let paint = reading.paint.filter(|paint| paint.step >= WEAK_SHARE * look.step)?;
            Some(paint.width_px / reading.px_per_m)
        });
        self.steps.extend(strong);
        if !self.steps.is_empty() {
            let middle = self.steps.len() / 2;
            let (_, width_m, _) = self.steps.select_nth_unstable_by(middle, f64::total_cmp);
            let share = if before.width_m > 0.0 { WIDTH_SHARE } else { 1.0 };
            look.width_m += share * (*width_m - look.width_m);
        }
        look
    }

    /// Drops what does not look like a side's paint; of a double marking, what shows no second line beside it, because that
    /// may be the second line itself.
    pub(crate) fn drop_unlike(&mut self, side: Side, look: &mut PaintLook) {
        let readings = &mut self.readings[side.index()];
        for reading in readings.iter_mut() {
            let px_per_m = reading.px_per_m;
            reading.paint = reading.paint.filter(|paint| {
                // A pixel more or less is no difference; before any has been seen every width is right.
                let [least, most] = WIDTHS.map(|share| share * look.width_m * px_per_m);
                let widths = if look.width_m > 0.0 { least - 1.0..=most + 1.0 } else { 0.0..=f64::INFINITY };
                paint.step >= FAINT_SHARE * look.step && widths.contains(&paint.width_px)
            });
        }
        self.steps.clear();
        self.steps.extend(readings.iter().filter_map(Reading::second_m));
        let painted = readings.iter().filter(|reading| reading.paint.is_some()).count();
        let doubled = self.steps.len() as f64;
        if self.steps.len() >= INNER_ROWS && doubled >= DOUBLE_SHARE * painted as f64 {
            let middle = self.steps.len() / 2;
            look.second_m = Some(*self.steps.select_nth_unstable_by(middle, f64::total_cmp).1);
        } else if painted >= SINGLE_ROWS && doubled < SINGLE_SHARE * painted as f64 {
            look.second_m = None;
        }
        if look.second_m.is_some() {
            readings.iter_mut().filter(|r| r.second_m().is_none()).for_each(|reading| reading.paint = None);
        }
    }
}

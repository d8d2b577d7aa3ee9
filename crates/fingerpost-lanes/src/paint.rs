//! Paint on the road: a bright bar as wide as markings are, whose inner edge is found to a fraction of a pixel.
//!
//! Rows of the camera's own picture are read where an edge is expected. An edge of paint rises towards the outside and falls
//! again within a marking's width; the step of a kerb or a shadow does not fall again.

mod sides;

use self::sides::BarPlace;
use super::Side;

pub(super) use self::sides::PaintSides;

/// Widths that markings have, metres: a worn narrow line to a wide one.
pub(super) const PAINT_WIDTH_M: [f64; 2] = [0.05, 0.42];
/// Length over which brightness is averaged on either side of a step, metres.
const SIDE_M: f64 = 0.05;
/// The same in pixels.
const SIDE_PX: [f64; 2] = [1.0, 8.0];
/// Length beside paint that is held against it, in those lengths: past a dark seam, short of the next line.
const BESIDE: usize = 3;
/// How much of a step there must be between the paint as a whole and the road inside it: a seam's rise is none.
const BODY_SHARE: f32 = 0.6;
/// Least step that counts, grey levels.
const LEAST_STEP: f32 = 8.0;
/// A step must stand out from the common steps of its surroundings by this factor.
const STANDS_OUT: f32 = 2.5;
/// How much of the rise there must be of a fall on the other side: roads differ on both sides of a line.
const FALL_SHARE: f32 = 0.45;
/// Of several bars beside each other the innermost counts that is at least so strong against the strongest.
const INNER_SHARE: f32 = 0.5;
/// Most pixels that a row is read over.
const MOST_PX: usize = 400;

/// Where the inner edge of paint is in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PaintEdge {
    /// Column, pixels.
    pub(super) u: f64,
    /// Width of the bar, pixels.
    pub(super) width_px: f64,
    /// How much brighter it is than the road, levels.
    pub(super) step: f64,
    /// How much further outside another bar begins, pixels, where one does within reach.
    pub(super) second_px: Option<f64>,
    /// Its colour and those beside it.
    pub(super) sides: PaintSides,
}

impl PaintEdge {
    /// How much yellower than the road it is: the gain of red and green over that of blue, levels.
    pub(super) fn yellowness(&self) -> f64 {
        let gain = |channel: usize| self.sides.paint[channel] - self.sides.inside[channel];
        0.5 * (gain(0) + gain(1)) - gain(2)
    }
}

/// Where in a row paint is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct PaintSearch {
    pub(super) side: Side,
    /// Column at which the inner edge is expected, pixels.
    pub(super) expected_u: f64,
    /// How far to either side of that it may be, pixels.
    pub(super) reach_px: f64,
    /// Pixels that a metre across the lane takes in this row.
    pub(super) px_per_m: f64,
}

/// Finds paint, with the buffers that it needs.
#[derive(Debug, Default)]
pub(super) struct PaintFinder {
    /// Sums of the levels from the window's inner end outwards, thirds of a level.
    sums: Vec<i32>,
    steps: Vec<f32>,
    /// The steps' amounts as bits, which order as the amounts do.
    sorted: Vec<u32>,
    bars: Vec<Bar>,
}

#[derive(Debug, Clone, Copy)]
struct Bar {
    rise: usize,
    fall: usize,
    step: f32,
}

impl PaintFinder {
    /// The inner edge of the paint in an RGB `row`, where there is one.
    pub(super) fn find(&mut self, row: &[u8], search: &PaintSearch) -> Option<PaintEdge> {
        let outward = search.side.outward();
        let side_px = (SIDE_M * search.px_per_m).clamp(SIDE_PX[0], SIDE_PX[1]).round();
        let widths = PAINT_WIDTH_M.map(|metres| metres * search.px_per_m);
        let (narrowest, widest) = (widths[0].floor().max(1.0), widths[1].ceil().max(2.0));
        let margin_px = (BESIDE as f64 + 1.0) * side_px + 2.0;
        let inner = (search.expected_u - outward * (search.reach_px + margin_px)).round();
        let count = (2.0 * search.reach_px + widest + 2.0 * margin_px).ceil();
        let columns = row.len() / 3;
        if !(inner >= 0.0 && inner < columns as f64 && count < MOST_PX as f64) {
            return None;
        }
        let room = if outward > 0.0 { columns - inner as usize } else { inner as usize + 1 };
        let (inner, count) = (inner as usize, (count as usize).min(room));
        let side = side_px as usize;
        let column = |index: usize| if outward > 0.0 { inner + index } else { inner - index };
        let from = if outward > 0.0 { inner } else { inner + 1 - count };
        let pixels = row.as_chunks().0.get(from..from + count)?;
        let mut sum = 0;
        let mut up_to = |pixel: &[u8; 3]| {
            sum += level_thirds(pixel);
            sum
        };
        self.sums.clear();
        self.sums.push(0);
        if outward > 0.0 {
            self.sums.extend(pixels.iter().map(up_to));
        } else {
            self.sums.extend(pixels.iter().rev().map(&mut up_to));
        }
        // A step lies between two pixels: step[i] is the one before pixel i.
        self.steps.clear();
        self.steps.resize(count + 1, 0.0);
        let level = 1.0 / (3 * side) as f32;
        let sums_from = |index: usize| self.sums.get(index..).unwrap_or_default();
        let ends = sums_from(0).iter().zip(sums_from(side)).zip(sums_from(2 * side));
        for (step, ((inner, middle), outer)) in self.steps.iter_mut().skip(side).zip(ends) {
            *step = (outer - 2 * middle + inner) as f32 * level;
        }
        // Most rows show no paint.
        if self.steps.iter().all(|step| *step < LEAST_STEP) {
            return None;
        }
        let threshold = self.threshold(side);
        let most_rise = (2.0 * search.reach_px + margin_px + 2.0) as usize;
        self.collect_bars(threshold, [narrowest as usize, widest as usize], most_rise, side);
        let strongest = self.bars.iter().map(|bar| bar.step).fold(0.0, f32::max);
        let (index, bar) =
            self.bars.iter().copied().enumerate().find(|(_, bar)| bar.step >= INNER_SHARE * strongest)?;
        let rise = self.refined(bar.rise, 1.0);
        let fall = self.refined(bar.fall, -1.0);
        let second = self.bars[index + 1..]
            .iter()
            .find(|next| next.rise > bar.fall && next.step >= INNER_SHARE * bar.step);
        let beyond = second.map_or(count, |next| next.rise).min(count);
        let place = BarPlace {
            side: search.side,
            first: column(bar.rise),
            width_px: bar.fall - bar.rise,
            outside_px: BESIDE * side,
            room_px: beyond.saturating_sub(bar.fall + 1),
            px_per_m: search.px_per_m,
        };
        Some(PaintEdge {
            u: inner as f64 + outward * (rise - 0.5),
            width_px: fall - rise,
            step: f64::from(bar.step),
            second_px: second.map(|next| next.rise as f64 - rise),
            sides: PaintSides::read(row, &place),
        })
    }

    /// The least step that is more than the texture of the road.
    fn threshold(&mut self, side: usize) -> f32 {
        self.sorted.clear();
        let end = self.steps.len().saturating_sub(side);
        self.sorted
            .extend(self.steps.get(side..end).unwrap_or_default().iter().map(|step| step.abs().to_bits()));
        if self.sorted.is_empty() {
            return f32::INFINITY;
        }
        // Paint may take half of the window: the lower third is road.
        let third = self.sorted.len() / 3;
        let (_, common, _) = self.sorted.select_nth_unstable(third);
        (STANDS_OUT * f32::from_bits(*common)).max(LEAST_STEP)
    }

    /// Rises, from the inside outwards, that are followed by a fall within a marking's width.
    fn collect_bars(
        &mut self,
        threshold: f32,
        [narrowest, widest]: [usize; 2],
        most_rise: usize,
        side: usize,
    ) {
        self.bars.clear();
        let steps = &self.steps;
        for i in 1..steps.len().saturating_sub(1) {
            let rise = steps[i];
            if rise < threshold || rise < steps[i - 1] || rise <= steps[i + 1] {
                continue;
            }
            let deep = (FALL_SHARE * rise).max(0.7 * threshold);
            let last = (i + widest).min(steps.len() - 2);
            let is_fall =
                |&at: &usize| -steps[at] >= deep && steps[at] <= steps[at - 1] && steps[at] < steps[at + 1];
            let Some(fall) = ((i + narrowest)..=last).find(is_fall) else { continue };
            // A stronger rise before the fall makes this one a part of that bar's inside.
            if steps[i + 1..fall].iter().any(|&later| later > rise) {
                continue;
            }
            let paint = self.mean(i, fall);
            let (inside, outside) =
                (self.mean(i.saturating_sub(BESIDE * side), i), self.mean(fall, fall + BESIDE * side));
            let step = paint - inside;
            if step < (BODY_SHARE * rise).max(0.8 * threshold) || paint - outside < FALL_SHARE * step {
                continue;
            }
            // The first bar beyond the search is kept too, as the second line of a double one.
            let beyond = self.bars.last().is_some_and(|last: &Bar| last.rise > most_rise);
            if i > most_rise && (self.bars.is_empty() || beyond) {
                break;
            }
            self.bars.push(Bar { rise: i, fall, step });
        }
    }

    /// Mean level from one pixel up to, not including, another.
    fn mean(&self, from: usize, to: usize) -> f32 {
        let to = to.min(self.sums.len() - 1);
        let from = from.min(to);
        (self.sums[to] - self.sums[from]) as f32 / (3 * (to - from).max(1)) as f32
    }

    /// The place of an extreme step between its neighbours.
    fn refined(&self, at: usize, sign: f32) -> f64 {
        let value = |i: usize| f64::from(sign * self.steps.get(i).copied().unwrap_or(0.0));
        let (before, peak, after) = (value(at.wrapping_sub(1)), value(at), value(at + 1));
        let bend = before - 2.0 * peak + after;
        let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        at as f64 + shift.clamp(-0.5, 0.5)
    }
}

/// Red, and a third of what it is more than blue, in thirds: white and yellow paint both stand out in it, yellow on light concrete too.
fn level_thirds(&[red, _, blue]: &[u8; 3]) -> i32 {
    4 * i32::from(red) - i32::from(blue)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grey row with bars `[from, to)` of another grey, edges at fractions of a pixel.
    fn row(bars: &[([f64; 2], u8)]) -> Vec<u8> {
        let mut row = Vec::new();
        for column in 0..200 {
            let (low, high) = (column as f64 - 0.5, column as f64 + 0.5);
            let mut value = 80.0;
            for ([from, to], level) in bars {
                let share = (to.min(high) - from.max(low)).max(0.0);
                value += share * (f64::from(*level) - 80.0);
            }
            row.extend([value.round() as u8; 3]);
        }
        row
    }

    fn search(side: Side, expected_u: f64) -> PaintSearch {
        PaintSearch { side, expected_u, reach_px: 12.0, px_per_m: 60.0 }
    }

    #[test]
    fn the_inner_edge_is_found_on_either_side_to_a_fraction_of_a_pixel() {
        let row = row(&[([60.3, 68.6], 200), ([130.7, 138.2], 200)]);
        let left = PaintFinder::default().find(&row, &search(Side::Left, 65.0)).unwrap();
        assert!((left.u - 68.6).abs() < 0.15, "{left:?}");
        assert!((left.width_px - 8.3).abs() < 0.5, "{left:?}");
        let right = PaintFinder::default().find(&row, &search(Side::Right, 134.0)).unwrap();
        assert!((right.u - 130.7).abs() < 0.15, "{right:?}");
        assert_eq!(right.second_px, None);
    }

    #[test]
    fn a_step_that_does_not_fall_again_is_no_paint() {
        let kerb = row(&[([0.0, 68.0], 160)]);
        assert_eq!(PaintFinder::default().find(&kerb, &search(Side::Left, 66.0)), None);
        let even = row(&[]);
        assert_eq!(PaintFinder::default().find(&even, &search(Side::Left, 66.0)), None);
    }

    #[test]
    fn the_far_edge_of_a_dark_seam_is_no_paint() {
        let seam = row(&[([60.0, 65.0], 30)]);
        assert_eq!(PaintFinder::default().find(&seam, &search(Side::Left, 60.0)), None);
    }

    #[test]
    fn of_a_double_line_the_inner_one_counts_and_the_other_is_told() {
        let row = row(&[([100.0, 107.0], 190), ([114.0, 121.0], 200)]);
        let found = PaintFinder::default().find(&row, &search(Side::Right, 102.0)).unwrap();
        assert!((found.u - 100.0).abs() < 0.6, "{found:?}");
        assert!((found.second_px.unwrap() - 14.0).abs() < 1.5, "{found:?}");
    }

    #[test]
    fn yellow_paint_is_yellower_than_the_road() {
        let mut row = row(&[([60.0, 68.0], 200)]);
        for column in 61..67 {
            row[3 * column + 2] = 60;
        }
        let found = PaintFinder::default().find(&row, &search(Side::Left, 67.0)).unwrap();
        assert!(found.yellowness() > 60.0, "{found:?}");
    }

    #[test]
    fn what_lies_outside_the_picture_is_not_read() {
        let row = row(&[([0.0, 4.0], 200)]);
        let mut finder = PaintFinder::default();
        for expected_u in [-50.0, -3.0, 2.0, 198.0, 260.0, f64::NAN] {
            for side in [Side::Left, Side::Right] {
                finder.find(&row, &search(side, expected_u));
            }
        }
        assert_eq!(finder.find(&[], &search(Side::Left, 0.0)), None);
    }
}

//! What lies under a piece of an arm against its shift across the road, and where in it the road's edges are.
//!
//! An edge is a step of the probability, not a level of it: on real streets the level under the road is as low as that of
//! a verge elsewhere.

use std::ops::RangeInclusive;

use super::mean;

/// Mean probability, or grey value, under a piece at a shift to the left, metres; none where too little is seen.
pub(super) type Sample = (f64, Option<f64>);

/// Changes of the level of at least this share of the greatest are as great.
const SAME_CHANGE: f64 = 0.95;
/// Share of the greatest step that makes an edge: behind the verge may stand a wall, whose foot is a greater step.
const MUCH_OF_GREATEST: f64 = 0.7;
/// Places whose level is within this of the highest are as much road as it.
const AS_MUCH_ROAD: f64 = 0.05;

/// Share of the pieces that must be seen at a shift for their mean to count.
const MOST_PIECES: f64 = 0.7;

/// Samples from right to left, of one piece or summed over several; its memory is reused.
#[derive(Debug, Default)]
pub(super) struct Profile {
    shifts_m: Vec<f64>,
    /// Sum and number of the seen samples at each shift.
    samples: Vec<(f64, f64)>,
    /// Sum of the means, and number of the shifts at which something is seen, before each shift and before the end.
    before: Vec<(f64, f64)>,
}

impl Profile {
    /// Takes samples in place of those before, evenly spaced.
    pub(super) fn take(&mut self, samples: impl Iterator<Item = Sample>) {
        self.clear();
        for (shift_m, p) in samples {
            self.shifts_m.push(shift_m);
            self.samples.push(p.map_or((0.0, 0.0), |p| (p, 1.0)));
        }
        self.add_up();
    }

    /// Takes all samples out.
    pub(super) fn clear(&mut self) {
        self.shifts_m.clear();
        self.samples.clear();
        self.before.clear();
    }

    /// Adds the samples of another piece at the same shifts.
    pub(super) fn add(&mut self, other: &Self) {
        if self.samples.is_empty() {
            self.shifts_m.extend_from_slice(&other.shifts_m);
            self.samples.extend_from_slice(&other.samples);
        } else {
            for (own, other) in self.samples.iter_mut().zip(&other.samples) {
                *own = (own.0 + other.0, own.1 + other.1);
            }
        }
        self.add_up();
    }

    fn add_up(&mut self) {
        self.before.clear();
        self.before.push((0.0, 0.0));
        // Where fewer of the pieces are seen their mean is that of another part of the arm.
        let least = MOST_PIECES * self.samples.iter().map(|(_, count)| *count).fold(0.0, f64::max);
        let (mut sum, mut seen) = (0.0, 0.0);
        for &(p, count) in &self.samples {
            if count > 0.0 && count >= least {
                (sum, seen) = (sum + p / count, seen + 1.0);
            }
            self.before.push((sum, seen));
        }
    }

    /// The left and right edge of the road, metres to the left, from samples `step_m` apart: the places, outwards from
    /// what is most road, at which the probability falls by at least `min_step` from the mean over `window_m` to the next. The innermost fall that is much of the
    /// greatest counts. The end of what is seen is no edge.
    pub(super) fn edges_m(&self, step_m: f64, window_m: f64, min_step: f64) -> [Option<f64>; 2] {
        let window = (window_m / step_m).round().max(2.0) as usize;
        let Some(middle) = self.most_road(window) else { return [None, None] };
        let left = innermost(min_step, middle + 1..self.shifts_m.len(), |i| self.fall(i, window));
        let right = innermost(min_step, (1..=middle).rev(), |i| self.fall(i, window).map(|fall| -fall));
        [left, right].map(|edge| edge.map(|i| 0.5 * (self.shifts_m[i - 1] + self.shifts_m[i])))
    }

    /// The place in `between_m` at which the level changes most, and by what share of the levels' sum: from the mean over
    /// `window_m` on one side to that on the other, but for `gap_m` next to it; none where too little is seen.
    pub(super) fn greatest_change(
        &self,
        step_m: f64,
        (window_m, gap_m): (f64, f64),
        between_m: &RangeInclusive<f64>,
    ) -> Option<(f64, f64)> {
        let window = (window_m / step_m).round().max(2.0) as usize;
        let gap = (gap_m / step_m).round() as usize;
        let end = self.shifts_m.len();
        let change = |i: usize| {
            let right = self.level(i.saturating_sub(window + gap), i.saturating_sub(gap), window)?;
            let left = self.level((i + gap).min(end), (i + gap + window).min(end), window)?;
            Some((left - right).abs() / (left + right).max(f64::EPSILON))
        };
        let changes = || {
            (1..end)
                .map(|i| (i, 0.5 * (self.shifts_m[i - 1] + self.shifts_m[i])))
                .filter(|(_, at_m)| between_m.contains(at_m))
                .filter_map(|(i, at_m)| Some((at_m, change(i)?)))
        };
        let (best_m, share) = changes().max_by(|a, b| a.1.total_cmp(&b.1))?;
        // A sharp step is about as great wherever it lies in the gap: the middle of those places counts.
        let is_same =
            |(at_m, s): &(f64, f64)| *s >= SAME_CHANGE * share && (at_m - best_m).abs() <= 2.5 * gap_m;
        Some((mean(changes().filter(is_same).map(|(at_m, _)| at_m))?, share))
    }

    /// The shifts of the samples, metres to the left.
    pub(super) fn shifts_m(&self) -> &[f64] {
        &self.shifts_m
    }

    /// Whether the samples within `window_m` of a place, `step_m` apart, are seen, or half of them.
    pub(super) fn is_seen_at(&self, at_m: f64, step_m: f64, window_m: f64) -> bool {
        let window = (window_m / step_m).round() as usize;
        let at = self.shifts_m.partition_point(|shift_m| *shift_m < at_m);
        let end = (at + window).min(self.shifts_m.len());
        self.level(at.saturating_sub(window), end, 2 * window).is_some()
    }

    /// Mean of the seen samples from `start` to before `end`; none of fewer than half a window.
    pub(super) fn level(&self, start: usize, end: usize, window: usize) -> Option<f64> {
        let ((sum, count), (sum_before, before)) = (*self.before.get(end)?, *self.before.get(start)?);
        (2.0 * (count - before) >= window as f64).then(|| (sum - sum_before) / (count - before))
    }

    /// How far the probability falls from right to left between samples `i - 1` and `i`.
    fn fall(&self, i: usize, window: usize) -> Option<f64> {
        let right = self.level(i.saturating_sub(window), i, window)?;
        Some(right - self.level(i, (i + window).min(self.shifts_m.len()), window)?)
    }

    /// The sample about which there is most road; of several, the one nearest to where the arm is believed.
    fn most_road(&self, window: usize) -> Option<usize> {
        let about = |i: usize| {
            let (start, end) = (i.saturating_sub(window / 2), (i + window / 2 + 1).min(self.shifts_m.len()));
            self.level(start, end, window)
        };
        let levels = || (0..self.shifts_m.len()).filter_map(|i| Some((i, about(i)?)));
        let highest = levels().map(|(_, level)| level).max_by(f64::total_cmp)?;
        let (middle, _) = levels()
            .filter(|(_, level)| *level >= highest - AS_MUCH_ROAD)
            .min_by(|a, b| self.shifts_m[a.0].abs().total_cmp(&self.shifts_m[b.0].abs()))?;
        Some(middle)
    }
}

/// The first place at which `fall` is much of its greatest and no longer grows; none where none reaches `min_step`.
fn innermost(
    min_step: f64,
    places: impl Iterator<Item = usize> + Clone,
    fall: impl Fn(usize) -> Option<f64>,
) -> Option<usize> {
    let falls = places.filter_map(|i| Some((i, fall(i)?)));
    let greatest = falls.clone().map(|(_, fall)| fall).max_by(f64::total_cmp)?;
    if greatest < min_step {
        return None;
    }
    let mut edge: Option<(usize, f64)> = None;
    for (i, fall) in falls.skip_while(|(_, fall)| *fall < MUCH_OF_GREATEST * greatest) {
        if edge.is_some_and(|(_, highest)| fall < highest) {
            break;
        }
        edge = Some((i, fall));
    }
    edge.map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges_m(p: impl Fn(f64) -> Option<f64>) -> [Option<f64>; 2] {
        let mut profile = Profile::default();
        profile.take((-50..=50).map(|k| 0.1 * f64::from(k)).map(|x| (x, p(x))));
        profile.edges_m(0.1, 0.8, 0.15)
    }

    fn near(edge: Option<f64>, expected_m: f64) -> bool {
        edge.is_some_and(|m| (m - expected_m).abs() < 0.06)
    }

    #[test]
    fn edges_are_found_over_holes_and_at_any_level() {
        for (road, verge) in [(0.95, 0.1), (0.5, 0.25)] {
            let hole = road - 0.5 * (road - verge);
            let p = |x: f64| match x {
                x if (0.0..0.3).contains(&x) => hole,
                x if (-2.05..2.95).contains(&x) => road,
                _ => verge,
            };
            let [left, right] = edges_m(|x| Some(p(x)));
            assert!(near(left, 2.95) && near(right, -2.05), "{left:?} {right:?}");
        }
    }

    #[test]
    fn the_kerb_is_the_edge_not_the_wall_behind_the_pavement() {
        let p = |x: f64| {
            if x.abs() < 2.55 {
                0.75
            } else if x.abs() < 4.05 {
                0.4
            } else {
                0.0
            }
        };
        let [left, right] = edges_m(|x| Some(p(x)));
        assert!(near(left, 2.55) && near(right, -2.55), "{left:?} {right:?}");
    }

    #[test]
    fn the_greatest_change_is_where_the_levels_differ_most() {
        let mut profile = Profile::default();
        let grey = |x: f64| if x < 1.48 { 0.3 + 0.01 * x } else { 0.4 + 0.01 * x };
        profile.take((-50..=50).map(|k| 0.1 * f64::from(k)).map(|x| (x, (x < 4.0).then(|| grey(x)))));
        let (at_m, share) = profile.greatest_change(0.1, (0.5, 0.1), &(-3.0..=3.0)).unwrap();
        assert!((at_m - 1.45).abs() < 0.06 && (share - 1.0 / 7.0).abs() < 0.01, "{at_m} {share}");
        assert_eq!(profile.greatest_change(0.1, (0.5, 0.1), &(4.5..=4.8)), None, "out of view");
    }

    #[test]
    fn a_place_is_seen_where_half_of_what_is_about_it_is() {
        let mut profile = Profile::default();
        profile.take((-50..=50).map(|k| 0.1 * f64::from(k)).map(|x| (x, (x < 1.95).then_some(0.5))));
        let is_seen = |at_m: f64| profile.is_seen_at(at_m, 0.1, 0.3);
        assert!(is_seen(-5.0) && is_seen(0.0) && is_seen(1.9), "in view");
        assert!(!is_seen(2.2) && !is_seen(4.0) && !is_seen(9.0), "out of view");
        assert!(!Profile::default().is_seen_at(0.0, 0.1, 0.3));
    }

    #[test]
    fn a_plane_without_edges_measures_nothing() {
        assert_eq!(edges_m(|_| Some(0.9)), [None, None]);
        assert_eq!(edges_m(|x| Some(0.5 - 0.02 * x)), [None, None], "a gentle slope is none");
        assert_eq!(edges_m(|_| None), [None, None]);
        let [left, right] = edges_m(|x| (x > -1.0).then_some(if x < 1.95 { 0.9 } else { 0.0 }));
        assert!(near(left, 1.95) && right.is_none(), "the right edge is out of view");
    }
}

//! Frames that repeat the one before, and frames that are missing between two, by how far the vehicle came meanwhile.
//!
//! A camera's ways from frame to frame are alike as long as it takes its pictures in time. Where some are whole multiples of the
//! others, or none at all, and neither a tyre within a frame nor the noise of the ways could have brought that about, it is the
//! recording that was filled or has lost something: 20 frames a second written as 30, or frames that were dropped on the way.
//!
//! A vehicle stops and starts slowly. Pictures that repeat beside one in which it is fast are no stand, however many they are: the step
//! behind them makes up for their ways, or, where it is too long to be seen, hides them. They count as ordinary intervals then, and as
//! open, unless the step is seen behind as many others.
//!
//! A way stands for the whole number of intervals that is nearest to it, as long as its noise leaves that number to be counted.
//!
//! Limits: what happens to every frame alike, as every second one lost, does not show, nor a frame that is missing where the road's
//! motion is too far to be followed.

use std::ops::Range;

use super::angles::MAD_TO_SIGMA;
use super::way::LENGTH_FLOOR;

/// How often the camera's own interval lies between a frame and the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interval {
    /// So often: 0 for a frame that repeats the one before, 2 where one is missing between them.
    Times(u32),
    /// More often than the noise of the ways lets be counted.
    Several,
    /// The way cannot be seen.
    Unknown,
    /// It is one of frames that repeat the one before, or the one behind them, whose way cannot be seen.
    Hidden,
    /// The vehicle stands.
    Standing,
}

/// What the ways say of a drive's frames.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cadence {
    /// Frames that repeat the one before.
    pub(super) repeated: usize,
    /// Frames that are missing between others, at least.
    pub(super) missing: usize,
    /// Intervals of the camera in one of the recording, on the mean; none where there are more than can be counted.
    pub(super) intervals_per_frame: Option<f64>,
    /// Share of the frames whose way is not seen and may be that of several intervals: hidden ones, and where a frame is missing all, as
    /// the longer a way is, the less of it is seen.
    pub(super) unseen_share: f64,
    /// Way of each frame but the first, for an interval of the mean length.
    pub(super) ways: Vec<f64>,
}

/// What a frame shows of the way since the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeenWay {
    /// In any unit, for an interval of the mean length; zero for a vehicle that stands, none where it cannot be told.
    pub(super) way: Option<f64>,
    /// The shortest way that would have shown in its place; zero where none is seen.
    pub(super) least: f64,
    /// Whether the picture is the one before.
    pub(super) is_still: bool,
}

/// What is seen nearest before and behind frames without a way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beside {
    /// Nothing.
    Unseen,
    /// A frame from whose speed a vehicle can stop, or that it can have after the first frame of a start.
    Slow,
    /// Only frames that are faster than that.
    Fast,
}

impl Beside {
    /// Beside the frames `run`; `least_jump` is the change of the way from one frame to the next that no tyre brings about.
    pub(super) fn of(seen: &[SeenWay], run: Range<usize>, least_jump: f64) -> Self {
        // From the nearest way that is seen there are so many frames to stop in, or to start.
        let is_slow = |(between, seen): (usize, &SeenWay)| {
            let way = seen.way.filter(|_| !seen.is_still)?;
            Some(way <= least_jump * (between + 1) as f64 + seen.least)
        };
        let (before, behind) = (seen.get(..run.start), seen.get(run.end..));
        let before = before.and_then(|seen| seen.iter().rev().enumerate().find_map(is_slow));
        let sides = [before, behind.and_then(|seen| seen.iter().enumerate().find_map(is_slow))];
        match (sides.iter().flatten().any(|is_slow| *is_slow), sides.iter().any(Option::is_some)) {
            (true, _) => Self::Slow,
            (false, true) => Self::Fast,
            (false, false) => Self::Unseen,
        }
    }
}

/// Ways of which one is twice the other lie on different sides of this ratio.
const ONE_OR_TWO: f64 = std::f64::consts::SQRT_2;
/// Least number of ways that set the camera's own interval: one alone may be an outlier.
const LEAST_ALIKE: usize = 2;

impl Cadence {
    /// Of the ways from each frame to the next; `least_jump` is the change of the way from one frame to the next that no tyre brings
    /// about. None where every frame comes once and none is missing.
    pub(super) fn of(seen: &[SeenWay], least_jump: f64) -> Option<Self> {
        let reach = reach(seen, least_jump);
        let mut units: Vec<Option<f64>> = (0..seen.len()).map(|frame| unit(seen, frame, reach)).collect();
        // Where too little is seen, as in the nearest place where enough is: first the one before, else the one behind.
        for frame in 1..units.len() {
            units[frame] = units[frame].or(units[frame - 1]);
        }
        for frame in (1..units.len()).rev() {
            units[frame - 1] = units[frame - 1].or(units[frame]);
        }
        let resolution = Resolution::of(seen, &units, least_jump);
        let mut intervals: Vec<Interval> =
            seen.iter().zip(&units).map(|(seen, unit)| resolution.interval(seen, *unit)).collect();
        mark_repeated(seen, least_jump, &mut intervals);
        let several = intervals.iter().filter(|interval| **interval == Interval::Several).count();
        let count_of = |of: &dyn Fn(u32) -> usize| -> usize {
            intervals.iter().map(|interval| if let Interval::Times(n) = interval { of(*n) } else { 0 }).sum()
        };
        let hidden = intervals.iter().filter(|interval| **interval == Interval::Hidden).count();
        let is_repeated =
            |(interval, seen): &(&Interval, &SeenWay)| seen.is_still && **interval != Interval::Standing;
        let repeated = intervals.iter().zip(seen).filter(is_repeated).count();
        let missing = several + count_of(&|times| (times as usize).saturating_sub(1));
        if repeated + missing == 0 {
            return None;
        }
        let (known, total) = (count_of(&|_| 1), count_of(&|times| times as usize));
        let intervals_per_frame = total as f64 / known.max(1) as f64;
        let ways = seen.iter().zip(&units).zip(&intervals).map(|((seen, unit), interval)| match interval {
            Interval::Times(times) => unit.unwrap_or_default() * f64::from(*times),
            Interval::Several => seen.way.unwrap_or_default(),
            Interval::Standing => 0.0,
            Interval::Unknown | Interval::Hidden => unit.unwrap_or_default() * intervals_per_frame,
        });
        let unknown = intervals.iter().filter(|interval| **interval == Interval::Unknown).count();
        let unseen = hidden + if missing > 0 { unknown } else { 0 };
        Some(Self {
            repeated,
            missing,
            intervals_per_frame: (several == 0).then_some(intervals_per_frame),
            unseen_share: unseen as f64 / seen.len() as f64,
            ways: ways.collect(),
        })
    }
}

/// Frames to either side whose ways a frame's own is compared with: as many as no tyre can change a typical way in so far that one
/// interval would be taken for two.
fn reach(seen: &[SeenWay], least_jump: f64) -> usize {
    let mut ways: Vec<f64> = seen.iter().filter_map(|seen| seen.way).filter(|way| *way > 0.0).collect();
    let middle = ways.len() / 2;
    let typical = if ways.is_empty() { 0.0 } else { *ways.select_nth_unstable_by(middle, f64::total_cmp).1 };
    (((ONE_OR_TWO - 1.0) * typical / least_jump) as usize).max(1)
}

/// The way of one of the camera's own intervals about a frame: the middle of the shortest ways that are alike and not fewer than half of
/// its neighbours. None where too few are seen.
fn unit(seen: &[SeenWay], frame: usize, reach: usize) -> Option<f64> {
    let width = reach.saturating_mul(2).saturating_add(1).min(seen.len());
    let start = frame.saturating_sub(reach).min(seen.len() - width);
    let near = &seen[start..start + width];
    let mut ways: Vec<f64> = near.iter().filter_map(|near| near.way).filter(|way| *way > 0.0).collect();
    ways.sort_unstable_by(f64::total_cmp);
    let alike = ways.chunk_by(|shorter, longer| *longer < ONE_OR_TWO * shorter);
    let unit =
        alike.into_iter().find(|alike| alike.len() >= LEAST_ALIKE && 2 * alike.len() + 1 >= ways.len())?;
    unit.get(unit.len() / 2).copied()
}

/// What ways can be told from others by.
#[derive(Debug, Clone, Copy)]
struct Resolution {
    /// The change of the way from one frame to the next that no tyre brings about.
    least_jump: f64,
    /// Standard deviation of a way, as a share of it.
    noise: f64,
    /// The standard deviations by which the noisiest of so many ways is expected to be off.
    most_sigmas: f64,
}

impl Resolution {
    /// By the ways that are alike to the middle of their neighbours.
    fn of(seen: &[SeenWay], units: &[Option<f64>], least_jump: f64) -> Self {
        let ratios = seen.iter().zip(units).filter_map(|(seen, unit)| Some(seen.way? / (*unit)?));
        let alike = ratios.filter(|ratio| (1.0 / ONE_OR_TWO..ONE_OR_TWO).contains(ratio));
        let mut off: Vec<f64> = alike.map(|ratio| (ratio - 1.0).abs()).collect();
        let middle = off.len() / 2;
        let noise = if off.is_empty() { 0.0 } else { *off.select_nth_unstable_by(middle, f64::total_cmp).1 };
        // Of n values of a Gaussian the largest is near to this.
        let most_sigmas = (2.0 * libm::log(off.len().max(1) as f64)).sqrt();
        Self { least_jump, noise: (MAD_TO_SIGMA * noise).max(LENGTH_FLOOR), most_sigmas }
    }

    fn interval(&self, seen: &SeenWay, unit: Option<f64>) -> Interval {
        match (seen.way, unit) {
            (Some(way), Some(unit)) if way > 0.0 => {
                let least_jump = self.least_jump.max(self.most_sigmas * self.noise * unit);
                let times = if way - unit > least_jump { (way / unit).round().max(1.0) } else { 1.0 };
                // The noise of a longer way is more than half an interval.
                let is_countable = times <= 1.0 || times * self.noise <= 0.5;
                if is_countable { Interval::Times(times as u32) } else { Interval::Several }
            }
            (Some(_), _) => Interval::Standing,
            (None, _) => Interval::Unknown,
        }
    }
}

/// Marks still frames beside others that are seen to move as repeated, where the vehicle could neither have stopped nor started so. What
/// follows them may make up for them: where its way is unknown, so are theirs, and hidden unless it is known behind as many others.
fn mark_repeated(seen: &[SeenWay], least_jump: f64, intervals: &mut [Interval]) {
    let (mut start, mut frozen) = (0, Vec::new());
    for run in seen.chunk_by(|a, b| a.is_still == b.is_still) {
        let end = start + run.len();
        let is_still = run.first().is_some_and(|seen| seen.is_still);
        if is_still && Beside::of(seen, start..end, least_jump) == Beside::Fast {
            frozen.push(start..end);
        }
        start = end;
    }
    let (known, unknown): (Vec<_>, Vec<_>) = frozen
        .into_iter()
        .partition(|run| intervals.get(run.end).is_some_and(|behind| *behind != Interval::Unknown));
    for run in &known {
        intervals[run.clone()].fill(Interval::Times(0));
    }
    for run in unknown {
        if known.iter().any(|other| other.len() == run.len()) {
            intervals[run].fill(Interval::Unknown);
        } else {
            let with_behind = run.start..(run.end + 1).min(intervals.len());
            intervals[with_behind].fill(Interval::Hidden);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOVED: SeenWay = SeenWay { way: Some(1.0), least: 0.0, is_still: false };
    const STILL: SeenWay = SeenWay { way: Some(0.0), least: 0.0, is_still: true };
    const UNSEEN: SeenWay = SeenWay { way: None, least: 0.0, is_still: false };

    /// A drive of a minute whose frames stand to the camera's as `pattern` says, over and over.
    fn drive(pattern: &[SeenWay]) -> Vec<SeenWay> {
        pattern.iter().copied().cycle().take(60 * pattern.len()).collect()
    }

    fn times(times: f64) -> SeenWay {
        SeenWay { way: Some(times), least: 0.0, is_still: false }
    }

    #[test]
    fn repeated_and_missing_frames_are_counted_and_the_way_is_whole() {
        for (pattern, repeated, missing, per_frame) in [
            // 20 frames a second as 30, and as 24.
            (vec![STILL, MOVED, MOVED], 1, 0, 2.0 / 3.0),
            (vec![STILL, MOVED, MOVED, MOVED, MOVED, MOVED], 1, 0, 5.0 / 6.0),
            // Each frame twice.
            (vec![STILL, MOVED], 1, 0, 0.5),
            // One of five lost; 30 frames a second as 20; two lost at once.
            (vec![MOVED, MOVED, MOVED, times(2.0)], 0, 1, 1.25),
            (vec![times(2.04), times(0.97)], 0, 1, 1.5),
            (vec![MOVED, MOVED, MOVED, MOVED, times(3.0)], 0, 2, 1.4),
            // Lost frames that the one before stands for.
            (vec![MOVED, MOVED, STILL, times(2.0), MOVED], 1, 1, 1.0),
        ] {
            let (seen, rounds) = (drive(&pattern), 60);
            let found = Cadence::of(&seen, 0.1).unwrap();
            assert_eq!((found.repeated, found.missing), (repeated * rounds, missing * rounds), "{pattern:?}");
            assert!((found.intervals_per_frame.unwrap() - per_frame).abs() < 1e-9, "{pattern:?}");
            let whole: f64 = seen.iter().filter_map(|seen| seen.way).sum();
            let found: f64 = found.ways.iter().sum();
            assert!((found / whole - 1.0).abs() < 0.04, "{pattern:?}: {found} of {whole}");
        }
    }

    #[test]
    fn what_is_not_seen_after_a_repeated_frame_is_not_believed_to_be_one_interval() {
        let found = Cadence::of(&drive(&[MOVED, MOVED, MOVED, STILL, times(2.0), MOVED, STILL, UNSEEN]), 0.1)
            .unwrap();
        assert!((found.intervals_per_frame.unwrap() - 1.0).abs() < 1e-9, "{found:?}");
        assert!((found.ways.iter().sum::<f64>() - 480.0).abs() < 1.0, "{found:?}");
    }

    #[test]
    fn a_stand_behind_frames_that_are_not_seen_is_one() {
        // Whether the vehicle slowed down meanwhile, nobody saw.
        for stand in [[UNSEEN, UNSEEN, STILL], [UNSEEN, STILL, STILL], [STILL, STILL, STILL]] {
            let moved = [MOVED; 20];
            assert_eq!(Cadence::of(&[&moved[..], &[UNSEEN; 12], &stand, &[UNSEEN]].concat(), 0.1), None);
            assert_eq!(Cadence::of(&[&[UNSEEN], &stand[..], &[UNSEEN; 12], &moved].concat(), 0.1), None);
        }
        // In two frames nobody stops from a way that takes ten.
        let filled = [&[MOVED; 20][..], &[UNSEEN], &[STILL; 5], &[UNSEEN; 2], &[MOVED; 20]].concat();
        assert_eq!(Cadence::of(&filled, 0.1).map(|found| found.repeated), Some(5));
        let found = Cadence::of(&[&[MOVED; 20][..], &[STILL], &[MOVED; 20]].concat(), 0.1).unwrap();
        assert_eq!(found.repeated, 1);
    }

    #[test]
    fn a_picture_that_freezes_is_no_stand_and_leaves_open_what_it_hides() {
        // Ten frames of a hundred, and the step behind them, which is too long to be seen.
        let frozen = [&[MOVED; 44][..], &[STILL; 10], &[UNSEEN], &[MOVED; 45]].concat();
        let found = Cadence::of(&frozen, 0.1).unwrap();
        assert_eq!((found.repeated, found.missing), (10, 0));
        assert!((found.ways.iter().sum::<f64>() - 100.0).abs() < 1e-9, "{found:?}");
        assert!((found.unseen_share - 0.11).abs() < 1e-9, "{found:?}");
        assert_eq!(found.intervals_per_frame, Some(1.0));
        // Behind others as many it is seen.
        let regular = [&[MOVED; 20][..], &[STILL], &[MOVED; 20], &[STILL], &[UNSEEN], &[MOVED; 20]].concat();
        let found = Cadence::of(&regular, 0.1).unwrap();
        assert!(found.repeated == 2 && found.unseen_share <= 0.0, "{found:?}");
        // To the drive's end.
        let found = Cadence::of(&frozen[..54], 0.1).unwrap();
        assert_eq!((found.repeated, found.intervals_per_frame), (10, Some(1.0)));
        assert!((found.unseen_share - 10.0 / 54.0).abs() < 1e-9, "{found:?}");
        // Where the step is seen, its intervals are counted.
        let counted = [&[MOVED; 44][..], &[STILL; 3], &[times(4.02)], &[MOVED; 45]].concat();
        let found = Cadence::of(&counted, 0.1).unwrap();
        assert_eq!((found.repeated, found.missing, found.intervals_per_frame), (3, 3, Some(1.0)));
        assert!(
            found.unseen_share <= 0.0 && (found.ways.iter().sum::<f64>() - 93.0).abs() < 1e-9,
            "{found:?}"
        );
    }

    #[test]
    fn a_way_of_more_intervals_than_its_noise_lets_be_counted_leaves_the_time_unknown() {
        let noisy = |i: i32| times(1.0 + 0.1 * f64::from(i * 7 % 11 - 5) / 5.0);
        for (way, is_known) in [(3.0, true), (30.0, false), (1e12, false)] {
            let mut seen: Vec<SeenWay> = (5..105).map(noisy).collect();
            seen[50] = times(way);
            let found = Cadence::of(&seen, 0.1).unwrap();
            assert_eq!(found.intervals_per_frame.is_some(), is_known, "{found:?}");
            let whole: f64 = seen.iter().filter_map(|seen| seen.way).sum();
            let ways: f64 = found.ways.iter().sum();
            assert!((ways / whole - 1.0).abs() < 0.02, "{ways} of {whole}");
        }
    }

    #[test]
    fn drives_that_stop_start_and_are_seen_badly_are_regular() {
        // At ten frames a second, in metres: from 15 m/s to a stand with 6 m/s², a second at rest, and on with 3 m/s².
        let braking = (0..=25).map(|i| 1.5 - 0.06 * f64::from(i));
        let ways = braking.chain([0.0; 10]).chain((1..60).map(|i| 0.03 * f64::from(i)));
        let seen: Vec<SeenWay> =
            ways.map(|way| SeenWay { way: Some(way.max(0.0)), least: 0.0, is_still: way < 0.001 }).collect();
        assert_eq!(Cadence::of(&seen, 0.098), None);
        let noisy: Vec<SeenWay> =
            (0..200).map(|i| times(1.0 + 0.2 * f64::from(i * 7 % 11 - 5) / 5.0)).collect();
        assert_eq!(Cadence::of(&noisy, 0.098), None);
        // Fast frames change their speed less than their noise.
        assert_eq!(Cadence::of(&noisy, 0.01), None);
        let noisier: Vec<SeenWay> = (0..200)
            .map(|i| times(1.0 + 0.3 * f64::from(i * 7 % 11 - 5) / 5.0 + if i % 40 == 0 { 0.3 } else { 0.0 }))
            .collect();
        assert_eq!(Cadence::of(&noisier, 0.01), None);
        // Two frames whose road was mistaken for something far, alike by chance and in each other's neighbourhood.
        let mistaken =
            [times(0.07), times(0.2), MOVED, MOVED, MOVED, MOVED, times(0.07), MOVED, MOVED, MOVED];
        assert_eq!(Cadence::of(&drive(&mistaken), 0.098), None);
        assert_eq!(Cadence::of(&drive(&[UNSEEN, STILL]), 0.098), None);
        assert_eq!(Cadence::of(&[], 0.098), None);
    }
}

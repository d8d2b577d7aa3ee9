//! Frames that repeat the one before, and frames that are missing between two, by how far the vehicle came meanwhile.
//!
//! A camera's ways from frame to frame are alike as long as it takes its pictures in time. Where some are whole multiples of the
//! others, or none at all, and no tyre could have changed the speed so within a frame, it is the recording that was filled or has
//! lost something: 20 frames a second written as 30, or frames that were dropped on the way.
//!
//! Limits: what happens to every frame alike, as every second one lost, does not show, nor a frame that is missing where the road's
//! motion is too far to be followed.

/// How often the camera's own interval lies between a frame and the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interval {
    /// So often: 0 for a frame that repeats the one before, 2 where one is missing between them.
    Times(u32),
    /// The way cannot be seen.
    Unknown,
    /// The vehicle stands.
    Standing,
}

/// What the ways say of a drive's frames.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cadence {
    /// Frames that repeat the one before.
    pub(super) repeated: usize,
    /// Frames that are missing between others.
    pub(super) missing: usize,
    /// Intervals of the camera in one of the recording, on the mean; exactly 1 where none is repeated or missing.
    pub(super) intervals_per_frame: f64,
    /// Share of the frames whose way is not seen and may be that of several intervals: the longer a way, the less of it is seen. Zero
    /// where no frame is missing elsewhere.
    pub(super) unseen_share: f64,
    /// Way of each frame but the first, for an interval of the mean length.
    pub(super) ways: Vec<f64>,
}

/// What a frame shows of the way since the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeenWay {
    /// In any unit, for an interval of the mean length; zero for a vehicle that stands, none where it cannot be told.
    pub(super) way: Option<f64>,
    /// Whether the picture is the one before.
    pub(super) is_still: bool,
}

/// Frames to either side whose ways a frame's own is compared with: a third of a second at ten a second, in which no drive
/// changes its speed much.
const NEIGHBOURS: usize = 3;
/// Ways of which one is twice the other lie on different sides of this ratio.
const ONE_OR_TWO: f64 = std::f64::consts::SQRT_2;
/// Least number of ways that set the camera's own interval, and of how many neighbours one at the least: a single one is an outlier.
const LEAST_ALIKE: usize = 2;
const ONE_OF: usize = 3;

impl Cadence {
    /// Of the ways from each frame to the next; `least_jump` is the change of the way from one frame to the next that no tyre brings
    /// about. None where every frame comes once and none is missing.
    pub(super) fn of(seen: &[SeenWay], least_jump: f64) -> Option<Self> {
        let mut units: Vec<Option<f64>> = (0..seen.len()).map(|frame| unit(seen, frame)).collect();
        // Where too little is seen, as in the nearest place where enough is: first the one before, else the one behind.
        for frame in 1..units.len() {
            units[frame] = units[frame].or(units[frame - 1]);
        }
        for frame in (1..units.len()).rev() {
            units[frame - 1] = units[frame - 1].or(units[frame]);
        }
        let mut intervals: Vec<Interval> =
            seen.iter().zip(&units).map(|(seen, unit)| interval(seen, *unit, least_jump)).collect();
        mark_repeated(seen, &units, least_jump, &mut intervals);
        let count_of = |of: &dyn Fn(u32) -> usize| -> usize {
            intervals.iter().map(|interval| if let Interval::Times(n) = interval { of(*n) } else { 0 }).sum()
        };
        let repeated = count_of(&|times| usize::from(times == 0));
        let missing = count_of(&|times| (times as usize).saturating_sub(1));
        if repeated + missing == 0 {
            return None;
        }
        let (known, total) = (count_of(&|_| 1), count_of(&|times| times as usize));
        let intervals_per_frame = total as f64 / known as f64;
        let ways = units.iter().zip(&intervals).map(|(unit, interval)| match interval {
            Interval::Times(times) => unit.unwrap_or_default() * f64::from(*times),
            Interval::Standing => 0.0,
            Interval::Unknown => unit.unwrap_or_default() * intervals_per_frame,
        });
        let unseen = seen.iter().filter(|seen| seen.way.is_none()).count();
        let unseen_share = if missing > 0 { unseen as f64 / seen.len() as f64 } else { 0.0 };
        Some(Self { repeated, missing, intervals_per_frame, unseen_share, ways: ways.collect() })
    }
}

/// The way of one of the camera's own intervals about a frame: the middle of the shortest ways that are alike. None where too
/// few are seen.
fn unit(seen: &[SeenWay], frame: usize) -> Option<f64> {
    let width = (2 * NEIGHBOURS + 1).min(seen.len());
    let start = frame.saturating_sub(NEIGHBOURS).min(seen.len() - width);
    let near = &seen[start..start + width];
    let mut ways: Vec<f64> = near.iter().filter_map(|near| near.way).filter(|way| *way > 0.0).collect();
    ways.sort_unstable_by(f64::total_cmp);
    let alike = ways.chunk_by(|shorter, longer| *longer < ONE_OR_TWO * shorter);
    let unit =
        alike.into_iter().find(|alike| alike.len() >= LEAST_ALIKE && alike.len() * ONE_OF >= ways.len())?;
    unit.get(unit.len() / 2).copied()
}

fn interval(seen: &SeenWay, unit: Option<f64>, least_jump: f64) -> Interval {
    match (seen.way, unit) {
        (Some(way), Some(unit)) if way > 0.0 => {
            let times = if way - unit > least_jump { (way / unit).round().max(1.0) } else { 1.0 };
            Interval::Times(times as u32)
        }
        (Some(_), _) => Interval::Standing,
        (None, _) => Interval::Unknown,
    }
}

/// Marks still frames between others that move as repeated, where the vehicle could neither have stopped nor started so. What
/// follows them may make up for them; where its way is unknown, so are they.
fn mark_repeated(seen: &[SeenWay], units: &[Option<f64>], least_jump: f64, intervals: &mut [Interval]) {
    let mut start = 0;
    for run in seen.chunk_by(|a, b| a.is_still == b.is_still) {
        let end = start + run.len();
        if run.first().is_some_and(|seen| seen.is_still) {
            let moves_on = |frame: Option<usize>| {
                let frame = frame.filter(|frame| *frame < seen.len())?;
                seen[frame].way.or(units[frame]).map(|way| way > least_jump)
            };
            let beside = [moves_on(start.checked_sub(1)), moves_on(Some(end))];
            let is_repeated =
                beside.iter().flatten().all(|moves| *moves) && beside.iter().any(Option::is_some);
            let is_known = intervals.get(end).is_none_or(|next| *next != Interval::Unknown);
            if is_repeated {
                intervals[start..end].fill(if is_known { Interval::Times(0) } else { Interval::Unknown });
            }
        }
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOVED: SeenWay = SeenWay { way: Some(1.0), is_still: false };
    const STILL: SeenWay = SeenWay { way: Some(0.0), is_still: true };
    const UNSEEN: SeenWay = SeenWay { way: None, is_still: false };

    /// A drive of a minute whose frames stand to the camera's as `pattern` says, over and over.
    fn drive(pattern: &[SeenWay]) -> Vec<SeenWay> {
        pattern.iter().copied().cycle().take(60 * pattern.len()).collect()
    }

    fn times(times: f64) -> SeenWay {
        SeenWay { way: Some(times), is_still: false }
    }

    #[test]
    fn repeated_and_missing_frames_are_counted_and_the_way_is_whole() {
        for (pattern, repeated, missing, per_frame) in [
            // 20 frames a second as 30, and as 24.
            (vec![STILL, MOVED, MOVED], 1, 0, 2.0 / 3.0),
            (vec![STILL, MOVED, MOVED, MOVED, MOVED, MOVED], 1, 0, 5.0 / 6.0),
            // Each frame twice.
            (vec![MOVED, STILL], 1, 0, 0.5),
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
            assert!((found.intervals_per_frame - per_frame).abs() < 1e-9, "{pattern:?}");
            let whole: f64 = seen.iter().filter_map(|seen| seen.way).sum();
            let found: f64 = found.ways.iter().sum();
            assert!((found / whole - 1.0).abs() < 0.04, "{pattern:?}: {found} of {whole}");
        }
    }

    #[test]
    fn what_is_not_seen_after_a_repeated_frame_is_not_believed_to_be_one_interval() {
        let found = Cadence::of(&drive(&[MOVED, MOVED, MOVED, STILL, times(2.0), MOVED, STILL, UNSEEN]), 0.1)
            .unwrap();
        assert!((found.intervals_per_frame - 1.0).abs() < 1e-9, "{found:?}");
        assert!((found.ways.iter().sum::<f64>() - 480.0).abs() < 1.0, "{found:?}");
    }

    #[test]
    fn drives_that_stop_start_and_are_seen_badly_are_regular() {
        // At ten frames a second, in metres: from 15 m/s to a stand with 6 m/s², a second at rest, and on with 3 m/s².
        let braking = (0..=25).map(|i| 1.5 - 0.06 * f64::from(i));
        let ways = braking.chain([0.0; 10]).chain((1..60).map(|i| 0.03 * f64::from(i)));
        let seen: Vec<SeenWay> =
            ways.map(|way| SeenWay { way: Some(way.max(0.0)), is_still: way < 0.001 }).collect();
        assert_eq!(Cadence::of(&seen, 0.098), None);
        let noisy: Vec<SeenWay> =
            (0..200).map(|i| times(1.0 + 0.2 * f64::from(i * 7 % 11 - 5) / 5.0)).collect();
        assert_eq!(Cadence::of(&noisy, 0.098), None);
        // Two frames whose road was mistaken for something far, alike by chance and in each other's neighbourhood.
        let mistaken =
            [times(0.07), times(0.2), MOVED, MOVED, MOVED, MOVED, times(0.07), MOVED, MOVED, MOVED];
        assert_eq!(Cadence::of(&drive(&mistaken), 0.098), None);
        assert_eq!(Cadence::of(&drive(&[UNSEEN, STILL]), 0.098), None);
        assert_eq!(Cadence::of(&[], 0.098), None);
    }
}

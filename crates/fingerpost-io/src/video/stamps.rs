//! The times of a video's frames, from the stamps that they came with.
//!
//! A stamp counts ticks of its container, milliseconds in Matroska: of a constant rate it is a rounded time. One that is the constant
//! rate's rounded is taken for that; every other one is believed as it is, unless both of the stamps behind it lie before it and go on
//! from the one before it: then it is the one that strays. One that strays, or does not come after the stamp before it, is counted, and
//! the frame's time still goes on: recordings that were joined begin anew. Limits: several in a row that stray together are believed, and so
//! is one among the last two frames.

/// Seconds of the units that ffmpeg's stamps are counted in here.
const US_PER_S: f64 = 1e6;

/// What the times of a video's frames are from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Timing {
    /// The stamps of its frames.
    Stamps {
        /// What they are whole numbers of, seconds.
        tick_s: f64,
    },
    /// The rate that it states; its frames have no stamps.
    StatedRate,
    /// A rate that ffmpeg takes where nothing is stated: bare streams of pictures, out of their container.
    GuessedRate,
}

/// Stamps of frames that are not those of a clock that goes on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StampFaults {
    /// Frames whose stamp lies before the last one; their time is a frame's duration after that one's.
    pub back: u64,
    /// Frames whose stamp is later than those of the two frames that follow them; their time is halfway between their neighbours'.
    pub stray: u64,
    /// Frames with the same stamp as the last one, and so the same time.
    pub repeated: u64,
    /// Frames without a stamp; their time is a frame's duration after the last one's.
    pub missing: u64,
    /// The first of all these frames.
    pub first: Option<u64>,
}

/// From stamps to times.
#[derive(Debug)]
pub(crate) struct StampClock {
    fps: f64,
    tick_s: f64,
    /// The stamp that a first frame had or would have had, microseconds.
    zero_us: Option<i64>,
    last: Option<Last>,
    faults: StampFaults,
}

/// The frame before.
#[derive(Debug, Clone, Copy)]
struct Last {
    t_s: f64,
    stamp_us: Option<i64>,
}

impl StampClock {
    /// Of a video of so many frames a second, on average, whose stamps count ticks of `tick_s` seconds.
    pub(crate) fn new(fps: f64, tick_s: f64) -> Self {
        Self { fps, tick_s, zero_us: None, last: None, faults: StampFaults::default() }
    }

    /// What was wrong with the stamps so far.
    pub(crate) const fn faults(&self) -> StampFaults {
        self.faults
    }

    /// Whether a stamp is that of the constant rate, which needs none of those behind it to be believed.
    pub(crate) fn is_even(&self, index: u64, stamp_us: i64) -> bool {
        self.zero_us.is_some_and(|zero_us| self.even_s(index, stamp_us.saturating_sub(zero_us)).is_some())
    }

    /// Time of the frame with that index and stamp, seconds since the first frame, given the stamps of the two frames behind it where they
    /// are known. To be asked for one frame after the other.
    pub(crate) fn time_s(&mut self, index: u64, stamp_us: Option<i64>, behind_us: Option<[i64; 2]>) -> f64 {
        let last_us = self.last.and_then(|last| last.stamp_us);
        let contradicting = |stamp_us: i64| {
            behind_us.filter(|[next_us, after_us]| {
                last_us.is_none_or(|last_us| last_us < *next_us) && next_us < after_us && *after_us < stamp_us
            })
        };
        let (t_s, believed_us) = match stamp_us.map(|stamp_us| (stamp_us, contradicting(stamp_us))) {
            Some((stamp_us, None)) => (self.stamped_s(index, stamp_us), Some(stamp_us)),
            Some((_, Some([next_us, _]))) => {
                self.note(index, |faults| &mut faults.stray);
                (self.halfway_s(next_us), None)
            }
            None => {
                self.note(index, |faults| &mut faults.missing);
                (self.next_s(), None)
            }
        };
        self.last = Some(Last { t_s, stamp_us: believed_us.or(last_us) });
        t_s
    }

    /// Halfway from the frame before to the one with the next stamp, seconds.
    fn halfway_s(&self, next_us: i64) -> f64 {
        match self.last {
            Some(Last { t_s, stamp_us: Some(last_us) }) => {
                t_s + 0.5 * next_us.saturating_sub(last_us) as f64 / US_PER_S
            }
            _ => self.next_s(),
        }
    }

    /// The time of the constant rate that a time since the first frame is rounded from; none where it is another.
    fn even_s(&self, index: u64, since_us: i64) -> Option<f64> {
        let even_s = index as f64 / self.fps;
        // Rounded to ticks by the container, and to microseconds here.
        let is_rounded = (since_us as f64 / US_PER_S - even_s).abs() <= self.tick_s / 2.0 + 1.0 / US_PER_S;
        is_rounded.then_some(even_s)
    }

    /// When a frame would come next at the mean rate, seconds.
    pub(crate) fn next_s(&self) -> f64 {
        self.last.map_or(0.0, |last| last.t_s + 1.0 / self.fps)
    }

    fn stamped_s(&mut self, index: u64, stamp_us: i64) -> f64 {
        let next_us = (self.next_s() * US_PER_S).round() as i64;
        let zero_us = *self.zero_us.get_or_insert(stamp_us.saturating_sub(next_us));
        let since_us = stamp_us.saturating_sub(zero_us);
        let own_s = self.even_s(index, since_us).unwrap_or(since_us as f64 / US_PER_S);
        let Some(Last { t_s: last_s, stamp_us: Some(last_us) }) = self.last else { return own_s };
        let step_us = stamp_us.saturating_sub(last_us);
        match step_us {
            0 => {
                self.note(index, |faults| &mut faults.repeated);
                return last_s;
            }
            ..0 => self.note(index, |faults| &mut faults.back),
            1.. => {}
        }
        match own_s > last_s {
            true => own_s,
            // Behind a step back times go on by as much as stamps do.
            false if step_us > 0 => last_s + step_us as f64 / US_PER_S,
            false => self.next_s(),
        }
    }

    fn note(&mut self, index: u64, count: impl Fn(&mut StampFaults) -> &mut u64) {
        *count(&mut self.faults) += 1;
        self.faults.first.get_or_insert(index);
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "times of a constant rate are to be those of its index")]
mod tests {
    use super::*;

    /// Times of frames with these stamps, milliseconds, at 10 frames a second, and what was wrong.
    fn times(stamps_ms: &[Option<i64>]) -> (Vec<f64>, StampFaults) {
        let mut clock = StampClock::new(10.0, 0.001);
        let stamp_us = |index: usize| stamps_ms.get(index).copied().flatten().map(|ms| 1000 * ms);
        let times = (0..stamps_ms.len()).map(|index| {
            let behind_us = stamp_us(index + 1).zip(stamp_us(index + 2)).map(<[i64; 2]>::from);
            clock.time_s(index as u64, stamp_us(index), behind_us)
        });
        let times = times.collect::<Vec<_>>();
        (times.into_iter().map(|t_s| (t_s * 1000.0).round() / 1000.0).collect(), clock.faults())
    }

    #[test]
    fn uneven_stamps_are_times_from_wherever_they_begin() {
        for from_ms in [0, 1450, -300, 1_700_000_000_000] {
            let stamps = [0, 120, 200, 900, 5000].map(|ms| Some(from_ms + ms));
            assert_eq!(times(&stamps), (vec![0.0, 0.12, 0.2, 0.9, 5.0], StampFaults::default()), "{from_ms}");
        }
    }

    #[test]
    fn rounded_stamps_of_a_constant_rate_give_its_times_exactly() {
        for (fps, tick_s) in
            [(30.0, 0.001), (30_000.0 / 1001.0, 1.0 / 90_000.0), (25.0, 0.04), (59.94, 0.001)]
        {
            let mut clock = StampClock::new(fps, tick_s);
            for index in 0..1000_u64 {
                let even_s = index as f64 / fps;
                let stamp_us = ((even_s / tick_s).round() * tick_s * 1e6).round() as i64;
                assert_eq!(clock.time_s(index, Some(stamp_us), None), even_s, "{fps} {index}");
                assert!(clock.is_even(index, stamp_us) && !clock.is_even(index, stamp_us + 1_000_000));
            }
            assert_eq!(clock.faults(), StampFaults::default());
        }
        // A frame that a camera left out is a whole tick.
        let mut clock = StampClock::new(25.0, 0.04);
        assert_eq!(
            [(0, 0), (1, 80_000), (2, 120_000)].map(|(i, us)| clock.time_s(i, Some(us), None)),
            [0.0, 0.08, 0.12]
        );
    }

    #[test]
    fn stamps_that_do_not_go_on_are_counted_and_times_still_do() {
        let faults = StampFaults::default();
        // One repeated, one that strays, joined recordings, and none at all at the beginning and half-way.
        let repeated = times(&[Some(0), Some(150), Some(150), Some(250)]);
        assert_eq!(
            repeated,
            (vec![0.0, 0.15, 0.15, 0.25], StampFaults { repeated: 1, first: Some(2), ..faults })
        );
        let stray = times(&[Some(0), Some(150), Some(20), Some(350)]);
        assert_eq!(stray, (vec![0.0, 0.15, 0.25, 0.35], StampFaults { back: 1, first: Some(2), ..faults }));
        let joined = times(&[Some(0), Some(150), Some(250), Some(0), Some(50), Some(210)]);
        assert_eq!(joined.0, [0.0, 0.15, 0.25, 0.35, 0.4, 0.56]);
        assert_eq!(joined.1, StampFaults { back: 1, first: Some(3), ..faults });
        let missing = times(&[None, Some(7000), None, Some(7250)]);
        assert_eq!(
            missing,
            (vec![0.0, 0.1, 0.2, 0.35], StampFaults { missing: 2, first: Some(0), ..faults })
        );
    }

    #[test]
    fn a_stamp_far_ahead_of_those_behind_it_moves_no_other_frame() {
        let even = [0, 100, 200, 300, 400, 500, 600];
        let uneven = [0, 130, 190, 320, 400, 540, 600];
        for (stamps, at) in [(even, 0), (even, 1), (even, 4), (uneven, 3), (uneven, 4)] {
            for far_ms in [5000, 1_000_000_000] {
                let mut faulty = stamps.map(Some);
                faulty[at] = Some(stamps[at] + far_ms);
                let (found, faults) = times(&faulty);
                let wanted: Vec<f64> = stamps.iter().map(|ms| *ms as f64 / 1000.0).collect();
                let strayed = StampFaults { stray: 1, first: Some(at as u64), ..StampFaults::default() };
                assert_eq!(faults, strayed, "{faulty:?}");
                for (index, (found_s, wanted_s)) in found.iter().zip(&wanted).enumerate() {
                    let most_s = if index == at { 0.05 } else { 0.0 };
                    assert!((found_s - wanted_s).abs() <= most_s, "{faulty:?}: {found:?}");
                }
                assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "{found:?}");
            }
        }
        // A pause, and recordings that were joined, are as they are.
        assert_eq!(times(&[0, 100, 9000, 9100, 9200].map(Some)).1, StampFaults::default());
        assert_eq!(times(&[7000, 7100, 7200, 0, 100].map(Some)).1.stray, 0);
    }

    #[test]
    fn absurd_stamps_are_no_panic() {
        let mut clock = StampClock::new(10.0, 0.001);
        for (index, us) in (0..).zip([i64::MIN, i64::MAX, 0, i64::MIN, i64::MAX]) {
            assert!(clock.time_s(index, Some(us), Some([us, i64::MAX])).is_finite());
        }
    }
}

//! The times of a video's frames, from the stamps that they came with.
//!
//! A stamp counts ticks of its container, milliseconds in Matroska: of a constant rate it is a rounded time. One that is the constant
//! rate's rounded is taken for that; every other one is believed as it is. One that does not come after the stamp before it is counted,
//! and the frame's time still goes on: recordings that were joined begin anew.

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

    /// Time of the frame with that index and stamp, seconds since the first frame. To be asked for one frame after the other.
    pub(crate) fn time_s(&mut self, index: u64, stamp_us: Option<i64>) -> f64 {
        let t_s = match stamp_us {
            Some(stamp_us) => self.stamped_s(index, stamp_us),
            None => {
                self.note(index, |faults| &mut faults.missing);
                self.next_s()
            }
        };
        self.last = Some(Last { t_s, stamp_us: stamp_us.or(self.last.and_then(|last| last.stamp_us)) });
        t_s
    }

    /// When a frame would come next at the mean rate, seconds.
    pub(crate) fn next_s(&self) -> f64 {
        self.last.map_or(0.0, |last| last.t_s + 1.0 / self.fps)
    }

    fn stamped_s(&mut self, index: u64, stamp_us: i64) -> f64 {
        let next_us = (self.next_s() * US_PER_S).round() as i64;
        let zero_us = *self.zero_us.get_or_insert(stamp_us.saturating_sub(next_us));
        let since_s = stamp_us.saturating_sub(zero_us) as f64 / US_PER_S;
        let even_s = index as f64 / self.fps;
        // Rounded to ticks by the container, and to microseconds here.
        let is_rounded = (since_s - even_s).abs() <= self.tick_s / 2.0 + 1.0 / US_PER_S;
        let own_s = if is_rounded { even_s } else { since_s };
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
        let stamps = (0..).zip(stamps_ms);
        let times = stamps.map(|(index, ms)| clock.time_s(index, ms.map(|ms| 1000 * ms))).collect::<Vec<_>>();
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
                assert_eq!(clock.time_s(index, Some(stamp_us)), even_s, "{fps} {index}");
            }
            assert_eq!(clock.faults(), StampFaults::default());
        }
        // A frame that a camera left out is a whole tick.
        let mut clock = StampClock::new(25.0, 0.04);
        assert_eq!(
            [(0, 0), (1, 80_000), (2, 120_000)].map(|(i, us)| clock.time_s(i, Some(us))),
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
    fn absurd_stamps_are_no_panic() {
        let mut clock = StampClock::new(10.0, 0.001);
        for (index, us) in (0..).zip([i64::MIN, i64::MAX, 0, i64::MIN, i64::MAX]) {
            assert!(clock.time_s(index, Some(us)).is_finite());
        }
    }
}

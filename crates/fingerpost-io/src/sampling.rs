//! Which frames of an input are used.

use std::num::NonZeroU64;

/// How long before its tick a frame may come, seconds: times in files are often cut to milliseconds.
const TOLERANCE_S: f64 = 0.0015;

/// Which frames of an input are used; the first one always is. Each keeps its index and its time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Sampling {
    /// All.
    #[default]
    All,
    /// Those whose index is a multiple of this.
    Every(NonZeroU64),
    /// At most so many a second: the first at or after each tick of the input's time. Where frames come more seldom than ticks,
    /// all are used.
    Rate {
        /// Ticks a second.
        hz: f64,
    },
}

impl Sampling {
    /// How many of `count` frames that come `fps` times a second are used.
    pub(crate) fn count(self, count: u64, fps: f64) -> u64 {
        match self {
            Self::All => count,
            Self::Every(nth) => count.div_ceil(nth.get()),
            Self::Rate { hz } if hz >= fps => count,
            Self::Rate { hz } => match count.checked_sub(1) {
                Some(last) => ((tick_of(last as f64 / fps, hz) - tick_of(0.0, hz)) as u64).saturating_add(1),
                None => 0,
            },
        }
    }

    /// How many frames a second are used of an input that gives `fps`.
    pub(crate) fn rate(self, fps: f64) -> f64 {
        match self {
            Self::All => fps,
            Self::Every(nth) => fps / nth.get() as f64,
            Self::Rate { hz } => fps.min(hz),
        }
    }
}

/// Chooses among the frames of an input as they come.
#[derive(Debug)]
pub(crate) struct Sampler {
    sampling: Sampling,
    /// Tick and time, seconds, of the frame that was used last.
    last: Option<(f64, f64)>,
}

impl Sampler {
    /// For an input's first frame on.
    pub(crate) const fn new(sampling: Sampling) -> Self {
        Self { sampling, last: None }
    }

    /// Whether the frame with that index and time, seconds since the first, is used. To be asked for one after the other.
    pub(crate) fn wants(&mut self, index: u64, t_s: f64) -> bool {
        match self.sampling {
            Sampling::All => true,
            Sampling::Every(nth) => index.is_multiple_of(nth.get()),
            Sampling::Rate { hz } => {
                let tick = tick_of(t_s, hz);
                // A clock that was put back does not stop the drive until it has caught up.
                let wanted = self.last.is_none_or(|(last, last_s)| tick > last || t_s < last_s);
                if wanted {
                    self.last = Some((tick, t_s));
                }
                wanted
            }
        }
    }
}

fn tick_of(t_s: f64, hz: f64) -> f64 {
    ((t_s + TOLERANCE_S) * hz).floor()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn used(sampling: Sampling, times_s: &[f64]) -> Vec<usize> {
        let mut sampler = Sampler::new(sampling);
        let wanted = |(index, t_s): (usize, &f64)| sampler.wants(index as u64, *t_s).then_some(index);
        times_s.iter().enumerate().filter_map(wanted).collect()
    }

    #[test]
    fn frames_are_used_at_even_numbers_or_times() {
        let thirty: Vec<f64> = (0..31).map(|i| f64::from(i) / 30.0).collect();
        let rounded: Vec<f64> = thirty.iter().map(|t_s| (t_s * 1000.0).floor() / 1000.0).collect();
        let every = |nth| Sampling::Every(NonZeroU64::new(nth).unwrap());
        assert_eq!(used(Sampling::All, &thirty).len(), 31);
        assert_eq!(used(every(7), &thirty), [0, 7, 14, 21, 28]);
        assert_eq!(used(every(1), &thirty).len(), 31);
        for times_s in [&thirty, &rounded] {
            assert_eq!(used(Sampling::Rate { hz: 10.0 }, times_s), [0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30]);
        }
        assert_eq!(used(Sampling::Rate { hz: 12.0 }, &thirty)[..6], [0, 3, 5, 8, 10, 13]);
        assert_eq!(used(Sampling::Rate { hz: 30.0 }, &rounded).len(), 31);
        assert_eq!(used(Sampling::Rate { hz: 100.0 }, &thirty).len(), 31);
    }

    #[test]
    fn pauses_and_clocks_that_are_put_back_are_gone_on_after() {
        let times_s = [0.0, 0.05, 0.1, 5.0, 5.05, 5.1, 2.0, 2.05, 2.1];
        assert_eq!(used(Sampling::Rate { hz: 10.0 }, &times_s), [0, 2, 3, 5, 6, 8]);
    }

    #[test]
    fn what_is_used_is_counted_beforehand() {
        for count in [0_u32, 1, 2, 3, 29, 30, 31, 100] {
            for fps in [9.9, 10.0, 25.0, 29.97, 30.0] {
                let times_s: Vec<f64> = (0..count).map(|i| f64::from(i) / fps).collect();
                let every = (1..5).map(|nth| Sampling::Every(NonZeroU64::new(nth).unwrap()));
                let rates = [0.3, 7.0, 10.0, 12.5, 25.0].map(|hz| Sampling::Rate { hz });
                for sampling in every.chain(rates) {
                    let expected = used(sampling, &times_s).len() as u64;
                    assert_eq!(sampling.count(u64::from(count), fps), expected, "{sampling:?} {count} {fps}");
                }
            }
        }
        let seldom = Sampling::Every(NonZeroU64::new(3).unwrap());
        assert!((seldom.rate(30.0) - 10.0).abs() < 1e-12);
        assert!((Sampling::Rate { hz: 10.0 }.rate(25.0) - 10.0).abs() < 1e-12);
    }
}

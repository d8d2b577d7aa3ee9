//! Wall time of every stage, frame by frame.
//!
//! A stage's time is what it took in its own thread. Stages of different threads go on at the same time, so that a frame
//! takes less than their sum: `decode` (waiting for ffmpeg with it) ahead of the method's own stages, `drawing` (of frames
//! that are shown) behind them, and `results` (compressing pictures and writing) later still.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use fingerpost::Stage;
use fingerpost_format::StageTime;
use hdrhistogram::Histogram;

/// Name of a stage in the files.
pub(crate) const fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::GroundView => "ground_view",
        Stage::Road => "road",
        Stage::Centreline => "centreline",
        Stage::Motion => "motion",
        Stage::Mount => "mount",
        Stage::Match => "match",
        Stage::Fix => "fix",
        Stage::DrivingLine => "driving_line",
        Stage::Lanes => "lanes",
        Stage::Advice => "advice",
    }
}

/// Times the stages of one frame, each from the end of the one before.
#[derive(Debug)]
pub(crate) struct FrameClock {
    last: Instant,
    /// Milliseconds by stage.
    pub(crate) stage_ms: BTreeMap<String, f64>,
}

impl FrameClock {
    /// A clock that runs from now.
    pub(crate) fn start() -> Self {
        Self { last: Instant::now(), stage_ms: BTreeMap::new() }
    }

    /// Takes the time of a stage that has just ended.
    pub(crate) fn finished(&mut self, name: &str) {
        let now = Instant::now();
        self.stage_ms.insert(name.to_owned(), milliseconds(now.duration_since(self.last)));
        self.last = now;
    }
}

/// Milliseconds, to the microsecond: finer than any stage's repeatability.
pub(crate) fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}

/// Times of all frames, by stage: how often each was seen, so that a run of any length takes the same memory.
#[derive(Debug, Default)]
pub(crate) struct StageTimes(BTreeMap<String, Histogram<u32>>);

/// Decimal digits of a time that are told apart: a thousandth of it is less than what repeats.
const SIGNIFICANT_DIGITS: u8 = 3;
/// Longest time that is told from longer ones, microseconds: an hour.
const LONGEST_US: u64 = 3_600_000_000;

impl StageTimes {
    /// Adds a frame's times.
    pub(crate) fn add(&mut self, stage_ms: &BTreeMap<String, f64>) {
        for (name, ms) in stage_ms {
            let time_us = (ms * 1e3).round() as u64;
            if let Some(times) = self.0.get_mut(name) {
                times.saturating_record(time_us);
            } else if let Ok(mut times) = Histogram::new_with_bounds(1, LONGEST_US, SIGNIFICANT_DIGITS) {
                times.saturating_record(time_us);
                self.0.insert(name.clone(), times);
            }
        }
    }

    /// Median and 95th percentile of every stage.
    pub(crate) fn summary(&self) -> BTreeMap<String, StageTime> {
        let ms = |times: &Histogram<u32>, quantile| times.value_at_quantile(quantile) as f64 / 1e3;
        let time = |times| StageTime { median: ms(times, 0.5), p95: ms(times, 0.95) };
        self.0.iter().map(|(name, times)| (name.clone(), time(times))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_times_take_no_more_memory_and_keep_their_quantiles() {
        let mut times = StageTimes::default();
        let add = |times: &mut StageTimes, frames: u32| {
            for i in 0..frames {
                let ms = if i % 10 == 3 { 40.0 + f64::from(i % 100) } else { 12.5 };
                times.add(&BTreeMap::from([("match".to_owned(), ms), ("road".to_owned(), 0.0)]));
            }
            times.0.values().map(Histogram::distinct_values).sum::<usize>()
        };
        let early = add(&mut times, 5_000);
        assert_eq!(add(&mut times, 200_000), early);
        let summary = times.summary();
        let StageTime { median, p95 } = summary["match"];
        assert!((median - 12.5).abs() < 0.013, "{median}");
        // Half of the slow tenth: 43, 53 ... 133 ms.
        assert!((p95 - 83.0).abs() < 0.083, "{p95}");
        assert_eq!(summary["road"], StageTime { median: 0.0, p95: 0.0 });
    }
}

//! Wall time of every stage, frame by frame.
//!
//! A stage's time is what it took in its own thread. Stages of different threads go on at the same time, so that a frame
//! takes less than their sum: `decode` (waiting for ffmpeg with it) ahead of the method's own stages, `drawing` (of frames
//! that are shown) behind them, and `results` (compressing pictures and writing) later still.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use fingerpost::Stage;
use fingerpost_eval::stage_time;
use fingerpost_format::StageTime;

/// Name of a stage in the files.
pub(crate) const fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::GroundView => "ground_view",
        Stage::Road => "road",
        Stage::Centreline => "centreline",
        Stage::Motion => "motion",
        Stage::Mount => "mount",
        Stage::Match => "match",
        Stage::DrivingLine => "driving_line",
        Stage::Lanes => "lanes",
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

/// Times of all frames, by stage.
#[derive(Debug, Default)]
pub(crate) struct StageTimes(BTreeMap<String, Vec<f64>>);

impl StageTimes {
    /// Adds a frame's times.
    pub(crate) fn add(&mut self, stage_ms: &BTreeMap<String, f64>) {
        for (name, ms) in stage_ms {
            self.0.entry(name.clone()).or_default().push(*ms);
        }
    }

    /// Median and 95th percentile of every stage.
    pub(crate) fn summary(&self) -> BTreeMap<String, StageTime> {
        let time =
            |(name, times): (&String, &Vec<f64>)| Some((name.clone(), stage_time(times.iter().copied())?));
        self.0.iter().filter_map(time).collect()
    }
}

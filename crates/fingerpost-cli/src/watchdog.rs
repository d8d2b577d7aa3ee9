//! The watchdog: a vehicle whose pictures stop coming is told to stop, without waiting for the next picture.

use std::time::{Duration, Instant};

use clap::Args;

use crate::arguments::number;

/// Time without a picture after which a vehicle is told to stop, seconds: at 10 pictures a second five in a row are missing.
const USUAL_S: f64 = 0.5;

/// When a vehicle is told to stop for want of pictures.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct WatchdogArgs {
    /// Say stop when no new picture has come for so long, seconds, 0.1 to 60; once, until pictures come again.
    #[arg(long, value_name = "S", default_value_t = USUAL_S,
          value_parser = number(0.1, 60.0, "time without a picture", "seconds"))]
    watchdog_s: f64,
    /// Never say stop for want of pictures: for those that may come as slowly as they like, as a simulator's.
    #[arg(long, conflicts_with = "watchdog_s")]
    no_watchdog: bool,
}

/// Watches the time since the last picture that could be used.
#[derive(Debug)]
pub(crate) struct Watchdog {
    /// None where nobody wants to be told.
    longest: Option<Duration>,
    /// When what was made of that picture was said; none before the first, and while the vehicle has been told to stop.
    since: Option<Instant>,
}

impl Watchdog {
    /// A watchdog that waits for the first picture.
    pub(crate) fn new(args: WatchdogArgs) -> Self {
        let longest = (!args.no_watchdog).then(|| Duration::from_secs_f64(args.watchdog_s));
        Self { longest, since: None }
    }

    /// What was made of a picture is said at this time.
    pub(crate) fn restart(&mut self, now: Instant) {
        self.since = Some(now);
    }

    /// How long no picture has come, where the vehicle is to be told to stop because of it and has not been told.
    pub(crate) fn silence(&self, now: Instant) -> Option<Duration> {
        let silence = now.saturating_duration_since(self.since?);
        (silence >= self.longest?).then_some(silence)
    }

    /// The vehicle has been told.
    pub(crate) fn rest(&mut self) {
        self.since = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watchdog(no_watchdog: bool) -> Watchdog {
        Watchdog::new(WatchdogArgs { watchdog_s: USUAL_S, no_watchdog })
    }

    #[test]
    fn a_silence_is_told_once_and_again_after_the_next_picture() {
        let began = Instant::now();
        let at = |ms: u64| began + Duration::from_millis(ms);
        let mut watchdog = watchdog(false);
        assert_eq!(watchdog.silence(at(10_000)), None, "before the first picture nothing was advised");
        watchdog.restart(at(10_000));
        assert_eq!(watchdog.silence(at(10_499)), None);
        assert_eq!(watchdog.silence(at(10_500)), Some(Duration::from_millis(500)));
        // For as long as it could not be told.
        assert_eq!(watchdog.silence(at(10_550)), Some(Duration::from_millis(550)));
        watchdog.rest();
        assert_eq!(watchdog.silence(at(20_000)), None);
        watchdog.restart(at(20_000));
        assert_eq!(watchdog.silence(at(20_100)), None);
        assert!(watchdog.silence(at(21_000)).is_some());
    }

    #[test]
    fn without_a_watchdog_nothing_is_told() {
        let mut watchdog = watchdog(true);
        let now = Instant::now();
        watchdog.restart(now);
        assert_eq!(watchdog.silence(now + Duration::from_secs(1000)), None);
    }
}

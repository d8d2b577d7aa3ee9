//! The watchdog: a vehicle whose pictures stop coming is told to stop, without waiting for the next picture.

use std::time::{Duration, Instant};

use clap::Args;

use crate::arguments::number;

/// Time without a picture after which a vehicle is told to stop, seconds: at 10 pictures a second five in a row are missing.
const USUAL_S: f64 = 0.5;

/// When a vehicle is told to stop for want of pictures.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct WatchdogArgs {
    /// Say stop when no new picture has come for so long, seconds, 0.1 to 60; once, until pictures come again. By default 0.5, of `advise`
    /// unless pictures come slower than half as fast as they were taken, as from a simulator that is slower than time.
    #[arg(long, value_name = "S", value_parser = number(0.1, 60.0, "time without a picture", "seconds"))]
    watchdog_s: Option<f64>,
    /// Never say stop for want of pictures: for those that may come as slowly as they like, as a simulator's.
    #[arg(long, conflicts_with = "watchdog_s")]
    no_watchdog: bool,
}

/// Watches the time since the last picture that could be used.
#[derive(Debug)]
pub(crate) struct Watchdog {
    /// None where nobody wants to be told.
    longest: Option<Duration>,
    /// How fast pictures come; none where it does not matter, because a time was named.
    pace: Option<Pace>,
    /// When what was made of that picture was said; none before the first, and while the vehicle has been told to stop.
    since: Option<Instant>,
}

impl Watchdog {
    /// A watchdog that waits for the first picture.
    pub(crate) fn new(args: WatchdogArgs) -> Self {
        let longest_s = args.watchdog_s.unwrap_or(USUAL_S);
        let longest = (!args.no_watchdog).then(|| Duration::from_secs_f64(longest_s));
        let pace = args.watchdog_s.is_none().then(Pace::default);
        Self { longest, pace, since: None }
    }

    /// The same for pictures that come by themselves, however fast.
    #[cfg(feature = "ros2")]
    pub(crate) fn at_any_pace(args: WatchdogArgs) -> Self {
        Self { pace: None, ..Self::new(args) }
    }

    /// What was made of a picture that came and was taken at these times, the second in seconds, is said at `now`.
    pub(crate) fn restart(&mut self, came: Instant, taken_s: f64, now: Instant) {
        let is_live = self.pace.as_mut().is_none_or(|pace| pace.is_live(came, taken_s));
        self.since = is_live.then_some(now);
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

/// Slower than half as fast as they were taken, and later than that, seconds, no vehicle gets its pictures: what gives them so is a
/// simulator that waits for each answer.
const SLOWEST: f64 = 0.5;
const LATEST_S: f64 = 0.25;

/// How fast pictures come beside how fast they were taken.
#[derive(Debug, Default)]
struct Pace {
    /// When the first one came, and its own time, seconds.
    first: Option<(Instant, f64)>,
}

impl Pace {
    /// Whether a picture that was taken at that time, seconds, comes as a vehicle gets it.
    fn is_live(&mut self, came: Instant, taken_s: f64) -> bool {
        let (first_came, first_taken_s) = *self.first.get_or_insert((came, taken_s));
        let since_s = came.saturating_duration_since(first_came).as_secs_f64();
        since_s <= (taken_s - first_taken_s) / SLOWEST + LATEST_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_a_simulator_that_is_slower_than_time_are_not_live() {
        let began = Instant::now();
        let are_live = |step_s: f64, takes_s: f64| {
            let mut pace = Pace::default();
            let is_live = |i: u32| {
                let i = f64::from(i);
                pace.is_live(began + Duration::from_secs_f64(i * takes_s), 3.0 + i * step_s)
            };
            (0..50).map(is_live).collect::<Vec<_>>()
        };
        assert!(are_live(0.1, 0.1).iter().all(|live| *live));
        assert!(are_live(0.1, 0.12).iter().all(|live| *live));
        assert!(are_live(0.1, 0.01).iter().all(|live| *live));
        // Of the first nobody knows.
        let slow = are_live(0.08, 0.6);
        assert!(slow[0] && slow[1..].iter().all(|live| !live), "{slow:?}");
    }

    fn watchdog(no_watchdog: bool) -> Watchdog {
        Watchdog::new(WatchdogArgs { watchdog_s: None, no_watchdog })
    }

    #[test]
    fn a_silence_is_told_once_and_again_after_the_next_picture() {
        let began = Instant::now();
        let at = |ms: u64| began + Duration::from_millis(ms);
        let mut watchdog = watchdog(false);
        assert_eq!(watchdog.silence(at(10_000)), None, "before the first picture nothing was advised");
        watchdog.restart(at(10_000), 0.0, at(10_000));
        assert_eq!(watchdog.silence(at(10_499)), None);
        assert_eq!(watchdog.silence(at(10_500)), Some(Duration::from_millis(500)));
        // For as long as it could not be told.
        assert_eq!(watchdog.silence(at(10_550)), Some(Duration::from_millis(550)));
        watchdog.rest();
        assert_eq!(watchdog.silence(at(20_000)), None);
        watchdog.restart(at(20_000), 10.0, at(20_000));
        assert_eq!(watchdog.silence(at(20_100)), None);
        assert!(watchdog.silence(at(21_000)).is_some());
    }

    #[test]
    fn without_a_watchdog_nothing_is_told() {
        let mut watchdog = watchdog(true);
        let now = Instant::now();
        watchdog.restart(now, 0.0, now);
        assert_eq!(watchdog.silence(now + Duration::from_secs(1000)), None);
    }
}

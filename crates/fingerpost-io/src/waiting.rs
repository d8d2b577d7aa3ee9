//! How long others are waited for: who writes a pipe, a camera, a program.

use std::{
    io::{self, ErrorKind},
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

/// What is waited for an input that gives nothing, where nobody says: network cameras answer within ten seconds, and
/// their key frames, before which nothing can be decoded, come every ten seconds at the most.
pub const DEFAULT_LONGEST_WAIT: Duration = Duration::from_secs(30);

/// The longest time without looking whether waiting is to end: "within a second" with room to spare.
const GLANCE: Duration = Duration::from_millis(50);

/// What who is at work has left when all waiting is to end: together with a glance less than a second.
const GRACE: Duration = Duration::from_millis(700);

static LONGEST: OnceLock<Duration> = OnceLock::new();

/// Says how long an input may give nothing before it counts as stalled: a pipe, a camera, a stream, a program. To be called
/// before any is opened; the first call holds.
pub fn set_longest_wait(longest: Duration) {
    // A second call has come too late to hold for all.
    let _ = LONGEST.set(longest);
}

/// How long somebody is waited for, and what ends the waiting before.
#[derive(Debug, Clone)]
pub(crate) struct Patience {
    longest: Duration,
    stop: Option<Arc<AtomicBool>>,
    grace: Duration,
}

impl Patience {
    /// As long as [`set_longest_wait`] says, or until `stop` is set.
    pub(crate) fn new(stop: Option<Arc<AtomicBool>>) -> Self {
        let longest = LONGEST.get().copied().unwrap_or(DEFAULT_LONGEST_WAIT);
        Self { longest, stop, grace: Duration::ZERO }
    }

    /// The same for what is to be ended well: a little longer when `stop` is set.
    pub(crate) fn with_grace(self) -> Self {
        Self { grace: GRACE, ..self }
    }

    /// How long somebody is waited for at the most.
    pub(crate) fn longest(&self) -> Duration {
        self.longest
    }

    /// Whether all waiting is to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::SeqCst))
    }

    /// Asks until there is an answer. What asks waits for the time it is given, no longer.
    ///
    /// # Errors
    /// [`ErrorKind::TimedOut`] when there is none in time, [`ErrorKind::Other`] when waiting is to end, and those of `ask`.
    pub(crate) fn until<T>(&self, mut ask: impl FnMut(Duration) -> io::Result<Option<T>>) -> io::Result<T> {
        let began = Instant::now();
        let mut stopped = None;
        // The first questions follow each other fast, because most are answered at once.
        let mut glance = Duration::from_millis(1);
        loop {
            if let Some(answer) = ask(glance)? {
                return Ok(answer);
            }
            if self.is_stopped() && stopped.get_or_insert_with(Instant::now).elapsed() >= self.grace {
                return Err(io::Error::other("waiting was ended"));
            }
            if began.elapsed() >= self.longest {
                let cause = format!("nothing came for {} s", self.longest.as_secs_f64());
                return Err(io::Error::new(ErrorKind::TimedOut, cause));
            }
            glance = (2 * glance).min(GLANCE);
        }
    }

    /// Waits until there is something to be read, or the end, while `check` finds nothing wrong.
    ///
    /// # Errors
    /// As [`Patience::until`], and those of `check`.
    #[cfg(unix)]
    pub(crate) fn readable(
        &self,
        from: &impl std::os::fd::AsFd,
        mut check: impl FnMut() -> io::Result<()>,
    ) -> io::Result<()> {
        self.until(|glance| {
            check()?;
            is_ready(from, rustix::event::PollFlags::IN, glance)
        })
    }

    /// Waits until something can be written, or nobody reads any more.
    ///
    /// # Errors
    /// As [`Patience::until`].
    #[cfg(unix)]
    pub(crate) fn writable(&self, to: &impl std::os::fd::AsFd) -> io::Result<()> {
        self.until(|glance| is_ready(to, rustix::event::PollFlags::OUT, glance))
    }
}

#[cfg(unix)]
fn is_ready(
    end: &impl std::os::fd::AsFd,
    what: rustix::event::PollFlags,
    glance: Duration,
) -> io::Result<Option<()>> {
    use rustix::event::{PollFd, Timespec, poll};
    let longest = Timespec::try_from(glance).map_err(io::Error::other)?;
    match poll(&mut [PollFd::new(end, what)], Some(&longest)) {
        // A signal that was handled.
        Ok(0) | Err(rustix::io::Errno::INTR) => Ok(None),
        // What is wrong with it is told by reading or writing.
        _ => Ok(Some(())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patience(longest: Duration, stop: Option<Arc<AtomicBool>>) -> Patience {
        Patience { longest, stop, grace: Duration::ZERO }
    }

    #[test]
    fn who_never_answers_is_given_up() {
        let began = Instant::now();
        let never = patience(Duration::from_millis(80), None).until(|glance| {
            std::thread::sleep(glance);
            Ok(None::<()>)
        });
        assert_eq!(never.unwrap_err().kind(), ErrorKind::TimedOut);
        assert!(began.elapsed() >= Duration::from_millis(80));
    }

    #[test]
    fn waiting_ends_when_it_is_to_end() {
        let stop = Arc::new(AtomicBool::new(false));
        let mut asked = 0;
        let ended = patience(Duration::from_secs(600), Some(Arc::clone(&stop))).until(|_| {
            asked += 1;
            stop.store(asked == 3, Ordering::SeqCst);
            Ok(None::<()>)
        });
        assert_eq!((ended.unwrap_err().kind(), asked), (ErrorKind::Other, 3));
    }

    #[test]
    fn answers_are_passed_on() {
        let patience = patience(Duration::ZERO, None);
        assert_eq!(patience.until(|_| Ok(Some(7))).unwrap(), 7);
        let broken = patience.until(|_| Err::<Option<()>, _>(ErrorKind::BrokenPipe.into()));
        assert_eq!(broken.unwrap_err().kind(), ErrorKind::BrokenPipe);
    }
}

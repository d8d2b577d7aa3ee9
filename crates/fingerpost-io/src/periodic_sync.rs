//! Bringing a growing file to the disk at intervals, without holding up whoever writes it.

use std::{
    io,
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{RecvTimeoutError, Sender, channel},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

/// Calls a function at intervals in a thread of its own, and once more at its end.
#[derive(Debug)]
pub(crate) struct PeriodicSync {
    /// Dropped to end the thread.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
    failure: Arc<Mutex<Option<io::Error>>>,
}

impl PeriodicSync {
    /// Calls `sync` after every `interval`.
    ///
    /// # Errors
    /// When the system has no more threads.
    pub(crate) fn start(
        interval: Duration,
        mut sync: impl FnMut() -> io::Result<()> + Send + 'static,
    ) -> io::Result<Self> {
        let (end, ended) = channel::<()>();
        let failure = Arc::new(Mutex::new(None));
        let told = Arc::clone(&failure);
        let work = move || {
            loop {
                let at_end = ended.recv_timeout(interval) != Err(RecvTimeoutError::Timeout);
                if let Err(cause) = sync() {
                    *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(cause);
                }
                if at_end {
                    return;
                }
            }
        };
        let thread = thread::Builder::new().name("sync".to_owned()).spawn(work)?;
        Ok(Self { end: Some(end), thread: Some(thread), failure })
    }

    /// The error of a call since this was last asked.
    pub(crate) fn failure(&self) -> io::Result<()> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// Calls it a last time, and says whether that or an earlier call failed.
    ///
    /// # Errors
    /// Whatever the function said.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        self.join();
        self.failure()
    }

    fn join(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            // The thread's failures are kept where `failure` finds them.
            let _ = thread.join();
        }
    }
}

impl Drop for PeriodicSync {
    fn drop(&mut self) {
        self.join();
    }
}

#[cfg(test)]
mod tests {
    use std::{
        sync::atomic::{AtomicUsize, Ordering},
        time::Instant,
    };

    use super::*;

    #[test]
    fn it_is_called_again_and_again_and_at_the_end() {
        let calls = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&calls);
        let count = move || {
            counted.fetch_add(1, Ordering::SeqCst);
            Ok(())
        };
        let sync = PeriodicSync::start(Duration::from_millis(1), count.clone()).unwrap();
        let patience = Instant::now();
        while calls.load(Ordering::SeqCst) < 3 {
            assert!(patience.elapsed() < Duration::from_secs(60), "it is not called");
            thread::sleep(Duration::from_millis(1));
        }
        drop(sync);
        let before = calls.load(Ordering::SeqCst);
        PeriodicSync::start(Duration::from_secs(600), count).unwrap().finish().unwrap();
        assert_eq!(calls.load(Ordering::SeqCst), before + 1);
    }

    #[test]
    fn a_failure_is_told_once() {
        let full = || Err(io::Error::from(io::ErrorKind::StorageFull));
        let sync = PeriodicSync::start(Duration::from_secs(600), full).unwrap();
        assert_eq!(sync.finish().unwrap_err().kind(), io::ErrorKind::StorageFull);
    }
}

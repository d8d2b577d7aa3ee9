//! Which connections are open, which of them wait, and which has to go.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;
use tokio::time::{Duration, Instant, sleep_until};

use super::Limits;

/// The open connections.
#[derive(Debug, Default)]
pub(crate) struct Connections {
    open: Mutex<Open>,
}

#[derive(Debug, Default)]
struct Open {
    next_number: u64,
    by_number: BTreeMap<u64, Entry>,
}

#[derive(Debug)]
struct Entry {
    activity: Activity,
    since: Instant,
    close: Arc<Notify>,
}

/// What a connection is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Activity {
    /// Nothing, or its next request's head is coming in, or its last answer is being taken.
    Idle,
    /// A request is being read or answered.
    Request,
}

/// A connection's place among the open ones; dropped, it is free.
#[derive(Debug)]
pub(crate) struct Place {
    connections: Arc<Connections>,
    number: u64,
    close: Arc<Notify>,
}

impl Connections {
    /// A place for a new connection. Where all are taken, the connection that has been idle for longest is asked to close; none
    /// where no connection is idle.
    pub(crate) fn take(self: &Arc<Self>, limits: &Limits) -> Option<Place> {
        let mut open = self.open();
        if open.by_number.len() >= limits.connections {
            open.close_longest_idle()?;
        }
        let number = open.next_number;
        open.next_number += 1;
        let close = Arc::new(Notify::new());
        let entry = Entry { activity: Activity::Idle, since: Instant::now(), close: Arc::clone(&close) };
        open.by_number.insert(number, entry);
        Some(Place { connections: Arc::clone(self), number, close })
    }

    /// Asks the connection that has been idle for longest to close: the system has no room for another.
    pub(crate) fn make_room(&self) {
        // Without an idle one the requests under way make room when they end.
        let _ = self.open().close_longest_idle();
    }

    /// Whether a request is being read or answered.
    pub(crate) fn are_busy(&self) -> bool {
        self.open().by_number.values().any(|entry| entry.activity == Activity::Request)
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Open {
    fn close_longest_idle(&mut self) -> Option<()> {
        let idle = self.by_number.iter().filter(|(_, entry)| entry.activity == Activity::Idle);
        let number = *idle.min_by_key(|(number, entry)| (entry.since, **number))?.0;
        self.by_number.remove(&number)?.close.notify_one();
        Some(())
    }
}

impl Place {
    /// A request's head is in.
    pub(crate) fn begin_request(&self) {
        self.now(Activity::Request);
    }

    /// A request's answer is made.
    pub(crate) fn end_request(&self) {
        self.now(Activity::Idle);
    }

    fn now(&self, activity: Activity) {
        if let Some(entry) = self.connections.open().by_number.get_mut(&self.number) {
            (entry.activity, entry.since) = (activity, Instant::now());
        }
    }

    /// Comes to an end when the connection has to close: asked to, or at the end of its time.
    pub(crate) async fn has_to_close(&self, limits: &Limits) {
        loop {
            let Some(until) = self.time_ends(limits) else { return };
            if until <= Instant::now() {
                return;
            }
            tokio::select! {
                biased;
                () = self.close.notified() => return,
                // An hour stands for times that the clock cannot hold.
                () = sleep_until(until.min(Instant::now() + Duration::from_secs(3600))) => {}
            }
        }
    }

    /// When the time of what the connection is at ends; none where its place is gone.
    fn time_ends(&self, limits: &Limits) -> Option<Instant> {
        let open = self.connections.open();
        let entry = open.by_number.get(&self.number)?;
        let granted = match entry.activity {
            Activity::Idle => limits.idle_time,
            Activity::Request => limits.request_time,
        };
        Some(entry.since.checked_add(granted).unwrap_or(entry.since))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.connections.open().by_number.remove(&self.number);
    }
}

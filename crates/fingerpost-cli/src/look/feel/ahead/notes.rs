//! What a stage found, frame by frame, handed from the thread that finds it to the one that waits for it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// What a stage found in each frame that it was asked about, in their order; or why it refused the frame.
#[derive(Debug)]
pub(super) struct Notes<T> {
    found: Mutex<Found<T>>,
    changed: Condvar,
}

#[derive(Debug)]
struct Found<T> {
    frames: Vec<Arc<Result<T, String>>>,
    /// No more will come.
    is_whole: bool,
}

impl<T> Default for Notes<T> {
    fn default() -> Self {
        Self { found: Mutex::new(Found { frames: Vec::new(), is_whole: false }), changed: Condvar::new() }
    }
}

impl<T> Notes<T> {
    fn found(&self) -> MutexGuard<'_, Found<T>> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Found<T>)) {
        change(&mut self.found());
        self.changed.notify_all();
    }

    /// Waits for those of a frame; none where the stage ended before it.
    fn frame(&self, index: usize) -> Option<Arc<Result<T, String>>> {
        let mut found = self.found();
        loop {
            match found.frames.get(index) {
                Some(note) => return Some(Arc::clone(note)),
                None if found.is_whole => return None,
                None => found = self.changed.wait(found).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }
}

/// Writes notes; with it they end.
#[derive(Debug)]
pub(super) struct Writer<T> {
    notes: Arc<Notes<T>>,
    is_last: Arc<AtomicBool>,
}

impl<T> Writer<T> {
    /// Of notes that have not begun; `is_last` is set before the last frame.
    pub(super) fn of(notes: &Arc<Notes<T>>, is_last: &Arc<AtomicBool>) -> Self {
        Self { notes: Arc::clone(notes), is_last: Arc::clone(is_last) }
    }

    /// Writes down what was found in the next frame.
    pub(super) fn write(&self, note: Result<T, String>) {
        self.notes.change(|found| found.frames.push(Arc::new(note)));
    }

    /// Whether this is the last frame, the one that is drawn.
    pub(super) fn is_at_last(&self) -> bool {
        self.is_last.load(Ordering::Relaxed)
    }
}

impl<T> Drop for Writer<T> {
    fn drop(&mut self) {
        self.notes.change(|found| found.is_whole = true);
    }
}

/// Reads notes from their beginning on.
#[derive(Debug)]
pub(super) struct Reader<T> {
    notes: Arc<Notes<T>>,
    next: usize,
    current: Option<Arc<Result<T, String>>>,
}

impl<T> Reader<T> {
    /// Before the first frame.
    pub(super) fn of(notes: &Arc<Notes<T>>) -> Self {
        Self { notes: Arc::clone(notes), next: 0, current: None }
    }

    /// What was found in the next frame, or why nothing was.
    pub(super) fn next(&mut self) -> Result<&T, String> {
        self.current = self.notes.frame(self.next);
        self.next += 1;
        match self.current.as_deref() {
            Some(Ok(note)) => Ok(note),
            Some(Err(cause)) => Err(cause.clone()),
            None => Err("the stretch was not found to its end".to_owned()),
        }
    }

    /// What was found in the frame that was asked for last.
    pub(super) fn current(&self) -> Option<&T> {
        self.current.as_deref()?.as_ref().ok()
    }

    /// Goes back to the beginning.
    pub(super) fn begin_again(&mut self) {
        (self.next, self.current) = (0, None);
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    #[test]
    fn who_reads_waits_for_who_writes_and_for_no_more_than_comes() {
        let notes = Arc::default();
        let is_last = Arc::default();
        let mut reader = Reader::of(&notes);
        thread::scope(|scope| {
            let writer = Writer::of(&notes, &is_last);
            scope.spawn(move || {
                writer.write(Ok(7));
                writer.write(Err("too dark".to_owned()));
            });
            assert_eq!(reader.next(), Ok(&7));
            assert_eq!(reader.current(), Some(&7));
            assert_eq!(reader.next(), Err("too dark".to_owned()));
            assert_eq!(reader.current(), None);
            assert!(reader.next().is_err(), "the writer has ended");
        });
        // What is whole is read again and again.
        reader.begin_again();
        assert_eq!(reader.next(), Ok(&7));
        assert_eq!(Reader::of(&notes).next(), Ok(&7));
    }
}

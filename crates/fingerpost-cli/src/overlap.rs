//! Making results and writing them at the same time.
//!
//! Results wait in a queue of a few: where writing is the slower of the two, making waits for it, and memory stays bounded.
//! Whatever fails, results made before are written, in their order.

use std::panic::resume_unwind;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread;

use anyhow::Result;

/// Results that may wait to be written: enough to go on with while pictures are compressed.
const WAITING: usize = 8;

/// Whether making and writing take turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Overlap {
    /// One thread does both.
    None,
    /// Writing has a thread of its own.
    Writing,
}

/// Makes results one by one and writes each of them, up to the first that cannot be made or written.
pub(crate) fn each<T: Send>(
    overlap: Overlap,
    results: impl Iterator<Item = Result<T>>,
    mut write: impl FnMut(T) -> Result<()> + Send,
) -> Result<()> {
    if overlap == Overlap::None {
        for result in results {
            write(result?)?;
        }
        return Ok(());
    }
    overlapped(results, |_, result, to| to.send(result).is_ok(), write)
}

/// How often what makes results is looked after while it waits for the writing.
#[cfg(feature = "ros2")]
const LOOKED_AFTER_EVERY: std::time::Duration = std::time::Duration::from_millis(20);

/// The same with writing in a thread of its own, where what makes results has to be looked after while it waits for the writing.
#[cfg(feature = "ros2")]
pub(crate) fn each_attended<T: Send, I: Iterator<Item = Result<T>>>(
    results: I,
    mut attend: impl FnMut(&mut I),
    write: impl FnMut(T) -> Result<()> + Send,
) -> Result<()> {
    use std::sync::mpsc::TrySendError;

    let hand_over = |results: &mut I, mut result: T, to: &SyncSender<T>| loop {
        match to.try_send(result) {
            Ok(()) => return true,
            Err(TrySendError::Disconnected(_)) => return false,
            Err(TrySendError::Full(back)) => result = back,
        }
        attend(results);
        thread::sleep(LOOKED_AFTER_EVERY);
    };
    overlapped(results, hand_over, write)
}

/// Makes results and hands them over to the writing, until there are no more or the writing has failed, which `hand_over` says.
fn overlapped<T: Send, I: Iterator<Item = Result<T>>>(
    mut results: I,
    mut hand_over: impl FnMut(&mut I, T, &SyncSender<T>) -> bool,
    write: impl FnMut(T) -> Result<()> + Send,
) -> Result<()> {
    thread::scope(|scope| {
        let (sender, made) = sync_channel(WAITING);
        let writing = scope.spawn(move || made.into_iter().try_for_each(write));
        let making = loop {
            match results.next() {
                Some(Ok(result)) => {
                    if !hand_over(&mut results, result, &sender) {
                        // Writing has failed and says why.
                        break Ok(());
                    }
                }
                Some(Err(cause)) => break Err(cause),
                None => break Ok(()),
            }
        };
        drop(sender);
        let written = writing.join().unwrap_or_else(|fault| resume_unwind(fault));
        // What could not be written comes before what could not be made.
        written.and(making)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    use anyhow::anyhow;

    use super::*;

    /// Makes numbers up to `end`, of which `fails` cannot be made; writing `refused` fails. What was written, and the error.
    fn written(overlap: Overlap, end: u32, fails: u32, refused: u32) -> (Vec<u32>, Option<String>) {
        let mut written = Vec::new();
        let numbers = (0..end).map(|n| if n == fails { Err(anyhow!("{n} not made")) } else { Ok(n) });
        let error = each(overlap, numbers, |n| {
            if n == refused {
                return Err(anyhow!("{n} not written"));
            }
            written.push(n);
            Ok(())
        });
        (written, error.err().map(|error| error.to_string()))
    }

    #[test]
    fn what_was_made_is_written_whatever_fails() {
        for overlap in [Overlap::None, Overlap::Writing] {
            assert_eq!(written(overlap, 100, 200, 200), ((0..100).collect(), None));
            assert_eq!(written(overlap, 100, 60, 200), ((0..60).collect(), Some("60 not made".to_owned())));
            assert_eq!(written(overlap, 100, 200, 7), ((0..7).collect(), Some("7 not written".to_owned())));
            // Both fail: the earlier result is the one that is missing.
            assert_eq!(written(overlap, 100, 9, 7), ((0..7).collect(), Some("7 not written".to_owned())));
        }
    }

    #[cfg(feature = "ros2")]
    #[test]
    fn making_is_looked_after_while_it_waits() {
        let mut attended = 0;
        let slowly = |_| {
            thread::sleep(Duration::from_millis(30));
            Ok(())
        };
        let all = each_attended((0..2 * WAITING).map(Ok), |_| attended += 1, slowly);
        assert!(all.is_ok() && attended > 0, "{all:?}, {attended}");
    }

    #[test]
    fn slow_writing_holds_making_up() {
        let (made, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let numbers = (0..50).map(|n| {
            let ahead = made.fetch_add(1, Ordering::SeqCst) - done.load(Ordering::SeqCst);
            // Those that wait, one in the writer's hands and one on its way.
            if ahead > WAITING + 2 { Err(anyhow!("{ahead} results wait")) } else { Ok(n) }
        });
        let all = each(Overlap::Writing, numbers, |_| {
            thread::sleep(Duration::from_millis(2));
            done.fetch_add(1, Ordering::SeqCst);
            Ok(())
        });
        assert!(all.is_ok(), "{all:?}");
    }
}

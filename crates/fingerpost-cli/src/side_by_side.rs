//! Pieces of work side by side, each in a thread of its own.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use anyhow::Result;

use crate::arguments::Threads;
use crate::interrupt::Interrupt;

/// Does pieces of work by their number until `count` are done, one fails or an end is wanted, each thread taking the next one when
/// it has finished one; as many threads as the machine has processor cores where no number is given.
pub(crate) fn each(
    threads: Option<Threads>,
    count: u64,
    interrupt: &Interrupt,
    work: impl Fn(u64) -> Result<()> + Sync,
) -> Result<()> {
    let threads = threads.map(|Threads(count)| count).or(thread::available_parallelism().ok());
    let next = AtomicU64::new(0);
    let worker = || -> Result<()> {
        // A piece's own parallel work stays in its thread: another piece must not begin in the middle of one.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        while !interrupt.wanted() {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                break;
            }
            pool.install(|| work(number))?;
        }
        Ok(())
    };
    thread::scope(|scope| {
        let workers: Vec<_> =
            (0..threads.map_or(1, NonZeroUsize::get)).map(|_| scope.spawn(worker)).collect();
        let mut ends = workers.into_iter().map(|worker| worker.join());
        ends.try_for_each(|end| end.unwrap_or_else(|fault| std::panic::resume_unwind(fault)))
    })
}

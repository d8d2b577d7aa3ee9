//! Interleaved timing of contestants, and what comes of it.

use std::time::Instant;

use anyhow::Result;
use fingerpost_vision::simd::{CodePath, InstructionSet};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

/// One of those that do the same work: makes that many calls, after one that does not count, and gives milliseconds a call.
pub struct Contestant<'a> {
    pub name: String,
    pub time: Box<dyn FnMut(usize) -> Result<Vec<f64>> + 'a>,
}

impl<'a> Contestant<'a> {
    /// A contestant of this process.
    pub fn here(name: &str, mut work: impl FnMut() + 'a) -> Self {
        let time = move |calls| {
            work();
            let mut milliseconds = Vec::with_capacity(calls);
            for _ in 0..calls {
                let start = Instant::now();
                work();
                milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
            }
            Ok(milliseconds)
        };
        Self { name: name.to_owned(), time: Box::new(time) }
    }

    /// A contestant of this process whose kernels use `set` at the most, in its own turns and until somebody else's limit.
    pub fn with(set: InstructionSet, name: &str, work: impl FnMut() + 'a) -> Self {
        let Self { name, mut time } = Self::here(name, work);
        let limited = move |calls| {
            CodePath::limit(set);
            time(calls)
        };
        Self { name, time: Box::new(limited) }
    }
}

/// Processor time of this thread, milliseconds: work that is longer than the system lets a thread go on takes longer by the clock
/// on a busy machine, and shorter work does not, so that costs would seem to grow.
pub fn processor_ms() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// How much is measured.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Times that every contestant has its turn; none to compare results only.
    pub rounds: usize,
    /// About how long a turn should last, milliseconds.
    pub turn_ms: f64,
}

/// Fewest calls in a turn, so that caches are warm in most of them.
const FEWEST_CALLS: usize = 3;
/// Most calls in a turn: more say nothing new of a kernel of microseconds.
const MOST_CALLS: usize = 200;

/// A contestant's median over all its turns.
#[derive(Debug, Clone, Serialize)]
pub struct Measured {
    pub name: String,
    pub median_ms: f64,
}

/// Lets the contestants take turns, the order reversed from round to round, so that whatever else the machine does meets
/// all of them.
pub fn side_by_side(effort: Effort, contestants: &mut [Contestant<'_>]) -> Result<Vec<Measured>> {
    let mut calls = Vec::new();
    for contestant in contestants.iter_mut() {
        let once_ms = median(&mut (contestant.time)(1)?);
        calls.push(((effort.turn_ms / once_ms.max(1e-6)) as usize).clamp(FEWEST_CALLS, MOST_CALLS));
    }
    let mut times = vec![Vec::new(); contestants.len()];
    for round in 0..effort.rounds {
        for turn in 0..contestants.len() {
            let who = if round % 2 == 0 { turn } else { contestants.len() - 1 - turn };
            times[who].extend((contestants[who].time)(calls[who])?);
        }
    }
    let measured = |(contestant, times): (&Contestant<'_>, &mut Vec<f64>)| Measured {
        name: contestant.name.clone(),
        median_ms: median(times),
    };
    Ok(contestants.iter().zip(&mut times).map(measured).collect())
}

/// The value below which this part of the values lies, the next higher one of them; not a number of none.
pub fn percentile(values: &mut [f64], part: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let below = (part * values.len() as f64).ceil() as usize;
    values.get(below.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

/// The middle of the values, the mean of the two middle ones where their number is even; not a number of none.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        odd if odd % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

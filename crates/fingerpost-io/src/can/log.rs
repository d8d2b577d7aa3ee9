//! The samples of chosen signals in a log.

use std::collections::BTreeSet;
use std::path::Path;

use super::candump::{CanLogError, read_can_log};
use super::frame::CanId;
use super::j1939::NoValue;
use super::layout::{SignalLayout, SignalReading};

/// Values of all signals together that are held, 1 GB: three signals of a hundred a second for two days. A packed log may hold a
/// thousand times its own size.
const MOST_SAMPLES: usize = 64_000_000;

/// Identifiers and interfaces that are kept, more than a vehicle has: those of garbage need not fit into memory.
const MOST_IDENTIFIERS: usize = 4096;
const MOST_INTERFACES: usize = 64;

/// A signal's value at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalSample {
    /// When its frame came, seconds of the log's clock.
    pub t_s: f64,
    /// Value, scaled as the DBC file says.
    pub value: f64,
}

/// Messages that say of a signal that it has no value.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NoValues {
    /// How many say that it is not available.
    pub not_available: u64,
    /// How many that it is in error.
    pub errors: u64,
    /// When the first of them came, seconds of the log's clock.
    pub first_s: Option<f64>,
}

impl NoValues {
    /// Counts one.
    pub(super) fn add(&mut self, t_s: f64, no_value: NoValue) {
        match no_value {
            NoValue::NotAvailable => self.not_available += 1,
            NoValue::Error => self.errors += 1,
        }
        self.first_s.get_or_insert(t_s);
    }

    /// All of them.
    pub const fn count(&self) -> u64 {
        self.not_available + self.errors
    }
}

/// What a log says of some signals.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SignalLog {
    /// When the first frame of all came, seconds of the log's clock.
    pub first_s: f64,
    /// When the last one came.
    pub last_s: f64,
    /// The samples of each signal, in the order of the signals that were asked for and of time.
    pub samples: Vec<Vec<SignalSample>>,
    /// Messages that say of each signal that it has no value.
    pub no_values: Vec<NoValues>,
    /// Data frames of all messages.
    pub frames: u64,
    /// Lines that are none of a log's.
    pub unreadable_lines: u64,
    /// The identifiers of each signal's frames, in the order of the signals: of J1939, the first of each sender.
    pub senders: Vec<BTreeSet<CanId>>,
    /// The identifiers of all frames of the interface, the first of them where there are very many.
    pub came: BTreeSet<CanId>,
    /// The interfaces of all frames.
    pub interfaces: BTreeSet<String>,
}

impl SignalLog {
    /// Reads a whole log for these signals, of one interface where it is named.
    ///
    /// # Errors
    /// [`CanLogError`] when it cannot be read, is no log, steps back in time or says more than 64 million values.
    pub fn read(path: &Path, interface: Option<&str>, signals: &[SignalLayout]) -> Result<Self, CanLogError> {
        let mut log = Self {
            samples: vec![Vec::new(); signals.len()],
            no_values: vec![NoValues::default(); signals.len()],
            senders: vec![BTreeSet::new(); signals.len()],
            ..Self::default()
        };
        let mut lines = read_can_log(path)?;
        let mut held = 0;
        while let Some(frame) = lines.next_frame()? {
            if log.frames == 0 {
                log.first_s = frame.t_s;
            }
            log.last_s = frame.t_s;
            log.frames += 1;
            if log.interfaces.len() < MOST_INTERFACES && !log.interfaces.contains(frame.interface) {
                log.interfaces.insert(frame.interface.to_owned());
            }
            if interface.is_some_and(|wanted| wanted != frame.interface) {
                continue;
            }
            let id = frame.frame.id;
            if log.came.len() < MOST_IDENTIFIERS {
                log.came.insert(id);
            }
            for (index, signal) in signals.iter().enumerate() {
                let Some(reading) = signal.decode(&frame.frame) else { continue };
                let senders = &mut log.senders[index];
                if !senders.iter().any(|known| signal.is_same_sender(*known, id)) {
                    senders.insert(id);
                }
                match reading {
                    SignalReading::Value(value) => {
                        log.samples[index].push(SignalSample { t_s: frame.t_s, value });
                        held += 1;
                    }
                    SignalReading::NoValue(no_value) => log.no_values[index].add(frame.t_s, no_value),
                }
            }
            if held > MOST_SAMPLES {
                return Err(CanLogError::TooManySamples { path: path.to_owned(), most: MOST_SAMPLES });
            }
        }
        for samples in &mut log.samples {
            // Two interfaces in one log may be a little out of step.
            samples.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        }
        log.unreadable_lines = lines.unreadable_lines;
        Ok(log)
    }
}

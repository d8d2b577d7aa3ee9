//! What is wrong with a motion log: said, counted, and survived.

use std::path::Path;

use fingerpost_format::{ColumnsError, MotionFaults, MotionLog, MotionLogRow};
use fingerpost_locate::{LONGEST_GAP_S, MotionError};

use crate::output;

/// Watches the rows go by.
#[derive(Debug, Default)]
pub(super) struct FaultWatch {
    faults: MotionFaults,
    /// The first thing that is wrong, in words.
    first: Option<String>,
    before: Option<MotionLogRow>,
    /// Since when nothing has changed, seconds.
    same_since_s: f64,
}

impl FaultWatch {
    /// Begins with the lines that are no rows.
    pub(super) fn of(log: &MotionLog) -> Self {
        let count =
            |is_such: fn(&ColumnsError) -> bool| log.passed_over.iter().filter(|e| is_such(e)).count();
        let faults = MotionFaults {
            not_numbers: count(|error| matches!(error, ColumnsError::NotANumber { .. })),
            not_later: count(|error| matches!(error, ColumnsError::NotLater { .. })),
            ..MotionFaults::default()
        };
        Self { faults, first: log.passed_over.first().map(ToString::to_string), ..Self::default() }
    }

    /// Says that lines are passed over, where some are.
    pub(super) fn say(&self, path: &Path) {
        if let Some(first) = &self.first {
            let MotionFaults { not_numbers, not_later, .. } = self.faults;
            output::message(&format!(
                "{}: {} lines are passed over; the first: {first}",
                path.display(),
                not_numbers + not_later
            ));
        }
    }

    /// A row that the locator has refused.
    pub(super) fn refuse(&mut self, error: &MotionError) {
        if self.faults.impossible == 0 {
            output::message(&format!("a row is passed over: {error}"));
        }
        self.faults.impossible += 1;
    }

    /// A row that was taken in: gives how long nothing was measured before it, where that was long.
    pub(super) fn watch(&mut self, row: &MotionLogRow) -> Option<f64> {
        let before = self.before.replace(*row);
        let goes_on = before.is_some_and(|before| {
            row.speed_mps != 0.0
                && (row.speed_mps, row.yaw_rate_rps) == (before.speed_mps, before.yaw_rate_rps)
        });
        if !goes_on {
            self.same_since_s = row.t_s;
        }
        self.faults.longest_repeat_s = self.faults.longest_repeat_s.max(row.t_s - self.same_since_s);
        let unseen_s = row.t_s - before?.t_s;
        if unseen_s <= LONGEST_GAP_S {
            return None;
        }
        self.faults.gaps += 1;
        self.faults.longest_gap_s = self.faults.longest_gap_s.max(unseen_s);
        Some(unseen_s)
    }

    pub(super) const fn faults(&self) -> MotionFaults {
        self.faults
    }
}

//! What of a recording could not be used.

/// Messages and lines that could not be used.
#[derive(Debug, Default)]
pub(super) struct PassedOver {
    /// How many.
    pub(super) count: u64,
    /// Why not the first.
    pub(super) first_reason: Option<String>,
}

impl PassedOver {
    /// Counts one; the reason is asked for of the first alone.
    pub(super) fn add(&mut self, reason: impl FnOnce() -> String) {
        self.count += 1;
        self.first_reason.get_or_insert_with(reason);
    }

    /// Adds those of a later step.
    pub(super) fn extend(&mut self, later: Self) {
        self.count += later.count;
        self.first_reason = self.first_reason.take().or(later.first_reason);
    }
}

//! What of a GPS log cannot be read and costs itself alone.

/// Positions, and times of positions, that cannot be read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PassedOver {
    /// How many.
    pub count: usize,
    /// The first of them.
    pub first: Option<UnreadPlace>,
}

/// A place in a log that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {cause}")]
pub struct UnreadPlace {
    /// Its line, from one.
    pub line: usize,
    /// What is wrong there.
    pub cause: String,
}

impl PassedOver {
    /// Counts one; where it is and what is wrong with it is asked for the first alone.
    pub(crate) fn add(&mut self, place: impl FnOnce() -> UnreadPlace) {
        self.count += 1;
        if self.first.is_none() {
            self.first = Some(place());
        }
    }
}

//! Names of the frames of a recording: each kept once, in bounds.

use std::collections::BTreeSet;
use std::sync::Arc;

use thiserror::Error;

use super::topics::MOST_NAME_BYTES;

/// Frames that a recording may name: one for each channel that MCAP can number.
pub(super) const MOST_FRAMES: usize = 1 << 16;

/// A name that is not kept.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FrameNameError {
    /// It is longer than any.
    #[error(
        "the name of its frame has {bytes} bytes, more than the {MOST_NAME_BYTES} that any may have; its sender is at fault"
    )]
    Long {
        /// Its bytes.
        bytes: usize,
    },
    /// There are too many.
    #[error("it names more frames than the {MOST_FRAMES} that a recording may have; its sender is at fault")]
    Many,
}

/// A frame's name out of a message, if it is no longer than a name may be.
pub(super) fn bounded(name: &str) -> Result<Arc<str>, FrameNameError> {
    if name.len() > MOST_NAME_BYTES {
        return Err(FrameNameError::Long { bytes: name.len() });
    }
    Ok(name.into())
}

/// The names so far.
#[derive(Debug, Clone, Default)]
pub(super) struct FrameNames(BTreeSet<Arc<str>>);

impl FrameNames {
    /// The one copy of a name.
    pub(super) fn shared(&mut self, name: &str) -> Result<Arc<str>, FrameNameError> {
        if let Some(known) = self.0.get(name) {
            return Ok(Arc::clone(known));
        }
        let name = bounded(name)?;
        if self.0.len() == MOST_FRAMES {
            return Err(FrameNameError::Many);
        }
        self.0.insert(Arc::clone(&name));
        Ok(name)
    }
}

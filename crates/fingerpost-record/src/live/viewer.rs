//! What waits for a viewer.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use crate::recording::FrameMessages;

/// Frames that may wait for a viewer: a second of the drive at usual rates; older ones are of no use any more.
const WAITING_FRAMES: usize = 10;

/// The frames that a viewer has not been sent yet.
#[derive(Debug, Default)]
pub(crate) struct Viewer {
    waiting: Mutex<VecDeque<Arc<FrameMessages>>>,
}

impl Viewer {
    /// Adds a frame; the oldest one is dropped where too many wait.
    pub(crate) fn add(&self, frame: &Arc<FrameMessages>) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.len() == WAITING_FRAMES {
            waiting.pop_front();
        }
        waiting.push_back(Arc::clone(frame));
    }

    /// The oldest frame that waits.
    pub(crate) fn take(&self) -> Option<Arc<FrameMessages>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewer_that_takes_nothing_loses_the_oldest() {
        let viewer = Viewer::default();
        for frame in 0..25 {
            viewer.add(&Arc::new(FrameMessages { frame, t_s: 0.0, messages: Vec::new() }));
        }
        let taken: Vec<u64> = std::iter::from_fn(|| viewer.take()).map(|frame| frame.frame).collect();
        assert_eq!(taken, (15..25).collect::<Vec<_>>());
    }
}

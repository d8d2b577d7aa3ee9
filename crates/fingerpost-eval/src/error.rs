//! What keeps a run and a truth from being compared.

use thiserror::Error;

/// A run and a truth that do not belong together.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EvalError {
    /// A run without frames.
    #[error("the run has no frames; there is nothing to compare")]
    NoFrames,
    /// A frame of the run that the truth does not have.
    #[error(
        "frame {frame} of the run has no truth: the truth has {truths} frames, {first} to {last}; give the truth of \
         the same drive"
    )]
    NoTruth {
        /// Frame of the run.
        frame: u64,
        /// Frames of the truth.
        truths: usize,
        /// First frame of the truth.
        first: u64,
        /// Last frame of the truth.
        last: u64,
    },
    /// Frames that do not ascend.
    #[error("the {what} has frame {frame} behind frame {before}; frames must ascend")]
    NotAscending {
        /// `run` or `truth`.
        what: &'static str,
        /// The frame.
        frame: u64,
        /// The frame before it in the file.
        before: u64,
    },
    /// A feature in the truth that the route does not have.
    #[error(
        "frame {frame} of the truth has feature {id}, which is none of the route's {features} features; give the truth \
         of the same route"
    )]
    OtherRoute {
        /// Frame of the truth.
        frame: u64,
        /// OpenStreetMap node.
        id: i64,
        /// Features of the route.
        features: usize,
    },
    /// No motion was estimated.
    #[error("no frame of the run has a motion; there is nothing to compare")]
    NoMotion,
    /// A vehicle that stood all along.
    #[error("the truth does not move; an error in percent of the distance driven has no meaning")]
    Standing,
    /// Probabilities and labels of different numbers of pixels.
    #[error(
        "{probabilities} pixels of road probability and {labels} of labels; give labels of the picture's size"
    )]
    LabelCount {
        /// Pixels with a probability.
        probabilities: usize,
        /// Pixels with a label.
        labels: usize,
    },
    /// No road in the labels.
    #[error("no pixel of the labels is road ({road}); give the number that the labels have for road")]
    NoRoad {
        /// Label of road.
        road: u8,
    },
}

/// Checks that frames ascend.
pub(crate) fn check_ascending(
    what: &'static str,
    frames: impl Iterator<Item = u64> + Clone,
) -> Result<(), EvalError> {
    let pairs = frames.clone().zip(frames.skip(1));
    match pairs.into_iter().find(|(before, frame)| frame <= before) {
        Some((before, frame)) => Err(EvalError::NotAscending { what, frame, before }),
        None => Ok(()),
    }
}

//! What keeps lane edges and their truth from being compared.

use thiserror::Error;

use crate::EvalError;

/// Lane edges and a truth that do not belong together.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LaneError {
    /// The frames do not match.
    #[error(transparent)]
    Frames(#[from] EvalError),
    /// Two sizes of the pictures.
    #[error(
        "the run's pictures have {} x {} pixels and the truth's {} x {}; give the truth of the same pictures at the same size",
        .run_px[0], .run_px[1], .truth_px[0], .truth_px[1]
    )]
    PictureSize {
        /// Width and height of the run's pictures.
        run_px: [u32; 2],
        /// Width and height of the truth's pictures.
        truth_px: [u32; 2],
    },
    /// The truth has more than one size.
    #[error(
        "frame {frame} of the truth has a picture of {} x {} pixels and those before {} x {}; give the truth of one drive",
        .picture_px[0], .picture_px[1], .before_px[0], .before_px[1]
    )]
    SizeChanges {
        /// Frame of the truth.
        frame: u64,
        /// Its width and height.
        picture_px: [u32; 2],
        /// Width and height before it.
        before_px: [u32; 2],
    },
    /// No size is known.
    #[error(
        "neither the run nor the truth says how large the pictures are, and rows are counted from their base; give \
         --picture-size WIDTHxHEIGHT"
    )]
    NoPictureSize,
    /// The truth lies outside the pictures.
    #[error(
        "frame {frame} of the truth has a lane edge at row {row}, and the pictures have {height} rows; give the truth of the \
         same pictures at the same size"
    )]
    Outside {
        /// Frame of the truth.
        frame: u64,
        /// The row, pixels.
        row: f64,
        /// Rows of the pictures.
        height: u32,
    },
    /// Edges that a region of interest does not reach.
    #[error(
        "the truth has lane edges, but none in the lowest {roi_rows} rows of the picture; give a truth whose edges go on down \
         to the picture's base, as `fingerpost mark` exports it"
    )]
    NoEdges {
        /// Rows of the region of interest.
        roi_rows: u32,
    },
    /// Another number of labelled pictures than of frames.
    #[error(
        "the run has {frames} frames and the labels {labels} pictures; give labels of the run's pictures, one a line, in \
         their order"
    )]
    LabelCount {
        /// Frames of the run.
        frames: usize,
        /// Labelled pictures.
        labels: usize,
    },
    /// Labels of larger pictures.
    #[error(
        "line {line} of the labels has a point outside the run's pictures of {} x {} pixels; give labels of the same pictures \
         at the same size",
        .picture_px[0], .picture_px[1]
    )]
    LabelOutside {
        /// Line, from one.
        line: usize,
        /// Width and height of the run's pictures.
        picture_px: [u32; 2],
    },
    /// A lane of another length than the rows.
    #[error(
        "line {line} of the labels has {rows} rows (h_samples) and a lane of {points} points; mend the labels"
    )]
    LabelRows {
        /// Line, from one.
        line: usize,
        /// Rows.
        rows: usize,
        /// Points of a lane.
        points: usize,
    },
}

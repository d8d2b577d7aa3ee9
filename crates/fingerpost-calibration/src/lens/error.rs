//! Why boards do not give a lens.

use thiserror::Error;

/// Boards that do not fix a lens, or contradict it; the message says which pictures to take.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LensCalibrationError {
    /// There are too few boards.
    #[error(
        "{found} usable pictures of the board are too few, at least {needed} are needed; take 10 to 20, the board tilted \
         differently in each and in every part of the picture"
    )]
    TooFewBoards {
        /// Boards that can be used.
        found: usize,
        /// Boards needed.
        needed: usize,
    },
    /// A board's points lie in one line, or are no numbers.
    #[error(
        "the points of board {board} are fewer than four, no numbers, or lie in one line; leave that picture out"
    )]
    NoPlane {
        /// The board, from 0 in the order of those used.
        board: usize,
    },
    /// The boards are parallel to each other, which any focal length explains.
    #[error(
        "all boards lie within {spread_deg:.1} degrees of one another, {needed_deg:.0} are needed at the least, so that the \
         focal length is not determined; tilt the board by 30 to 45 degrees in different directions"
    )]
    NotTilted {
        /// Largest angle between two of the boards' planes, degrees.
        spread_deg: f64,
        /// What is needed, degrees.
        needed_deg: f64,
    },
    /// No focal length explains the boards.
    #[error(
        "the boards do not determine the focal length: they face the camera squarely, or are no pictures of one flat board \
         by one camera; tilt the board by 30 to 45 degrees in different directions"
    )]
    Undetermined,
    /// A focal length or the principal point is too uncertain.
    #[error(
        "{name} is only known within {sigma_px:.1} pixels, at most {most_px:.1} are trusted; take more pictures, the board \
         tilted by 30 to 45 degrees in different directions and in every part of the picture"
    )]
    Uncertain {
        /// The number.
        name: &'static str,
        /// Its standard deviation, pixels.
        sigma_px: f64,
        /// The largest that is trusted, pixels.
        most_px: f64,
    },
    /// The points are not where any lens of this kind shows them.
    #[error(
        "the boards fit no lens with five Brown-Conrady coefficients: points are {rms_px:.1} pixels off, at most \
         {most_px:.1} are trusted; is the board flat, are all pictures by one camera without zoom, and is it no fish-eye?"
    )]
    PoorFit {
        /// Root mean square distance, pixels.
        rms_px: f64,
        /// The largest that is trusted, pixels.
        most_px: f64,
    },
}

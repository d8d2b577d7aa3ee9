//! The error that every kernel shares: pictures whose sizes do not fit.

use crate::picture::Rect;

/// A picture whose size or packing does not fit what a kernel needs.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// The buffer does not hold exactly the picture's values.
    #[error(
        "a picture of {width} x {height} pixels needs {expected} values, but the buffer holds {found}; \
         check the picture's size and packing"
    )]
    BufferLength {
        /// Width of the picture, pixels.
        width: usize,
        /// Height of the picture, pixels.
        height: usize,
        /// Values needed.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// Rows would overlap or the last one would end outside the buffer.
    #[error(
        "rows of {width} pixels, {stride} values apart, {height} of them, do not fit a buffer of {found} values; \
         the stride must be at least the width and the last row must end inside the buffer"
    )]
    Stride {
        /// Width of the view, pixels.
        width: usize,
        /// Height of the view, pixels.
        height: usize,
        /// Values from one row's start to the next one's.
        stride: usize,
        /// Values given.
        found: usize,
    },
    /// A rectangle reaches outside the picture that it is to be cut from.
    #[error(
        "the rectangle of {}x{} pixels at ({}, {}) reaches outside the picture of {width} x {height} pixels; \
         clip it to the picture first",
        rect.width, rect.height, rect.x, rect.y
    )]
    CropOutside {
        /// The rectangle asked for.
        rect: Rect,
        /// Width of the picture, pixels.
        width: usize,
        /// Height of the picture, pixels.
        height: usize,
    },
    /// Two pictures that belong together differ in size.
    #[error(
        "the {what} is {found_width} x {found_height} pixels where {expected_width} x {expected_height} were expected; \
         give pictures of one size"
    )]
    SizeMismatch {
        /// Which of the pictures is at fault.
        what: &'static str,
        /// Width expected, pixels.
        expected_width: usize,
        /// Height expected, pixels.
        expected_height: usize,
        /// Width given, pixels.
        found_width: usize,
        /// Height given, pixels.
        found_height: usize,
    },
    /// A picture without any pixel where at least one is needed.
    #[error("the {what} has no pixels ({width} x {height}); give a picture of at least one pixel")]
    Empty {
        /// Which picture.
        what: &'static str,
        /// Width given, pixels.
        width: usize,
        /// Height given, pixels.
        height: usize,
    },
    /// A picture beyond what pixel indices of 32 bits can address.
    #[error("the {what} of {width} x {height} pixels is too large; at most {limit} pixels are supported")]
    TooLarge {
        /// Which picture.
        what: &'static str,
        /// Width given, pixels.
        width: usize,
        /// Height given, pixels.
        height: usize,
        /// Most pixels supported.
        limit: usize,
    },
}

/// Checks that a picture has the expected size, `(width, height)` in pixels.
pub(crate) fn check_size(
    what: &'static str,
    expected: (usize, usize),
    found: (usize, usize),
) -> Result<(), PictureError> {
    if expected == found {
        return Ok(());
    }
    Err(PictureError::SizeMismatch {
        what,
        expected_width: expected.0,
        expected_height: expected.1,
        found_width: found.0,
        found_height: found.1,
    })
}

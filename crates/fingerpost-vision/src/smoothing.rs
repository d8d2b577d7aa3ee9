//! Smoothing of 8-bit pictures: Gaussian blur and box blur.
//!
//! Integers throughout, so results are the same bytes everywhere; weights and rounding are those of OpenCV's fixed-point
//! Gaussian, so that results compare level by level. Beyond its edges a picture is continued by a mirror through the
//! centre of the edge pixel (dcb|abcd). For `f32` pictures there is [`crate::filter`].

mod box_blur;
mod gaussian;

pub use box_blur::BoxBlur;
pub use gaussian::GaussianBlur;

/// Widest window of a smoothing, pixels: what lane finding needs several times over, and small enough that the sums of
/// 8-bit pixels keep to the integers they are held in.
pub const MAX_SIZE_PX: usize = 31;

/// A smoothing that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SmoothingError {
    /// The window has no middle pixel or is too wide.
    #[error(
        "a smoothing window of {size_px} pixels does not work; give an odd number from 1 to {MAX_SIZE_PX}"
    )]
    Size {
        /// Width and height asked for, pixels.
        size_px: usize,
    },
    /// The deviation is not a number.
    #[error(
        "a standard deviation of {sigma_px} pixels does not work; give a positive one, or 0 to derive it from the window"
    )]
    Sigma {
        /// Standard deviation asked for, pixels.
        sigma_px: f64,
    },
}

fn check_window(size_px: usize) -> Result<(), SmoothingError> {
    if size_px.is_multiple_of(2) || size_px > MAX_SIZE_PX {
        return Err(SmoothingError::Size { size_px });
    }
    Ok(())
}

//! What can be wrong with a camera, a ground view or a curve.

use thiserror::Error;

/// A geometry that cannot be right; the message says which number to mend.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GeometryError {
    /// A number is not finite or outside what is physically possible.
    #[error(
        "{name} = {value} is out of range: expected {expected}; correct it in the calibration or configuration"
    )]
    OutOfRange {
        /// Name of the number, as in the file.
        name: &'static str,
        /// The value found.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A distortion model got a number of coefficients that it does not have.
    #[error(
        "distortion model {model} takes {expected} coefficients, {found} were given; check the calibration file"
    )]
    CoefficientCount {
        /// The distortion model.
        model: &'static str,
        /// How many it takes.
        expected: &'static str,
        /// How many were given.
        found: usize,
    },
    /// The lens turns back on itself inside the picture.
    #[error(
        "the lens distortion folds back {fold_px:.0} pixels from the principal point, inside the picture, whose edge is \
         {edge_px:.0} pixels away; the coefficients are of another lens or of another picture size, calibrate again"
    )]
    FoldedLens {
        /// Distance from the principal point at which the picture would turn back, pixels.
        fold_px: f64,
        /// Distance of the picture's farthest edge, pixels.
        edge_px: f64,
    },
    /// Four point pairs do not define a road plane (three in a line, or a mirrored order).
    #[error(
        "the four picture points and their places on the road do not fit one plane seen from above: {reason}; \
         measure them again, in the same order"
    )]
    DegeneratePoints {
        /// What is wrong with them.
        reason: &'static str,
    },
    /// A curve needs at least two different points.
    #[error("a line needs at least two different points, {found} were given; remove it or add points")]
    TooFewPoints {
        /// How many different points were given.
        found: usize,
    },
}

/// `Ok` when `value` is finite and inside `[low, high]`.
pub(crate) fn check_range(
    name: &'static str,
    value: f64,
    low: f64,
    high: f64,
    expected: &'static str,
) -> Result<(), GeometryError> {
    if value.is_finite() && (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(GeometryError::OutOfRange { name, value, expected })
    }
}

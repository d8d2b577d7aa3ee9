//! Straight lines and segments by the Hough transform.
//!
//! P. V. C. Hough, US patent 3069654, 1962; R. O. Duda and P. E. Hart, "Use of the Hough transformation to detect lines and
//! curves in pictures", CACM 15(1), 1972. Every pixel that is not 0 votes for all lines through it; a line is
//! u cos(theta) + v sin(theta) = rho in the `image` frame. Angles run from 0 up to, not including, pi, so rho can be
//! negative. Lines that are the same across that seam are not recognised as one, as in OpenCV.

mod lines;
mod remaining;
mod segments;

pub use lines::HoughLines;
pub use segments::{HoughSegments, Segment};

use std::f64::consts::PI;

/// How finely lines are told apart and how many votes they need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoughParams {
    /// Step of rho, pixels; [`FINEST_RHO_STEP_PX`] to [`COARSEST_RHO_STEP_PX`].
    pub rho_step_px: f64,
    /// Step of theta, radians; at least [`FINEST_THETA_STEP_RAD`], at most pi.
    pub theta_step_rad: f64,
    /// A line has more votes than this.
    pub votes: u32,
}

/// Finest step of rho, pixels: pixels do not tell lines apart that are closer.
pub const FINEST_RHO_STEP_PX: f64 = 0.1;

/// Coarsest step of rho, pixels: what lies that far apart is no line, and as many pixels fit a machine word across it.
pub const COARSEST_RHO_STEP_PX: f64 = 40.0;

/// Finest step of theta, radians: it moves a line by a pixel over ten thousand.
pub const FINEST_THETA_STEP_RAD: f64 = 1e-4;

/// A straight line, u cos(theta) + v sin(theta) = rho.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoughLine {
    /// Distance from the centre of the top-left pixel along the line's normal, pixels.
    pub rho_px: f64,
    /// Angle of the line's normal from the u axis towards the v axis, 0 up to pi, radians.
    pub theta_rad: f64,
    /// Pixels that voted for it.
    pub votes: u32,
}

/// Steps and lengths that do not work.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HoughError {
    /// The step of rho is too fine, too coarse or no number.
    #[error(
        "a step of {rho_step_px} pixels of rho does not work; give {FINEST_RHO_STEP_PX} to {COARSEST_RHO_STEP_PX}"
    )]
    RhoStep {
        /// Step asked for, pixels.
        rho_step_px: f64,
    },
    /// The step of theta is too fine, too large or no number.
    #[error("a step of {theta_step_rad} rad of theta does not work; give {FINEST_THETA_STEP_RAD} to pi")]
    ThetaStep {
        /// Step asked for, radians.
        theta_step_rad: f64,
    },
    /// A length of segments is negative or no number.
    #[error("a {what} of {length_px} pixels does not work; give 0 or more")]
    Length {
        /// Which length.
        what: &'static str,
        /// Length asked for, pixels.
        length_px: f64,
    },
}

impl HoughParams {
    fn check(&self) -> Result<(), HoughError> {
        let Self { rho_step_px, theta_step_rad, .. } = *self;
        if !(FINEST_RHO_STEP_PX..=COARSEST_RHO_STEP_PX).contains(&rho_step_px) {
            return Err(HoughError::RhoStep { rho_step_px });
        }
        if !(FINEST_THETA_STEP_RAD..=PI).contains(&theta_step_rad) {
            return Err(HoughError::ThetaStep { theta_step_rad });
        }
        Ok(())
    }

    /// The angles that lines can have, radians.
    fn angles(&self) -> impl Iterator<Item = f64> + use<> {
        let step_rad = self.theta_step_rad;
        // A last angle nearer to pi than half a step would be the first one again.
        let count = (PI / step_rad).round().max(1.0) as usize;
        (0..count).map(move |index| index as f64 * step_rad)
    }
}

#[cfg(test)]
mod tests;

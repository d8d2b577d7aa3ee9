//! Why a drive does not show the mount.

use fingerpost_geometry::GeometryError;
use fingerpost_vision::error::PictureError;
use thiserror::Error;

/// A drive that does not show the mount.
#[derive(Debug, Error)]
pub enum CalibrationError {
    /// A camera known by points has no mount.
    #[error(
        "a camera known by four points has no mount to calibrate; give a calibration with [intrinsics] and [mount]"
    )]
    NoIntrinsics,
    /// Too few frames show a straight drive.
    #[error(
        "{straight} of {frames} frames show the vehicle driving straight ahead ({moving} show it moving at all) and {needed} \
         are needed; give a longer drive on a straight road, at more than walking speed, in daylight"
    )]
    TooLittleStraight {
        /// Frames looked at.
        frames: usize,
        /// Frames with enough motion.
        moving: usize,
        /// Straight ones of them.
        straight: usize,
        /// Straight frames needed.
        needed: usize,
    },
    /// The frames contradict each other.
    #[error(
        "the {angle} is only known to {sigma_deg:.2} degrees and {most_deg} are needed; give a longer drive on a straight, \
         even road with steady speed"
    )]
    Uncertain {
        /// Which angle.
        angle: &'static str,
        /// Its standard deviation, degrees.
        sigma_deg: f64,
        /// The largest that is trusted, degrees.
        most_deg: f64,
    },
    /// The direction of travel does not point ahead.
    #[error(
        "the camera would look {away_deg:.0} degrees away from the direction of driving; check that the drive is of a camera \
         that looks forward and that the intrinsics are its own"
    )]
    NotForward {
        /// Angle between the camera's axis and the direction of travel, degrees.
        away_deg: f64,
    },
    /// The road was not seen well enough for the height.
    #[error(
        "the road's own motion is seen in {found} frames and {needed} are needed for the height; give a drive on a road with \
         texture, or leave the known length out"
    )]
    NoRoad {
        /// Frames with the road's plane.
        found: usize,
        /// Frames needed.
        needed: usize,
    },
    /// The resulting mount cannot be right.
    #[error("the drive gives a mount that cannot be right: {0}")]
    Mount(#[from] GeometryError),
    /// A frame has another size than the calibration says.
    #[error(transparent)]
    Frame(#[from] PictureError),
}

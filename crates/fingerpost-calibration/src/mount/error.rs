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
    /// Frames repeat others or are missing, so that nobody knows how long the drive took, or how far it went.
    #[error(
        "{repeated} of {frames} frames repeat the one before and {missing} are missing between others, as the way from each to the next \
         shows; that leaves {:.0} % of the height open, and {:.0} % are trusted at the most; give the width of the lane, or the distance \
         driven in place of the speed, or the recording as the camera made it, with the time of each frame",
        100.0 * .open, 100.0 * .most
    )]
    UnevenFrames {
        /// Frames looked at.
        frames: usize,
        /// Frames that repeat the one before.
        repeated: usize,
        /// Frames that are missing.
        missing: usize,
        /// Share of the height that is open.
        open: f64,
        /// The largest that is trusted.
        most: f64,
    },
    /// No camera is so high or low.
    #[error(
        "the drive gives a camera {height_m:.3} m above the road, and {expected} is possible; check the speed or distance that was given, \
         and how long the drive took: the number of its frames, their rate or their times"
    )]
    NoHeight {
        /// The height found, metres.
        height_m: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The angles found are none that a camera is mounted at.
    #[error(
        "the drive gives no mount that can be ({0}); give a longer drive of this camera, straight ahead on an even road"
    )]
    Mount(GeometryError),
    /// A frame has another size than the calibration says.
    #[error(transparent)]
    Frame(#[from] PictureError),
}

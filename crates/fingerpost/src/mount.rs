//! The mount while driving: where the camera looks against what the calibration says.
//!
//! Angles are those of the mount (`CONVENTIONS.md`): pitch positive nose down, yaw positive left, roll positive left side
//! up, all as differences from the configured mount.

/// An angle as it was seen in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedAngle {
    /// The angle, radians.
    pub angle_rad: f64,
    /// Its variance, square radians; never zero.
    pub variance_rad2: f64,
}

/// What one frame says about the camera's attitude: differences from the configured mount, where they could be seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AttitudeObservation {
    /// Pitch against the road that the vehicle stands on, the suspension's part included; positive nose down.
    pub pitch: Option<ObservedAngle>,
    /// Roll against that road; positive left side up.
    pub roll: Option<ObservedAngle>,
    /// Yaw against the direction of driving; positive left. None in turns, where the camera does not move straight ahead.
    pub yaw: Option<ObservedAngle>,
    /// Change of the pitch since the frame before.
    pub pitch_change: Option<ObservedAngle>,
    /// Change of the roll since the frame before.
    pub roll_change: Option<ObservedAngle>,
}

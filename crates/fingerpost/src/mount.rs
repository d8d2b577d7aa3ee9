//! The mount while driving: where the camera looks against what the calibration says, and whether it has been moved.
//!
//! A camera's angles are known from a calibration, and then the vehicle is loaded, brakes, is washed or loses a screw. Every
//! frame some of the angles can be seen anew ([`attitude`](crate::attitude)): from the road's own motion in the ground view, from the
//! point of the picture that the vehicle moves towards. [`MountFilter`] joins them into a [`MountEstimate`]: a slow correction to the
//! configured mount, the suspension's part of the pitch, and whether either can be believed.
//!
//! Angles are those of the mount (`CONVENTIONS.md`): pitch positive nose down, yaw positive left, roll positive left side
//! up, all as differences from the configured mount.
//!
//! Limits: height and place of the camera are taken as configured.

mod fault;
mod filter;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ground_view::CameraTurn;
use crate::motion::CameraAttitude;

pub use filter::MountFilter;

/// Whether an estimate of the mount can be used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MountState {
    /// Too little has been seen yet.
    #[default]
    NotYetValid,
    /// The estimate is known well enough to be used.
    Valid,
    /// The camera has been turned, and its new direction is not known well enough yet.
    Moved,
}

/// An angle of the mount.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MountAngle {
    /// Nose up and down.
    Pitch,
    /// Left and right.
    Yaw,
    /// About the direction of driving.
    Roll,
}

/// A camera that has been turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountFault {
    /// The angle that changed most clearly.
    pub angle: MountAngle,
    /// By how much, radians.
    pub by_rad: f64,
    /// Frames since then, as far as can be told.
    pub frames_since: usize,
}

/// A calibrated angle that the drive contradicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountContradiction {
    /// The angle that is off farthest.
    pub angle: MountAngle,
    /// What would have to be added to it, radians.
    pub by_rad: f64,
    /// How much that may be at the most, radians.
    pub most_rad: f64,
}

/// Where the camera looks against the configured mount.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MountEstimate {
    /// Slow correction to the configured pitch, radians, positive nose down.
    pub pitch_rad: f64,
    /// Slow correction to the configured yaw, radians, positive left.
    pub yaw_rad: f64,
    /// Slow correction to the configured roll, radians, positive left side up.
    pub roll_rad: f64,
    /// What the suspension adds to the pitch in this frame, radians, positive nose down.
    pub suspension_pitch_rad: f64,
    /// Standard deviations of pitch, yaw, roll and the suspension's pitch, radians; never zero.
    pub sigma_rad: [f64; 4],
    /// Whether the slow corrections can be used.
    pub state: MountState,
    /// What moved the camera last, while the state is [`MountState::Moved`].
    pub fault: Option<MountFault>,
    /// The angle in which the calibration cannot be true, where there is one and the state is [`MountState::Valid`].
    pub contradiction: Option<MountContradiction>,
}

impl MountEstimate {
    /// How the camera is turned in this frame: for a motion estimator that does not see it itself.
    pub(crate) fn attitude(&self) -> CameraAttitude {
        let [pitch, _, roll, suspension] = self.sigma_rad;
        let pitch_rad = self.pitch_rad + self.suspension_pitch_rad;
        CameraAttitude {
            turn: CameraTurn { pitch_rad, roll_rad: self.roll_rad, yaw_rad: 0.0 },
            sigma_rad: [libm::hypot(pitch, suspension), roll],
        }
    }
}

/// Settings of the mount's estimate while driving.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MountConfig {
    /// How far the configured pitch, yaw and roll may be off, one standard deviation, degrees.
    #[schemars(range(min = 0.05, max = 10.0))]
    pub prior_sigma_deg: f64,
    /// How much each drifts in a hundred frames, one standard deviation, degrees.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drift_sigma_deg: f64,
    /// How far the suspension pitches the vehicle, one standard deviation, degrees.
    #[schemars(range(min = 0.01, max = 5.0))]
    pub suspension_sigma_deg: f64,
    /// Standard deviation of pitch and yaw below which the estimate is valid, degrees.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub valid_sigma_deg: f64,
    /// Change of an angle from which the camera counts as moved, degrees.
    #[schemars(range(min = 0.5, max = 45.0))]
    pub moved_deg: f64,
}

impl Default for MountConfig {
    fn default() -> Self {
        Self {
            prior_sigma_deg: 1.5,
            drift_sigma_deg: 0.1,
            suspension_sigma_deg: 0.3,
            valid_sigma_deg: 0.35,
            moved_deg: 1.8,
        }
    }
}

#[cfg(test)]
mod tests;

//! The camera's attitude as single frames show it: how it is turned against its mount.
//!
//! The camera's own motion in its own picture needs no road ([`AttitudeWatch`]): corners are followed to the next frame
//! (`sparse`), rotation and direction of travel fitted to them (`camera_motion`), and read as angles of the mount (`sighting`). The
//! road's own motion in the ground view shows the attitude as well ([`motion`](crate::motion)). Such observations are noisy and
//! rarely complete; [`mount`](crate::mount) joins them over time.
//!
//! Angles are those of the mount (`CONVENTIONS.md`): pitch positive nose down, yaw positive left, roll positive left side
//! up, all as differences from the configured mount.

mod camera_motion;
mod sighting;
mod sparse;
mod watch;

pub use camera_motion::CameraMotion;
pub use fingerpost_geometry::ObservedAngle;
pub use sighting::{Sighting, Sightings, angles_of_travel};
pub use sparse::{BackCheck, RayPair, SparseSetting};
pub use watch::AttitudeWatch;

/// What one frame says about the camera's attitude: differences from the configured mount, where they could be seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AttitudeObservation {
    /// Pitch against the road that the vehicle stands on, the suspension's part included; positive nose down.
    pub pitch: Option<ObservedAngle>,
    /// Roll against that road; positive left side up.
    pub roll: Option<ObservedAngle>,
    /// Yaw against the direction in which the camera moves; positive left. None in sharp turns.
    pub yaw: Option<ObservedAngle>,
    /// Change of the pitch since the frame before.
    pub pitch_change: Option<ObservedAngle>,
    /// Change of the roll since the frame before.
    pub roll_change: Option<ObservedAngle>,
    /// Change of the vehicle's heading since the frame before; positive left.
    pub heading_change: Option<ObservedAngle>,
    /// Whether near things were seen to be left behind, in whatever direction: a vehicle that drives passes them.
    pub passes_things: bool,
}

/// Least standard deviation of a turn that the picture shows between two frames: 0.02 degrees.
const CHANGE_FLOOR_RAD: f64 = 3.5e-4;
/// What a turn's own standard deviation is short by: corners of one thing err together (30 drives of drawn worlds, 5 to 30 frames a second).
const CHANGE_UNDERRATED: f64 = 2.5;

/// The variance of a turn that was seen between two frames, square radians, with what its own leaves out.
pub(crate) fn lasting_variance_rad2(turn: &ObservedAngle) -> f64 {
    (CHANGE_UNDERRATED * CHANGE_UNDERRATED * turn.variance_rad2).max(CHANGE_FLOOR_RAD * CHANGE_FLOOR_RAD)
}

impl AttitudeObservation {
    /// This observation and an independent one of the same frame as one.
    #[must_use]
    pub fn joined_with(&self, other: &Self) -> Self {
        let joined = |a: Option<ObservedAngle>, b: Option<ObservedAngle>| match (a, b) {
            (Some(a), Some(b)) => Some(a.joined_with(b)),
            (a, b) => a.or(b),
        };
        Self {
            pitch: joined(self.pitch, other.pitch),
            roll: joined(self.roll, other.roll),
            yaw: joined(self.yaw, other.yaw),
            pitch_change: joined(self.pitch_change, other.pitch_change),
            roll_change: joined(self.roll_change, other.roll_change),
            heading_change: joined(self.heading_change, other.heading_change),
            passes_things: self.passes_things || other.passes_things,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEGREE: f64 = std::f64::consts::PI / 180.0;

    fn seen(angle_deg: f64, sigma_deg: f64) -> Option<ObservedAngle> {
        Some(ObservedAngle { angle_rad: angle_deg * DEGREE, variance_rad2: (sigma_deg * DEGREE).powi(2) })
    }

    #[test]
    fn joining_observations_weighs_them_by_their_variance() {
        let a = AttitudeObservation { pitch: seen(1.0, 0.1), ..Default::default() };
        let b = AttitudeObservation { pitch: seen(2.0, 0.2), yaw: seen(0.3, 0.1), ..Default::default() };
        let both = a.joined_with(&b);
        assert!((both.pitch.unwrap().angle_rad / DEGREE - 1.2).abs() < 1e-9);
        assert!((both.pitch.unwrap().variance_rad2.sqrt() / DEGREE - 0.1 * 0.8_f64.sqrt()).abs() < 1e-9);
        assert_eq!(both.yaw, b.yaw);
    }
}

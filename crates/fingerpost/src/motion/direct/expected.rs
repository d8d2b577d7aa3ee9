//! What is expected of a motion before the road is looked at: that of the frame before, and the turn that the far scene shows.
//!
//! A turn and a roll move the road just ahead alike; what is far away tells them apart.

use fingerpost_geometry::wrap_angle;
use nalgebra::{Isometry2, Matrix3, Vector3};

use super::Last;
use super::gauss_newton::Prior;
use crate::motion::camera_turn::{PredictedTurn, TurnFilter};
use crate::mount::AttitudeObservation;

/// Change of the motion from frame to frame, one standard deviation: metres forward and left, radians. A frame may last a
/// fifth of a second.
const CHANGE_SIGMA: [f64; 3] = [0.15, 0.05, 0.02];
/// The same where the motion of the frame before does not help.
const UNKNOWN_SIGMA: [f64; 3] = [2.0, 0.3, 0.1];
/// A turn that differs by more standard deviations from that of the frame before is a real one, or none of the far scene.
const SURPRISING_SIGMAS: f64 = 3.0;

/// Motion and turning of the camera that are expected.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    pub(super) current_from_previous: Isometry2<f64>,
    /// Forward, left and yaw in the older frame.
    pub(super) covariance: Matrix3<f64>,
    pub(super) turn: PredictedTurn,
}

impl Expected {
    /// After `last`, with what the far scene shows.
    pub(super) fn after(last: &Last, turn: TurnFilter, far: &AttitudeObservation) -> Self {
        let covariance =
            last.covariance.map_or(diagonal(UNKNOWN_SIGMA), |last| last + diagonal(CHANGE_SIGMA));
        let turn = turn.predicted().with(far);
        Self { current_from_previous: last.current_from_previous, covariance, turn }.with_heading(far)
    }

    /// Of a motion that was searched for, because it is none that was expected.
    pub(super) fn searched(self, current_from_previous: Isometry2<f64>, far: &AttitudeObservation) -> Self {
        let covariance = diagonal(UNKNOWN_SIGMA);
        Self { current_from_previous, covariance, turn: self.turn }.with_heading(far)
    }

    fn with_heading(self, far: &AttitudeObservation) -> Self {
        let Some(seen) = far.heading_change else { return self };
        let across = self.covariance.column(2).into_owned();
        let gain = across / (across.z + seen.lasting_variance_rad2());
        // The scene turns the other way than the vehicle does.
        let change = gain * wrap_angle(-seen.angle_rad - self.current_from_previous.rotation.angle());
        Self {
            current_from_previous: self.current_from_previous * Isometry2::new(change.xy(), change.z),
            covariance: self.covariance - gain * across.transpose(),
            ..self
        }
    }

    /// It as a prior of the alignment; none when it is so sure of itself that it has no inverse.
    pub(super) fn prior(&self) -> Option<Prior> {
        let information = self.covariance.try_inverse()?;
        Some(Prior {
            current_from_previous: self.current_from_previous,
            information,
            turn: self.turn.prior()?,
        })
    }
}

/// Whether the far scene turns otherwise than it would if the vehicle went on as it did.
pub(super) fn is_surprising(last: &Last, far: &AttitudeObservation) -> bool {
    let (Some(seen), Some(covariance)) = (far.heading_change, last.covariance) else { return false };
    let surprise_rad = wrap_angle(seen.angle_rad + last.current_from_previous.rotation.angle());
    let variance = covariance[(2, 2)] + seen.lasting_variance_rad2();
    surprise_rad * surprise_rad > SURPRISING_SIGMAS * SURPRISING_SIGMAS * variance
}

fn diagonal(sigma: [f64; 3]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::from(sigma.map(|sigma| sigma * sigma)))
}

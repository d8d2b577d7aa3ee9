//! What is expected of a motion before the road is looked at: that of the frame before, and how the
//! camera turned against the far scene.

use nalgebra::{Isometry2, Matrix3, Vector3};

use super::Last;
use super::gauss_newton::Prior;
use crate::attitude::{AttitudeObservation, lasting_variance_rad2};
use crate::motion::camera_turn::{PredictedTurn, TurnFilter};

/// Change of the motion from frame to frame, one standard deviation: metres forward and left, radians. A frame may last a
/// fifth of a second.
const CHANGE_SIGMA: [f64; 3] = [0.15, 0.05, 0.02];
/// The same where the motion of the frame before does not help.
const UNKNOWN_SIGMA: [f64; 3] = [2.0, 0.3, 0.1];

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
        let expected = Self { current_from_previous: last.current_from_previous, covariance, turn };
        if last.is_to_be_searched() { expected.turning(far) } else { expected }
    }

    /// With the heading's change as the far scene shows it, which needs no road: where that shows itself, it measures the turn better
    /// than a camera does whose focal length is a little off.
    fn turning(mut self, far: &AttitudeObservation) -> Self {
        let Some(seen) = &far.heading_change else { return self };
        let previous_from_current = self.current_from_previous.inverse();
        let (moved, yaw_rad) =
            (previous_from_current.translation.vector, previous_from_current.rotation.angle());
        let of_yaw = self.covariance.column(2).into_owned();
        let change = of_yaw * (seen.angle_rad - yaw_rad) / (of_yaw.z + lasting_variance_rad2(seen));
        self.current_from_previous = Isometry2::new(moved + change.xy(), yaw_rad + change.z).inverse();
        self
    }

    /// Of a motion that was searched for, because it is none that was expected.
    pub(super) fn searched(self, current_from_previous: Isometry2<f64>) -> Self {
        let covariance = diagonal(UNKNOWN_SIGMA);
        Self { current_from_previous, covariance, turn: self.turn }
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

fn diagonal(sigma: [f64; 3]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::from(sigma.map(|sigma| sigma * sigma)))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::attitude::ObservedAngle;

    /// The turn to the left that is expected after one of 0.1 rad where the far scene shows another, radians.
    fn expected_rad(seen_rad: f64, bearable: f64) -> f64 {
        let last = Last {
            current_from_previous: Isometry2::new(Vector2::new(0.7, 0.0), 0.1).inverse(),
            covariance: Some(diagonal([0.1, 0.05, 0.02])),
            bearable,
        };
        let heading_change = Some(ObservedAngle { angle_rad: seen_rad, variance_rad2: 1e-6 });
        let far = AttitudeObservation { heading_change, ..AttitudeObservation::default() };
        let expected = Expected::after(&last, TurnFilter::default(), &far);
        expected.current_from_previous.inverse().rotation.angle()
    }

    #[test]
    fn the_far_scene_says_how_a_vehicle_turns_whose_road_is_lost() {
        for seen_rad in [-0.05, 0.0, 0.08] {
            assert!((expected_rad(seen_rad, 0.0) - seen_rad).abs() < 0.005, "{seen_rad}");
            assert!((expected_rad(seen_rad, 5.0) - 0.1).abs() < 1e-9, "the road is not lost");
        }
    }
}

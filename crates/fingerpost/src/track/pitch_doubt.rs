//! What is not known of the camera's pitch, and how far it moves what is seen.

use nalgebra::{Point2, Vector2};

use crate::ground_view::Viewpoint;
use crate::motion::CameraAttitude;

/// What is assumed of the pitch where nothing measures the camera's attitude: set by hand to a fifth of a degree, and not measured.
const CALIBRATED_SIGMA_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;

/// The camera's pitch against what is believed of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PitchDoubt {
    /// One standard deviation, radians.
    sigma_rad: f64,
    /// Where the camera is.
    viewpoint: Viewpoint,
}

impl PitchDoubt {
    /// Of a camera at `viewpoint` of whose attitude nothing is measured.
    pub(super) const fn of_calibration(viewpoint: Viewpoint) -> Self {
        Self { sigma_rad: CALIBRATED_SIGMA_RAD, viewpoint }
    }

    /// What the measured attitude leaves open, from the same place.
    pub(super) const fn of_attitude(self, attitude: &CameraAttitude) -> Self {
        Self { sigma_rad: attitude.sigma_rad[0], ..self }
    }

    /// How far one standard deviation moves a place of the road in the ground view, vehicle frame, metres: a place X ahead
    /// of the camera and Y to its left, seen from height h, by (X^2 + h^2, X Y) / h for each radian.
    pub(super) fn moves_m(&self, p_in_vehicle: Point2<f64>) -> Vector2<f64> {
        let (from_foot, height_m) = (p_in_vehicle - self.viewpoint.foot, self.viewpoint.height_m);
        let forward_m = (from_foot.x * from_foot.x + height_m * height_m) / height_m;
        self.sigma_rad * Vector2::new(forward_m, from_foot.x * from_foot.y / height_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground_view::CameraTurn;

    #[test]
    fn a_place_is_as_unsure_as_the_measured_pitch_and_the_more_the_farther_it_is() {
        let viewpoint = Viewpoint { foot: Point2::new(1.0, 0.0), height_m: 1.5 };
        let sure = |pitch_rad| {
            // The roll is another one, so that it cannot be taken for the pitch.
            let attitude = CameraAttitude { turn: CameraTurn::default(), sigma_rad: [pitch_rad, 0.1] };
            PitchDoubt::of_calibration(viewpoint).of_attitude(&attitude)
        };
        let ahead = Point2::new(11.0, 3.0);
        let moved = sure(0.003).moves_m(ahead);
        assert!((moved.x - 0.003 * (100.0 + 2.25) / 1.5).abs() < 1e-12, "{moved}");
        assert!((moved.y - 0.003 * 30.0 / 1.5).abs() < 1e-12, "{moved}");
        assert!((sure(0.006).moves_m(ahead) - 2.0 * moved).norm() < 1e-12);
        assert!(sure(0.003).moves_m(Point2::new(6.0, 0.0)).x < moved.x);
    }
}

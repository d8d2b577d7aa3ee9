//! What is not known of the camera's pitch, and how far it moves what is seen.

use nalgebra::{Point2, Vector2};

use crate::ground_view::Viewpoint;
use crate::motion::CameraAttitude;

/// What a careful calibration leaves open of the pitch, a fifth of a degree.
const CALIBRATED_SIGMA_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;

/// The camera's pitch against what is believed of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PitchDoubt {
    /// One standard deviation, radians.
    sigma_rad: f64,
    /// Where the camera is.
    pub(super) viewpoint: Viewpoint,
}

impl PitchDoubt {
    /// Of a camera at `viewpoint` of whose attitude nothing is measured: the horizon shows a calibration's pitch to about this.
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

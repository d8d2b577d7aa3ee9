//! What is not known of the camera's pitch, and how far it moves what is seen.

use nalgebra::{Point2, Vector2};

use crate::ground_view::Viewpoint;

/// The camera's pitch against what is believed of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PitchDoubt {
    /// One standard deviation, radians.
    pub(super) sigma_rad: f64,
    /// Where the camera is.
    pub(super) viewpoint: Viewpoint,
}

impl PitchDoubt {
    /// How far one standard deviation moves a place of the road in the ground view, vehicle frame, metres: a place X ahead
    /// of the camera and Y to its left, seen from height h, by (X^2 + h^2, X Y) / h for each radian.
    pub(super) fn moves_m(&self, p_in_vehicle: Point2<f64>) -> Vector2<f64> {
        let (from_foot, height_m) = (p_in_vehicle - self.viewpoint.foot, self.viewpoint.height_m);
        let forward_m = (from_foot.x * from_foot.x + height_m * height_m) / height_m;
        self.sigma_rad * Vector2::new(forward_m, from_foot.x * from_foot.y / height_m)
    }
}

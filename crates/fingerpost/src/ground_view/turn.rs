//! A camera that is turned against its configured mount, and what that does to the ground view.
//!
//! The ground view is made for one direction of the camera. A camera turned from it by a small rotation shows the road at
//! other places of the view: the road is a plane, so the places are related by a projective map. With a pitch p and a roll
//! r, seen from height h, the place (X, Y) is shown at
//! (X + p (X^2 + h^2)/h - r XY/h, Y + p XY/h - r (Y^2 + h^2)/h) to first order; a degree is too much for that at 10 m.

use nalgebra::{Matrix3, Point2, Rotation3};

/// Where the camera looks from, in the vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// Place on the road below the camera, metres.
    pub foot: Point2<f64>,
    /// Height of the camera, metres.
    pub height_m: f64,
}

/// How a camera is turned against its configured mount: about the vehicle's axes through the camera, in the order and with
/// the signs of the mount (`CONVENTIONS.md`).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CameraTurn {
    /// Positive nose down, radians.
    pub pitch_rad: f64,
    /// Positive left side up, radians.
    pub roll_rad: f64,
    /// Positive left, radians.
    pub yaw_rad: f64,
}

impl CameraTurn {
    /// The projective map from places on the road to the places at which the configured camera would show them, vehicle
    /// frame, metres, homogeneous.
    #[must_use]
    pub fn shown_from_road(&self, viewpoint: Viewpoint) -> Matrix3<f64> {
        viewpoint.turned(&self.rotation().inverse())
    }

    /// The inverse of [`CameraTurn::shown_from_road`].
    #[must_use]
    pub fn road_from_shown(&self, viewpoint: Viewpoint) -> Matrix3<f64> {
        viewpoint.turned(&self.rotation())
    }

    fn rotation(&self) -> Rotation3<f64> {
        Rotation3::from_euler_angles(self.roll_rad, self.pitch_rad, self.yaw_rad)
    }
}

impl Viewpoint {
    /// The map of the road's places whose rays are turned by `rotation`.
    fn turned(self, rotation: &Rotation3<f64>) -> Matrix3<f64> {
        let Self { foot, height_m } = self;
        let rays_from_road = Matrix3::new(1.0, 0.0, -foot.x, 0.0, 1.0, -foot.y, 0.0, 0.0, -height_m);
        let (x, y, w) = (foot.x / height_m, foot.y / height_m, -1.0 / height_m);
        let road_from_rays = Matrix3::new(1.0, 0.0, -x, 0.0, 1.0, -y, 0.0, 0.0, w);
        road_from_rays * rotation.matrix() * rays_from_road
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};

    use super::*;

    #[test]
    fn a_turned_camera_shows_the_road_where_the_map_says() {
        let mount = Mount { x_m: 1.5, y_m: 0.2, ..Mount::level(1.5) };
        let intrinsics = Intrinsics { fx: 400.0, fy: 400.0, cx: 320.0, cy: 100.0 };
        let camera = |mount| Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
        let viewpoint = Viewpoint { foot: Point2::new(1.5, 0.2), height_m: 1.5 };
        let turn = CameraTurn { pitch_rad: 0.02, roll_rad: -0.03, yaw_rad: 0.01 };
        let turned = Mount { pitch_rad: 0.02, roll_rad: -0.03, yaw_rad: 0.01, ..mount };
        for place in [Point2::new(8.0, 2.0), Point2::new(15.0, -3.0)] {
            let pixel = camera(turned).pixel_of_ground(place).unwrap();
            let shown = camera(mount).ground_of_pixel(pixel).unwrap();
            let mapped = turn.shown_from_road(viewpoint) * place.to_homogeneous();
            assert!((Point2::from_homogeneous(mapped).unwrap() - shown).norm() < 1e-9, "{mapped} {shown}");
            let back = turn.road_from_shown(viewpoint) * shown.to_homogeneous();
            assert!((Point2::from_homogeneous(back).unwrap() - place).norm() < 1e-9);
        }
    }
}

//! Pixels and places on the road, with the camera pitched a little against its mount.
//!
//! The far end of a lane moves by metres with every tenth of a degree that the nose dips. The lane's two edges show the
//! pitch, because they are parallel, so it is estimated with them; this is how it enters.

use fingerpost_geometry::{Camera, Pixel, View};
use nalgebra::{Point2, Point3, Vector3};

/// A camera whose pitch against its mount is known.
#[derive(Debug, Clone, Copy)]
pub struct RoadView<'a> {
    camera: &'a Camera,
    sine: f64,
    cosine: f64,
}

impl<'a> RoadView<'a> {
    /// `pitch_rad` is added to the mount's, positive nose down; a camera known by points stays as it is.
    #[inline]
    pub fn new(camera: &'a Camera, pitch_rad: f64) -> Self {
        let (sine, cosine) = libm::sincos(pitch_rad);
        Self { camera, sine, cosine }
    }

    /// Whether a pitch makes a difference: a camera known by points knows the road plane alone.
    pub(crate) const fn knows_pitch(camera: &Camera) -> bool {
        matches!(camera.view(), View::Calibrated { .. })
    }

    /// The place that a pixel shows, vehicle frame, metres; none at or above the horizon and behind the camera.
    #[inline]
    pub fn ground_of_pixel(&self, pixel: Pixel) -> Option<Point2<f64>> {
        let Some((origin, direction)) = self.camera.ray(pixel) else {
            return self.camera.ground_of_pixel(pixel).filter(|p| p.x > 0.0);
        };
        let d = Vector3::new(
            self.cosine * direction.x + self.sine * direction.z,
            direction.y,
            self.cosine * direction.z - self.sine * direction.x,
        );
        // Flatter rays meet the road beyond a few hundred metres, where no lane is looked for.
        if d.z > -2e-3 || d.x <= 0.0 {
            return None;
        }
        let along = -origin.z / d.z;
        Some(Point2::new(origin.x + along * d.x, origin.y + along * d.y))
    }

    /// Where a place on the road appears; none where the lens does not see it.
    #[inline]
    pub fn pixel_of_ground(&self, p_in_vehicle: Point2<f64>) -> Option<Pixel> {
        let View::Calibrated { vehicle_from_camera, .. } = self.camera.view() else {
            return self.camera.pixel_of_ground(p_in_vehicle);
        };
        let origin = vehicle_from_camera.translation.vector;
        let q = Vector3::new(p_in_vehicle.x, p_in_vehicle.y, 0.0) - origin;
        let turned =
            Vector3::new(self.cosine * q.x - self.sine * q.z, q.y, self.cosine * q.z + self.sine * q.x);
        self.camera.project(Point3::from(turned + origin))
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount};

    use super::*;

    fn camera(pitch_deg: f64) -> Camera {
        let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5 };
        let mount = Mount { pitch_rad: pitch_deg.to_radians(), x_m: 1.5, ..Mount::level(1.3) };
        Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap()
    }

    #[test]
    fn a_pitch_added_is_a_pitch_of_the_mount() {
        let (level, pitched) = (camera(0.5), camera(2.0));
        let view = RoadView::new(&level, 1.5_f64.to_radians());
        for place in [Point2::new(6.0, 1.7), Point2::new(30.0, -2.0)] {
            let pixel = pitched.pixel_of_ground(place).unwrap();
            assert!(view.pixel_of_ground(place).unwrap().distance(pixel) < 1e-6);
            assert!((view.ground_of_pixel(pixel).unwrap() - place).norm() < 1e-6);
        }
    }

    #[test]
    fn a_nose_that_dips_lifts_the_road_in_the_picture() {
        let camera = camera(0.0);
        let place = Point2::new(20.0, 0.0);
        let level = RoadView::new(&camera, 0.0).pixel_of_ground(place).unwrap();
        let dipped = RoadView::new(&camera, 0.01).pixel_of_ground(place).unwrap();
        assert!(dipped.v < level.v - 5.0);
        assert!(RoadView::new(&camera, 0.0).ground_of_pixel(Pixel::new(320.0, 100.0)).is_none());
    }
}

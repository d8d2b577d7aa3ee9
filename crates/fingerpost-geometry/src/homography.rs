//! The plane-to-plane map of the papers' four points.
//!
//! Paper 1, section IV-A: four picture points whose places on the road are known fix the perspective transform
//! between road and picture (Ballard and Brown 1982). Limits: no lens distortion, and only the road plane.

use nalgebra::{Matrix3, Point2, SMatrix, SVector, Vector2, Vector3};

use crate::{GeometryError, PictureScale, Pixel};

/// A projective map from the road plane (vehicle frame, metres) to the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Homography {
    image_from_road: Matrix3<f64>,
    road_from_image: Matrix3<f64>,
}

impl Homography {
    /// The map that takes each place on the road to its picture point.
    ///
    /// # Errors
    /// [`GeometryError::DegeneratePoints`] when three of the points lie in a line, when a number is not finite, or
    /// when the order of the points mirrors the road (left and right exchanged).
    pub fn from_points(road_m: [Point2<f64>; 4], image: [Pixel; 4]) -> Result<Self, GeometryError> {
        let degenerate = |reason| GeometryError::DegeneratePoints { reason };
        let finite = road_m.iter().all(|p| p.x.is_finite() && p.y.is_finite())
            && image.iter().all(|p| p.u.is_finite() && p.v.is_finite());
        if !finite {
            return Err(degenerate("a coordinate is not a finite number"));
        }
        if flat_triangle(road_m) || flat_triangle(image.map(|p| Point2::new(p.u, p.v))) {
            return Err(degenerate("three of them lie in one line"));
        }
        // The last entry is set to one, which only holds where the origin is in front of the camera: the middle of the
        // points is, the vehicle's origin may lie in the plane of the lens.
        let middle = road_m.iter().map(|p| p.coords).sum::<Vector2<f64>>() / 4.0;
        let mut system = SMatrix::<f64, 8, 8>::zeros();
        let mut right_side = SVector::<f64, 8>::zeros();
        for (i, (road, pixel)) in road_m.iter().zip(image).enumerate() {
            let (x, y, u, v) = (road.x - middle.x, road.y - middle.y, pixel.u, pixel.v);
            system.fixed_view_mut::<1, 8>(2 * i, 0).copy_from_slice(&[
                x,
                y,
                1.0,
                0.0,
                0.0,
                0.0,
                -u * x,
                -u * y,
            ]);
            system.fixed_view_mut::<1, 8>(2 * i + 1, 0).copy_from_slice(&[
                0.0,
                0.0,
                0.0,
                x,
                y,
                1.0,
                -v * x,
                -v * y,
            ]);
            right_side[2 * i] = u;
            right_side[2 * i + 1] = v;
        }
        let h = system.lu().solve(&right_side).ok_or(degenerate("three of them lie in one line"))?;
        let mut image_from_road = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0)
            * Matrix3::new(1.0, 0.0, -middle.x, 0.0, 1.0, -middle.y, 0.0, 0.0, 1.0);
        // The sign is chosen so that the third coordinate is positive in front of the camera.
        let scale_at = |p: &Point2<f64>| (image_from_road * Vector3::new(p.x, p.y, 1.0)).z;
        if scale_at(&road_m[0]) < 0.0 {
            image_from_road = -image_from_road;
        }
        if road_m.iter().any(|p| (image_from_road * Vector3::new(p.x, p.y, 1.0)).z <= 0.0) {
            return Err(degenerate("the horizon runs between them"));
        }
        // Forward goes up the picture and left goes left: one axis exchange, so the orientation is reversed.
        if image_from_road.determinant() >= 0.0 {
            return Err(degenerate("their order mirrors the road"));
        }
        let road_from_image =
            image_from_road.try_inverse().ok_or(degenerate("three of them lie in one line"))?;
        Ok(Self { image_from_road, road_from_image })
    }

    /// The map as a matrix, with a positive third coordinate in front of the camera.
    #[inline]
    pub const fn image_from_road(&self) -> &Matrix3<f64> {
        &self.image_from_road
    }

    /// The same map to the picture at another size.
    pub(crate) fn scaled(&self, scale: PictureScale) -> Self {
        let (along_u, along_v) = scale.factors();
        let corner = scale.scaled(Pixel::new(0.0, 0.0));
        let scaled_from_image = Matrix3::new(along_u, 0.0, corner.u, 0.0, along_v, corner.v, 0.0, 0.0, 1.0);
        let middle = scale.unscaled(Pixel::new(0.0, 0.0));
        let image_from_scaled =
            Matrix3::new(1.0 / along_u, 0.0, middle.u, 0.0, 1.0 / along_v, middle.v, 0.0, 0.0, 1.0);
        Self {
            image_from_road: scaled_from_image * self.image_from_road,
            road_from_image: self.road_from_image * image_from_scaled,
        }
    }

    /// Where a place on the road is in the picture; none behind the camera.
    pub fn pixel_of_ground(&self, p_in_vehicle: Point2<f64>) -> Option<Pixel> {
        let p = self.image_from_road * Vector3::new(p_in_vehicle.x, p_in_vehicle.y, 1.0);
        (p.z > 1e-9).then(|| Pixel::new(p.x / p.z, p.y / p.z))
    }

    /// Which place on the road a picture point shows; none at or above the horizon.
    pub fn ground_of_pixel(&self, pixel: Pixel) -> Option<Point2<f64>> {
        let p = self.road_from_image * Vector3::new(pixel.u, pixel.v, 1.0);
        (p.z > 1e-12).then(|| Point2::new(p.x / p.z, p.y / p.z))
    }
}

/// Whether three of four points lie in one line, up to a thousandth of their extent.
fn flat_triangle(points: [Point2<f64>; 4]) -> bool {
    let extent = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    (0..4).any(|left_out| {
        let [a, b, c] = [1, 2, 3].map(|step| points[(left_out + step) % 4]);
        (b - a).perp(&(c - a)).abs() < 1e-3 * extent * extent
    })
}

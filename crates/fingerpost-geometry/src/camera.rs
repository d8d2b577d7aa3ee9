//! The camera: from places on the road to pixels and back.
//!
//! Paper 1, section IV-A (inverse perspective mapping); paper 2, sections 2.1 and 3.1. Either a calibrated lens on a
//! measured mount, or the papers' four picture points with their places on the road.

use nalgebra::{Isometry3, Point2, Point3, Unit, Vector3};

use crate::error::check_range;
use crate::{Distortion, GeometryError, Homography, Mount, PictureScale, Pixel};

/// Pinhole parameters, pixels; the principal point is counted from the centre of the top-left pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length along u, pixels.
    pub fx: f64,
    /// Focal length along v, pixels.
    pub fy: f64,
    /// Principal point, pixels from the centre of the left column.
    pub cx: f64,
    /// Principal point, pixels from the centre of the top row.
    pub cy: f64,
}

/// How the camera's picture and the road plane are related.
#[derive(Debug, Clone, PartialEq)]
pub enum View {
    /// A lens on a mount: directions of any point in space are known.
    Calibrated {
        /// Focal lengths and principal point.
        intrinsics: Intrinsics,
        /// Lens distortion.
        distortion: Distortion,
        /// Place and direction on the vehicle.
        mount: Mount,
        /// Derived from `mount`.
        vehicle_from_camera: Isometry3<f64>,
    },
    /// Four point pairs: only the road plane is known (paper 1, IV-A).
    RoadPlane(Homography),
}

/// A camera on a vehicle, above a flat road.
///
/// ```
/// use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
/// use nalgebra::Point2;
/// let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 319.5, cy: 239.5 };
/// let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(1.5)).unwrap();
/// // 10 m ahead and 2 m left: 100 px left of the middle, 75 px below the horizon.
/// let pixel = camera.pixel_of_ground(Point2::new(10.0, 2.0)).unwrap();
/// assert!((pixel.u - 219.5).abs() < 1e-9 && (pixel.v - 314.5).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    width: usize,
    height: usize,
    view: View,
}

/// Largest picture side that is believed, pixels; larger numbers are typing errors.
const MAX_SIDE_PX: f64 = 16384.0;

impl Camera {
    /// A calibrated camera for pictures of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`GeometryError`] naming the first number that is not finite or cannot be right.
    pub fn calibrated(
        width: usize,
        height: usize,
        intrinsics: Intrinsics,
        distortion: Distortion,
        mount: Mount,
    ) -> Result<Self, GeometryError> {
        check_size(width, height)?;
        let (w, h) = (width as f64, height as f64);
        // A focal length under a twentieth of the picture's width is a lens of more than 168 degrees as a pinhole.
        let focal = "a focal length in pixels, between a twentieth and a hundred times the picture's width";
        check_range("intrinsics.fx", intrinsics.fx, 0.05 * w, 100.0 * w, focal)?;
        check_range("intrinsics.fy", intrinsics.fy, 0.05 * w, 100.0 * w, focal)?;
        let centre = "a principal point inside the picture, in pixels (is the picture's size right?)";
        check_range("intrinsics.cx", intrinsics.cx, 0.0, w, centre)?;
        check_range("intrinsics.cy", intrinsics.cy, 0.0, h, centre)?;
        let ratio =
            "a focal length along v within half and twice that along u, because pixels are nearly square";
        check_range("intrinsics.fy", intrinsics.fy, 0.5 * intrinsics.fx, 2.0 * intrinsics.fx, ratio)?;
        check_fold(&intrinsics, &distortion, [w, h])?;
        mount.check()?;
        let vehicle_from_camera = mount.vehicle_from_camera();
        let view = View::Calibrated { intrinsics, distortion, mount, vehicle_from_camera };
        Ok(Self { width, height, view })
    }

    /// A camera known by four picture points and their places on the road (vehicle frame, metres).
    ///
    /// # Errors
    /// [`GeometryError::DegeneratePoints`] when the points do not define a road seen from above.
    pub fn from_points(
        width: usize,
        height: usize,
        image: [Pixel; 4],
        road_m: [Point2<f64>; 4],
    ) -> Result<Self, GeometryError> {
        check_size(width, height)?;
        Ok(Self { width, height, view: View::RoadPlane(Homography::from_points(road_m, image)?) })
    }

    /// Picture width, pixels.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Picture height, pixels.
    pub const fn height(&self) -> usize {
        self.height
    }

    /// How picture and road are related.
    pub const fn view(&self) -> &View {
        &self.view
    }

    /// The same camera at another attitude and height, as a moving suspension gives it.
    ///
    /// # Errors
    /// [`GeometryError::OutOfRange`] for an absurd mount; a camera known by points has no mount and stays as it is.
    pub fn with_mount(&self, mount: Mount) -> Result<Self, GeometryError> {
        match &self.view {
            View::Calibrated { intrinsics, distortion, .. } => {
                Self::calibrated(self.width, self.height, *intrinsics, *distortion, mount)
            }
            View::RoadPlane(_) => Ok(self.clone()),
        }
    }

    /// The same camera for its pictures at `width` x `height` pixels, outer edges kept; lens and mount stay as they are.
    ///
    /// # Errors
    /// [`GeometryError::OutOfRange`] for a size that no picture has.
    ///
    /// ```
    /// use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
    /// use nalgebra::Point2;
    /// let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 319.5, cy: 239.5 };
    /// let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(1.5)).unwrap();
    /// let half = camera.scaled_to(320, 240).unwrap();
    /// // Pixel 219.5 of the columns is half of 109 and half of 110.
    /// assert!((half.pixel_of_ground(Point2::new(10.0, 2.0)).unwrap().u - 109.5).abs() < 1e-9);
    /// ```
    pub fn scaled_to(&self, width: usize, height: usize) -> Result<Self, GeometryError> {
        check_size(width, height)?;
        let scale = PictureScale::between((self.width, self.height), (width, height));
        match &self.view {
            View::Calibrated { intrinsics, distortion, mount, .. } => {
                let middle = scale.scaled(Pixel::new(intrinsics.cx, intrinsics.cy));
                let (along_u, along_v) = scale.factors();
                let (fx, fy) = (intrinsics.fx * along_u, intrinsics.fy * along_v);
                let intrinsics = Intrinsics { fx, fy, cx: middle.u, cy: middle.v };
                Self::calibrated(width, height, intrinsics, *distortion, *mount)
            }
            View::RoadPlane(homography) => {
                Ok(Self { width, height, view: View::RoadPlane(homography.scaled(scale)) })
            }
        }
    }

    /// Where a place on the road (vehicle frame, metres) appears, pixels; none where the lens does not see it. The
    /// pixel may lie outside the picture.
    pub fn pixel_of_ground(&self, p_in_vehicle: Point2<f64>) -> Option<Pixel> {
        match &self.view {
            View::Calibrated { .. } => self.project(Point3::new(p_in_vehicle.x, p_in_vehicle.y, 0.0)),
            View::RoadPlane(homography) => homography.pixel_of_ground(p_in_vehicle),
        }
    }

    /// Which place on the road (vehicle frame, metres) a pixel shows; none at or above the horizon.
    pub fn ground_of_pixel(&self, pixel: Pixel) -> Option<Point2<f64>> {
        match &self.view {
            View::Calibrated { .. } => {
                let (origin, direction) = self.ray(pixel)?;
                // Rays flatter than this meet the road beyond a kilometre even from a high mount.
                if direction.z > -1e-6 {
                    return None;
                }
                let along = -origin.z / direction.z;
                Some(Point2::new(origin.x + along * direction.x, origin.y + along * direction.y))
            }
            View::RoadPlane(homography) => homography.ground_of_pixel(pixel),
        }
    }

    /// Where a point in space (vehicle frame, metres) appears; none where the lens does not see it, and for a camera
    /// known by points, which knows the road plane alone.
    pub fn project(&self, p_in_vehicle: Point3<f64>) -> Option<Pixel> {
        let View::Calibrated { intrinsics, distortion, vehicle_from_camera, .. } = &self.view else {
            return None;
        };
        let p_in_camera = vehicle_from_camera.inverse_transform_point(&p_in_vehicle);
        let p = distortion.distort(p_in_camera.coords)?;
        Some(Pixel::new(intrinsics.fx * p.x + intrinsics.cx, intrinsics.fy * p.y + intrinsics.cy))
    }

    /// The ray of a pixel: the optical centre and a unit direction, both in the vehicle frame (metres); none where
    /// no direction reaches that pixel, and for a camera known by points.
    pub fn ray(&self, pixel: Pixel) -> Option<(Point3<f64>, Unit<Vector3<f64>>)> {
        let View::Calibrated { vehicle_from_camera, .. } = &self.view else {
            return None;
        };
        let direction_in_camera = self.ray_in_camera(pixel)?;
        Some((
            vehicle_from_camera.translation.vector.into(),
            vehicle_from_camera.rotation * direction_in_camera,
        ))
    }

    /// The direction of a pixel in the camera frame (x right, y down, z forward), whatever the mount; none where no
    /// direction reaches that pixel, and for a camera known by points.
    pub fn ray_in_camera(&self, pixel: Pixel) -> Option<Unit<Vector3<f64>>> {
        let View::Calibrated { intrinsics, distortion, .. } = &self.view else {
            return None;
        };
        let distorted = nalgebra::Vector2::new(
            (pixel.u - intrinsics.cx) / intrinsics.fx,
            (pixel.v - intrinsics.cy) / intrinsics.fy,
        );
        distortion.undistort(distorted)
    }

    /// Whether a pixel lies inside the picture, so that it can be interpolated.
    pub fn contains(&self, pixel: Pixel) -> bool {
        (0.0..=self.width as f64 - 1.0).contains(&pixel.u)
            && (0.0..=self.height as f64 - 1.0).contains(&pixel.v)
    }
}

/// A lens whose picture turns back before the middle of an edge shows some places twice; corners may lie beyond.
fn check_fold(
    intrinsics: &Intrinsics,
    distortion: &Distortion,
    [width, height]: [f64; 2],
) -> Result<(), GeometryError> {
    let Some(fold) = distortion.fold_radius() else { return Ok(()) };
    let edge = |centre: f64, side: f64, focal: f64| (centre.max(side - 1.0 - centre), focal);
    let (cx, cy) = (intrinsics.cx, intrinsics.cy);
    for (edge_px, focal_px) in [edge(cx, width, intrinsics.fx), edge(cy, height, intrinsics.fy)] {
        if edge_px > fold * focal_px {
            return Err(GeometryError::FoldedLens { fold_px: fold * focal_px, edge_px });
        }
    }
    Ok(())
}

fn check_size(width: usize, height: usize) -> Result<(), GeometryError> {
    let sides = "a picture side of 16 to 16384 pixels";
    check_range("image.width", width as f64, 16.0, MAX_SIDE_PX, sides)?;
    check_range("image.height", height as f64, 16.0, MAX_SIDE_PX, sides)
}

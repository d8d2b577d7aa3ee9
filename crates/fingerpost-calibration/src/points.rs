//! The mount of a camera whose lens is known, from places on the road seen in its picture.
//!
//! The map from the road plane to undistorted picture coordinates is `[r1 r2 t]` up to its scale, so that rotation and place
//! follow from it (R. Tsai, 1987; Z. Zhang, "A flexible new technique for camera calibration", 2000); they are then refined
//! until the places appear where they were seen, Gauss-Newton over the mount's six numbers.

use fingerpost_geometry::{Camera, GeometryError, Homography, Mount, Pixel};
use nalgebra::{Matrix3, Matrix6, Point2, Rotation3, UnitQuaternion, Vector6};
use thiserror::Error;

/// A mount with how well it explains the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountFromPoints {
    /// The mount.
    pub mount: Mount,
    /// Root mean square distance between where the places were seen and where they would be, pixels.
    pub error_px: f64,
}

const ITERATIONS: usize = 30;
/// Steps of the numeric derivative: metres and radians.
const STEP: f64 = 1e-5;

/// Mean distance of the points from where the mount that is found sees them beyond which they contradict each other, as a share of
/// the picture's width: 6 pixels of 640.
const MOST_ERROR_SHARE: f64 = 0.01;

/// Points that give no mount.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PointsError {
    /// They define no road that this lens can see, or the mount would be absurd.
    #[error("no mount explains the points with this lens: {0}")]
    NoMount(#[from] GeometryError),
    /// No mount comes near to all of them.
    #[error(
        "the points contradict each other or the lens: no mount comes nearer to them than {error_px:.1} pixels, and {most_px:.1} \
         are allowed; measure them again, in the same order"
    )]
    Contradiction {
        /// How near the best mount comes, pixels.
        error_px: f64,
        /// The largest distance that is trusted, pixels.
        most_px: f64,
    },
}

/// The mount with which the lens of `camera` sees the places `road_m` (vehicle frame, metres) at the pixels `image`; its own mount
/// plays no part.
///
/// # Errors
/// [`PointsError::NoMount`] when the points do not define a road seen from above, the lens does not reach them, or the mount would
/// be absurd; [`PointsError::Contradiction`] when it does not explain them well enough to be trusted.
pub fn mount_from_points(
    camera: &Camera,
    image: [Pixel; 4],
    road_m: [Point2<f64>; 4],
) -> Result<MountFromPoints, PointsError> {
    let outside = GeometryError::DegeneratePoints { reason: "the lens reaches none of them there" };
    let mut undistorted = image;
    for (pixel, of) in undistorted.iter_mut().zip(image) {
        let ray = camera.ray_in_camera(of).filter(|ray| ray.z > 0.0).ok_or_else(|| outside.clone())?;
        *pixel = Pixel::new(ray.x / ray.z, ray.y / ray.z);
    }
    let homography = Homography::from_points(road_m, undistorted)?;
    let mut mount = mount_of(homography.image_from_road())?;
    for _ in 0..ITERATIONS {
        let (mut information, mut gradient) = (Matrix6::identity() * 1e-9, Vector6::zeros());
        let seen = pixels_of(camera, &mount, road_m)?;
        let columns = [0, 1, 2, 3, 4, 5].map(|i| {
            let mut step = Vector6::zeros();
            step[i] = STEP;
            pixels_of(camera, &moved(&mount, &step), road_m)
        });
        for (place, pixel) in image.iter().enumerate() {
            let (mut by_u, mut by_v) = (Vector6::zeros(), Vector6::zeros());
            for (i, column) in columns.iter().enumerate() {
                let shifted = column.clone()?[place];
                by_u[i] = (shifted.u - seen[place].u) / STEP;
                by_v[i] = (shifted.v - seen[place].v) / STEP;
            }
            information += by_u * by_u.transpose() + by_v * by_v.transpose();
            gradient += by_u * (pixel.u - seen[place].u) + by_v * (pixel.v - seen[place].v);
        }
        let change = information.cholesky().ok_or_else(|| outside.clone())?.solve(&gradient);
        mount = moved(&mount, &change);
        if change.norm() < 1e-9 {
            break;
        }
    }
    mount.check()?;
    let seen = pixels_of(camera, &mount, road_m)?;
    let squares: f64 = seen.iter().zip(image).map(|(seen, pixel)| seen.distance(pixel).powi(2)).sum();
    let error_px = (squares / 4.0).sqrt();
    let most_px = MOST_ERROR_SHARE * camera.width() as f64;
    if error_px > most_px {
        return Err(PointsError::Contradiction { error_px, most_px });
    }
    Ok(MountFromPoints { mount, error_px })
}

/// Where the lens of `camera` sees the places on that mount.
fn pixels_of(camera: &Camera, mount: &Mount, road_m: [Point2<f64>; 4]) -> Result<[Pixel; 4], GeometryError> {
    let camera = camera.with_mount(*mount)?;
    let mut pixels = [Pixel::new(0.0, 0.0); 4];
    for (pixel, place) in pixels.iter_mut().zip(road_m) {
        *pixel = camera
            .pixel_of_ground(place)
            .ok_or(GeometryError::DegeneratePoints { reason: "the horizon runs between them" })?;
    }
    Ok(pixels)
}

/// The mount behind a map from the road to a pinhole's picture with unit focal length.
fn mount_of(image_from_road: &Matrix3<f64>) -> Result<Mount, GeometryError> {
    let [forward, left, middle] = [0, 1, 2].map(|column| image_from_road.column(column).into_owned());
    let scale = 0.5 * (forward.norm() + left.norm());
    let (forward, left) = (forward / scale, left / scale);
    let mut axes = Matrix3::from_columns(&[forward, left, forward.cross(&left)]);
    let parts = axes.svd(true, true);
    if let (Some(u), Some(v)) = (parts.u, parts.v_t) {
        axes = u * v;
    }
    let camera_from_vehicle = Rotation3::from_matrix_unchecked(axes);
    let place = camera_from_vehicle.inverse() * (-middle / scale);
    let level = Mount::level(1.0).vehicle_from_camera().rotation;
    let vehicle_from_camera = UnitQuaternion::from_rotation_matrix(&camera_from_vehicle.inverse());
    let (roll_rad, pitch_rad, yaw_rad) = (vehicle_from_camera * level.inverse()).euler_angles();
    let mount = Mount { height_m: place.z, pitch_rad, yaw_rad, roll_rad, x_m: place.x, y_m: place.y };
    mount.check().map(|()| mount)
}

fn moved(mount: &Mount, by: &Vector6<f64>) -> Mount {
    Mount {
        height_m: mount.height_m + by[0],
        pitch_rad: mount.pitch_rad + by[1],
        yaw_rad: mount.yaw_rad + by[2],
        roll_rad: mount.roll_rad + by[3],
        x_m: mount.x_m + by[4],
        y_m: mount.y_m + by[5],
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics};

    use super::*;

    #[test]
    fn a_known_mount_is_found_from_its_own_picture() {
        let intrinsics = Intrinsics { fx: 500.0, fy: 510.0, cx: 320.0, cy: 230.0 };
        let mount =
            Mount { height_m: 1.4, pitch_rad: 0.12, yaw_rad: -0.05, roll_rad: 0.03, x_m: 1.7, y_m: 0.2 };
        let road_m = [(6.0, 1.5), (6.0, -1.5), (14.0, 2.0), (15.0, -2.0)].map(|(x, y)| Point2::new(x, y));
        for lens in [Distortion::None, Distortion::brown_conrady(&[-0.25, 0.07, 0.0005, -0.0003]).unwrap()] {
            let camera = |mount| Camera::calibrated(640, 480, intrinsics, lens, mount).unwrap();
            let image = road_m.map(|place| camera(mount).pixel_of_ground(place).unwrap());
            let found = mount_from_points(&camera(Mount::level(1.0)), image, road_m).unwrap();
            assert!(found.error_px < 1e-4, "{found:?}");
            for (a, b) in [
                (found.mount.height_m, mount.height_m),
                (found.mount.pitch_rad, mount.pitch_rad),
                (found.mount.yaw_rad, mount.yaw_rad),
                (found.mount.roll_rad, mount.roll_rad),
                (found.mount.x_m, mount.x_m),
                (found.mount.y_m, mount.y_m),
            ] {
                assert!((a - b).abs() < 1e-5, "{found:?}");
            }
        }
    }

    #[test]
    fn points_that_no_mount_explains_are_refused_with_how_far_off_they_are() {
        let intrinsics = Intrinsics { fx: 500.0, fy: 510.0, cx: 320.0, cy: 230.0 };
        let mount = Mount { pitch_rad: 0.12, ..Mount::level(1.4) };
        let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
        let road_m = [(6.0, 1.5), (6.0, -1.5), (14.0, 2.0), (15.0, -2.0)].map(|(x, y)| Point2::new(x, y));
        let image = road_m.map(|place| camera.pixel_of_ground(place).unwrap());
        let mut off = image;
        off[2] = Pixel::new(image[2].u + 25.0, image[2].v);
        let error = mount_from_points(&camera, off, road_m).unwrap_err();
        assert!(
            matches!(error, PointsError::Contradiction { error_px, most_px } if error_px > most_px && most_px > 6.3),
            "{error:?}"
        );
        let in_line = [image[0], image[0], image[2], image[3]];
        let error = mount_from_points(&camera, in_line, road_m).unwrap_err();
        assert!(matches!(error, PointsError::NoMount(_)), "{error:?}");
    }
}

//! The camera behind a car's windscreen that lane drives are seen with.

use fingerpost_geometry::{Camera, Distortion, GeometryError, Intrinsics, Mount};

/// Focal length as a share of the picture's width: 58 degrees across.
const FOCAL_SHARE: f64 = 0.902;
/// Behind the mirror of a medium car, the horizon a little above the picture's middle.
const MOUNT: Mount = Mount {
    height_m: 1.3,
    pitch_rad: 3.0 * (std::f64::consts::PI / 180.0),
    yaw_rad: 0.0,
    roll_rad: 0.0,
    x_m: 1.7,
    y_m: 0.0,
};

/// A camera without distortion as it is mounted for lane keeping: 58 degrees across, 1.3 m above the road, 1.7 m ahead of
/// the rear axle, looking 3 degrees down. The picture is `width` by `height` pixels.
///
/// # Errors
/// [`GeometryError`]: a picture without pixels.
pub fn windscreen_camera(width: usize, height: usize) -> Result<Camera, GeometryError> {
    let f = FOCAL_SHARE * width as f64;
    let intrinsics =
        Intrinsics { fx: f, fy: f, cx: 0.5 * (width as f64 - 1.0), cy: 0.5 * (height as f64 - 1.0) };
    Camera::calibrated(width, height, intrinsics, Distortion::None, MOUNT)
}

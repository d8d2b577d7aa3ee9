//! A camera for pictures of another size than its calibration's.

use anyhow::{Result, bail};
use fingerpost_geometry::Camera;

use crate::output;

/// The camera of pictures of such a size, pixels: as it is, or scaled where they have its shape, which is said. `source` names the
/// calibration.
///
/// # Errors
/// When the pictures have another shape, so that they were cut or are another camera's.
pub(crate) fn of_pictures(camera: Camera, (width, height): (usize, usize), source: &str) -> Result<Camera> {
    let calibrated = (camera.width(), camera.height());
    if calibrated == (width, height) {
        return Ok(camera);
    }
    let ((cw, ch), exchanged) =
        (calibrated, if calibrated == (height, width) { "; width and height are exchanged" } else { "" });
    // As many rows as a program that keeps the shape makes of so many columns, or columns of rows, to the nearest.
    let nearest = |side: usize, to: usize, from: usize| (2 * side * to + from) / (2 * from);
    let has_shape = nearest(ch, width, cw) == height || nearest(cw, height, ch) == width;
    if !has_shape {
        bail!(
            "the pictures have {width} x {height} pixels and the calibration ({source}) is for {cw} x {ch}{exchanged}: they were cut or are \
             another camera's; give the calibration of this camera at this size"
        );
    }
    let scaled = camera.scaled_to(width, height)?;
    output::message(&format!(
        "{source}: the calibration is for {cw} x {ch} pixels and the pictures have {width} x {height}; it is scaled to them, as for \
         whole pictures of the same lens at the same zoom"
    ));
    Ok(scaled)
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount, Pixel};

    use super::*;

    fn camera() -> Camera {
        let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5 };
        Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(1.5)).unwrap()
    }

    #[test]
    fn pictures_of_the_same_shape_are_seen_along_the_same_rays() {
        for size in [(640, 480), (320, 240), (1280, 960), (333, 250), (150, 113)] {
            let scaled = of_pictures(camera(), size, "camera.toml").unwrap();
            assert_eq!((scaled.width(), scaled.height()), size);
            let corner = |camera: &Camera| {
                let pixel = Pixel::new(camera.width() as f64 - 0.5, camera.height() as f64 - 0.5);
                camera.ray_in_camera(pixel).unwrap()
            };
            assert!(corner(&scaled).angle(&corner(&camera())) < 1e-9, "{size:?}");
        }
    }

    #[test]
    fn pictures_of_another_shape_are_refused() {
        for (size, word) in [((640, 360), "640 x 360"), ((330, 240), "330 x 240"), ((480, 640), "exchanged")]
        {
            let error = of_pictures(camera(), size, "rough.toml").unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("rough.toml"), "{error}");
        }
    }
}

//! A camera's calibration as robots' messages and files hold it: matrices and the name of a distortion model, no mount.
//!
//! Source: ROS `sensor_msgs/CameraInfo`, whose names of models and order of coefficients are OpenCV's.

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};

use crate::CameraFileError;

/// Most Brown-Conrady coefficients that are used; OpenCV's thin-prism and tilt terms come behind them.
const MOST_COEFFICIENTS: usize = 8;

/// A calibration without a mount.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CameraInfo {
    /// Width of the pictures, pixels.
    pub width: usize,
    /// Height of the pictures, pixels.
    pub height: usize,
    /// Name of the distortion model; empty for none.
    pub distortion_model: String,
    /// Its coefficients, in OpenCV's order.
    pub distortion: Vec<f64>,
    /// The camera matrix K by rows, pixels.
    pub matrix: [f64; 9],
    /// The projection matrix P of rectified pictures by rows, pixels.
    pub projection: [f64; 12],
}

/// Which pictures a calibration is wanted for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PictureKind {
    /// As the lens made them.
    #[default]
    AsTaken,
    /// Rectified: the lens is taken out, and the projection matrix holds.
    Rectified,
}

impl CameraInfo {
    /// The camera of such pictures on its mount.
    ///
    /// # Errors
    /// [`CameraFileError`] when the distortion model is unknown or the numbers cannot be those of a camera.
    pub fn camera(&self, pictures: PictureKind, mount: Mount) -> Result<Camera, CameraFileError> {
        let (intrinsics, lens) = match pictures {
            PictureKind::AsTaken => {
                let [fx, _, cx, _, fy, cy, ..] = self.matrix;
                (Intrinsics { fx, fy, cx, cy }, distortion(&self.distortion_model, &self.distortion)?)
            }
            PictureKind::Rectified => {
                let [fx, _, cx, _, _, fy, cy, ..] = self.projection;
                (Intrinsics { fx, fy, cx, cy }, Distortion::None)
            }
        };
        Ok(Camera::calibrated(self.width, self.height, intrinsics, lens, mount)?)
    }
}

/// The lens of a model's name and coefficients. Viewers' messages call Kannala and Brandt's by their names.
pub(crate) fn distortion(model: &str, coefficients: &[f64]) -> Result<Distortion, CameraFileError> {
    match model {
        "plumb_bob" | "rational_polynomial" if coefficients.is_empty() => Ok(Distortion::None),
        "plumb_bob" | "rational_polynomial" => Ok(Distortion::brown_conrady(used(coefficients))?),
        "equidistant" | "fisheye" | "kannala_brandt" => Ok(Distortion::kannala_brandt(coefficients)?),
        "none" | "" => Ok(Distortion::None),
        other => Err(CameraFileError::UnknownDistortion {
            model: other.to_owned(),
            known: "\"plumb_bob\", \"rational_polynomial\", \"equidistant\" or \"none\"",
        }),
    }
}

/// The coefficients without a tail of zeros behind those that are used.
fn used(coefficients: &[f64]) -> &[f64] {
    match coefficients.split_at_checked(MOST_COEFFICIENTS) {
        Some((used, unused)) if unused.iter().all(|coefficient| coefficient.abs() < f64::MIN_POSITIVE) => {
            used
        }
        _ => coefficients,
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::View;

    use super::*;

    fn info() -> CameraInfo {
        CameraInfo {
            width: 640,
            height: 480,
            distortion_model: "plumb_bob".to_owned(),
            distortion: vec![-0.2, 0.05, 0.0, 0.0, 0.0],
            matrix: [500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0],
            projection: [450.0, 0.0, 310.0, 0.0, 0.0, 455.0, 230.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        }
    }

    fn of(pictures: PictureKind) -> (Intrinsics, Distortion) {
        let camera = info().camera(pictures, Mount::level(1.4)).expect("a camera");
        match camera.view() {
            View::Calibrated { intrinsics, distortion, .. } => (*intrinsics, *distortion),
            View::RoadPlane(_) => panic!("a camera known by points"),
        }
    }

    #[test]
    fn rectified_pictures_have_the_projection_and_no_lens() {
        let (taken, lens) = of(PictureKind::AsTaken);
        assert_eq!(taken, Intrinsics { fx: 500.0, fy: 510.0, cx: 320.0, cy: 240.0 });
        assert!(matches!(lens, Distortion::BrownConrady { .. }));
        let (rectified, lens) = of(PictureKind::Rectified);
        assert_eq!(rectified, Intrinsics { fx: 450.0, fy: 455.0, cx: 310.0, cy: 230.0 });
        assert!(matches!(lens, Distortion::None));
    }

    #[test]
    fn what_no_camera_has_is_refused() {
        let nothing = CameraInfo::default();
        assert!(nothing.camera(PictureKind::AsTaken, Mount::level(1.4)).is_err());
        let unknown = CameraInfo { distortion_model: "fisheye62".to_owned(), ..info() };
        let error = unknown.camera(PictureKind::AsTaken, Mount::level(1.4)).unwrap_err().to_string();
        assert!(error.contains("fisheye62"), "{error}");
    }
}

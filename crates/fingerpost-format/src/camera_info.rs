//! A camera's calibration as robots' messages and files hold it: matrices and the name of a distortion model, no mount.
//!
//! Source: ROS `sensor_msgs/CameraInfo`, whose names of models and order of coefficients are OpenCV's.

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};

use crate::{CameraFileError, CameraRemark, ReadCamera};

/// Most Brown-Conrady coefficients that are used; OpenCV's thin-prism and tilt terms come behind them.
const BROWN_CONRADY_COEFFICIENTS: usize = 8;
/// Those of Kannala and Brandt's model.
const KANNALA_BRANDT_COEFFICIENTS: usize = 4;
/// Share of a matrix's largest element by which one that must be zero may differ from it: what is lost in adding doubles up.
const ROUNDING: f64 = 1e-12;

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
    /// The camera of such pictures on its mount, with what must be known of how it was understood.
    ///
    /// # Errors
    /// [`CameraFileError`] when the distortion model is unknown or the numbers cannot be those of a camera.
    pub fn camera(&self, pictures: PictureKind, mount: Mount) -> Result<ReadCamera, CameraFileError> {
        let (matrix, lens, remarks) = match pictures {
            PictureKind::AsTaken => {
                let lens = distortion(&self.distortion_model, &self.distortion)?;
                (self.matrix, lens, self.remark_on_lens().into_iter().collect())
            }
            PictureKind::Rectified => {
                let [a, b, c, _, d, e, f, _, g, h, i, _] = self.projection;
                ([a, b, c, d, e, f, g, h, i], Distortion::None, Vec::new())
            }
        };
        let camera = Camera::calibrated(self.width, self.height, intrinsics(matrix)?, lens, mount)?;
        Ok(ReadCamera { camera, remarks })
    }

    /// Without coefficients a lens is taken not to distort, as ROS's `image_geometry` does.
    fn remark_on_lens(&self) -> Option<CameraRemark> {
        match self.distortion_model.as_str() {
            _ if !self.distortion.is_empty() => None,
            "none" => None,
            "" => Some(CameraRemark::NoDistortion),
            model => Some(CameraRemark::NoCoefficients { model: model.to_owned() }),
        }
    }
}

/// Focal lengths and principal point of a camera matrix by rows, in which nothing else may stand.
fn intrinsics(matrix: [f64; 9]) -> Result<Intrinsics, CameraFileError> {
    let [fx, skew_px, cx, below, fy, cy, first, second, scale] = matrix;
    let is_zero = |value: f64| value.abs() <= ROUNDING * fx.abs().max(1.0);
    if !is_zero(skew_px) {
        return Err(CameraFileError::Skew { skew_px });
    }
    let is_in_pixels = [below, first, second, scale - 1.0].into_iter().all(is_zero);
    // A matrix of zeros is how ROS says that a camera is not calibrated; its focal length says so.
    if is_in_pixels || is_zero(fx) {
        Ok(Intrinsics { fx, fy, cx, cy })
    } else {
        Err(CameraFileError::Matrix { matrix })
    }
}

/// Names of the fisheye lens of Kannala and Brandt, in ROS, Kalibr, OpenCV and this project.
pub(crate) const KANNALA_BRANDT_NAMES: [&str; 4] = ["equidistant", "equi", "fisheye", "kannala_brandt"];

/// The lens of a model's name and coefficients, by the names of ROS, OpenCV, Kalibr and viewers' messages.
fn distortion(model: &str, coefficients: &[f64]) -> Result<Distortion, CameraFileError> {
    let used = |most| without_zeros_behind(coefficients, most);
    match model {
        "plumb_bob" | "rational_polynomial" | "radtan" if coefficients.is_empty() => Ok(Distortion::None),
        "plumb_bob" | "rational_polynomial" | "radtan" => {
            Ok(Distortion::brown_conrady(used(BROWN_CONRADY_COEFFICIENTS))?)
        }
        model if KANNALA_BRANDT_NAMES.contains(&model) => {
            Ok(Distortion::kannala_brandt(used(KANNALA_BRANDT_COEFFICIENTS))?)
        }
        "none" | "" if used(0).is_empty() => Ok(Distortion::None),
        "none" | "" => Err(CameraFileError::NoModel { count: coefficients.len() }),
        other => Err(CameraFileError::UnknownDistortion {
            model: other.to_owned(),
            known: "\"plumb_bob\", \"rational_polynomial\", \"radtan\", \"equidistant\" or \"none\"",
        }),
    }
}

/// The first `most` coefficients where only zeros come behind them, else all.
fn without_zeros_behind(coefficients: &[f64], most: usize) -> &[f64] {
    match coefficients.split_at_checked(most) {
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
        let read = info().camera(pictures, Mount::level(1.4)).expect("a camera");
        match read.camera.view() {
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
        for (info, named) in [
            (CameraInfo { distortion_model: "fisheye62".to_owned(), ..info() }, "fisheye62"),
            (CameraInfo { distortion_model: String::new(), ..info() }, "5 coefficients"),
            (CameraInfo { distortion_model: "none".to_owned(), ..info() }, "5 coefficients"),
            (
                CameraInfo { distortion_model: "fisheye".to_owned(), distortion: vec![0.1; 5], ..info() },
                "5 were",
            ),
            (CameraInfo { matrix: [500.0, 3.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0], ..info() }, "skew"),
            (CameraInfo { matrix: [500.0, 0.0, 0.0, 0.0, 510.0, 0.0, 320.0, 240.0, 1.0], ..info() }, "rows"),
        ] {
            let error = info.camera(PictureKind::AsTaken, Mount::level(1.4)).unwrap_err().to_string();
            assert!(error.contains(named), "{error}");
        }
    }

    #[test]
    fn a_lens_without_coefficients_is_said_to_be_none() {
        let remarks = |model: &str| {
            let info = CameraInfo { distortion_model: model.to_owned(), distortion: Vec::new(), ..info() };
            info.camera(PictureKind::AsTaken, Mount::level(1.4)).map(|read| read.remarks).ok()
        };
        assert_eq!(remarks("none"), Some(Vec::new()));
        assert_eq!(remarks(""), Some(vec![CameraRemark::NoDistortion]));
        let named = CameraRemark::NoCoefficients { model: "plumb_bob".to_owned() };
        assert_eq!(remarks("plumb_bob"), Some(vec![named]));
        assert_eq!(remarks("equidistant"), None, "a lens of that kind has four coefficients");
    }
}

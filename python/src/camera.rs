//! Cameras.

use std::path::PathBuf;

use fingerpost::geometry::{self, Distortion, Intrinsics, Mount, Pixel};
use fingerpost::nalgebra::Point2;
use fingerpost_format::{camera_from_toml, camera_from_yaml, camera_to_toml};
use fingerpost_io::read_camera;
use pyo3::prelude::*;

use crate::errors::{CameraError, exception};

/// A calibrated camera on its mount.
#[pyclass(frozen, module = "fingerpost")]
pub(crate) struct Camera(pub(crate) geometry::Camera);

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (width, height, *, fx, fy, cx, cy, height_m, pitch_deg=0.0, yaw_deg=0.0, roll_deg=0.0, x_m=0.0, y_m=0.0,
                        distortion="none", coefficients=Vec::new()))]
    #[expect(clippy::too_many_arguments, reason = "the keys of camera.toml, each by its name")]
    fn new(
        width: usize,
        height: usize,
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        height_m: f64,
        pitch_deg: f64,
        yaw_deg: f64,
        roll_deg: f64,
        x_m: f64,
        y_m: f64,
        distortion: &str,
        coefficients: Vec<f64>,
    ) -> PyResult<Self> {
        let lens = match distortion {
            "none" => Ok(Distortion::None),
            "brown-conrady" => Distortion::brown_conrady(&coefficients),
            "kannala-brandt" => Distortion::kannala_brandt(&coefficients),
            other => {
                return Err(CameraError::new_err(format!(
                    "distortion {other:?} is unknown; use \"none\", \"brown-conrady\" or \"kannala-brandt\""
                )));
            }
        };
        let mount = Mount {
            height_m,
            pitch_rad: pitch_deg.to_radians(),
            yaw_rad: yaw_deg.to_radians(),
            roll_rad: roll_deg.to_radians(),
            x_m,
            y_m,
        };
        let camera = lens.and_then(|lens| {
            geometry::Camera::calibrated(width, height, Intrinsics { fx, fy, cx, cy }, lens, mount)
        });
        camera.map(Self).map_err(exception!(CameraError))
    }

    /// Reads camera.toml, or the YAML of ROS camera_info or OpenCV with a mount.toml beside it.
    #[staticmethod]
    fn from_file(path: PathBuf) -> PyResult<Self> {
        read_camera(&path).map(|read| Self(read.camera)).map_err(exception!(CameraError))
    }

    /// The camera of a text as in camera.toml.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        camera_from_toml(text).map(Self).map_err(exception!(CameraError))
    }

    /// The camera of a YAML text with a mapping `mount` in it.
    #[staticmethod]
    fn from_yaml(text: &str) -> PyResult<Self> {
        camera_from_yaml(text, None).map(|read| Self(read.camera)).map_err(exception!(CameraError))
    }

    /// The text of its camera.toml.
    fn to_toml(&self) -> PyResult<String> {
        camera_to_toml(&self.0).map_err(exception!(CameraError))
    }

    /// Width of its pictures, pixels.
    #[getter]
    fn width(&self) -> usize {
        self.0.width()
    }

    /// Height of its pictures, pixels.
    #[getter]
    fn height(&self) -> usize {
        self.0.height()
    }

    /// Where a place on the road, metres forward and left, is in the picture: right and down, pixels; None behind the camera.
    fn pixel_of_ground(&self, x_m: f64, y_m: f64) -> Option<(f64, f64)> {
        self.0.pixel_of_ground(Point2::new(x_m, y_m)).map(|pixel| (pixel.u, pixel.v))
    }

    /// Which place on the road a pixel shows, metres forward and left; None above the horizon.
    fn ground_of_pixel(&self, u: f64, v: f64) -> Option<(f64, f64)> {
        self.0.ground_of_pixel(Pixel::new(u, v)).map(|place| (place.x, place.y))
    }

    /// The camera of pictures made smaller or larger.
    fn scaled_to(&self, width: usize, height: usize) -> PyResult<Self> {
        self.0.scaled_to(width, height).map(Self).map_err(exception!(CameraError))
    }

    fn __repr__(&self) -> String {
        format!("Camera({} x {})", self.0.width(), self.0.height())
    }
}

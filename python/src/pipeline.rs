//! The method, frame by frame.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use fingerpost::fix::NearPlace;
use fingerpost::vehicle_signals::VehicleSamples;
use fingerpost::vision::picture::RgbImage;
use fingerpost::{Config, PipelineError, Sensors};
use fingerpost_eval::FeatureIdentity;
use fingerpost_record::{FrameTime, feature_identities, frame_record};
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use crate::camera::Camera;
use crate::errors::{CameraError, ConfigError, FrameError, MapError, chain, exception};
use crate::output::{Arrays, Output};
use crate::roads::{RoadMap, Route, place};

/// How well the place that `near` gives is known, standard deviation, metres, as `fingerpost run --near` takes it.
const NEAR_SIGMA_M: f64 = 20.0;

/// The method with its state.
#[pyclass(frozen, module = "fingerpost")]
pub(crate) struct Pipeline(Mutex<Driven>);

struct Driven {
    pipeline: fingerpost::Pipeline,
    features: Vec<FeatureIdentity>,
    /// Memory that frames are copied to.
    frame: RgbImage,
    frames: u64,
    last_t_s: Option<f64>,
}

#[pymethods]
impl Pipeline {
    #[new]
    #[pyo3(signature = (camera, route=None, *, start_m=None, config=None, roads=None, near=None))]
    fn new(
        py: Python<'_>,
        camera: &Camera,
        route: Option<&Route>,
        start_m: Option<f64>,
        config: Option<&str>,
        roads: Option<&RoadMap>,
        near: Option<(f64, f64)>,
    ) -> PyResult<Self> {
        let config =
            config.map_or(Ok(Config::default()), Config::from_toml).map_err(exception!(ConfigError))?;
        config.check().map_err(exception!(ConfigError))?;
        let near = near.map(place).transpose()?.map(|at| NearPlace { at, sigma_m: NEAR_SIGMA_M });
        let (camera, route) = (&camera.0, route.map(|route| &route.0));
        let parts = fingerpost_papers::parts(&config).map_err(exception!(ConfigError))?;
        let made = py.detach(|| fingerpost::Pipeline::with_parts(&config, camera, route, start_m, parts));
        let mut pipeline = made.map_err(|error| match error {
            PipelineError::Config(_) | PipelineError::Advice(_) => ConfigError::new_err(chain(&error)),
            PipelineError::Route(_) | PipelineError::Mask(_) => MapError::new_err(chain(&error)),
            _ => CameraError::new_err(chain(&error)),
        })?;
        if let Some(roads) = roads {
            pipeline.locate_on(&roads.0, near);
        }
        let features = feature_identities(pipeline.tracker().stops());
        let frame = RgbImage::new(camera.width(), camera.height());
        Ok(Self(Mutex::new(Driven { pipeline, features, frame, frames: 0, last_t_s: None })))
    }

    /// Takes one frame in.
    #[pyo3(signature = (frame, t_s=None, *, gps=None, speed_mps=None, yaw_rate_rps=None))]
    fn step(
        &self,
        py: Python<'_>,
        frame: PyReadonlyArray3<'_, u8>,
        t_s: Option<f64>,
        gps: Option<(f64, f64)>,
        speed_mps: Option<f64>,
        yaw_rate_rps: Option<f64>,
    ) -> PyResult<Output> {
        let numbers = [t_s, speed_mps, yaw_rate_rps];
        if numbers.iter().flatten().any(|number| !number.is_finite()) {
            return Err(FrameError::new_err(
                "t_s, speed_mps and yaw_rate_rps must be finite; leave out what is not known",
            ));
        }
        let gps = gps.map(place).transpose()?;
        let signals = VehicleSamples::of_now(speed_mps, yaw_rate_rps);
        let mut driven = self.driven(py);
        driven.take(&frame)?;
        let driven = &mut *driven;
        py.detach(|| driven.step(t_s, Sensors { gps, signals, dt_s: None })).map_err(exception!(FrameError))
    }

    /// How many frames were taken in.
    #[getter]
    fn frames(&self, py: Python<'_>) -> u64 {
        self.driven(py).frames
    }

    /// The settings in force, TOML.
    fn config(&self, py: Python<'_>) -> PyResult<String> {
        self.driven(py).pipeline.config().to_toml().map_err(exception!(ConfigError))
    }
}

impl Pipeline {
    /// Waits for a step of another thread with the interpreter's lock released.
    fn driven(&self, py: Python<'_>) -> MutexGuard<'_, Driven> {
        self.0.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }
}

impl Driven {
    /// Copies a frame, so that its owner may change it while the method works.
    fn take(&mut self, frame: &PyReadonlyArray3<'_, u8>) -> PyResult<()> {
        let (width, height) = self.frame.size();
        let shape = frame.shape();
        if shape != [height, width, 3] {
            return Err(FrameError::new_err(format!(
                "the frame has shape {shape:?} and the camera's pictures have [{height}, {width}, 3]; give height, width and red, green, \
                 blue, or scale the camera (Camera.scaled_to)"
            )));
        }
        match frame.as_slice() {
            Ok(pixels) => self.frame.as_mut_slice().copy_from_slice(pixels),
            // A view with gaps, as of a picture that was cut or turned.
            Err(_) => {
                let pixels = self.frame.as_mut_slice().iter_mut().zip(frame.as_array());
                pixels.for_each(|(target, source)| *target = *source);
            }
        }
        Ok(())
    }

    fn step(&mut self, t_s: Option<f64>, sensors: Sensors) -> Result<Output, PipelineError> {
        let dt_s = t_s.zip(self.last_t_s).map(|(t_s, last_s)| t_s - last_s).filter(|dt_s| *dt_s >= 0.0);
        let sensors = Sensors { dt_s, ..sensors };
        let (output, evidence) = self.pipeline.step(&self.frame, sensors, &mut |_stage| ())?;
        let time = FrameTime { frame: self.frames, t_s: t_s.unwrap_or_default() };
        let record = frame_record(time, output, &evidence, &self.features, BTreeMap::new());
        let arrays = Arrays::of(output, &evidence);
        self.frames += 1;
        self.last_t_s = t_s.or(self.last_t_s);
        Ok(Output::new(record, arrays))
    }
}

/// The JSON Schema of the settings: every key with its unit, range and default.
#[pyfunction]
pub(crate) fn config_schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    crate::json::to_python(py, Config::schema())
}

//! Simulated drives.

use fingerpost_sim::{Conditions, CornerStyle, SimConfig, SimFrame, TrafficSide};
use numpy::{PyArray2, PyArray3, PyArrayMethods, ToPyArray};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;

use crate::camera::Camera;
use crate::errors::{SimulationError, exception};
use crate::json;
use crate::output::plane;
use crate::roads::{RoadMap, Route};

/// A vehicle on a map's roads, seen by its camera.
#[pyclass(frozen, module = "fingerpost", sequence)]
pub(crate) struct Simulator(fingerpost_sim::Simulator);

#[pymethods]
impl Simulator {
    #[new]
    #[pyo3(signature = (roads, route, camera, *, seed=1, conditions="clear", fps=10.0, frames=None, traffic="right"))]
    #[expect(clippy::too_many_arguments, reason = "the options of simulate, each by its name")]
    fn new(
        py: Python<'_>,
        roads: &RoadMap,
        route: &Route,
        camera: &Camera,
        seed: u64,
        conditions: &str,
        fps: f64,
        frames: Option<usize>,
        traffic: &str,
    ) -> PyResult<Self> {
        let traffic = match traffic {
            "left" => TrafficSide::Left,
            "right" => TrafficSide::Right,
            "centre" => TrafficSide::Centre,
            other => {
                return Err(SimulationError::new_err(format!(
                    "traffic {other:?} is unknown; use \"left\", \"right\" or \"centre\""
                )));
            }
        };
        let conditions = Conditions::named(conditions).map_err(exception!(SimulationError))?;
        let corners = if conditions.kerbs > 0.0 { CornerStyle::Drawn } else { CornerStyle::default() };
        let config = SimConfig { seed, fps, frames, traffic, corners, conditions, ..SimConfig::default() };
        py.detach(|| fingerpost_sim::Simulator::new(&roads.0, &route.0, &camera.0, &config))
            .map(Self)
            .map_err(exception!(SimulationError))
    }

    fn __len__(&self) -> usize {
        self.0.frames()
    }

    fn __getitem__(&self, py: Python<'_>, index: isize) -> PyResult<SimulatedFrame> {
        let length = self.0.frames();
        let from_start =
            if index < 0 { length.checked_add_signed(index) } else { usize::try_from(index).ok() };
        let index = from_start.filter(|index| *index < length);
        let index = index.ok_or_else(|| PyIndexError::new_err(format!("the drive has {length} frames")))?;
        Ok(SimulatedFrame(py.detach(|| self.0.frame(index))))
    }
}

/// A frame of a simulated drive.
#[pyclass(frozen, module = "fingerpost")]
pub(crate) struct SimulatedFrame(SimFrame);

#[pymethods]
impl SimulatedFrame {
    /// What the camera sees: rows, columns, and red, green, blue.
    #[getter]
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let (width, height) = self.0.picture.size();
        self.0.picture.as_slice().to_pyarray(py).reshape([height, width, 3])
    }

    /// Where road is in it: 255, else 0.
    #[getter]
    fn road_mask<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        plane(py, &self.0.road)
    }

    /// What is true of it, as a line of truth.jsonl.
    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.0.truth)
    }
}

/// Names of the conditions that drives can be simulated under.
#[pyfunction]
pub(crate) fn conditions() -> Vec<&'static str> {
    Conditions::names().to_vec()
}

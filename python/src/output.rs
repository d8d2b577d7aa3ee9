//! What comes of a frame, and what it came from.

use fingerpost::vision::picture::{Plane, RgbImage};
use fingerpost::{FrameEvidence, FrameOutput};
use fingerpost_format::FrameRecord;
use numpy::{PyArray2, PyArray3, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;

use crate::json;

/// The pictures of a frame's evidence.
pub(crate) struct Arrays {
    ground_view: RgbImage,
    ground_validity: Plane<u8>,
    road_surface: Plane<u8>,
    road_known: Plane<u8>,
    driving_line: Vec<[f64; 2]>,
}

impl Arrays {
    pub(crate) fn of(output: &FrameOutput, evidence: &FrameEvidence<'_>) -> Self {
        Self {
            ground_view: evidence.ground.colour.clone(),
            ground_validity: evidence.validity.clone(),
            road_surface: evidence.surface.probability.clone(),
            road_known: evidence.surface.known().plane().clone(),
            driving_line: output.driving_line.iter().map(|p| [p.x, p.y]).collect(),
        }
    }
}

/// What the method says of a frame, and what it saw.
#[pyclass(frozen, module = "fingerpost")]
pub(crate) struct Output {
    record: FrameRecord,
    arrays: Arrays,
}

impl Output {
    pub(crate) fn new(record: FrameRecord, arrays: Arrays) -> Self {
        Self { record, arrays }
    }
}

#[pymethods]
impl Output {
    /// What the program writes as a line of frames.jsonl; its stage_ms is empty.
    #[getter]
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.record)
    }

    /// "searching", "tracking", "arrived", "lost", "route_done" or "no_route".
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.record.state)
    }

    /// The followed feature; None where there is none.
    #[getter]
    fn feature<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.record.feature)
    }

    /// Steering angle and speed for a controller, and why.
    #[getter]
    fn advice<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.record.advice)
    }

    /// What was decided and what decided it.
    #[getter]
    fn why(&self) -> &str {
        &self.record.why
    }

    /// The view from above, far up: rows, columns, and red, green, blue.
    #[getter]
    fn ground_view<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let (width, height) = self.arrays.ground_view.size();
        self.arrays.ground_view.as_slice().to_pyarray(py).reshape([height, width, 3])
    }

    /// Where the camera shows the road's plane: 1, else 0.
    #[getter]
    fn ground_validity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        plane(py, &self.arrays.ground_validity)
    }

    /// How probable road is in the view from above, 255 for 1.
    #[getter]
    fn road_surface<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        plane(py, &self.arrays.road_surface)
    }

    /// Where that is known, seen or remembered: 1, else 0.
    #[getter]
    fn road_known<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        plane(py, &self.arrays.road_known)
    }

    /// The driving line: points forward and left of the vehicle, metres.
    #[getter]
    fn driving_line<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.arrays.driving_line.as_flattened().to_pyarray(py).reshape([self.arrays.driving_line.len(), 2])
    }

    fn __repr__(&self) -> String {
        format!("Output({:?})", self.record.why)
    }
}

/// A plane as rows and columns.
pub(crate) fn plane<'py>(py: Python<'py>, plane: &Plane<u8>) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let (width, height) = plane.size();
    plane.as_slice().to_pyarray(py).reshape([height, width])
}

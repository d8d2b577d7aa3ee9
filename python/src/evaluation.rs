//! Records against truth.

use fingerpost_eval::LaneMeasure;
use fingerpost_format::{FrameRecord, TruthRecord};
use pyo3::prelude::*;

use crate::errors::{EvaluationError, exception};
use crate::json;
use crate::roads::Route;

/// What a run found of a route's features and how far off it put them, by the records of its frames and the truth of its drive.
#[pyfunction]
pub(crate) fn evaluate_junctions<'py>(
    py: Python<'py>,
    records: &Bound<'py, PyAny>,
    truth: &Bound<'py, PyAny>,
    route: &Route,
) -> PyResult<Bound<'py, PyAny>> {
    let records: Vec<FrameRecord> = json::from_python(records, "frame")?;
    let truth: Vec<TruthRecord> = json::from_python(truth, "truth")?;
    let ids: Vec<i64> = route.0.features.iter().map(|feature| feature.id).collect();
    let evaluation = py.detach(|| fingerpost_eval::evaluate_junctions(&records, &truth, &ids));
    json::to_python(py, &evaluation.map_err(exception!(EvaluationError))?)
}

/// How near the lane edges of a run are to those of the truth, by the records of its frames.
#[pyfunction]
pub(crate) fn evaluate_lanes<'py>(
    py: Python<'py>,
    records: &Bound<'py, PyAny>,
    truth: &Bound<'py, PyAny>,
    picture_px: [u32; 2],
) -> PyResult<Bound<'py, PyAny>> {
    let records: Vec<FrameRecord> = json::from_python(records, "frame")?;
    let truth: Vec<TruthRecord> = json::from_python(truth, "truth")?;
    let measure = LaneMeasure::default();
    let evaluation = py.detach(|| fingerpost_eval::evaluate_lanes(&records, &truth, picture_px, &measure));
    json::to_python(py, &evaluation.map_err(exception!(EvaluationError))?)
}

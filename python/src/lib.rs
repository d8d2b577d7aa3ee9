//! The package `fingerpost` for Python: the method, the simulator and the evaluation. What Python sees is documented in
//! `fingerpost/_fingerpost.pyi`.

mod camera;
mod errors;
mod evaluation;
mod json;
mod output;
mod pipeline;
mod roads;
mod search;
mod simulator;

use pyo3::prelude::*;

/// Fingerpost's method, simulator and evaluation.
#[pymodule(gil_used = false)]
mod _fingerpost {
    #[pymodule_export]
    use super::camera::Camera;
    #[pymodule_export]
    use super::errors::{
        CameraError, ConfigError, EvaluationError, FingerpostError, FrameError, MapError, SimulationError,
    };
    #[pymodule_export]
    use super::evaluation::{evaluate_junctions, evaluate_lanes};
    #[pymodule_export]
    use super::output::Output;
    #[pymodule_export]
    use super::pipeline::{Pipeline, config_schema};
    #[pymodule_export]
    use super::roads::{RoadMap, Route, demo_town};
    #[pymodule_export]
    use super::search::{Search, front};
    #[pymodule_export]
    use super::simulator::{SimulatedFrame, Simulator, conditions};
    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

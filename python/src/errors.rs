//! Errors as exceptions, whose text is the cause and the next action.

use pyo3::create_exception;
use pyo3::exceptions::PyException;

create_exception!(fingerpost, FingerpostError, PyException, "What went wrong, and what to do about it.");
create_exception!(fingerpost, CameraError, FingerpostError, "A calibration cannot be used.");
create_exception!(fingerpost, ConfigError, FingerpostError, "A setting is unknown or out of range.");
create_exception!(fingerpost, MapError, FingerpostError, "A map or route cannot be used.");
create_exception!(
    _fingerpost,
    FrameError,
    FingerpostError,
    "A frame cannot be used; the pipeline is as before it."
);
create_exception!(fingerpost, SimulationError, FingerpostError, "A drive cannot be simulated.");
create_exception!(fingerpost, EvaluationError, FingerpostError, "Records and truth do not fit together.");

/// An exception with an error's text and those of what caused it.
macro_rules! exception {
    ($kind:ty) => {
        |error| <$kind>::new_err($crate::errors::chain(&error))
    };
}
pub(crate) use exception;

/// An error with its causes, each once.
pub(crate) fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        let cause_text = cause.to_string();
        if !text.contains(&cause_text) {
            text = format!("{text}: {cause_text}");
        }
        source = cause.source();
    }
    text
}

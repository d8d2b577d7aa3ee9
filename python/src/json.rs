//! Records between Rust and Python, as the JSON that files hold.

use pyo3::prelude::*;
use serde::{Serialize, de::DeserializeOwned};

use crate::errors::EvaluationError;

/// A record as dictionaries, lists and numbers.
pub(crate) fn to_python<'py>(py: Python<'py>, record: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(record).map_err(|cause| EvaluationError::new_err(cause.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Records of dictionaries as files hold them, `what` they are called in the error.
pub(crate) fn from_python<T: DeserializeOwned>(records: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<T>> {
    let dumps = records.py().import("json")?.getattr("dumps")?;
    let mut read = Vec::new();
    for (index, record) in records.try_iter()?.enumerate() {
        let text: String = dumps.call1((record?,))?.extract()?;
        read.push(serde_json::from_str(&text).map_err(|cause| {
            EvaluationError::new_err(format!(
                "{what} {index} is no such record: {cause}; give those of the files"
            ))
        })?);
    }
    Ok(read)
}

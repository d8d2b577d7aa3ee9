//! JSON lines: one object a line.

use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error;

/// A JSON-lines text that cannot be used.
#[derive(Debug, Error)]
pub enum LinesError {
    /// A line does not hold the object it should.
    #[error("line {line} is not a valid record ({cause}); remove or mend it")]
    Parse {
        /// Line number, from one.
        line: usize,
        /// What the parser says.
        cause: serde_json::Error,
    },
    /// A value cannot be written as JSON.
    #[error("the record cannot be written as JSON ({cause})")]
    Write {
        /// What the writer says.
        cause: serde_json::Error,
    },
}

/// The records of a JSON-lines text; empty lines are passed over.
///
/// # Errors
/// [`LinesError::Parse`] names the first line that is no such record.
pub fn from_json_lines<T: DeserializeOwned>(text: &str) -> Result<Vec<T>, LinesError> {
    json_lines(text).collect()
}

/// The records of a text one after the other, for a reader that keeps but a part of each.
pub fn json_lines<T: DeserializeOwned>(text: &str) -> impl Iterator<Item = Result<T, LinesError>> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(i, line)| serde_json::from_str(line).map_err(|cause| LinesError::Parse { line: i + 1, cause }))
}

/// A record as one line, line end included.
///
/// # Errors
/// [`LinesError::Write`] when the record has no JSON form.
pub fn to_json_line<T: Serialize>(record: &T) -> Result<String, LinesError> {
    let mut line = serde_json::to_string(record).map_err(|cause| LinesError::Write { cause })?;
    line.push('\n');
    Ok(line)
}

//! Values as the JSON of their files, and JSON lines: one object a line.
//!
//! What turns a type into JSON and back is compiled with the type, once, and not in every crate that reads or writes it.

use thiserror::Error;

use crate::{
    Campaign, ClosedLoop, FixLine, FrameRecord, LoopDrive, LoopFrame, SilenceRecord, Summary, TruthRecord,
    TuSimpleRecord, TuningFront, TuningTrial,
};

/// A value that a file has as JSON: a record on one line, a table indented.
pub trait ToJson {
    /// The JSON, without an end of line behind it.
    ///
    /// # Errors
    /// Whatever has no JSON form.
    fn to_json(&self) -> serde_json::Result<String>;
}

/// A value that is read from JSON.
pub trait FromJson: Sized {
    /// The value of a text.
    ///
    /// # Errors
    /// What the text lacks or has too much.
    fn from_json(text: &str) -> serde_json::Result<Self>;
}

/// Implements [`ToJson`], as one line, and [`FromJson`] for types that serde writes and reads, in the crate that calls it.
#[macro_export]
macro_rules! json_records {
    ($($of:ty),+ $(,)?) => {$(
        impl $crate::ToJson for $of {
            fn to_json(&self) -> $crate::serde_json::Result<String> {
                $crate::serde_json::to_string(self)
            }
        }

        impl $crate::FromJson for $of {
            fn from_json(text: &str) -> $crate::serde_json::Result<Self> {
                $crate::serde_json::from_str(text)
            }
        }
    )+};
}

json_records!(
    FrameRecord,
    SilenceRecord,
    TruthRecord,
    TuSimpleRecord,
    FixLine,
    LoopDrive,
    LoopFrame,
    TuningTrial
);

macro_rules! json_tables {
    ($($of:ty),+) => {$(
        impl ToJson for $of {
            fn to_json(&self) -> serde_json::Result<String> {
                serde_json::to_string_pretty(self)
            }
        }
    )+};
}

json_tables!(Summary, Campaign, ClosedLoop, TuningFront);

impl FromJson for Summary {
    fn from_json(text: &str) -> serde_json::Result<Self> {
        serde_json::from_str(text)
    }
}

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
pub fn from_json_lines<T: FromJson>(text: &str) -> Result<Vec<T>, LinesError> {
    json_lines(text).collect()
}

/// The records of a text one after the other, for a reader that keeps but a part of each.
pub fn json_lines<T: FromJson>(text: &str) -> impl Iterator<Item = Result<T, LinesError>> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines.map(|(i, line)| T::from_json(line).map_err(|cause| LinesError::Parse { line: i + 1, cause }))
}

/// A record as one line, line end included.
///
/// # Errors
/// [`LinesError::Write`] when the record has no JSON form.
pub fn to_json_line<T: ToJson>(record: &T) -> Result<String, LinesError> {
    let mut line = record.to_json().map_err(|cause| LinesError::Write { cause })?;
    line.push('\n');
    Ok(line)
}

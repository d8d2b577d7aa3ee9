//! Calling the program.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Output};

use fingerpost_format::{FrameRecord, Summary, from_json_lines};

/// What came of a call.
#[derive(Debug)]
pub(crate) struct Called {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Called {
    /// The call, which must have ended well.
    pub(crate) fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }

    /// Asserts that the call failed with `code` and that its message holds every one of `words`.
    pub(crate) fn refused(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "{word:?} is not in: {}", self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
    }
}

impl From<Output> for Called {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// The program, ready to be given arguments. What the environment asks it to say is not what tests expect.
pub(crate) fn command() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fingerpost"));
    command.env_remove("RUST_LOG");
    command
}

/// Calls the program.
pub(crate) fn call<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Called {
    command().args(arguments).output().unwrap().into()
}

/// Calls the program with a line of arguments that hold no spaces.
pub(crate) fn call_line(line: &str) -> Called {
    call(line.split_whitespace())
}

/// The frames of a run folder; every line must be valid.
pub(crate) fn frames(run: &Path) -> Vec<FrameRecord> {
    from_json_lines(&std::fs::read_to_string(run.join("frames.jsonl")).unwrap()).unwrap()
}

/// The summary of a run folder.
pub(crate) fn summary(run: &Path) -> Summary {
    serde_json::from_str(&std::fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

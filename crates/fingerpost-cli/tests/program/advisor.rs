//! `fingerpost advise` under way, and what it is given.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use fingerpost_format::{FrameRecord, SilenceRecord, TruthRecord};
use fingerpost_io::{picture_paths, read_picture, read_truth};
use serde::de::DeserializeOwned;
use serde_json::json;

use crate::drive::Drive;
use crate::program::command;

/// The program under way.
pub(crate) struct Advisor {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    /// How often it said that no picture came, before an answer.
    pub(crate) silences: usize,
}

/// How the program ended.
pub(crate) struct Ended {
    /// What it still answered.
    pub(crate) rest: Vec<FrameRecord>,
    pub(crate) code: Option<i32>,
    pub(crate) messages: String,
}

/// A line of the program, if it is one of that kind.
fn read<T: DeserializeOwned>(line: &str) -> Option<T> {
    serde_json::from_str(line).ok()
}

impl Advisor {
    pub(crate) fn start(arguments: &[&str]) -> Self {
        let drive = Drive::get();
        let mut child = command()
            .args(["advise", "--start-m", "0", "--camera"])
            .arg(drive.camera())
            .arg("--route")
            .arg(drive.route())
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (child.stdin.take(), BufReader::new(child.stdout.take().unwrap()));
        Self { child, input, output, silences: 0 }
    }

    pub(crate) fn give(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().unwrap();
        input.write_all(bytes).unwrap();
        input.flush().unwrap();
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.output.read_line(&mut line).unwrap();
        line
    }

    /// The answer to what was given, which comes before anything more is. Who is held up for long meanwhile is told to stop.
    pub(crate) fn answer(&mut self) -> FrameRecord {
        loop {
            let line = self.line();
            if read::<SilenceRecord>(&line).is_none() {
                return serde_json::from_str(&line).unwrap();
            }
            self.silences += 1;
        }
    }

    /// What is said while nothing is given.
    pub(crate) fn silence(&mut self) -> SilenceRecord {
        serde_json::from_str(&self.line()).unwrap()
    }

    pub(crate) fn asked(&mut self, header: &str, pixels: &[u8]) -> FrameRecord {
        self.give(header.as_bytes());
        self.give(b"\n");
        self.give(pixels);
        self.answer()
    }

    /// Ends the input.
    pub(crate) fn end(mut self) -> Ended {
        drop(self.input.take());
        self.ended()
    }

    /// Waits until it ends.
    pub(crate) fn ended(self) -> Ended {
        let lines = self.output.lines().map(Result::unwrap);
        let answers = lines.filter(|line| read::<SilenceRecord>(line).is_none());
        let rest = answers.map(|line| serde_json::from_str(&line).unwrap()).collect();
        let output = self.child.wait_with_output().unwrap();
        let messages = String::from_utf8(output.stderr).unwrap();
        Ended { rest, code: output.status.code(), messages }
    }
}

pub(crate) fn header(truth: &TruthRecord) -> String {
    json!({"t_s": truth.t_s, "width": 320, "height": 240, "speed_mps": truth.speed_mps}).to_string()
}

/// The drive's frames with their truth.
pub(crate) fn drive() -> Vec<(TruthRecord, Vec<u8>)> {
    let drive = Drive::get();
    let truth = read_truth(&drive.truth()).unwrap();
    let paths = picture_paths(&drive.path()).unwrap();
    truth
        .into_iter()
        .zip(paths)
        .map(|(truth, path)| (truth, read_picture(&path).unwrap().as_slice().to_vec()))
        .collect()
}

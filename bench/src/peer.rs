//! The OpenCV peer: a Python program that is asked to do the same work on the same bytes.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::measure::Contestant;

/// An array that goes to the peer or comes back: row-major, in the machine's byte order.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Element type as numpy names it: `u1`, `i2`, `i4`, `f4`.
    pub kind: String,
    pub shape: Vec<usize>,
    pub bytes: Vec<u8>,
}

impl Array {
    pub fn of_u8(shape: &[usize], values: &[u8]) -> Self {
        Self { kind: "u1".to_owned(), shape: shape.to_vec(), bytes: values.to_vec() }
    }

    pub fn of_f32(shape: &[usize], values: &[f32]) -> Self {
        let bytes = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
        Self { kind: "f4".to_owned(), shape: shape.to_vec(), bytes }
    }

    pub fn u8s(&self) -> &[u8] {
        &self.bytes
    }

    pub fn i16s(&self) -> Vec<i16> {
        self.bytes.as_chunks::<2>().0.iter().map(|&bytes| i16::from_ne_bytes(bytes)).collect()
    }

    pub fn i32s(&self) -> Vec<i32> {
        self.bytes.as_chunks::<4>().0.iter().map(|&bytes| i32::from_ne_bytes(bytes)).collect()
    }

    pub fn f32s(&self) -> Vec<f32> {
        self.bytes.as_chunks::<4>().0.iter().map(|&bytes| f32::from_ne_bytes(bytes)).collect()
    }
}

#[derive(Debug, Deserialize)]
struct Announced(String, Vec<usize>);

/// The running program.
#[derive(Debug)]
pub struct OpenCv {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    pub version: String,
}

impl OpenCv {
    /// Starts `script` with the interpreter `python`, which must have OpenCV and numpy.
    pub fn start(python: &Path, script: &Path) -> Result<Self> {
        let mut child = Command::new(python)
            .arg(script)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("{} cannot be started", python.display()))?;
        let (Some(to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
            bail!("the peer has no pipes");
        };
        let mut peer = Self { child, to, from: BufReader::new(from), version: String::new() };
        let (line, _) = peer.ask(&json!({"do": "describe"}), &[])?;
        peer.version = line["opencv"].as_str().unwrap_or("unknown").to_owned();
        Ok(peer)
    }

    /// Hands over an operation's inputs; what is timed and put out from now on is this operation.
    pub fn prepare(&mut self, operation: &str, parameters: &Value, inputs: &[Array]) -> Result<()> {
        let kinds: Vec<_> = inputs.iter().map(|array| (&array.kind, &array.shape)).collect();
        let request =
            json!({"do": "prepare", "operation": operation, "parameters": parameters, "arrays": kinds});
        self.ask(&request, inputs).map(|_| ())
    }

    /// What the operation gives.
    pub fn outputs(&mut self) -> Result<Vec<Array>> {
        Ok(self.ask(&json!({"do": "outputs"}), &[])?.1)
    }

    /// Milliseconds of each of `calls` calls, and of every stage in them where the operation has stages.
    pub fn time(&mut self, calls: usize) -> Result<(Vec<f64>, Vec<(String, Vec<f64>)>)> {
        let (line, _) = self.ask(&json!({"do": "time", "calls": calls}), &[])?;
        let milliseconds = |values: &Value| -> Vec<f64> {
            let values = values.as_array().map(Vec::as_slice).unwrap_or_default();
            values.iter().filter_map(Value::as_f64).map(|nanoseconds| nanoseconds / 1e6).collect()
        };
        let stages = line["stages"].as_object().into_iter().flatten();
        let stages = stages.map(|(name, values)| (name.clone(), milliseconds(values))).collect();
        Ok((milliseconds(&line["nanoseconds"]), stages))
    }

    /// The prepared operation as a contestant.
    pub fn contestant(&mut self) -> Contestant<'_> {
        Contestant { name: "OpenCV".to_owned(), time: Box::new(|calls| Ok(self.time(calls)?.0)) }
    }

    fn ask(&mut self, request: &Value, inputs: &[Array]) -> Result<(Value, Vec<Array>)> {
        writeln!(self.to, "{request}")?;
        for array in inputs {
            self.to.write_all(&array.bytes)?;
        }
        self.to.flush()?;
        let mut line = String::new();
        ensure!(self.from.read_line(&mut line)? > 0, "the peer ended; its message is above");
        let line: Value = serde_json::from_str(&line).context("the peer's answer is not understood")?;
        let announced: Vec<Announced> = serde_json::from_value(line["arrays"].clone())?;
        let mut arrays = Vec::new();
        for Announced(kind, shape) in announced {
            let width: usize = kind[1..].parse()?;
            let mut bytes = vec![0; shape.iter().product::<usize>() * width];
            self.from.read_exact(&mut bytes)?;
            arrays.push(Array { kind, shape, bytes });
        }
        Ok((line, arrays))
    }
}

impl Drop for OpenCv {
    fn drop(&mut self) {
        // It may be gone already, which is what is wanted.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

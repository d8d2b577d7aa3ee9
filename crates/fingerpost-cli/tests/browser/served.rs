//! The program with a page of its.

use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

/// The program while it serves a page; killed with the value.
pub(crate) struct Served {
    program: Child,
    pub(crate) address: String,
}

impl Served {
    /// Starts it with these arguments on a free port.
    pub(crate) fn start<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Self {
        let mut program = Command::new(env!("CARGO_BIN_EXE_fingerpost"))
            .args(arguments)
            .args(["--port", "0"])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let said = BufReader::new(program.stderr.take().unwrap()).lines().map(Result::unwrap);
        let address = said
            .filter_map(|line| Some(line.strip_prefix("open ")?.split(' ').next()?.to_owned()))
            .next()
            .unwrap();
        Self { program, address }
    }

    /// Processor time that it has taken so far, on all cores together, seconds; Linux counts it in hundredths.
    pub(crate) fn processor_s(&self) -> f64 {
        let stat = fs::read_to_string(format!("/proc/{}/stat", self.program.id())).unwrap();
        // Its name, in brackets, may hold spaces; then user and system time are the 12th and 13th.
        let numbers = stat.rsplit(')').next().unwrap().split_whitespace().skip(11).take(2);
        numbers.map(|ticks| ticks.parse::<f64>().unwrap() / 100.0).sum()
    }

    /// The first line of the answer to a request, in which PORT stands for the server's.
    pub(crate) fn ask(&self, request: &str) -> String {
        let port = self.address.trim_end_matches('/').rsplit(':').next().unwrap();
        let mut stream = TcpStream::connect(format!("127.0.0.1:{port}")).unwrap();
        stream.write_all(request.replace("PORT", port).as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer).lines().next().unwrap_or_default().to_owned()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

//! Runs, and what happens to them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::Random;

/// What happens to a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// SIGKILL.
    Kill,
    /// SIGTERM.
    Terminate,
    /// Files may not grow beyond a size.
    FullDisk,
}

/// What was seen of a run.
#[derive(Debug)]
pub(crate) struct Seen {
    /// Whole lines of `frames.jsonl` just before the fault.
    pub(crate) frames: usize,
    /// What the program said.
    pub(crate) stderr: String,
    /// Its exit code; none where a signal ended it.
    pub(crate) code: Option<i32>,
}

/// Frames of the drive.
const FRAMES: usize = 40;
/// Largest limit of a full disk, blocks of 512 bytes: what the frames of a whole run take is more.
const MOST_BLOCKS: f64 = 150.0;

/// A drive, and a run folder and a file of surfaces that all runs share.
pub(crate) struct Subject {
    folder: TempDir,
    /// How long a run takes.
    whole_run: Duration,
}

impl Subject {
    /// Simulates the drive, and learns its surfaces.
    pub(crate) fn new() -> Self {
        let mut subject = Self { folder: TempDir::new().unwrap(), whole_run: Duration::ZERO };
        let config = "[road_surface]\ndetector = \"bank\"\n";
        fs::write(subject.path("bank.toml"), config).unwrap();
        let simulate = format!(
            "simulate --course country --length-m 200 --frames {FRAMES} --size 320x240 --conditions ideal --out {}",
            subject.path("drive").display()
        );
        let done = Command::new(program()).args(simulate.split_whitespace()).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let started = Instant::now();
        subject.run_to_its_end();
        subject.whole_run = started.elapsed();
        subject
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The run folder.
    pub(crate) fn out(&self) -> PathBuf {
        self.path("run")
    }

    /// The file of surfaces.
    pub(crate) fn bank(&self) -> PathBuf {
        self.path("bank.json")
    }

    /// The folder with all of it.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn line(&self) -> String {
        let [drive, camera, config] = ["drive", "drive/camera.toml", "bank.toml"].map(|name| self.path(name));
        format!(
            "run {} --camera {} --config {} --bank {} --pictures 0-{FRAMES} --out {}",
            drive.display(),
            camera.display(),
            config.display(),
            self.bank().display(),
            self.out().display()
        )
    }

    /// A run that nothing happens to.
    pub(crate) fn run_to_its_end(&self) {
        let done = Command::new(program()).args(self.line().split_whitespace()).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        assert_eq!(self.frames(), FRAMES);
    }

    /// Begins a run, and lets a fault meet it at a random moment.
    pub(crate) fn meet(&self, fault: Fault, random: &mut Random) -> Seen {
        // Lines that are seen from here on are this run's.
        let _ = fs::remove_file(self.out().join("frames.jsonl"));
        let share = random.share();
        let limit = match fault {
            Fault::FullDisk => format!("ulimit -f {}; ", 1 + (share * MOST_BLOCKS) as usize),
            Fault::Kill | Fault::Terminate => String::new(),
        };
        let script = format!("{limit}exec {} {}", program(), self.line());
        let mut command = Command::new("sh");
        let mut child =
            command.args(["-c", &script]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let moment = self.whole_run.mul_f64(share);
        let frames = match fault {
            Fault::FullDisk => 0,
            Fault::Kill => self.signal("-KILL", &mut child, moment),
            Fault::Terminate => self.signal("-TERM", &mut child, moment),
        };
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        Seen { frames, stderr, code: output.status.code() }
    }

    /// Sends a signal after a time, and gives the frames seen before.
    fn signal(&self, name: &str, child: &mut Child, moment: Duration) -> usize {
        sleep(moment);
        let frames = self.frames();
        if child.try_wait().unwrap().is_none() {
            assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
        }
        frames
    }

    /// Whole lines of the run's frames.
    fn frames(&self) -> usize {
        let text = fs::read(self.out().join("frames.jsonl")).unwrap_or_default();
        text.iter().filter(|byte| **byte == b'\n').count()
    }
}

pub(crate) fn program() -> &'static str {
    env!("CARGO_BIN_EXE_fingerpost")
}

//! The programs ffmpeg and ffprobe as child processes.
//!
//! Codecs, containers, network streams and cameras are ffmpeg's trade; this crate talks to it through pipes, so that
//! nothing of it is linked in and pictures in folders need none of it.

use std::{
    io::{self, ErrorKind, Read},
    path::PathBuf,
    process::{Child, ChildStderr, Command, Stdio},
    thread::JoinHandle,
};

use thiserror::Error;

use crate::file::FileError;

/// Names or paths of the two programs; the defaults are looked up where the system looks for programs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FfmpegPrograms {
    /// Decodes and encodes.
    pub ffmpeg: PathBuf,
    /// Describes a video.
    pub ffprobe: PathBuf,
}

impl Default for FfmpegPrograms {
    fn default() -> Self {
        Self { ffmpeg: PathBuf::from("ffmpeg"), ffprobe: PathBuf::from("ffprobe") }
    }
}

/// What can go wrong with a video.
#[derive(Debug, Error)]
pub enum VideoError {
    /// One of the programs is not there.
    #[error(
        "the program {program} is needed for video and was not found; install ffmpeg (Debian, Ubuntu: \
         apt install ffmpeg) or give a folder of pictures instead"
    )]
    NotInstalled {
        /// The program looked for.
        program: String,
    },
    /// One of the programs cannot be run.
    #[error("the program {program} cannot be run ({cause}); check its installation")]
    Run {
        /// The program.
        program: String,
        /// What the system says.
        cause: io::Error,
    },
    /// The input is no video that ffmpeg can read.
    #[error("{input} cannot be read as a video ({cause}); check that it plays, or convert it again")]
    Unreadable {
        /// File, address or device.
        input: String,
        /// ffmpeg's last message.
        cause: String,
    },
    /// The video ended before it should.
    #[error(
        "{input} breaks off after {frames} frames ({cause}); the frames before are good, record or copy the rest again"
    )]
    BrokenOff {
        /// File, address or device.
        input: String,
        /// Frames that were read.
        frames: u64,
        /// ffmpeg's last message.
        cause: String,
    },
    /// A video cannot be written.
    #[error("the video {} cannot be written ({cause}); check the disk's space and the ffmpeg installation", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What ffmpeg or the system says.
        cause: String,
    },
    /// The file of a video cannot be made.
    #[error(transparent)]
    File(#[from] FileError),
    /// A picture has another size than the video that it should go into.
    #[error(
        "a picture of {width} x {height} pixels does not fit a video of {expected_width} x {expected_height}; \
         give all pictures of a video the same size"
    )]
    Size {
        /// Width of the picture, pixels.
        width: usize,
        /// Height of the picture, pixels.
        height: usize,
        /// Width of the video, pixels.
        expected_width: usize,
        /// Height of the video, pixels.
        expected_height: usize,
    },
}

/// Bytes of messages that are kept, from the end: enough for the last lines, whatever a damaged stream brings.
const KEPT_MESSAGE_BYTES: usize = 4096;

/// Starts a program with pipes to it, in a process group of its own.
///
/// Ctrl-C in a terminal reaches the whole group of the program that runs there. A child in that group would end before
/// its last frames are written; in its own it ends when its pipes do.
pub(crate) fn spawn(command: &mut Command, stdin: Stdio) -> Result<Child, VideoError> {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    command
        .stdin(stdin)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|cause| start_error(command, cause))
}

/// Why a program did not start.
pub(crate) fn start_error(command: &Command, cause: io::Error) -> VideoError {
    let program = command.get_program().to_string_lossy().into_owned();
    if cause.kind() == ErrorKind::NotFound {
        VideoError::NotInstalled { program }
    } else {
        VideoError::Run { program, cause }
    }
}

/// Reads a program's messages beside its work, so that it never waits for somebody to listen.
#[derive(Debug)]
pub(crate) struct Messages(Option<JoinHandle<Vec<u8>>>);

impl Messages {
    /// Starts to listen.
    pub(crate) fn listen(stderr: Option<ChildStderr>) -> Self {
        Self(stderr.map(|stderr| std::thread::spawn(move || read_tail(stderr))))
    }

    /// The last line said; waits for the program to close its end.
    pub(crate) fn last_line(&mut self) -> Option<String> {
        let tail = self.0.take()?.join().ok()?;
        last_line(&tail)
    }
}

fn read_tail(mut from: impl Read) -> Vec<u8> {
    let mut tail = Vec::new();
    let mut block = [0; KEPT_MESSAGE_BYTES];
    // A pipe that breaks has nothing more to say.
    while let Ok(length @ 1..) = from.read(&mut block) {
        tail.extend_from_slice(&block[..length]);
        let surplus = tail.len().saturating_sub(KEPT_MESSAGE_BYTES);
        tail.drain(..surplus);
    }
    tail
}

/// The last line that is not empty.
pub(crate) fn last_line(text: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(text);
    text.lines().map(str::trim).rfind(|line| !line.is_empty()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_of_endless_messages_is_kept() {
        let mut text = "noise, noise, noise\n".repeat(10_000).into_bytes();
        text.extend_from_slice(b"the reason\n\n");
        let tail = read_tail(text.as_slice());
        assert!(tail.len() <= KEPT_MESSAGE_BYTES);
        assert_eq!(last_line(&tail).as_deref(), Some("the reason"));
        assert_eq!(last_line(b" \n\n"), None);
    }
}

//! The programs ffmpeg and ffprobe as child processes.
//!
//! Codecs, containers, network streams and cameras are ffmpeg's trade; this crate talks to it through pipes, so that
//! nothing of it is linked in, unless the feature `libav` asks for that, and pictures in folders need none of it.

use std::{
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
    process::{Child, ChildStderr, Command, ExitStatus, Stdio},
    sync::{
        Arc,
        atomic::AtomicBool,
        mpsc::{Receiver, RecvTimeoutError, channel},
    },
    thread,
    time::Duration,
};

use thiserror::Error;

use crate::{
    address::without_credentials,
    file::FileError,
    tether::{is_there, tethered},
    waiting::Patience,
};

/// Names or paths of the two programs, and how they are run; the defaults are looked up where the system looks for
/// programs.
#[derive(Debug, Clone)]
pub struct FfmpegPrograms {
    /// Decodes and encodes.
    pub ffmpeg: PathBuf,
    /// Describes a video.
    pub ffprobe: PathBuf,
    /// A program that calls [`become_tethered`](crate::become_tethered), so that the two never outlive this one; none: they
    /// end when their pipes do, which one that stalls does not notice.
    pub tether: Option<PathBuf>,
    /// Set by whoever wants the work to end: nobody waits for the two any more then.
    pub stop: Option<Arc<AtomicBool>>,
}

impl Default for FfmpegPrograms {
    fn default() -> Self {
        let (ffmpeg, ffprobe) = (PathBuf::from("ffmpeg"), PathBuf::from("ffprobe"));
        Self { ffmpeg, ffprobe, tether: None, stop: None }
    }
}

impl FfmpegPrograms {
    /// How long the two are waited for.
    pub(crate) fn patience(&self) -> Patience {
        Patience::new(self.stop.clone())
    }

    /// Starts `program`, one of the two, with pipes to it, in a process group of its own.
    ///
    /// Somebody has to listen to its messages, or it waits for that once there are many.
    ///
    /// Ctrl-C in a terminal reaches the whole group of the program that runs there. A child in that group would end before
    /// its last frames are written; in its own it ends when its pipes do, or when this program does.
    pub(crate) fn start<'a>(
        &self,
        program: &Path,
        arguments: impl IntoIterator<Item = &'a str>,
        stdin: Stdio,
        patience: Patience,
    ) -> Result<RunningProgram, VideoError> {
        let failed = |cause| start_error(program, cause);
        let mut command = match &self.tether {
            Some(_) if !is_there(program) => return Err(failed(ErrorKind::NotFound.into())),
            Some(tether) => tethered(tether, program),
            None => Command::new(program),
        };
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command.args(arguments).stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().map_err(failed)?;
        Ok(RunningProgram { child, messages: Messages { tail: None }, patience })
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
    /// The pictures go on in another size or another way of coding pixels.
    #[error(
        "{input} changes at frame {frames} {change}; the frames before are good, split it there and take each part by itself"
    )]
    Changed {
        /// File, address or device.
        input: String,
        /// Frames that were read.
        frames: u64,
        /// Both forms: "from 640 x 480 (yuv420p) to 320 x 240 (yuv420p)".
        change: String,
    },
    /// The video gives nothing any more.
    #[error(
        "{input} stalls after {frames} frames ({cause}); check the camera and the network, or wait longer (--timeout-s)"
    )]
    Stalled {
        /// File, address or device.
        input: String,
        /// Frames that were read.
        frames: u64,
        /// How long was waited.
        cause: io::Error,
    },
    /// Nobody wants to wait for it any more.
    #[error("{input} was given up before its first frame")]
    Stopped {
        /// File, address or device.
        input: String,
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

/// Time in which a program that was ended closes its pipes.
const CLOSING: Duration = Duration::from_secs(1);

/// Why a program did not start.
pub(crate) fn start_error(program: &Path, cause: io::Error) -> VideoError {
    let program = program.to_string_lossy().into_owned();
    if cause.kind() == ErrorKind::NotFound {
        VideoError::NotInstalled { program }
    } else {
        VideoError::Run { program, cause }
    }
}

/// One of the programs while it runs. It is ended when this is dropped.
#[derive(Debug)]
pub(crate) struct RunningProgram {
    /// With its pipes, as far as nobody has taken them.
    pub(crate) child: Child,
    messages: Messages,
    patience: Patience,
}

impl RunningProgram {
    /// Waits until it has ended by itself; `goes_on` says whether it is seen to work, so that it may take its time.
    ///
    /// # Errors
    /// As [`Patience::until`]; it has been ended then.
    pub(crate) fn wait(&mut self, mut goes_on: impl FnMut() -> bool) -> io::Result<ExitStatus> {
        loop {
            let ended = self.patience.until(|glance| {
                let status = self.child.try_wait()?;
                if status.is_none() {
                    thread::sleep(glance);
                }
                Ok(status)
            });
            match ended {
                Err(_) if goes_on() => {}
                Err(cause) => {
                    self.kill();
                    return Err(cause);
                }
                Ok(status) => return Ok(status),
            }
        }
    }

    /// The same, with its messages listened to and their end kept.
    pub(crate) fn listened_to(mut self) -> Self {
        self.messages = Messages::listen(self.child.stderr.take());
        self
    }

    /// Ends it, and whatever it started; one that has ended already is left in peace.
    pub(crate) fn kill(&mut self) {
        #[cfg(unix)]
        if let Ok(None) = self.child.try_wait() {
            use rustix::process::{Pid, Signal, kill_process_group};
            // It fails only where the child is gone, which is what is wanted.
            let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// The last line that it said, once it has ended, with the input's address as it may be shown.
    pub(crate) fn last_line(&mut self) -> Option<String> {
        let line = last_line(&self.messages.tail.take()?.recv_timeout(CLOSING).ok()?)?;
        Some(without_credentials(&line))
    }
}

impl Drop for RunningProgram {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Reads a program's messages beside its work, so that it never waits for somebody to listen.
#[derive(Debug)]
struct Messages {
    tail: Option<Receiver<Vec<u8>>>,
}

impl Messages {
    /// Starts to listen.
    fn listen(stderr: Option<ChildStderr>) -> Self {
        Self { tail: stderr.map(|stderr| read_beside(move || read_tail(stderr))) }
    }
}

/// Reads in a thread of its own, which nobody has to wait for.
fn read_beside(read: impl FnOnce() -> Vec<u8> + Send + 'static) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        // Nobody may be left who wants it.
        let _ = sender.send(read());
    });
    receiver
}

/// Everything that a program says on its standard output, up to `most_bytes`, and how it ended.
///
/// # Errors
/// As [`Patience::until`]; the program has been ended then.
pub(crate) fn answer(program: &mut RunningProgram, most_bytes: u64) -> io::Result<(ExitStatus, Vec<u8>)> {
    let stdout = program.child.stdout.take().ok_or(ErrorKind::BrokenPipe)?;
    let said = read_beside(move || {
        let mut said = Vec::new();
        // A pipe that breaks has nothing more to say.
        let _ = stdout.take(most_bytes).read_to_end(&mut said);
        said
    });
    let said = program.patience.until(|glance| match said.recv_timeout(glance) {
        Ok(said) => Ok(Some(said)),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => Err(ErrorKind::BrokenPipe.into()),
    });
    let said = said.inspect_err(|_| program.kill())?;
    Ok((program.wait(|| false)?, said))
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

//! The pipe that ffmpeg's pictures come through.
//!
//! ffmpeg writes a picture in pieces of some kilobytes. A reader that waits for every piece is woken two dozen times a
//! picture, and each time the writer has to wake it: together a fifth of the time that decoding takes. So the pipe is made
//! large enough for a picture, and the reader rests while one is being written.

use std::{
    io::{self, Read},
    process::ChildStdout,
};

use super::decode_log::{DecodeLog, FrameNotes};
use crate::waiting::Patience;

/// Reads from a child's standard output, large pieces in one go.
#[derive(Debug)]
pub(crate) struct PicturePipe {
    stdout: ChildStdout,
    patience: Patience,
    log: DecodeLog,
    /// Index of the picture that is being read.
    frame: u64,
    /// What the pipe holds at the most, bytes; none where the system does not say.
    capacity: Option<usize>,
}

#[cfg(target_os = "linux")]
mod gather {
    use std::{process::ChildStdout, thread::sleep, time::Duration};

    use rustix::event::{PollFd, PollFlags, poll};

    /// Size that the pipe is given, bytes; more than a picture of 960 x 540 pixels. The most that the system gives anybody.
    const PIPE_BYTES: usize = 1 << 20;
    /// How long the reader rests, a tenth of the time in which a picture is decoded.
    const REST: Duration = Duration::from_micros(200);

    /// Makes the pipe hold more than the usual 64 kB, and says how much it holds.
    pub(super) fn enlarge(pipe: &ChildStdout) -> Option<usize> {
        // Where the system does not allow it, the pipe stays as it is.
        let _ = rustix::pipe::fcntl_setpipe_size(pipe, PIPE_BYTES);
        rustix::pipe::fcntl_getpipe_size(pipe).ok()
    }

    /// Waits for `wanted` bytes, or until no more come for a while, or for the end.
    pub(super) fn wait_for(pipe: &ChildStdout, wanted: usize) {
        let mut before = 0;
        loop {
            let mut ends = [PollFd::new(pipe, PollFlags::IN)];
            // What is wrong with the pipe is told by reading.
            if poll(&mut ends, None).is_err() || ends[0].revents().contains(PollFlags::HUP) {
                return;
            }
            match rustix::io::ioctl_fionread(pipe) {
                Ok(there) if (there as usize) < wanted && there > before => before = there,
                _ => return,
            }
            sleep(REST);
        }
    }
}

impl PicturePipe {
    /// Reads `stdout`, waiting for its writer as long as `patience` lasts.
    pub(crate) fn new(stdout: ChildStdout, log: DecodeLog, patience: Patience) -> Self {
        #[cfg(target_os = "linux")]
        let capacity = gather::enlarge(&stdout);
        #[cfg(not(target_os = "linux"))]
        let capacity = None;
        Self { stdout, patience, log, frame: 0, capacity }
    }

    /// Ends a picture that has come whole, and says what was said of it.
    ///
    /// # Errors
    /// As [`DecodeLog::check_form`].
    pub(crate) fn end_picture(&mut self) -> io::Result<FrameNotes> {
        self.log.check_form(self.frame).map_err(io::Error::other)?;
        let notes = self.log.take_notes(self.frame);
        self.frame += 1;
        Ok(notes)
    }
}

impl Read for PicturePipe {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        #[cfg(unix)]
        self.patience.readable(&self.stdout, || self.log.check_form(self.frame).map_err(io::Error::other))?;
        #[cfg(target_os = "linux")]
        if let Some(capacity) = self.capacity {
            // A pipe's pages may be filled in part: it can be full before it holds its capacity.
            gather::wait_for(&self.stdout, buffer.len().min(capacity / 4 * 3));
        }
        self.stdout.read(buffer)
    }
}

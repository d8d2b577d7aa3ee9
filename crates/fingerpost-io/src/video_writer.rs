//! Pictures out as an H.264 video in an MP4 file, encoded by ffmpeg.

use std::{
    io::Write,
    path::{Path, PathBuf},
    process::{Child, ChildStdin, Command, Stdio},
};

use fingerpost_vision::picture::RgbImage;

use crate::ffmpeg::{FfmpegPrograms, Messages, VideoError, spawn};

/// Constant rate factor of x264: text and thin lines stay legible, a minute of 1280x720 takes some 10 MB.
const RATE_FACTOR: &str = "23";

/// A video being written; [`VideoWriter::finish`] ends it and says whether all went well.
///
/// Dropped without it (a run that fails), the video is ended as well, so that what was written plays.
#[derive(Debug)]
pub struct VideoWriter {
    path: PathBuf,
    width: usize,
    height: usize,
    child: Child,
    stdin: Option<ChildStdin>,
    messages: Messages,
}

impl VideoWriter {
    /// Starts a video of `width` x `height` pixels and `fps` frames a second, replacing a file of that name.
    ///
    /// Odd sides, which the format does not know, get one black row or column more.
    ///
    /// # Errors
    /// [`VideoError::NotInstalled`] without ffmpeg, [`VideoError::Run`] when it does not start. What ffmpeg dislikes
    /// about the path comes with the next call.
    pub fn create(
        path: &Path,
        (width, height): (usize, usize),
        fps: f64,
        programs: &FfmpegPrograms,
    ) -> Result<Self, VideoError> {
        let mut command = Command::new(&programs.ffmpeg);
        command
            .args(["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"])
            .args(["-s", &format!("{width}x{height}"), "-r", &fps.to_string(), "-i", "-"])
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset", "veryfast"])
            .args(["-crf", RATE_FACTOR, "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"])
            .arg(format!("file:{}", path.display()));
        let mut child = spawn(&mut command, Stdio::piped())?;
        let messages = Messages::listen(child.stderr.take());
        let stdin = child.stdin.take();
        Ok(Self { path: path.to_owned(), width, height, child, stdin, messages })
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// [`VideoError::Size`] when it has another size than the video, [`VideoError::Write`] with ffmpeg's message when
    /// the video cannot be written.
    pub fn write(&mut self, picture: &RgbImage) -> Result<(), VideoError> {
        let (width, height) = picture.size();
        if (width, height) != (self.width, self.height) {
            let (expected_width, expected_height) = (self.width, self.height);
            return Err(VideoError::Size { width, height, expected_width, expected_height });
        }
        let written = self.stdin.as_mut().map(|stdin| stdin.write_all(picture.as_slice()));
        match written {
            Some(Ok(())) => Ok(()),
            Some(Err(cause)) => {
                self.close();
                Err(self.write_error(&cause.to_string()))
            }
            None => Err(self.write_error("ffmpeg has ended already")),
        }
    }

    /// Ends the video and waits until the file is whole.
    ///
    /// # Errors
    /// [`VideoError::Write`] with ffmpeg's message when it could not be written.
    pub fn finish(mut self) -> Result<(), VideoError> {
        if self.close() { Ok(()) } else { Err(self.write_error("ffmpeg failed without a message")) }
    }

    /// Closes the pipe, which tells ffmpeg that the video is complete; whether it ended well.
    fn close(&mut self) -> bool {
        self.stdin = None;
        self.child.wait().is_ok_and(|status| status.success())
    }

    fn write_error(&mut self, otherwise: &str) -> VideoError {
        let cause = self.messages.last_line().unwrap_or_else(|| otherwise.to_owned());
        VideoError::Write { path: self.path.clone(), cause }
    }
}

impl Drop for VideoWriter {
    fn drop(&mut self) {
        self.close();
    }
}

//! Pictures out as an H.264 video in an MP4 file, encoded by ffmpeg.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, Command, Stdio},
};

use fingerpost_vision::picture::RgbImage;

use crate::{
    ffmpeg::{FfmpegPrograms, Messages, VideoError, spawn},
    whole_file::FileInWork,
};

/// Constant rate factor of x264: text and thin lines stay legible, a minute of 1280x720 takes some 10 MB.
const RATE_FACTOR: &str = "23";

/// A video being written; [`VideoWriter::finish`] ends it and says whether all went well.
///
/// Until then it has a temporary name. Dropped without it (a run that fails), the video is ended as well, so that what was
/// written plays.
#[derive(Debug)]
pub struct VideoWriter {
    path: PathBuf,
    /// None when it has its name, or never will.
    in_work: Option<FileInWork>,
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
    /// [`VideoError::NotInstalled`] without ffmpeg, [`VideoError::Run`] when it does not start, [`VideoError::File`] when
    /// the file cannot be made.
    pub fn create(
        path: &Path,
        (width, height): (usize, usize),
        fps: f64,
        programs: &FfmpegPrograms,
    ) -> Result<Self, VideoError> {
        let in_work = FileInWork::begin(path)?;
        let mut command = Command::new(&programs.ffmpeg);
        command
            .args(["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"])
            .args(["-s", &format!("{width}x{height}"), "-r", &fps.to_string(), "-i", "-"])
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset", "veryfast"])
            .args(["-crf", RATE_FACTOR, "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"])
            .arg(format!("file:{}", in_work.temporary_path().display()));
        let mut child = spawn(&mut command, Stdio::piped())?;
        let messages = Messages::listen(child.stderr.take());
        let stdin = child.stdin.take();
        Ok(Self { path: path.to_owned(), in_work: Some(in_work), width, height, child, stdin, messages })
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
                // What the write said comes first.
                let _ = self.close();
                Err(self.write_error(&cause.to_string()))
            }
            None => Err(self.write_error("ffmpeg has ended already")),
        }
    }

    /// Ends the video, waits until the file is whole and gives it its name.
    ///
    /// # Errors
    /// [`VideoError::Write`] with ffmpeg's message when it could not be written.
    pub fn finish(mut self) -> Result<(), VideoError> {
        self.close().map_err(|cause| self.write_error(&cause.to_string()))
    }

    /// Closes the pipe, which tells ffmpeg that the video is complete, and keeps what it wrote if it ended well.
    fn close(&mut self) -> io::Result<()> {
        self.stdin = None;
        let status = self.child.wait()?;
        match self.in_work.take() {
            Some(in_work) if status.success() => in_work.finish(),
            _ if status.success() => Ok(()),
            _ => Err(io::Error::other("ffmpeg failed without a message")),
        }
    }

    fn write_error(&mut self, otherwise: &str) -> VideoError {
        let cause = self.messages.last_line().unwrap_or_else(|| otherwise.to_owned());
        VideoError::Write { path: self.path.clone(), cause }
    }
}

impl Drop for VideoWriter {
    fn drop(&mut self) {
        // Nobody is left to be told.
        let _ = self.close();
    }
}

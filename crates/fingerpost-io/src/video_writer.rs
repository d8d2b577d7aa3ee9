//! Pictures out as an H.264 video in an MP4 file, encoded by ffmpeg.

use std::{
    fs,
    io::{self, ErrorKind, Write},
    path::{Path, PathBuf},
    process::{ChildStdin, Stdio},
};

use fingerpost_vision::picture::RgbImage;

use crate::{
    ffmpeg::{FfmpegPrograms, RunningProgram, VideoError},
    waiting::Patience,
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
    ffmpeg: RunningProgram,
    stdin: Option<ChildStdin>,
    patience: Patience,
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
        let (size, rate) = (format!("{width}x{height}"), fps.to_string());
        let file = format!("file:{}", in_work.temporary_path().display());
        let input =
            ["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", &size, "-r", &rate, "-i", "-"];
        let even = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"];
        let coding = ["-c:v", "libx264", "-preset", "veryfast", "-crf", RATE_FACTOR, "-pix_fmt", "yuv420p"];
        let output = ["-movflags", "+faststart", "-f", "mp4", &file];
        let arguments = input.into_iter().chain(even).chain(coding).chain(output);
        let patience = programs.patience().with_grace();
        let mut ffmpeg =
            programs.start(&programs.ffmpeg, arguments, Stdio::piped(), patience.clone())?.listened_to();
        let stdin = ffmpeg.child.stdin.take();
        #[cfg(unix)]
        if let Some(stdin) = &stdin {
            // Where it cannot be set, a program that stalls is waited for.
            let _ = rustix::io::ioctl_fionbio(stdin, true);
        }
        let path = path.to_owned();
        Ok(Self { path, in_work: Some(in_work), width, height, ffmpeg, stdin, patience })
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
        let written = self.stdin.as_mut().map(|stdin| write_all(stdin, picture.as_slice(), &self.patience));
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
        let Some(in_work) = self.in_work.take() else { return Ok(()) };
        let modified =
            || fs::metadata(in_work.temporary_path()).and_then(|metadata| metadata.modified()).ok();
        let mut before = modified();
        // A long video takes its time, in which its file goes on to change.
        let status = self.ffmpeg.wait(|| std::mem::replace(&mut before, modified()) != modified())?;
        if status.success() {
            in_work.finish()
        } else {
            Err(io::Error::other("ffmpeg failed without a message"))
        }
    }

    fn write_error(&mut self, otherwise: &str) -> VideoError {
        let cause = self.ffmpeg.last_line().unwrap_or_else(|| otherwise.to_owned());
        VideoError::Write { path: self.path.clone(), cause }
    }
}

/// Writes all of it, waiting for the reader as long as `patience` lasts.
fn write_all(to: &mut ChildStdin, mut bytes: &[u8], patience: &Patience) -> io::Result<()> {
    while !bytes.is_empty() {
        match to.write(bytes) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(written) => bytes = &bytes[written..],
            Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
            #[cfg(unix)]
            Err(cause) if cause.kind() == ErrorKind::WouldBlock => patience.writable(to)?,
            Err(cause) => return Err(cause),
        }
    }
    Ok(())
}

impl Drop for VideoWriter {
    fn drop(&mut self) {
        // Nobody is left to be told.
        let _ = self.close();
    }
}

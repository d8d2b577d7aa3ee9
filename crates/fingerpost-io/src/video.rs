//! Frames of anything ffmpeg reads: video files, network streams, cameras.
//!
//! ffprobe says the frame rate and, for files, the number of frames; ffmpeg then writes every decoded frame as a PPM
//! picture into a pipe. PPM, rather than bare bytes, because each picture states its own size: what rotation marks and
//! codecs make of the size in the container's header does not matter.
//!
//! A video has broken off when ffmpeg fails, when its last picture is cut, or when it complained and delivered fewer
//! frames than the container promised; where the container promises nothing, any complaint counts.
//!
//! Limits: a frame's time is its index over the average frame rate. That is right for constant rates; recordings of
//! varying rate (some telephones) are timed as if theirs were constant.

use std::{
    io::{self, BufRead, BufReader, ErrorKind},
    path::Path,
    process::{Child, ChildStdout, Command, Stdio},
};

use fingerpost_vision::picture::RgbImage;
use serde::Deserialize;

use crate::{
    ffmpeg::{FfmpegPrograms, Messages, VideoError, last_line, spawn, start_error},
    picture_file::MAX_SIDE_PX,
};

/// Bytes read from the pipe at once: a frame of a common camera in a few calls.
const PIPE_BUFFER_BYTES: usize = 1 << 20;
/// Frame rate that is taken where a stream states none.
const FALLBACK_RATE: Rate = Rate { frames: 25, seconds: 1 };

/// A video being read.
#[derive(Debug)]
pub(crate) struct VideoReader {
    input: String,
    child: Child,
    stdout: BufReader<ChildStdout>,
    messages: Messages,
    rate: Rate,
    length: Option<u64>,
    frames: u64,
    ended: bool,
}

/// Frames in a number of seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Rate {
    frames: u32,
    seconds: u32,
}

impl Rate {
    /// From ffprobe's `30000/1001`; none where it says `0/0`.
    fn parse(text: &str) -> Option<Self> {
        let (frames, seconds) = text.split_once('/')?;
        let rate = Self { frames: frames.parse().ok()?, seconds: seconds.parse().ok()? };
        (rate.frames > 0 && rate.seconds > 0).then_some(rate)
    }

    fn fps(self) -> f64 {
        f64::from(self.frames) / f64::from(self.seconds)
    }
}

#[derive(Deserialize)]
struct Probe {
    #[serde(default)]
    streams: Vec<ProbeStream>,
}

#[derive(Deserialize)]
struct ProbeStream {
    avg_frame_rate: Option<String>,
    r_frame_rate: Option<String>,
    nb_frames: Option<String>,
}

impl VideoReader {
    /// Starts to read `input`: a file, an address such as `rtsp://...`, or a device.
    pub(crate) fn open(input: &str, programs: &FfmpegPrograms) -> Result<Self, VideoError> {
        let argument = ffmpeg_argument(input);
        let stream = probe(input, &argument, programs)?;
        let rate = [&stream.avg_frame_rate, &stream.r_frame_rate]
            .into_iter()
            .flatten()
            .find_map(|text| Rate::parse(text))
            .unwrap_or(FALLBACK_RATE);
        let length = stream.nb_frames.and_then(|text| text.parse().ok());
        let mut child = spawn(&mut decode_command(&argument, rate, programs), Stdio::null())?;
        let messages = Messages::listen(child.stderr.take());
        let Some(stdout) = child.stdout.take() else {
            let cause = io::Error::from(ErrorKind::BrokenPipe);
            return Err(start_error(&Command::new(&programs.ffmpeg), cause));
        };
        let stdout = BufReader::with_capacity(PIPE_BUFFER_BYTES, stdout);
        Ok(Self { input: input.to_owned(), child, stdout, messages, rate, length, frames: 0, ended: false })
    }

    /// Frames that the container says it holds; none for live inputs and containers that do not say.
    pub(crate) fn length(&self) -> Option<u64> {
        self.length
    }

    /// Frames a second.
    pub(crate) fn fps(&self) -> f64 {
        self.rate.fps()
    }

    /// The next frame in the memory of `buffer`; none behind the last. After an error there is nothing more.
    pub(crate) fn next_picture(&mut self, buffer: Vec<u8>) -> Option<Result<RgbImage, VideoError>> {
        if self.ended {
            return None;
        }
        match read_ppm(&mut self.stdout, buffer) {
            Ok(Some(picture)) => {
                self.frames += 1;
                Some(Ok(picture))
            }
            Ok(None) => self.end(None).map(Err),
            Err(cause) => self.end(Some(cause)).map(Err),
        }
    }

    /// What was wrong with the way the video ended.
    fn end(&mut self, broken_frame: Option<io::Error>) -> Option<VideoError> {
        self.ended = true;
        if broken_frame.is_some() {
            // It may still be writing what nobody can make sense of.
            stop(&mut self.child);
        }
        let said = self.messages.last_line();
        let failed = !self.child.wait().is_ok_and(|status| status.success());
        let short = self.length.is_none_or(|length| self.frames < length);
        let cause = match (broken_frame, said) {
            (_, Some(said)) if failed || short => said,
            (Some(cause), _) => cause.to_string(),
            (None, None) if failed => "ffmpeg failed without a message".to_owned(),
            _ => return None,
        };
        let input = self.input.clone();
        Some(if self.frames == 0 {
            VideoError::Unreadable { input, cause }
        } else {
            VideoError::BrokenOff { input, frames: self.frames, cause }
        })
    }
}

impl Drop for VideoReader {
    fn drop(&mut self) {
        stop(&mut self.child);
    }
}

/// Ends a child and takes its exit status; one that has ended already is left in peace.
fn stop(child: &mut Child) {
    // Both fail only where the child is gone, which is what is wanted.
    let _ = child.kill();
    let _ = child.wait();
}

/// A file's name with the protocol in front, so that a colon in it is no protocol; all else as it is.
fn ffmpeg_argument(input: &str) -> String {
    if Path::new(input).is_file() { format!("file:{input}") } else { input.to_owned() }
}

fn probe(input: &str, argument: &str, programs: &FfmpegPrograms) -> Result<ProbeStream, VideoError> {
    let mut command = Command::new(&programs.ffprobe);
    command
        .args(["-v", "error", "-select_streams", "v:0", "-of", "json"])
        .args(["-show_entries", "stream=avg_frame_rate,r_frame_rate,nb_frames", argument])
        .stdin(Stdio::null());
    let output = command.output().map_err(|cause| start_error(&command, cause))?;
    let unreadable =
        |cause: &str| VideoError::Unreadable { input: input.to_owned(), cause: cause.to_owned() };
    if !output.status.success() {
        let said = last_line(&output.stderr);
        return Err(unreadable(said.as_deref().unwrap_or("ffprobe failed without a message")));
    }
    let probe: Probe = serde_json::from_slice(&output.stdout)
        .map_err(|cause| unreadable(&format!("ffprobe's answer is not understood: {cause}")))?;
    probe.streams.into_iter().next().ok_or_else(|| unreadable("there are no moving pictures in it"))
}

fn decode_command(argument: &str, rate: Rate, programs: &FfmpegPrograms) -> Command {
    let Rate { frames, seconds } = rate;
    let mut command = Command::new(&programs.ffmpeg);
    command
        .args(["-v", "error", "-nostdin", "-i", argument, "-map", "0:v:0"])
        // Each decoded frame gets the time of its index, so that none is dropped or doubled to make the rate constant;
        // the option that says so directly has different names in different releases.
        .arg("-vf")
        .arg(format!("settb=AVTB,setpts=N*{seconds}/{frames}/TB"))
        .arg("-r")
        .arg(format!("{frames}/{seconds}"))
        .args(["-f", "image2pipe", "-c:v", "ppm", "-"]);
    command
}

/// Reads one binary PPM picture of 8 bits; none at the end of the stream.
fn read_ppm(from: &mut impl BufRead, mut buffer: Vec<u8>) -> io::Result<Option<RgbImage>> {
    if from.fill_buf()?.is_empty() {
        return Ok(None);
    }
    let mut magic = [0; 2];
    from.read_exact(&mut magic)?;
    let [width, height, largest] = [header_number(from)?, header_number(from)?, header_number(from)?];
    let sides = 1..=MAX_SIDE_PX;
    if &magic != b"P6" || largest != 255 || !sides.contains(&width) || !sides.contains(&height) {
        let cause = format!("ffmpeg's picture has an unexpected header: {width} x {height}, {largest}");
        return Err(io::Error::new(ErrorKind::InvalidData, cause));
    }
    buffer.clear();
    buffer.resize(width * height * RgbImage::CHANNELS, 0);
    from.read_exact(&mut buffer)?;
    RgbImage::from_vec(width, height, buffer)
        .map(Some)
        .map_err(|cause| io::Error::new(ErrorKind::InvalidData, cause.to_string()))
}

/// A decimal number of a PPM header with the one white space behind it, leading white space left out.
fn header_number(from: &mut impl BufRead) -> io::Result<usize> {
    let mut number = 0_usize;
    let mut digits = 0;
    loop {
        let mut byte = [0];
        from.read_exact(&mut byte)?;
        match byte[0] {
            digit @ b'0'..=b'9' if digits < 6 => {
                number = number * 10 + usize::from(digit - b'0');
                digits += 1;
            }
            space if space.is_ascii_whitespace() && digits == 0 => {}
            space if space.is_ascii_whitespace() => return Ok(number),
            _ => return Err(io::Error::new(ErrorKind::InvalidData, "ffmpeg's picture has no header")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pictures_of_different_sizes_follow_each_other() {
        let mut stream = &b"P6\n1 2\n255\nabcdefP6\n1 1\n255\nxyz"[..];
        let first = read_ppm(&mut stream, Vec::new()).unwrap().unwrap();
        assert_eq!((first.size(), first.as_slice()), ((1, 2), &b"abcdef"[..]));
        let second = read_ppm(&mut stream, first.into_vec()).unwrap().unwrap();
        assert_eq!((second.size(), second.as_slice()), ((1, 1), &b"xyz"[..]));
        assert!(read_ppm(&mut stream, Vec::new()).unwrap().is_none());
    }

    #[test]
    fn a_picture_that_ends_early_or_is_none_is_an_error() {
        for stream in
            [&b"P6\n1 2\n255\nabc"[..], b"P6\n1", b"P5\n1 1\n255\nx", b"P6\n0 1\n255\n", b"P6\n99999999 1\n"]
        {
            assert!(read_ppm(&mut &*stream, Vec::new()).is_err(), "{stream:?}");
        }
    }

    #[test]
    fn rates_are_fractions() {
        assert_eq!(Rate::parse("30000/1001"), Some(Rate { frames: 30_000, seconds: 1001 }));
        assert_eq!(Rate::parse("0/0"), None);
        assert_eq!(Rate::parse("25"), None);
    }
}

//! Frames of anything ffmpeg reads: video files, network streams, cameras.
//!
//! ffprobe says the frame rate, the way of coding pixels and, for files, the number of frames. ffmpeg then writes every
//! decoded frame into a pipe: pixels of the commonest way (8 bits, 4:2:0) as they are, in YUV4MPEG2, all others turned into
//! red, green and blue by ffmpeg, as PPM. Both, rather than bare bytes, because they state their size: what rotation marks
//! and codecs make of the size in the container's header does not matter.
//!
//! A video has broken off when ffmpeg fails, when its last picture is cut, when it delivered fewer frames than the container
//! counts, or when it complained and delivered fewer than fill the duration that the container states; where that states
//! nothing, any complaint counts. Where size or pixels change half-way the video ends; what comes before is read.
//!
//! Limits: a frame's time is its index over the average frame rate. That is right for constant rates; recordings of
//! varying rate (some telephones) are timed as if theirs were constant.

mod decode_log;
mod pipe;
mod ppm;
mod probe;
mod y4m;

use std::{
    io::{self, BufReader, ErrorKind},
    num::NonZeroUsize,
    path::Path,
    process::Stdio,
    time::Duration,
};

use fingerpost_vision::picture::RgbImage;

use self::{
    decode_log::{DecodeLog, FRAME_LINES, FormChange, LOG_ARGUMENTS},
    pipe::PicturePipe,
    ppm::read_ppm,
    probe::{Expected, Rate, Stream},
    y4m::Y4mReader,
};
use crate::{
    decoders::{Decode, Decoded, Decoders},
    ffmpeg::{FfmpegPrograms, RunningProgram, VideoError, start_error},
    waiting::Patience,
};

/// Bytes that are read ahead of a line: few, because what follows a line is read straight into the picture.
const LINE_BUFFER_BYTES: usize = 256;

/// A video being read.
#[derive(Debug)]
pub(crate) struct VideoReader {
    input: String,
    /// Before the pictures: whoever waits for the next one finds the pipe at its end when this is dropped.
    ffmpeg: RunningProgram,
    patience: Patience,
    rate: Rate,
    length: Option<u64>,
    expected: Expected,
    log: DecodeLog,
    frames: u64,
    ended: bool,
    pictures: Decoders<PictureStream>,
}

/// The pictures that ffmpeg writes.
#[derive(Debug)]
pub(crate) struct PictureStream {
    pipe: BufReader<PicturePipe>,
    format: Format,
}

/// A picture of a video.
#[derive(Debug)]
pub(crate) struct VideoPicture {
    /// It.
    pub(crate) picture: RgbImage,
    /// Whether ffmpeg had to make up parts of it.
    pub(crate) damaged: bool,
}

/// How ffmpeg writes them.
#[derive(Debug)]
enum Format {
    Ppm,
    Y4m(Y4mReader),
}

impl Decode for PictureStream {
    type Picture = io::Result<VideoPicture>;

    fn decode(&mut self, buffer: Vec<u8>) -> Option<Self::Picture> {
        let picture = match &mut self.format {
            Format::Ppm => read_ppm(&mut self.pipe, buffer),
            Format::Y4m(reader) => reader.read(&mut self.pipe, buffer),
        };
        let picture = picture.transpose()?;
        Some(
            picture.and_then(|picture| {
                Ok(VideoPicture { picture, damaged: self.pipe.get_mut().end_picture()? })
            }),
        )
    }
}

impl VideoReader {
    /// Starts to read `input`: a file, an address such as `rtsp://...`, or a device. With one of `threads` ffmpeg gets one
    /// too, and pictures are taken from it when they are asked for; else they are taken ahead. None: as ffmpeg likes.
    pub(crate) fn open(
        input: &str,
        programs: &FfmpegPrograms,
        threads: Option<NonZeroUsize>,
    ) -> Result<Self, VideoError> {
        let argument = ffmpeg_argument(input);
        let stream = Stream::probe(input, &argument, programs)?;
        let (rate, length, expected) = (stream.rate(), stream.length(), stream.expected_length());
        let coding = stream.yuv420_coding();
        let mut arguments = decode_arguments(&argument, rate, threads);
        let format = match coding {
            Some((pixels, coding)) => {
                arguments.extend(["-pix_fmt", pixels, "-f", "yuv4mpegpipe", "-"].map(str::to_owned));
                Format::Y4m(Y4mReader::new(coding))
            }
            None => {
                let ppm = ["-pix_fmt", "rgb24", "-f", "image2pipe", "-c:v", "ppm", "-"];
                arguments.extend(ppm.map(str::to_owned));
                Format::Ppm
            }
        };
        let arguments = arguments.iter().map(String::as_str);
        let patience = programs.patience();
        let mut ffmpeg = programs.start(&programs.ffmpeg, arguments, Stdio::null(), patience.clone())?;
        let Some((stdout, stderr)) = ffmpeg.child.stdout.take().zip(ffmpeg.child.stderr.take()) else {
            return Err(start_error(&programs.ffmpeg, ErrorKind::BrokenPipe.into()));
        };
        let log = DecodeLog::listen(stderr).map_err(|cause| start_error(&programs.ffmpeg, cause))?;
        let pipe = PicturePipe::new(stdout, log.clone(), patience.clone());
        let pipe = BufReader::with_capacity(LINE_BUFFER_BYTES, pipe);
        let stream = PictureStream { pipe, format };
        let pictures = if threads == Some(NonZeroUsize::MIN) {
            Decoders::on_demand(stream)
        } else {
            Decoders::ahead([stream])
        };
        let (input, frames, ended) = (input.to_owned(), 0, false);
        Ok(Self { input, ffmpeg, patience, rate, length, expected, log, frames, ended, pictures })
    }

    /// Frames that the container says it holds; none for live inputs and containers that do not say.
    pub(crate) fn length(&self) -> Option<u64> {
        self.length
    }

    /// Frames that there should be: those that the container counts and shows, or those that fill the duration that it states.
    pub(crate) fn expected_length(&self) -> Option<u64> {
        match self.expected {
            Expected::Counted(frames) | Expected::Estimated(frames) => Some(frames),
            Expected::Unknown => None,
        }
    }

    /// What ffmpeg complained about last.
    pub(crate) fn complaint(&self) -> Option<String> {
        self.log.complaint()
    }

    /// Frames a second.
    pub(crate) fn fps(&self) -> f64 {
        self.rate.fps()
    }

    /// The next frame; none behind the last. After an error there is nothing more.
    pub(crate) fn next_picture(&mut self) -> Option<Decoded<Result<VideoPicture, VideoError>>> {
        if self.ended {
            return None;
        }
        let Some(Decoded { picture, decoding }) = self.pictures.next() else {
            let error = self.end(None)?;
            return Some(Decoded { picture: Err(error), decoding: Duration::ZERO });
        };
        let picture = match picture {
            Ok(picture) => {
                self.frames += 1;
                Ok(picture)
            }
            Err(cause) => Err(self.end(Some(cause))?),
        };
        Some(Decoded { picture, decoding })
    }

    /// Takes a buffer back for a later picture.
    pub(crate) fn recycle(&mut self, buffer: Vec<u8>) {
        self.pictures.recycle(buffer);
    }

    /// What was wrong with the way the video ended.
    fn end(&mut self, broken_frame: Option<io::Error>) -> Option<VideoError> {
        self.ended = true;
        let (input, frames) = (self.input.clone(), self.frames);
        if broken_frame.is_some() || self.patience.is_stopped() {
            // It may still be writing what nobody can make sense of, or wants.
            self.ffmpeg.kill();
        }
        if self.patience.is_stopped() {
            return None;
        }
        if let Some(change) = broken_frame.as_ref().and_then(form_change) {
            return Some(VideoError::Changed { input, frames, change: change.to_string() });
        }
        if let Err(change) = self.log.check_form(frames) {
            return Some(VideoError::Changed { input, frames, change: change.to_string() });
        }
        let broken_frame = match broken_frame {
            Some(cause) if cause.kind() == ErrorKind::TimedOut => {
                return Some(VideoError::Stalled { input, frames, cause });
            }
            broken_frame => broken_frame,
        };
        let failed = !self.ffmpeg.wait(|| false).is_ok_and(|status| status.success());
        let short = match self.expected {
            Expected::Counted(counted) => frames < counted,
            Expected::Estimated(estimated) => frames.saturating_add(1) < estimated,
            Expected::Unknown => true,
        };
        let cause = match (broken_frame, self.log.complaint(), self.expected) {
            (_, Some(said), _) if failed || short => said,
            (Some(cause), ..) => cause.to_string(),
            (None, None, _) if failed => "ffmpeg failed without a message".to_owned(),
            (None, None, Expected::Counted(counted)) if short => format!("the container counts {counted}"),
            _ => return None,
        };
        Some(if frames == 0 {
            VideoError::Unreadable { input, cause }
        } else {
            VideoError::BrokenOff { input, frames, cause }
        })
    }
}

fn form_change(cause: &io::Error) -> Option<&FormChange> {
    cause.get_ref()?.downcast_ref()
}

/// A file's name with the protocol in front, so that a colon in it is no protocol; all else as it is.
fn ffmpeg_argument(input: &str) -> String {
    if Path::new(input).is_file() { format!("file:{input}") } else { input.to_owned() }
}

/// What makes ffmpeg decode `argument`, without the format of the pictures.
fn decode_arguments(argument: &str, rate: Rate, threads: Option<NonZeroUsize>) -> Vec<String> {
    let Rate { frames, seconds } = rate;
    let mut arguments = LOG_ARGUMENTS.into_iter().chain(["-nostdin"]).map(str::to_owned).collect::<Vec<_>>();
    if let Some(threads) = threads {
        arguments.extend(["-threads".to_owned(), threads.to_string()]);
    }
    arguments.extend(["-i", argument, "-map", "0:v:0"].map(str::to_owned));
    // Each decoded frame gets the time of its index, so that none is dropped or doubled to make the rate constant; the
    // option that says so directly has different names in different releases.
    let times = format!("settb=AVTB,setpts=N*{seconds}/{frames}/TB,{FRAME_LINES}");
    let constant_rate = ["-vf".to_owned(), times, "-r".to_owned(), format!("{frames}/{seconds}")];
    arguments.extend(constant_rate);
    arguments
}

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
//! Cameras and streams are under way whether anybody takes their pictures or not: the latest one is given, with the time at which
//! it was taken, and those that came in between are counted.
//!
//! Of a recording, a frame's time is that of its stamp (`stamps.rs`); bare streams of pictures have none, and are timed by their rate.

mod any;
mod decode_log;
#[cfg(feature = "libav")]
mod libraries;
mod live;
mod pipe;
mod ppm;
mod probe;
mod stamps;
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
    decode_log::{DecodeLog, FRAME_LINES, FormChange, FrameNotes, LOG_ARGUMENTS},
    live::LiveFrames,
    pipe::PicturePipe,
    ppm::read_ppm,
    probe::{Expected, Rate, Stream},
    y4m::Y4mReader,
};
use crate::{
    address::without_credentials,
    decoders::{Decode, Decoded, Decoders},
    ffmpeg::{FfmpegPrograms, RunningProgram, VideoError, start_error},
    latest::{Latest, Reusable},
    sampling::{Sampler, Sampling},
    waiting::Patience,
};

pub(crate) use self::any::Video;
pub(crate) use self::stamps::{StampClock, Timing};
pub use self::{any::VideoDecoder, live::Liveness, stamps::StampFaults};

/// Bytes that are read ahead of a line: few, because what follows a line is read straight into the picture.
const LINE_BUFFER_BYTES: usize = 256;

/// A video being read.
#[derive(Debug)]
pub(crate) struct VideoReader {
    /// As it may be shown.
    input: String,
    /// Before the pictures: whoever waits for the next one finds the pipe at its end when this is dropped.
    ffmpeg: RunningProgram,
    patience: Patience,
    rate: Rate,
    timing: Timing,
    length: Option<u64>,
    expected: Expected,
    log: DecodeLog,
    frames: u64,
    ended: bool,
    pictures: Pictures,
}

/// How pictures are taken from ffmpeg.
#[derive(Debug)]
enum Pictures {
    /// All, in their order: ffmpeg waits where they are not taken.
    All(Box<Decoders<PictureStream>>),
    /// The latest: of an input that does not wait.
    Latest(Latest<VideoPicture>),
}

/// Whether an input waits for who takes its pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Pace {
    /// It does.
    Waits,
    /// It does not; of its pictures these are used.
    Live(Sampling),
}

/// The pictures that ffmpeg writes.
#[derive(Debug)]
pub(crate) struct PictureStream {
    pipe: BufReader<PicturePipe>,
    format: Format,
    /// Of an input that is under way.
    live: Option<LiveFrames>,
}

/// A picture of a video.
#[derive(Debug)]
pub(crate) struct VideoPicture {
    /// It.
    pub(crate) picture: RgbImage,
    /// Its index among all that ffmpeg gives.
    pub(crate) index: u64,
    /// Whether ffmpeg had to make up parts of it.
    pub(crate) damaged: bool,
    /// When it was taken, seconds since the first one; known of live inputs.
    pub(crate) taken_s: Option<f64>,
    /// The stamp that it came with, microseconds since any moment.
    pub(crate) stamp_us: Option<i64>,
}

impl Reusable for VideoPicture {
    fn into_buffer(self) -> Vec<u8> {
        self.picture.into_vec()
    }
}

/// How ffmpeg writes them.
#[derive(Debug)]
enum Format {
    Ppm,
    Y4m(Y4mReader),
}

impl Decode for PictureStream {
    type Picture = io::Result<VideoPicture>;

    fn decode(&mut self, mut buffer: Vec<u8>) -> Option<Self::Picture> {
        loop {
            let picture = match &mut self.format {
                Format::Ppm => read_ppm(&mut self.pipe, buffer),
                Format::Y4m(reader) => reader.read(&mut self.pipe, buffer),
            };
            let (picture, notes) = match picture {
                Ok(picture) => match (picture?, self.pipe.get_mut().end_picture()) {
                    (picture, Ok(notes)) => (picture, notes),
                    (_, Err(cause)) => return Some(Err(cause)),
                },
                Err(cause) => return Some(Err(cause)),
            };
            let FrameNotes { frame: index, damaged, stamp_us } = notes;
            let taken_s = self.live.as_mut().map(|live| live.used_at_s(index, stamp_us));
            if taken_s == Some(None) {
                buffer = picture.into_vec();
                continue;
            }
            return Some(Ok(VideoPicture { picture, index, damaged, taken_s: taken_s.flatten(), stamp_us }));
        }
    }
}

impl VideoReader {
    /// Starts to read `input`: a file, an address such as `rtsp://...`, or a device. With one of `threads` ffmpeg gets one
    /// too, and pictures are taken from it when they are asked for; else they are taken ahead. None: as ffmpeg likes. Of an
    /// input that does not wait they are taken as they come, in a thread of their own.
    pub(crate) fn open(
        input: &str,
        programs: &FfmpegPrograms,
        threads: Option<NonZeroUsize>,
        pace: Pace,
    ) -> Result<Self, VideoError> {
        let argument = ffmpeg_argument(input);
        let stream = match pace {
            Pace::Waits if Path::new(input).is_file() => Stream::probe_recording(input, &argument, programs)?,
            Pace::Waits | Pace::Live(_) => Stream::probe(input, &argument, programs)?,
        };
        let (rate, timing) = (stream.rate(), stream.timing());
        let (length, expected) = match pace {
            Pace::Waits => (stream.length(), stream.expected_length()),
            Pace::Live(_) => (None, Expected::Unknown),
        };
        let coding = stream.yuv420_coding();
        let mut arguments = decode_arguments(&argument, rate, threads, pace);
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
        let pictures = match pace {
            Pace::Live(sampling) => {
                let live = Some(LiveFrames::new(Sampler::new(sampling)));
                Pictures::Latest(Latest::start(PictureStream { pipe, format, live }))
            }
            Pace::Waits => {
                let stream = PictureStream { pipe, format, live: None };
                let one = threads == Some(NonZeroUsize::MIN);
                let pictures = if one { Decoders::on_demand(stream) } else { Decoders::ahead([stream]) };
                Pictures::All(Box::new(pictures))
            }
        };
        let (input, frames, ended) = (without_credentials(input), 0, false);
        Ok(Self { input, ffmpeg, patience, rate, timing, length, expected, log, frames, ended, pictures })
    }

    /// Frames that the container says it holds; none for live inputs and containers that do not say.
    pub(crate) fn length(&self) -> Option<u64> {
        self.length
    }

    /// Frames that there should be: those that the container counts and shows, or those that fill the duration that it states.
    pub(crate) fn expected_length(&self) -> Option<u64> {
        self.expected.frames()
    }

    /// What ffmpeg complained about last.
    pub(crate) fn complaint(&self) -> Option<String> {
        self.log.complaint()
    }

    /// Frames a second.
    pub(crate) fn fps(&self) -> f64 {
        self.rate.fps()
    }

    /// What the times of its frames are from.
    pub(crate) fn timing(&self) -> Timing {
        self.timing
    }

    /// The next frame; none behind the last. After an error there is nothing more.
    pub(crate) fn next_picture(&mut self) -> Option<Decoded<Result<VideoPicture, VideoError>>> {
        if self.ended {
            return None;
        }
        let next = match &mut self.pictures {
            Pictures::All(pictures) => pictures.next(),
            Pictures::Latest(pictures) => pictures.next(),
        };
        let Some(Decoded { picture, decoding }) = next else {
            let error = self.end(None)?;
            return Some(Decoded { picture: Err(error), decoding: Duration::ZERO });
        };
        let picture = match picture {
            Ok(picture) => {
                self.frames = picture.index + 1;
                Ok(picture)
            }
            Err(cause) => Err(self.end(Some(cause))?),
        };
        Some(Decoded { picture, decoding })
    }

    /// Takes a buffer back for a later picture.
    pub(crate) fn recycle(&mut self, buffer: Vec<u8>) {
        match &mut self.pictures {
            Pictures::All(pictures) => pictures.recycle(buffer),
            Pictures::Latest(pictures) => pictures.recycle(buffer),
        }
    }

    /// Pictures that came faster than they were taken, and gave way to later ones.
    pub(crate) fn dropped(&self) -> u64 {
        match &self.pictures {
            Pictures::All(_) => 0,
            Pictures::Latest(pictures) => pictures.dropped(),
        }
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
        let short = self.expected.is_short(frames);
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
fn decode_arguments(argument: &str, rate: Rate, threads: Option<NonZeroUsize>, pace: Pace) -> Vec<String> {
    let Rate { frames, seconds } = rate;
    let mut arguments = LOG_ARGUMENTS.into_iter().chain(["-nostdin"]).map(str::to_owned).collect::<Vec<_>>();
    if let Some(threads) = threads {
        arguments.extend(["-threads".to_owned(), threads.to_string()]);
    }
    arguments.extend(["-i", argument, "-map", "0:v:0"].map(str::to_owned));
    // The lines tell the times that the frames came with, in microseconds. Each decoded frame then gets the time of its index, so
    // that none is dropped or doubled to make the rate constant; the option that says so directly has different names in different
    // releases.
    let indexed = format!("settb=AVTB,{FRAME_LINES},setpts=N*{seconds}/{frames}/TB");
    let filters = match pace {
        // Counted in ticks of the container first, times are rounded once, as those that the libraries give.
        Pace::Waits => format!("setpts=PTS-STARTPTS,{indexed}"),
        Pace::Live(_) => indexed,
    };
    let constant_rate = ["-vf".to_owned(), filters, "-r".to_owned(), format!("{frames}/{seconds}")];
    arguments.extend(constant_rate);
    arguments
}

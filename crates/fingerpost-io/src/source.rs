//! The frames of a drive, one after the other, wherever they come from.

use std::{
    collections::VecDeque,
    num::NonZeroUsize,
    path::{Path, PathBuf},
    time::Duration,
};

use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::{
    decoders::{Decoded, threads_of_machine},
    ffmpeg::{FfmpegPrograms, VideoError},
    frame_clock::{FrameClock, VideoClock},
    numbered_names::TimesDoubt,
    picture_file::PictureFileError,
    picture_folder::{PictureFolder, PictureFolderError, PictureTimes},
    picture_frames::PictureFrames,
    sampling::{Sampler, Sampling},
    video::{Liveness, Pace, StampClock, StampFaults, Timing, Video, VideoDecoder, VideoPicture},
};

/// Frame rate of a folder of pictures without times, where none is given: that of many recorded drives.
pub const DEFAULT_PICTURE_FPS: f64 = 10.0;

/// How to read an input.
#[derive(Debug, Clone, Default)]
pub struct SourceOptions {
    /// Frames a second, in place of [`DEFAULT_PICTURE_FPS`], times in the names of pictures, or a video's own times. Refused of
    /// pictures with a `times.txt`, and of an input that is under way.
    pub fps: Option<f64>,
    /// Which frames are used. Pictures of a folder that are not are never opened.
    pub sampling: Sampling,
    /// Whether the input is under way. Of one that is, the latest frame is given, with the time at which it was taken, and those
    /// that came before anybody asked are passed over ([`FrameSource::dropped`]).
    pub live: Liveness,
    /// Threads that decode, ffmpeg's with them. With one, pictures are decoded when they are asked for; with more, ahead.
    /// None: as many as the machine runs at once. Pictures do not depend on it.
    pub threads: Option<NonZeroUsize>,
    /// What decodes video.
    pub decoder: VideoDecoder,
    /// The programs that decode video.
    pub programs: FfmpegPrograms,
}

/// An input that cannot be opened.
#[derive(Debug, Error)]
pub enum SourceError {
    /// There is nothing of that name.
    #[error("there is no {input}; {}", hint(.input))]
    NotFound {
        /// The input as it was given.
        input: String,
    },
    /// The frame rate, or that of the frames to use, cannot be right.
    #[error("a frame rate of {fps} a second cannot be right; give 0.01 to 1000")]
    FrameRate {
        /// The rate given, 1/s.
        fps: f64,
    },
    /// A rate is given of an input that is under way.
    #[error(
        "{input} is under way: each of its frames is timed as it is taken, and a rate says nothing of them; leave the rate (--fps) out, or \
         choose the frames to use (--rate)"
    )]
    RateOfLive {
        /// The input as it was given.
        input: String,
    },
    /// A rate is given of pictures that have a file of times.
    #[error(
        "{} says when each of its pictures was taken, and a rate says nothing of them; leave the rate (--fps) out, or remove the file \
         where its times are wrong", .path.display()
    )]
    RateOfTimed {
        /// The file of times.
        path: PathBuf,
    },
    /// A folder that is no recorded drive.
    #[error(transparent)]
    Folder(#[from] PictureFolderError),
    /// A video that cannot be read.
    #[error(transparent)]
    Video(#[from] VideoError),
}

/// A frame that cannot be used.
#[derive(Debug, Error)]
pub enum FrameError {
    /// Its picture file is unreadable or damaged; the next frame may be good.
    #[error(transparent)]
    Picture(#[from] PictureFileError),
    /// The video breaks off here; there is no next frame.
    #[error(transparent)]
    Video(#[from] VideoError),
}

/// One frame of a drive.
#[derive(Debug)]
pub struct Frame {
    /// Index in the input, from zero; broken frames and frames that are not used count.
    pub index: u64,
    /// Seconds since the first frame.
    pub t_s: f64,
    /// Wall time that decoding took in its own thread, waiting for ffmpeg with it.
    pub decoding: Duration,
    /// Whether the picture is damaged and the decoder made up parts of it; of pictures in files it is not known.
    pub damaged: bool,
    /// The picture, or why there is none.
    pub picture: Result<RgbImage, FrameError>,
}

/// The frames of a drive in their order, as an iterator.
///
/// A broken picture is an item that says so, and the source goes on behind it. Hand pictures back with
/// [`FrameSource::recycle`] to have their memory used again.
#[derive(Debug)]
pub struct FrameSource {
    input: Input,
    fps: f64,
    clock: FrameClock,
    times_doubt: Option<TimesDoubt>,
    sampling: Sampling,
    /// Whether the input is under way.
    is_live: bool,
    /// Frames that were looked at before anybody took them.
    ahead: VecDeque<Frame>,
}

/// What decodes the frames of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameDecoder {
    /// Picture files, each by itself, in this process.
    Pictures,
    /// FFmpeg's libraries, in this process.
    Libraries,
    /// The program ffmpeg.
    Program,
}

#[derive(Debug)]
enum Input {
    Pictures(PictureFrames),
    Video { video: Video, upcoming: Upcoming, next_index: u64, sampler: Sampler, clock: VideoClock },
}

/// Pictures of a video that were decoded before their turn, for their stamps.
type Upcoming = VecDeque<Decoded<Result<VideoPicture, VideoError>>>;

impl FrameSource {
    /// Opens an input: a folder of pictures, a drive folder with the pictures in `frames`, or anything ffmpeg reads (a
    /// video file, an address such as `rtsp://...`, a camera such as `/dev/video0`).
    ///
    /// # Errors
    /// [`SourceError`] when there is no such input, it holds no frames, its times do not fit, or a video cannot be read.
    pub fn open(input: &str, options: &SourceOptions) -> Result<Self, SourceError> {
        let sampling = options.sampling;
        let wanted = if let Sampling::Rate { hz } = sampling { Some(hz) } else { None };
        for fps in [options.fps, wanted].into_iter().flatten() {
            if !(0.01..=1000.0).contains(&fps) {
                return Err(SourceError::FrameRate { fps });
            }
        }
        let path = Path::new(input);
        if path.is_dir() {
            let PictureFolder { paths, times } = PictureFolder::open(path)?;
            let (clock, times_s, times_doubt) = match (times, options.fps) {
                (PictureTimes::File { path, .. }, Some(_)) => return Err(SourceError::RateOfTimed { path }),
                (PictureTimes::File { times_s, .. }, None) => (FrameClock::Own, Some(times_s), None),
                (PictureTimes::Names(times_s), None) => (FrameClock::Names, Some(times_s), None),
                (PictureTimes::Names(_), Some(_)) => (FrameClock::Given, None, None),
                (PictureTimes::None(doubt), Some(_)) => (FrameClock::Given, None, doubt),
                (PictureTimes::None(doubt), None) => (FrameClock::Guessed, None, doubt),
            };
            let mean_fps = times_s.as_deref().and_then(mean_rate);
            let fps = mean_fps.or(options.fps).unwrap_or(DEFAULT_PICTURE_FPS);
            let times_s =
                times_s.unwrap_or_else(|| (0..paths.len()).map(|index| index as f64 / fps).collect());
            let threads = options.threads.unwrap_or_else(threads_of_machine);
            let input = Input::Pictures(PictureFrames::new(paths, times_s, sampling, threads));
            Ok(Self { input, fps, clock, times_doubt, sampling, is_live: false, ahead: VecDeque::new() })
        } else if path.exists() || input.contains("://") {
            let pace = if options.live.holds(input) { Pace::Live(sampling) } else { Pace::Waits };
            let is_live = pace != Pace::Waits;
            if is_live && options.fps.is_some() {
                return Err(SourceError::RateOfLive { input: input.to_owned() });
            }
            let video = Video::open(input, &options.programs, options.threads, pace, options.decoder)?;
            let fps = options.fps.unwrap_or_else(|| video.fps());
            // What comes of a live input has been chosen already.
            let sampler = Sampler::new(if pace == Pace::Waits { sampling } else { Sampling::All });
            let (clock, video_clock) = match (video.timing(), options.fps) {
                (timing, None) if !is_live => match timing {
                    Timing::Stamps { tick_s } => {
                        (FrameClock::Own, VideoClock::Stamps(StampClock::new(fps, tick_s)))
                    }
                    Timing::StatedRate => (FrameClock::Stated, VideoClock::Rate(fps)),
                    Timing::GuessedRate => (FrameClock::Guessed, VideoClock::Rate(fps)),
                },
                (_, Some(_)) => (FrameClock::Given, VideoClock::Rate(fps)),
                (_, None) => (FrameClock::Own, VideoClock::Rate(fps)),
            };
            let upcoming = Upcoming::new();
            let input = Input::Video { video, upcoming, next_index: 0, sampler, clock: video_clock };
            Ok(Self { input, fps, clock, times_doubt: None, sampling, is_live, ahead: VecDeque::new() })
        } else {
            Err(SourceError::NotFound { input: input.to_owned() })
        }
    }

    /// Width and height of the first picture that can be read, pixels, before any frame is taken. None where none can, and of
    /// inputs that are under way, whose first picture would be old by the time it is used.
    pub fn picture_size(&mut self) -> Option<(usize, usize)> {
        let size_of = |frame: &Frame| frame.picture.as_ref().ok().map(RgbImage::size);
        if let Some(size) = self.ahead.iter().find_map(size_of) {
            return Some(size);
        }
        while !self.is_live {
            let frame = self.next_of_input()?;
            let (size, ends) = (size_of(&frame), matches!(frame.picture, Err(FrameError::Video(_))));
            self.ahead.push_back(frame);
            if size.is_some() || ends {
                return size;
            }
        }
        None
    }

    /// Whether the input is under way, so that nobody sees the same frames again.
    pub const fn is_live(&self) -> bool {
        self.is_live
    }

    /// Number of frames that are used; none for live inputs and videos that do not say. A video may turn out to hold fewer.
    pub fn length(&self) -> Option<u64> {
        match &self.input {
            Input::Pictures(frames) => Some(frames.used()),
            Input::Video { video, .. } => Some(self.sampling.count(video.length()?, self.fps)),
        }
    }

    /// Number of frames that there should be to use: like [`FrameSource::length`], or as many as fill the duration that a video
    /// states where they are fewer or nothing else is known.
    pub fn expected_length(&self) -> Option<u64> {
        match &self.input {
            Input::Pictures(frames) => Some(frames.used()),
            Input::Video { video, .. } => Some(self.sampling.count(video.expected_length()?, self.fps)),
        }
    }

    /// What decodes the frames. Where the libraries give a video up, the program goes on with it.
    pub fn decoder(&self) -> FrameDecoder {
        match &self.input {
            Input::Pictures(_) => FrameDecoder::Pictures,
            Input::Video { video, .. } => video.decoder(),
        }
    }

    /// What the video's decoder complained about last, if it did; frames may be whole all the same.
    pub fn complaint(&self) -> Option<String> {
        match &self.input {
            Input::Pictures(_) => None,
            Input::Video { video, .. } => video.complaint(),
        }
    }

    /// Frames of a live input that came faster than they were taken, so far. They count in the index.
    pub fn dropped(&self) -> u64 {
        match &self.input {
            Input::Pictures(_) => 0,
            Input::Video { video, .. } => video.dropped(),
        }
    }

    /// Frames a second that are used; the mean where every frame has its own time.
    pub fn fps(&self) -> f64 {
        self.sampling.rate(self.fps)
    }

    /// Frames a second that come, used or not; the mean where every frame has its own time.
    pub fn unsampled_fps(&self) -> f64 {
        self.fps
    }

    /// What the times of frames are from.
    pub fn clock(&self) -> FrameClock {
        self.clock
    }

    /// Why pictures of which most are named by times have none, and an order that may be wrong.
    pub fn times_doubt(&self) -> Option<&TimesDoubt> {
        self.times_doubt.as_ref()
    }

    /// What was wrong so far with the stamps that times are from.
    pub fn stamp_faults(&self) -> StampFaults {
        match &self.input {
            Input::Video { clock: VideoClock::Stamps(clock), .. } => clock.faults(),
            Input::Video { .. } | Input::Pictures(_) => StampFaults::default(),
        }
    }

    /// Times of a folder's pictures, seconds since the first; none of a video, whose frames say theirs as they come.
    pub fn picture_times_s(&self) -> Option<&[f64]> {
        match &self.input {
            Input::Pictures(frames) => Some(frames.times_s()),
            Input::Video { .. } => None,
        }
    }

    /// Takes back a picture that is no longer needed; its memory serves a later frame.
    pub fn recycle(&mut self, picture: RgbImage) {
        match &mut self.input {
            Input::Pictures(frames) => frames.recycle(picture.into_vec()),
            Input::Video { video, .. } => video.recycle(picture.into_vec()),
        }
    }
}

impl Iterator for FrameSource {
    type Item = Frame;

    fn next(&mut self) -> Option<Frame> {
        self.ahead.pop_front().or_else(|| self.next_of_input())
    }
}

impl FrameSource {
    /// The next frame that was not looked at yet.
    fn next_of_input(&mut self) -> Option<Frame> {
        match &mut self.input {
            Input::Pictures(frames) => {
                let (index, t_s, Decoded { picture, decoding }) = frames.next()?;
                Some(Frame {
                    index,
                    t_s,
                    decoding,
                    damaged: false,
                    picture: picture.map_err(FrameError::from),
                })
            }
            Input::Video { video, upcoming, next_index, sampler, clock } => {
                let mut all_decoding = Duration::ZERO;
                loop {
                    let Decoded { picture, decoding } =
                        upcoming.pop_front().or_else(|| video.next_picture())?;
                    all_decoding += decoding;
                    let index = picture.as_ref().map_or(*next_index, |picture| picture.index);
                    let shown = picture.as_ref().ok();
                    let behind_us = shown
                        .filter(|picture| clock.asks_for_those_behind(picture))
                        .and_then(|_| stamps_behind_us(video, upcoming));
                    let t_s = clock.time_s(index, shown, behind_us);
                    *next_index = index + 1;
                    match picture {
                        Ok(VideoPicture { picture, .. }) if !sampler.wants(index, t_s) => {
                            video.recycle(picture.into_vec());
                        }
                        picture => {
                            let damaged = picture.as_ref().is_ok_and(|picture| picture.damaged);
                            let picture = picture.map(|picture| picture.picture).map_err(FrameError::from);
                            return Some(Frame { index, t_s, decoding: all_decoding, damaged, picture });
                        }
                    }
                }
            }
        }
    }
}

/// Stamps of the next two pictures, microseconds; none where the video ends before, or one has none.
fn stamps_behind_us(video: &mut Video, upcoming: &mut Upcoming) -> Option<[i64; 2]> {
    while upcoming.len() < 2 {
        upcoming.push_back(video.next_picture()?);
    }
    let stamp_us = |place: usize| upcoming.get(place)?.picture.as_ref().ok()?.stamp_us;
    Some([stamp_us(0)?, stamp_us(1)?])
}

/// What was meant, as far as the name of an input that is not there shows it.
fn hint(input: &str) -> String {
    if !input.is_empty() && input.bytes().all(|byte| byte.is_ascii_digit()) {
        return format!("a camera is given by its device: /dev/video{input}");
    }
    if input.starts_with("/dev/") {
        return "see with `ls /dev/video*` which cameras there are, and that this one is plugged in"
            .to_owned();
    }
    if input.contains(['*', '?', '[', '%']) {
        return "an input is one name, and patterns of names are not filled in: give the folder that holds the pictures".to_owned();
    }
    "give a folder of pictures, a video file, an address (rtsp://...) or a camera (/dev/video0)".to_owned()
}

/// Mean rate of a list of times that begins at zero; none where no time passes.
fn mean_rate(times_s: &[f64]) -> Option<f64> {
    let duration_s = times_s.last().copied().filter(|last_s| *last_s > 0.0)?;
    Some((times_s.len() - 1) as f64 / duration_s)
}

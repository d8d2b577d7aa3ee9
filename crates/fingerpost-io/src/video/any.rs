//! A video, whoever decodes it.

use std::num::NonZeroUsize;
#[cfg(feature = "libav")]
use std::{path::Path, time::Duration};

#[cfg(feature = "libav")]
use super::libraries::{LibraryVideo, Next};
use super::{Pace, Timing, VideoPicture, VideoReader};
use crate::{
    decoders::Decoded,
    ffmpeg::{FfmpegPrograms, VideoError},
    source::FrameDecoder,
};

/// What decodes videos. Pictures and their times do not depend on it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum VideoDecoder {
    /// FFmpeg's libraries in this process, where the crate is built with its feature `libav` and they read the video: whole
    /// files of 8 bits, 4:2:0, that stand upright. Else the program.
    #[default]
    Libraries,
    /// The program ffmpeg.
    Program,
}

/// A video being read.
#[derive(Debug)]
pub(crate) enum Video {
    /// By the program.
    Program(Box<VideoReader>),
    /// By the libraries, for as long as nothing is wrong.
    #[cfg(feature = "libav")]
    Libraries {
        /// What they read.
        video: Box<LibraryVideo>,
        /// What goes on where they give up.
        program: ProgramBehind,
        /// Whether the program could not go on either.
        ended: bool,
    },
}

/// How the program goes on with a video that the libraries have given up.
#[cfg(feature = "libav")]
#[derive(Debug)]
pub(crate) struct ProgramBehind {
    input: String,
    programs: FfmpegPrograms,
    threads: Option<NonZeroUsize>,
}

#[cfg(feature = "libav")]
impl ProgramBehind {
    /// Opens the video and passes over so many frames.
    fn go_on_behind(&self, frames: u64) -> Result<VideoReader, VideoError> {
        let Self { input, programs, threads } = self;
        let mut video = VideoReader::open(input, programs, *threads, Pace::Waits)?;
        for _ in 0..frames {
            match video.next_picture() {
                Some(Decoded { picture: Ok(picture), .. }) => video.recycle(picture.picture.into_vec()),
                Some(Decoded { picture: Err(error), .. }) => return Err(error),
                None => break,
            }
        }
        Ok(video)
    }
}

impl Video {
    /// Starts to read `input` by `decoder`; all else as of [`VideoReader::open`].
    #[cfg_attr(not(feature = "libav"), expect(unused_variables, reason = "there is one decoder then"))]
    pub(crate) fn open(
        input: &str,
        programs: &FfmpegPrograms,
        threads: Option<NonZeroUsize>,
        pace: Pace,
        decoder: VideoDecoder,
    ) -> Result<Self, VideoError> {
        #[cfg(feature = "libav")]
        if decoder == VideoDecoder::Libraries
            && pace == Pace::Waits
            && Path::new(input).is_file()
            && let Some(video) = LibraryVideo::open(input, threads)
        {
            let program = ProgramBehind { input: input.to_owned(), programs: programs.clone(), threads };
            return Ok(Self::Libraries { video: Box::new(video), program, ended: false });
        }
        Ok(Self::Program(Box::new(VideoReader::open(input, programs, threads, pace)?)))
    }

    /// What decodes it.
    pub(crate) fn decoder(&self) -> FrameDecoder {
        match self {
            Self::Program(_) => FrameDecoder::Program,
            #[cfg(feature = "libav")]
            Self::Libraries { .. } => FrameDecoder::Libraries,
        }
    }

    /// Frames that the container says it holds; none for live inputs and containers that do not say.
    pub(crate) fn length(&self) -> Option<u64> {
        match self {
            Self::Program(video) => video.length(),
            #[cfg(feature = "libav")]
            Self::Libraries { video, .. } => video.length(),
        }
    }

    /// Frames that there should be: those that the container counts and shows, or those that fill the duration that it states.
    pub(crate) fn expected_length(&self) -> Option<u64> {
        match self {
            Self::Program(video) => video.expected_length(),
            #[cfg(feature = "libav")]
            Self::Libraries { video, .. } => video.expected_length(),
        }
    }

    /// What ffmpeg complained about last.
    pub(crate) fn complaint(&self) -> Option<String> {
        match self {
            Self::Program(video) => video.complaint(),
            #[cfg(feature = "libav")]
            Self::Libraries { .. } => None,
        }
    }

    /// Frames a second.
    pub(crate) fn fps(&self) -> f64 {
        match self {
            Self::Program(video) => video.fps(),
            #[cfg(feature = "libav")]
            Self::Libraries { video, .. } => video.fps(),
        }
    }

    /// What the times of its frames are from.
    pub(crate) fn timing(&self) -> Timing {
        match self {
            Self::Program(video) => video.timing(),
            #[cfg(feature = "libav")]
            Self::Libraries { video, .. } => video.timing(),
        }
    }

    /// The next frame; none behind the last. After an error there is nothing more.
    pub(crate) fn next_picture(&mut self) -> Option<Decoded<Result<VideoPicture, VideoError>>> {
        match self {
            Self::Program(video) => video.next_picture(),
            #[cfg(feature = "libav")]
            Self::Libraries { ended: true, .. } => None,
            #[cfg(feature = "libav")]
            Self::Libraries { video, program, ended } => match video.next_picture() {
                Next::Picture(Decoded { picture, decoding }) => {
                    Some(Decoded { picture: Ok(picture), decoding })
                }
                Next::End => None,
                Next::GivenUp { frames } => match program.go_on_behind(frames) {
                    Ok(video) => {
                        *self = Self::Program(Box::new(video));
                        self.next_picture()
                    }
                    Err(error) => {
                        *ended = true;
                        Some(Decoded { picture: Err(error), decoding: Duration::ZERO })
                    }
                },
            },
        }
    }

    /// Takes a buffer back for a later picture.
    pub(crate) fn recycle(&mut self, buffer: Vec<u8>) {
        match self {
            Self::Program(video) => video.recycle(buffer),
            #[cfg(feature = "libav")]
            Self::Libraries { video, .. } => video.recycle(buffer),
        }
    }

    /// Pictures that came faster than they were taken, and gave way to later ones.
    pub(crate) fn dropped(&self) -> u64 {
        match self {
            Self::Program(video) => video.dropped(),
            #[cfg(feature = "libav")]
            Self::Libraries { .. } => 0,
        }
    }
}

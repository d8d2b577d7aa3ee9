//! The frames of a drive, one after the other, wherever they come from.

use std::{
    num::NonZeroUsize,
    path::{Path, PathBuf},
    time::Duration,
};

use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::{
    decoders::{Decode, Decoded, Decoders, threads_of_machine},
    ffmpeg::{FfmpegPrograms, VideoError},
    picture_file::{PictureFileError, read_picture_into},
    picture_folder::{PictureFolder, PictureFolderError},
    video::VideoReader,
};

/// Frame rate of a folder of pictures without times, where none is given: that of many recorded drives.
pub const DEFAULT_PICTURE_FPS: f64 = 10.0;

/// How to read an input.
#[derive(Debug, Clone, Default)]
pub struct SourceOptions {
    /// Frames a second, in place of [`DEFAULT_PICTURE_FPS`] or the video's own rate; a `times.txt` goes before it.
    pub fps: Option<f64>,
    /// Threads that decode, ffmpeg's with them. With one, pictures are decoded when they are asked for; with more, ahead.
    /// None: as many as the machine runs at once. Pictures do not depend on it.
    pub threads: Option<NonZeroUsize>,
    /// The programs that decode video.
    pub programs: FfmpegPrograms,
}

/// An input that cannot be opened.
#[derive(Debug, Error)]
pub enum SourceError {
    /// There is nothing of that name.
    #[error(
        "there is no {input}; give a folder of pictures, a video file, an address (rtsp://...) or a camera (/dev/video0)"
    )]
    NotFound {
        /// The input as it was given.
        input: String,
    },
    /// The frame rate cannot be right.
    #[error("a frame rate of {fps} a second cannot be right; give 0.01 to 1000")]
    FrameRate {
        /// The rate given, 1/s.
        fps: f64,
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
    /// Index in the input, from zero; broken frames count.
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
    next_index: u64,
}

#[derive(Debug)]
enum Input {
    Pictures { pictures: Decoders<PictureFiles>, count: u64, times_s: Option<Vec<f64>> },
    Video(Box<VideoReader>),
}

/// Some of the pictures of a folder.
#[derive(Debug)]
struct PictureFiles(std::vec::IntoIter<PathBuf>);

impl Decode for PictureFiles {
    type Picture = Result<RgbImage, PictureFileError>;

    fn decode(&mut self, buffer: Vec<u8>) -> Option<Self::Picture> {
        self.0.next().map(|path| read_picture_into(&path, buffer))
    }
}

impl FrameSource {
    /// Opens an input: a folder of pictures, a drive folder with the pictures in `frames`, or anything ffmpeg reads (a
    /// video file, an address such as `rtsp://...`, a camera such as `/dev/video0`).
    ///
    /// # Errors
    /// [`SourceError`] when there is no such input, it holds no frames, its times do not fit, or a video cannot be read.
    pub fn open(input: &str, options: &SourceOptions) -> Result<Self, SourceError> {
        if let Some(fps) = options.fps.filter(|fps| !(0.01..=1000.0).contains(fps)) {
            return Err(SourceError::FrameRate { fps });
        }
        let path = Path::new(input);
        if path.is_dir() {
            let PictureFolder { paths, times_s } = PictureFolder::open(path)?;
            let fps = times_s.as_deref().and_then(mean_rate).or(options.fps).unwrap_or(DEFAULT_PICTURE_FPS);
            let count = paths.len() as u64;
            let pictures = decoders(&paths, options.threads.unwrap_or_else(threads_of_machine));
            Ok(Self { input: Input::Pictures { pictures, count, times_s }, fps, next_index: 0 })
        } else if path.exists() || input.contains("://") {
            let video = VideoReader::open(input, &options.programs, options.threads)?;
            let fps = options.fps.unwrap_or_else(|| video.fps());
            Ok(Self { input: Input::Video(Box::new(video)), fps, next_index: 0 })
        } else {
            Err(SourceError::NotFound { input: input.to_owned() })
        }
    }

    /// Number of frames; none for live inputs and videos that do not say. A video may turn out to hold fewer.
    pub fn length(&self) -> Option<u64> {
        match &self.input {
            Input::Pictures { count, .. } => Some(*count),
            Input::Video(video) => video.length(),
        }
    }

    /// Number of frames that there should be: like [`FrameSource::length`], or as many as fill the duration that a video states
    /// where they are fewer or nothing else is known.
    pub fn expected_length(&self) -> Option<u64> {
        match &self.input {
            Input::Pictures { count, .. } => Some(*count),
            Input::Video(video) => video.expected_length(),
        }
    }

    /// What the video's decoder complained about last, if it did; frames may be whole all the same.
    pub fn complaint(&self) -> Option<String> {
        match &self.input {
            Input::Pictures { .. } => None,
            Input::Video(video) => video.complaint(),
        }
    }

    /// Frames a second; the mean where every frame has its own time.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// Time of the frame with that index, seconds since the first.
    pub fn time_s(&self, index: u64) -> f64 {
        let listed = match &self.input {
            Input::Pictures { times_s: Some(times_s), .. } => {
                usize::try_from(index).ok().and_then(|index| times_s.get(index))
            }
            _ => None,
        };
        listed.copied().unwrap_or(index as f64 / self.fps)
    }

    /// Takes back a picture that is no longer needed; its memory serves a later frame.
    pub fn recycle(&mut self, picture: RgbImage) {
        match &mut self.input {
            Input::Pictures { pictures, .. } => pictures.recycle(picture.into_vec()),
            Input::Video(video) => video.recycle(picture.into_vec()),
        }
    }
}

impl Iterator for FrameSource {
    type Item = Frame;

    fn next(&mut self) -> Option<Frame> {
        let index = self.next_index;
        let t_s = self.time_s(index);
        let (decoding, damaged, picture) = match &mut self.input {
            Input::Pictures { pictures, .. } => {
                let Decoded { picture, decoding } = pictures.next()?;
                (decoding, false, picture.map_err(FrameError::from))
            }
            Input::Video(video) => {
                let Decoded { picture, decoding } = video.next_picture()?;
                let damaged = picture.as_ref().is_ok_and(|picture| picture.damaged);
                (decoding, damaged, picture.map(|picture| picture.picture).map_err(FrameError::from))
            }
        };
        self.next_index += 1;
        Some(Frame { index, t_s, decoding, damaged, picture })
    }
}

/// Decoders of pictures that may use `threads` threads.
fn decoders(paths: &[PathBuf], threads: NonZeroUsize) -> Decoders<PictureFiles> {
    let count = threads.get().min(paths.len()).max(1);
    let every_nth = |first| paths.iter().skip(first).step_by(count).cloned().collect::<Vec<_>>();
    let mut files = (0..count).map(|first| PictureFiles(every_nth(first).into_iter()));
    match files.next() {
        Some(all) if threads == NonZeroUsize::MIN => Decoders::on_demand(all),
        first => Decoders::ahead(first.into_iter().chain(files)),
    }
}

/// Mean rate of a list of times that begins at zero; none where no time passes.
fn mean_rate(times_s: &[f64]) -> Option<f64> {
    let duration_s = times_s.last().copied().filter(|last_s| *last_s > 0.0)?;
    Some((times_s.len() - 1) as f64 / duration_s)
}

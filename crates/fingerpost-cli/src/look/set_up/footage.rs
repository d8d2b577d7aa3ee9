//! The pictures of a drive that is set up: those of a folder, or some of a video.

use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result, bail};
use fingerpost::ground_view::{GroundView, GroundViewConfig};
use fingerpost_geometry::Camera;
use fingerpost_io::{
    FrameError, FrameSource, Sampling, SourceOptions, decode_picture, picture_paths, read_picture,
};
use fingerpost_look::GroundViews;
use fingerpost_server::{Cause, Picture, Pictures};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};
use fingerpost_vision::picture::RgbImage;

use crate::{inputs, output, picture_for_page};

/// JPEG quality of ground views and of a video's pictures.
const QUALITY: u8 = 90;
/// Nobody reads the bins of these views.
const BINS: HueSaturationBins = HueSaturationBins { hue: 1, saturation: 1 };
/// Pictures of a video that are kept, in memory: some 100 MB of large ones. A mount is seen in any of them.
const MOST_OF_VIDEO: u64 = 240;

/// The pictures of a drive.
pub(super) struct Footage {
    kept: KeptPictures,
    /// From the number of a picture's frame to that of the next.
    step: u64,
    /// The picture that was asked for last, and its frame: while a mount is changed it stays the same.
    last: Mutex<Option<(u64, Arc<RgbImage>)>>,
}

enum KeptPictures {
    Files(Vec<PathBuf>),
    Jpeg(Vec<Vec<u8>>),
}

impl Footage {
    /// The pictures of a folder, a drive folder or a video.
    pub(super) fn open(drive: &str) -> Result<Self> {
        let options = SourceOptions { programs: inputs::ffmpeg(), ..SourceOptions::default() };
        let source = FrameSource::open(drive, &options)?;
        if source.is_live() {
            bail!("{drive} is under way, and its frames do not come again; record it first");
        }
        let (kept, step) = if source.picture_times_s().is_some() {
            (KeptPictures::Files(picture_paths(drive.as_ref())?), 1)
        } else {
            let step = source.length().map_or(1, |frames| frames.div_ceil(MOST_OF_VIDEO).max(1));
            (KeptPictures::Jpeg(pictures_of_video(drive, options, step)?), step)
        };
        Ok(Self { kept, step, last: Mutex::new(None) })
    }

    /// How many pictures there are.
    pub(super) const fn count(&self) -> u64 {
        match &self.kept {
            KeptPictures::Files(paths) => paths.len() as u64,
            KeptPictures::Jpeg(files) => files.len() as u64,
        }
    }

    /// From the number of a picture's frame to that of the next.
    pub(super) const fn step(&self) -> u64 {
        self.step
    }

    /// Width and height of the first picture that can be read.
    pub(super) fn picture_size(&self) -> Option<(usize, usize)> {
        (0..self.count()).find_map(|index| Some(self.decoded(index * self.step).ok()?.size()))
    }

    fn of_frame<T>(&self, frame: u64, kept: &[T]) -> Result<usize, Cause> {
        let index = usize::try_from(frame / self.step)?;
        if index < kept.len() { Ok(index) } else { Err("there is no such frame".into()) }
    }

    fn decoded(&self, frame: u64) -> Result<Arc<RgbImage>, Cause> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, picture)) = last.as_ref().filter(|(of, _)| *of == frame) {
            return Ok(Arc::clone(picture));
        }
        let picture = Arc::new(match &self.kept {
            KeptPictures::Files(paths) => read_picture(&paths[self.of_frame(frame, paths)?])?,
            KeptPictures::Jpeg(files) => {
                decode_picture(&files[self.of_frame(frame, files)?], Path::new("video"))?
            }
        });
        *last = Some((frame, Arc::clone(&picture)));
        Ok(picture)
    }
}

/// Every so many-th picture of a video, as JPEG files.
fn pictures_of_video(drive: &str, options: SourceOptions, step: u64) -> Result<Vec<Vec<u8>>> {
    let sampling = NonZeroU64::new(step).map_or(Sampling::All, Sampling::Every);
    let source = FrameSource::open(drive, &SourceOptions { sampling, ..options })?;
    let bar = output::progress(source.length(), "frames");
    let mut files = Vec::new();
    for frame in source.take(MOST_OF_VIDEO as usize) {
        match frame.picture {
            Ok(picture) => files.push(jpeg_file(&picture, QUALITY, ChromaSampling::Full)?),
            // What comes before is enough to see the mount.
            Err(FrameError::Video(cause)) if !files.is_empty() => {
                output::message(&cause.to_string());
                break;
            }
            Err(cause) => return Err(cause.into()),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    files.first().with_context(|| format!("{drive} has no frames; give another video"))?;
    Ok(files)
}

/// The pictures of a drive as the page asks for them.
pub(super) struct FootagePictures(pub(super) Arc<Footage>);

impl Pictures for FootagePictures {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        let Self(footage) = self;
        match &footage.kept {
            KeptPictures::Files(paths) => picture_for_page::of_file(&paths[footage.of_frame(frame, paths)?]),
            KeptPictures::Jpeg(files) => {
                let bytes = files[footage.of_frame(frame, files)?].clone();
                Ok(Picture { content_type: "image/jpeg", bytes })
            }
        }
    }
}

/// The same from above.
pub(super) struct FootageViews {
    pub(super) footage: Arc<Footage>,
    pub(super) view: GroundViewConfig,
}

impl GroundViews for FootageViews {
    fn ground_view(&self, frame: u64, camera: &Camera) -> Result<Picture, Cause> {
        let picture = self.footage.decoded(frame)?;
        let view = GroundView::new(&self.view, BINS, camera)?;
        let mut shown = view.black_picture();
        view.render(&picture, &mut shown)?;
        let bytes = jpeg_file(&shown.colour, QUALITY, ChromaSampling::Full)?;
        Ok(Picture { content_type: "image/jpeg", bytes })
    }
}

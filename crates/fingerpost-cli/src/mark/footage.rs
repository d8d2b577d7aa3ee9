//! What is marked: the frames of an input, each as a picture file that a browser shows.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use fingerpost_io::{
    FrameSource, MARKED_FRAMES_FOLDER, SourceOptions, picture_paths, read_picture, without_credentials,
    write_jpeg,
};
use fingerpost_server::{Cause, Picture, Pictures};
use fingerpost_vision::{jpeg::ChromaSampling, picture::RgbImage};

use crate::{inputs, output, picture_for_page};

/// JPEG quality of a video's pictures, whose colours keep their resolution: edges stay where they are.
const PICTURE_QUALITY: u8 = 95;

/// The frames of an input.
#[derive(Debug, Clone)]
pub(super) struct Footage {
    name: String,
    picture_px: [u32; 2],
    /// The picture file of each frame; of a video without a folder for them, what they would be called.
    pictures: Vec<PathBuf>,
    times_s: Vec<f64>,
}

impl Footage {
    /// The frames of an input whose pictures are to be shown: those of a video are written below `out`.
    pub(super) fn open(input: &str, fps: Option<f64>, out: &Path) -> Result<Self> {
        Self::new(input, fps, Some(&out.join(MARKED_FRAMES_FOLDER)))
    }

    /// The frames of an input whose pictures are not wanted.
    pub(super) fn look_through(input: &str, fps: Option<f64>) -> Result<Self> {
        Self::new(input, fps, None)
    }

    fn new(input: &str, fps: Option<f64>, folder: Option<&Path>) -> Result<Self> {
        let source = inputs::frames(
            input,
            &SourceOptions { fps, programs: inputs::ffmpeg(), ..SourceOptions::default() },
        )?;
        let path = Path::new(input);
        let shown = without_credentials(input);
        let name = Path::new(&shown).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let times_s = source.picture_times_s().map(<[f64]>::to_vec);
        let Some(times_s) = times_s else { return Self::of_video(source, folder, name) };
        let pictures = picture_paths(path)?;
        let size = pictures.iter().find_map(|path| Some(size(&read_picture(path).ok()?)));
        let picture_px =
            size.with_context(|| format!("no picture of {input} can be read; give another folder"))?;
        Ok(Self { name, picture_px, pictures, times_s })
    }

    /// Decodes a video, and writes its pictures into a folder where one is given.
    fn of_video(mut source: FrameSource, folder: Option<&Path>, name: String) -> Result<Self> {
        if let Some(folder) = folder {
            fingerpost_io::create_private_folder(folder)?;
        }
        let bar = output::progress(source.length(), "frames");
        let (mut pictures, mut times_s, mut picture_px) = (Vec::new(), Vec::new(), None);
        while let Some(frame) = source.next() {
            let picture = frame.picture?;
            picture_px.get_or_insert_with(|| size(&picture));
            let path = folder.unwrap_or(Path::new("")).join(format!("{:06}.jpg", frame.index));
            if folder.is_some() {
                write_jpeg(&path, &picture, PICTURE_QUALITY, ChromaSampling::Full)?;
            }
            pictures.push(path);
            times_s.push(frame.t_s);
            source.recycle(picture);
            bar.inc(1);
        }
        bar.finish_and_clear();
        inputs::say_stamp_faults(&name, source.stamp_faults());
        let Some(picture_px) = picture_px else { bail!("{name} has no frames; give another video") };
        Ok(Self { name, picture_px, pictures, times_s })
    }

    /// Name of the input.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Width and height of the pictures.
    pub(super) const fn picture_px(&self) -> [u32; 2] {
        self.picture_px
    }

    /// Number of frames.
    pub(super) fn frames(&self) -> u64 {
        self.pictures.len() as u64
    }

    /// Time of a frame, seconds since the first.
    pub(super) fn time_s(&self, frame: u64) -> f64 {
        usize::try_from(frame).ok().and_then(|index| self.times_s.get(index)).copied().unwrap_or_default()
    }

    /// What labels call the picture of a frame: its folder and name.
    pub(super) fn label(&self, frame: u64) -> String {
        let path = usize::try_from(frame).ok().and_then(|index| self.pictures.get(index));
        let file = path.and_then(|path| path.file_name()).unwrap_or_default();
        format!("{}/{}", self.name, file.to_string_lossy())
    }
}

impl Pictures for Footage {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        let path = self.pictures.get(usize::try_from(frame)?).ok_or("there is no such frame")?;
        picture_for_page::of_file(path)
    }
}

fn size(picture: &RgbImage) -> [u32; 2] {
    [picture.width(), picture.height()].map(|side| side as u32)
}

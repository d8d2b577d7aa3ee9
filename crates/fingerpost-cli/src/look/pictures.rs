//! The pictures of the drive that a run was made of.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Result, bail};
use fingerpost::road_surface::Knowledge;
use fingerpost_io::bag::{self, Content, Schema};
use fingerpost_io::{IndexedRecording, encode_png, picture_paths};
use fingerpost_look::Overview;
use fingerpost_record::recording::{Channel, RecordedSurface};
use fingerpost_report::road_colour;
use fingerpost_server::{Cause, Picture, Pictures};
use fingerpost_vision::picture::RgbImage;

use crate::{output, picture_for_page};

/// Pictures of a folder; frames have their numbers in its order.
#[derive(Debug)]
pub(super) struct FolderPictures {
    paths: Vec<PathBuf>,
}

impl FolderPictures {
    /// Those of a folder of pictures or a drive folder.
    pub(super) fn open(folder: &Path) -> Result<Self> {
        if folder.is_file() {
            bail!(
                "{} is no folder; pictures of a video are those of the run's own recording, run.mcap: leave --input out",
                folder.display()
            );
        }
        Ok(Self { paths: picture_paths(folder)? })
    }
}

impl Pictures for FolderPictures {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        let path = usize::try_from(frame).ok().and_then(|index| self.paths.get(index));
        let count = self.paths.len();
        let no_such =
            || format!("--input holds {count} pictures and none of frame {frame}; give the run's own input");
        picture_for_page::of_file(path.ok_or_else(no_such)?)
    }
}

/// The recording of a run, whose pictures are those that the method used.
#[derive(Debug, Clone)]
pub(super) struct RunRecording {
    recording: Arc<IndexedRecording>,
    /// When each frame was, by its number.
    times: Arc<BTreeMap<u64, Duration>>,
}

impl RunRecording {
    /// Opens `run.mcap` of a run with such frames; none where the run has none, or was killed before its end, which is said.
    pub(super) fn open(run: &Path, overview: &Overview) -> Option<Self> {
        let path = run.join("run.mcap");
        if !path.exists() {
            return None;
        }
        let times = overview.frames().iter().copied().zip(overview.times_s());
        // What is no time of a recording has no picture in it.
        let times = times.filter_map(|(frame, t_s)| Some((frame, Duration::try_from_secs_f64(*t_s).ok()?)));
        match IndexedRecording::open(&path) {
            Ok(recording) => Some(Self { recording: Arc::new(recording), times: Arc::new(times.collect()) }),
            Err(cause) => {
                output::message(&format!("{cause}; its pictures are not shown"));
                None
            }
        }
    }

    /// The message of a channel in a frame.
    fn message(&self, channel: Channel, frame: u64) -> Result<Vec<u8>, Cause> {
        let no_such = || format!("run.mcap holds no {} of frame {frame}", channel.topic());
        let time = self.times.get(&frame).ok_or_else(no_such)?;
        // Numbers of messages wrap as they did when they were written.
        let message = self.recording.message(channel.topic(), frame as u32, *time)?;
        Ok(message.ok_or_else(no_such)?)
    }

    /// The probability of road in each frame, as pictures of the ground view's size; none where it was not recorded.
    pub(super) fn road_surfaces(&self) -> Option<Box<dyn Pictures>> {
        let is_recorded = self.recording.holds(Channel::RoadSurface.topic());
        is_recorded.then(|| Box::new(RecordedRoadSurfaces(self.clone())) as Box<dyn Pictures>)
    }

    /// The pictures of one of its channels.
    pub(super) fn pictures(&self, channel: Channel) -> Box<dyn Pictures> {
        Box::new(RecordedPictures { run: self.clone(), channel })
    }
}

/// Pictures of a channel of a recording.
struct RecordedPictures {
    run: RunRecording,
    channel: Channel,
}

impl Pictures for RecordedPictures {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        let message = self.run.message(self.channel, frame)?;
        match bag::decode(Schema::FoxgloveCompressedImage, &message)?.content {
            Content::Picture(bag::Picture::Jpeg(bytes)) => Ok(Picture { content_type: "image/jpeg", bytes }),
            _ => Err(format!("{} of frame {frame} is no JPEG picture", self.channel.topic()).into()),
        }
    }
}

/// The road surfaces of a recording, in the colours of the report.
struct RecordedRoadSurfaces(RunRecording);

impl Pictures for RecordedRoadSurfaces {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        let message = self.0.message(Channel::RoadSurface, frame)?;
        let RecordedSurface { probability, known } = RecordedSurface::from_message(&message)?;
        let (width, height) = probability.size();
        let cells = probability.as_slice().iter().zip(known.as_slice());
        let colours = cells.flat_map(|(probability, known)| {
            let knowledge = match known {
                0 => Knowledge::Unknown,
                1 => Knowledge::Remembered,
                _ => Knowledge::Seen,
            };
            road_colour(*probability, knowledge)
        });
        let picture = RgbImage::from_vec(width, height, colours.collect())?;
        Ok(Picture { content_type: "image/png", bytes: encode_png(&picture)? })
    }
}

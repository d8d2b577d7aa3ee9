//! The pictures of the drive that a run was made of.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Result, bail};
use fingerpost_io::bag::{self, Content, Schema};
use fingerpost_io::{IndexedRecording, picture_paths};
use fingerpost_look::Overview;
use fingerpost_record::recording::Channel;
use fingerpost_server::{Cause, Picture, Pictures};

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
        let no_such = || format!("run.mcap holds no {} of frame {frame}", self.channel.topic());
        let time = self.run.times.get(&frame).ok_or_else(no_such)?;
        // Numbers of messages wrap as they did when they were written.
        let message = self.run.recording.message(self.channel.topic(), frame as u32, *time)?;
        match bag::decode(Schema::FoxgloveCompressedImage, &message.ok_or_else(no_such)?)?.content {
            Content::Picture(bag::Picture::Jpeg(bytes)) => Ok(Picture { content_type: "image/jpeg", bytes }),
            _ => Err(no_such().into()),
        }
    }
}

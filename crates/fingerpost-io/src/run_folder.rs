//! A run's results as a folder.

use std::fs::File;
use std::path::{Path, PathBuf};

use fingerpost_format::{FrameRecord, Summary, ToJson};
use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::{
    file::FileError,
    folder_kind::{FRAMES_FILE, FolderKind, PICTURES_FOLDER, RECORDING_FILE},
    json_lines::{AppendError, JsonLinesFile},
    output_folder::{OutputFolder, OutputFolderError},
    picture_file::{PictureFileError, write_png},
    private::{create_private_folder, private_file},
    whole_file::write_private_file,
};

/// A result that cannot be written.
#[derive(Debug, Error)]
pub enum RunFolderError {
    /// The folder cannot be taken for results.
    #[error(transparent)]
    Folder(#[from] OutputFolderError),
    /// One of its files cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A frame cannot be added; those before are whole.
    #[error(transparent)]
    Append(#[from] AppendError),
    /// A picture cannot be written.
    #[error(transparent)]
    Picture(#[from] PictureFileError),
    /// The summary has no JSON form.
    #[error(
        "the summary cannot be written as JSON ({cause}); this is a fault of the program, please report it"
    )]
    Summary {
        /// What the writer says.
        cause: serde_json::Error,
    },
}

/// The folder of a run being written: `config.toml`, `frames.jsonl`, `summary.json`, `report.html`, `pictures/`,
/// `run.mcap`, and the path of `annotated.mp4`.
#[derive(Debug)]
pub struct RunFolder {
    frames: JsonLinesFile,
    /// Nobody else writes it meanwhile.
    folder: OutputFolder,
}

impl RunFolder {
    /// Makes the folder, or takes one of an earlier run, whose results are removed; see [`OutputFolder::take`].
    ///
    /// # Errors
    /// [`RunFolderError`] when the folder cannot be made, holds something else or is in use.
    pub fn create(path: &Path) -> Result<Self, RunFolderError> {
        Self::of_kind(path, FolderKind::Run)
    }

    /// The same for a run of a campaign.
    ///
    /// # Errors
    /// As [`RunFolder::create`].
    pub fn create_in_campaign(path: &Path) -> Result<Self, RunFolderError> {
        Self::of_kind(path, FolderKind::CampaignRun)
    }

    fn of_kind(path: &Path, kind: FolderKind) -> Result<Self, RunFolderError> {
        let folder = OutputFolder::take(path, kind)?;
        let frames = JsonLinesFile::create(&path.join(FRAMES_FILE))?;
        Ok(Self { frames, folder })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Writes the effective configuration, `config.toml`.
    ///
    /// # Errors
    /// [`RunFolderError::File`] when it cannot be written.
    pub fn write_config(&self, text: &str) -> Result<(), RunFolderError> {
        Ok(write_private_file(&self.path().join("config.toml"), text)?)
    }

    /// Adds a frame to `frames.jsonl`.
    ///
    /// # Errors
    /// [`RunFolderError::Append`] when it cannot be written; the frames before stay valid lines.
    pub fn append(&mut self, frame: &FrameRecord) -> Result<(), RunFolderError> {
        Ok(self.frames.append(frame)?)
    }

    /// Writes `summary.json`.
    ///
    /// # Errors
    /// [`RunFolderError`] when it cannot be written.
    pub fn write_summary(&self, summary: &Summary) -> Result<(), RunFolderError> {
        let mut text = summary.to_json().map_err(|cause| RunFolderError::Summary { cause })?;
        text.push('\n');
        Ok(write_private_file(&self.path().join("summary.json"), text)?)
    }

    /// Writes `report.html` and gives its path.
    ///
    /// # Errors
    /// [`RunFolderError::File`] when it cannot be written.
    pub fn write_report(&self, html: &str) -> Result<PathBuf, RunFolderError> {
        let path = self.path().join("report.html");
        write_private_file(&path, html)?;
        Ok(path)
    }

    /// Writes the picture of a frame, `pictures/frame_NNNNNN.png`, and gives its path.
    ///
    /// # Errors
    /// [`RunFolderError`] when it cannot be written.
    pub fn write_picture(&self, frame: u64, picture: &RgbImage) -> Result<PathBuf, RunFolderError> {
        let folder = self.path().join(PICTURES_FOLDER);
        create_private_folder(&folder)?;
        let path = folder.join(format!("frame_{frame:06}.png"));
        write_png(&path, picture)?;
        Ok(path)
    }

    /// Ends the run: its frames are on the disk.
    ///
    /// # Errors
    /// [`RunFolderError::File`] when they cannot be brought there.
    pub fn finish(self) -> Result<(), RunFolderError> {
        Ok(self.frames.finish()?)
    }

    /// Where the records are: every one that was added is there to be read.
    pub fn frames_path(&self) -> PathBuf {
        self.path().join(FRAMES_FILE)
    }

    /// The empty recording, `run.mcap`; its writer is to hand over whole chunks.
    ///
    /// # Errors
    /// [`RunFolderError::File`] when it cannot be made.
    pub fn create_recording(&self) -> Result<File, RunFolderError> {
        let path = self.recording_path();
        Ok(private_file(&path).map_err(FileError::writing(&path))?)
    }

    /// Where the recording belongs.
    pub fn recording_path(&self) -> PathBuf {
        self.path().join(RECORDING_FILE)
    }

    /// Where the annotated video belongs.
    pub fn video_path(&self) -> PathBuf {
        self.path().join("annotated.mp4")
    }
}

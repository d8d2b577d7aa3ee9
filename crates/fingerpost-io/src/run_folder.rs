//! A run's results as a folder.

use std::path::{Path, PathBuf};

use fingerpost_format::{FrameRecord, Summary};
use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::{
    file::{FileError, create_folder, remove_if_there, write_file},
    json_lines::{AppendError, JsonLinesFile},
    picture_file::{PictureFileError, write_png},
};

/// File of a run's frames, the first that it makes.
const FRAMES_FILE: &str = "frames.jsonl";
/// Files of a run, beside its pictures.
const RESULT_FILES: [&str; 6] =
    ["config.toml", FRAMES_FILE, "summary.json", "report.html", "annotated.mp4", "run.mcap"];
/// Folder of a run's pictures.
const PICTURES_FOLDER: &str = "pictures";

/// A result that cannot be written.
#[derive(Debug, Error)]
pub enum RunFolderError {
    /// The folder or one of its files cannot be written.
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

/// The folder of a run being written: `config.toml`, `frames.jsonl`, `summary.json`, `report.html`, `pictures/`, and
/// the path of `annotated.mp4`.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    frames: JsonLinesFile,
}

impl RunFolder {
    /// Makes the folder, or takes one that exists: results of an earlier run are removed, all other files stay. Pictures
    /// are taken for an earlier run's only beside its `frames.jsonl`.
    ///
    /// # Errors
    /// [`RunFolderError::File`] when the folder cannot be made or an earlier result cannot be removed.
    pub fn create(path: &Path) -> Result<Self, RunFolderError> {
        create_folder(path)?;
        let frames_path = path.join(FRAMES_FILE);
        if frames_path.exists() {
            remove_pictures(&path.join(PICTURES_FOLDER))?;
        }
        for name in RESULT_FILES {
            remove_if_there(&path.join(name))?;
        }
        let frames = JsonLinesFile::create(&frames_path)?;
        Ok(Self { path: path.to_owned(), frames })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the effective configuration, `config.toml`.
    ///
    /// # Errors
    /// [`RunFolderError::File`] when it cannot be written.
    pub fn write_config(&self, text: &str) -> Result<(), RunFolderError> {
        Ok(write_file(&self.path.join("config.toml"), text)?)
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
        let mut text =
            serde_json::to_string_pretty(summary).map_err(|cause| RunFolderError::Summary { cause })?;
        text.push('\n');
        Ok(write_file(&self.path.join("summary.json"), text)?)
    }

    /// Writes `report.html` and gives its path.
    ///
    /// # Errors
    /// [`RunFolderError::File`] when it cannot be written.
    pub fn write_report(&self, html: &str) -> Result<PathBuf, RunFolderError> {
        let path = self.path.join("report.html");
        write_file(&path, html)?;
        Ok(path)
    }

    /// Writes `pictures/NAME.png` and gives its path.
    ///
    /// # Errors
    /// [`RunFolderError`] when it cannot be written.
    pub fn write_picture(&self, name: &str, picture: &RgbImage) -> Result<PathBuf, RunFolderError> {
        let folder = self.path.join(PICTURES_FOLDER);
        create_folder(&folder)?;
        let path = folder.join(format!("{name}.png"));
        write_png(&path, picture)?;
        Ok(path)
    }

    /// Where the annotated video belongs.
    pub fn video_path(&self) -> PathBuf {
        self.path.join("annotated.mp4")
    }
}

/// Removes the PNG files that an earlier run wrote, and the folder where nothing else is in it.
fn remove_pictures(folder: &Path) -> Result<(), FileError> {
    if !folder.is_dir() {
        return Ok(());
    }
    let reading = || FileError::reading(folder);
    let mut others = false;
    for entry in std::fs::read_dir(folder).map_err(reading())? {
        let path = entry.map_err(reading())?.path();
        if path.extension().is_some_and(|ending| ending == "png") {
            remove_if_there(&path)?;
        } else {
            others = true;
        }
    }
    if others { Ok(()) } else { std::fs::remove_dir(folder).map_err(FileError::writing(folder)) }
}

//! Closed-loop drives as a folder that can be gone on with.

use std::path::{Path, PathBuf};

use fingerpost_format::{ClosedLoop, LinesError, LoopDrive, ToJson, from_json_lines};
use thiserror::Error;

use crate::{
    file::FileError,
    folder_kind::{CLOSED_LOOP_FILE, CLOSED_LOOP_LINES_FILE, FolderKind},
    json_lines::{AppendError, JsonLinesFile},
    output_folder::{OutputFolder, OutputFolderError},
    setup_file::keep_setup,
    whole_file::write_private_file,
};

/// A folder of closed-loop drives that cannot be used.
#[derive(Debug, Error)]
pub enum ClosedLoopFolderError {
    /// The folder cannot be taken for results.
    #[error(transparent)]
    Folder(#[from] OutputFolderError),
    /// One of its files cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A drive cannot be added; those before are whole.
    #[error(transparent)]
    Append(#[from] AppendError),
    /// One of its drives is none.
    #[error("{}: {cause}, or choose another folder", .path.display())]
    Drives {
        /// The file.
        path: PathBuf,
        /// Which line, and what is wrong with it.
        cause: LinesError,
    },
    /// It holds drives of another campaign.
    #[error(
        "{} holds drives of another campaign: its {differs} differs; give the arguments of that campaign to go on with it, or \
         choose another folder",
        .path.display()
    )]
    OtherCampaign {
        /// The folder.
        path: PathBuf,
        /// What is not the same.
        differs: String,
    },
    /// The table has no JSON form.
    #[error(
        "the table cannot be written as JSON ({cause}); this is a fault of the program, please report it"
    )]
    Table {
        /// What the writer says.
        cause: serde_json::Error,
    },
}

/// The folder of closed-loop drives: `setup.json`, `closed_loop.jsonl`, `closed_loop.json`, `report.html`, and the folders of
/// runs.
#[derive(Debug)]
pub struct ClosedLoopFolder {
    lines: JsonLinesFile,
    /// Nobody else writes it meanwhile.
    folder: OutputFolder,
}

impl ClosedLoopFolder {
    /// Makes the folder, or goes on with one of the same campaign, whose drives it gives. `setup` is what the drives follow
    /// from, a JSON object.
    ///
    /// # Errors
    /// [`ClosedLoopFolderError`] when the folder cannot be made, holds something else or another campaign, or is in use.
    pub fn go_on_with(
        path: &Path,
        setup: &serde_json::Value,
    ) -> Result<(Self, Vec<LoopDrive>), ClosedLoopFolderError> {
        let folder = OutputFolder::go_on_with(path, FolderKind::ClosedLoop)?;
        if let Some(differs) = keep_setup(path, setup)? {
            return Err(ClosedLoopFolderError::OtherCampaign { path: path.to_owned(), differs });
        }
        let lines_path = path.join(CLOSED_LOOP_LINES_FILE);
        let (lines, done) = JsonLinesFile::go_on_with(&lines_path)?;
        let done = from_json_lines(&done)
            .map_err(|cause| ClosedLoopFolderError::Drives { path: lines_path, cause })?;
        Ok((Self { lines, folder }, done))
    }

    /// Adds a drive to `closed_loop.jsonl`.
    ///
    /// # Errors
    /// [`ClosedLoopFolderError::Append`] when it cannot be written; the drives before stay valid lines.
    pub fn append(&mut self, drive: &LoopDrive) -> Result<(), ClosedLoopFolderError> {
        Ok(self.lines.append(drive)?)
    }

    /// Writes `closed_loop.json` and `report.html`.
    ///
    /// # Errors
    /// [`ClosedLoopFolderError`] when they cannot be written.
    pub fn write_table(&self, table: &ClosedLoop, report: &str) -> Result<(), ClosedLoopFolderError> {
        let mut text = table.to_json().map_err(|cause| ClosedLoopFolderError::Table { cause })?;
        text.push('\n');
        write_private_file(&self.folder.path().join("report.html"), report)?;
        Ok(write_private_file(&self.folder.path().join(CLOSED_LOOP_FILE), text)?)
    }

    /// Ends the file of drives: they are on the disk.
    ///
    /// # Errors
    /// [`ClosedLoopFolderError::File`] when they cannot be brought there.
    pub fn finish(self) -> Result<(), ClosedLoopFolderError> {
        Ok(self.lines.finish()?)
    }
}

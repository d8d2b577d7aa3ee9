//! A search of settings as a folder that can be gone on with.

use std::path::{Path, PathBuf};

use fingerpost_format::{LinesError, TuningTrial, from_json_lines};
use thiserror::Error;

use crate::{
    file::FileError,
    folder_kind::{DRIVES_FOLDER, FRONT_FILE, FolderKind, TRIALS_FILE, remove_numbered_configs},
    json_lines::{AppendError, JsonLinesFile},
    output_folder::{OutputFolder, OutputFolderError},
    private::create_private_folder,
    setup_file::keep_setup,
    whole_file::write_private_file,
};

/// A search's folder that cannot be used.
#[derive(Debug, Error)]
pub enum TuningFolderError {
    /// The folder cannot be taken for results.
    #[error(transparent)]
    Folder(#[from] OutputFolderError),
    /// One of its files cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A trial cannot be added; those before are whole.
    #[error(transparent)]
    Append(#[from] AppendError),
    /// One of its trials is none.
    #[error("{}: {cause}, or choose another folder", .path.display())]
    Trials {
        /// The file.
        path: PathBuf,
        /// Which line, and what is wrong with it.
        cause: LinesError,
    },
    /// It holds trials of another search.
    #[error(
        "{} holds trials of another search: its {differs} differs; give the arguments of that search to go on with it, or choose \
         another folder",
        .path.display()
    )]
    OtherSearch {
        /// The folder.
        path: PathBuf,
        /// What is not the same.
        differs: String,
    },
}

/// The folder of a search: `setup.json`, `trials.jsonl`, `front.json`, `report.html`, a configuration a point of the front, and the
/// drives that were simulated for it.
#[derive(Debug)]
pub struct TuningFolder {
    trials: JsonLinesFile,
    /// Nobody else writes it meanwhile.
    folder: OutputFolder,
}

impl TuningFolder {
    /// Makes the folder, or goes on with one of the same search, whose trials it gives. `setup` is what the search is about, a
    /// JSON object: trials of another are not mixed with its own.
    ///
    /// # Errors
    /// [`TuningFolderError`] when the folder cannot be made, holds something else or another search, or is in use.
    pub fn go_on_with(
        path: &Path,
        setup: &serde_json::Value,
    ) -> Result<(Self, Vec<TuningTrial>), TuningFolderError> {
        let folder = OutputFolder::go_on_with(path, FolderKind::Tuning)?;
        if let Some(differs) = keep_setup(path, setup)? {
            return Err(TuningFolderError::OtherSearch { path: path.to_owned(), differs });
        }
        let trials_path = path.join(TRIALS_FILE);
        let (trials, lines) = JsonLinesFile::go_on_with(&trials_path)?;
        let done = from_json_lines(&lines)
            .map_err(|cause| TuningFolderError::Trials { path: trials_path, cause })?;
        Ok((Self { trials, folder }, done))
    }

    /// Adds a trial to `trials.jsonl`.
    ///
    /// # Errors
    /// [`TuningFolderError::Append`] when it cannot be written; the trials before stay valid lines.
    pub fn append(&mut self, trial: &TuningTrial) -> Result<(), TuningFolderError> {
        Ok(self.trials.append(trial)?)
    }

    /// Where a simulated drive of that name belongs.
    ///
    /// # Errors
    /// [`TuningFolderError::File`] when the folder of all drives cannot be made.
    pub fn drive(&self, name: &str) -> Result<PathBuf, TuningFolderError> {
        let drives = self.folder.path().join(DRIVES_FOLDER);
        create_private_folder(&drives)?;
        Ok(drives.join(name))
    }

    /// Writes `front.json`, `report.html` and the configurations by name, in the place of those of an earlier front; and brings the
    /// trials to the disk.
    ///
    /// # Errors
    /// [`TuningFolderError::File`] when they cannot be written.
    pub fn finish(
        self,
        front: &str,
        report: &str,
        configs: &[(String, String)],
    ) -> Result<(), TuningFolderError> {
        let path = self.folder.path();
        self.trials.finish()?;
        remove_numbered_configs(path)?;
        for (name, config) in configs {
            write_private_file(&path.join(name), config)?;
        }
        write_private_file(&path.join("report.html"), report)?;
        Ok(write_private_file(&path.join(FRONT_FILE), front)?)
    }
}

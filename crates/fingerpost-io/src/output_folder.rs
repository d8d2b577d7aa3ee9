//! Folders that the program writes: told from others by a marker file, and written by one program at a time.

use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    file::{FileError, read_text, remove_if_there},
    folder_kind::FolderKind,
    folder_lock::{FolderLock, FolderLockError, LOCK_FILE},
    private::create_private_folder,
    whole_file::{is_temporary, remove_all_abandoned, write_private_file},
};

/// Name of the marker file.
const MARKER_FILE: &str = ".fingerpost.json";
/// Version of the marker file's form.
const MARKER_VERSION: u32 = 1;

/// A folder that cannot be written.
#[derive(Debug, Error)]
pub enum OutputFolderError {
    /// There is something in it that may be the user's.
    #[error(
        "{} holds {entry} and no {MARKER_FILE} that says this program wrote it, so it may be yours; choose another folder, \
         or empty this one first (results of versions that wrote no such file are not replaced either)",
        .path.display()
    )]
    NotOurs {
        /// The folder.
        path: PathBuf,
        /// The first thing in it by name.
        entry: String,
    },
    /// It holds results of another kind.
    #[error("{} holds {found}, which {wanted} does not replace; choose another folder", .path.display())]
    OtherKind {
        /// The folder.
        path: PathBuf,
        /// What is in it.
        found: FolderKind,
        /// What was to be written.
        wanted: FolderKind,
    },
    /// Its marker file is not one that this version knows.
    #[error("{} is no marker file that this version reads ({cause}); choose another folder", .path.display())]
    Marker {
        /// The marker file.
        path: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
    /// A folder for results is a link, and what it leads to may be the user's.
    #[error("{} is a link and no folder of this program; choose another folder, or remove the link", .path.display())]
    Link {
        /// The link.
        path: PathBuf,
    },
    /// Another program writes it.
    #[error(transparent)]
    Lock(#[from] FolderLockError),
    /// The folder or something in it cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
}

/// What the marker file says.
#[derive(Debug, Serialize, Deserialize)]
struct Marker {
    version: u32,
    kind: FolderKind,
    /// Name and version of the program.
    written_by: String,
}

/// A folder that belongs to this program, and to nobody else until this is dropped.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    _lock: FolderLock,
}

impl OutputFolder {
    /// Makes a folder or takes one that is empty or holds results of the same kind, which are removed: only files that the
    /// program writes there. All else in it stays. What a killed program left half-written is removed as well.
    ///
    /// # Errors
    /// [`OutputFolderError`] when it holds anything without a marker, results of another kind, or is in use. Nothing in it
    /// has been changed then.
    pub fn take(path: &Path, kind: FolderKind) -> Result<Self, OutputFolderError> {
        let folder = Self::go_on_with(path, kind)?;
        kind.remove_results(path)?;
        Ok(folder)
    }

    /// The same, and the results that are there stay, to be gone on with.
    ///
    /// # Errors
    /// As [`OutputFolder::take`].
    pub fn go_on_with(path: &Path, kind: FolderKind) -> Result<Self, OutputFolderError> {
        // Looked at before the lock, so that nothing is written into a folder that is not ours.
        check(path, kind)?;
        create_private_folder(path)?;
        let lock = FolderLock::take(path)?;
        check(path, kind)?;
        remove_all_abandoned(path)?;
        for (name, _) in kind.picture_folders() {
            remove_all_abandoned(&path.join(name))?;
        }
        write_marker(path, kind)?;
        Ok(Self { path: path.to_owned(), _lock: lock })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// The kind of results that a folder's marker tells of; none without a marker.
pub(crate) fn marked_kind(path: &Path) -> Result<Option<FolderKind>, OutputFolderError> {
    let marker = path.join(MARKER_FILE);
    if !marker.exists() {
        return Ok(None);
    }
    let text = read_text(&marker)?;
    let refused = |cause: String| OutputFolderError::Marker { path: marker.clone(), cause };
    let read: Marker = serde_json::from_str(&text).map_err(|cause| refused(cause.to_string()))?;
    if read.version == MARKER_VERSION {
        Ok(Some(read.kind))
    } else {
        Err(refused(format!("version {}", read.version)))
    }
}

fn check(path: &Path, kind: FolderKind) -> Result<(), OutputFolderError> {
    let entries = match fs::read_dir(path) {
        Err(cause) if cause.kind() == ErrorKind::NotFound => return Ok(()),
        entries => entries.map_err(FileError::writing(path))?,
    };
    match marked_kind(path)? {
        Some(found) if found != kind => {
            return Err(OutputFolderError::OtherKind { path: path.to_owned(), found, wanted: kind });
        }
        Some(_) => {
            let folders = kind.picture_folders().iter().map(|(name, _)| path.join(name));
            return match folders.into_iter().find(|folder| folder.is_symlink()) {
                Some(path) => Err(OutputFolderError::Link { path }),
                None => Ok(()),
            };
        }
        None => {}
    }
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(FileError::reading(path))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.retain(|name| name != LOCK_FILE && !is_temporary(name));
    names.sort();
    // Marks are a person's work, and versions without markers left many of them.
    if names.iter().any(|name| name == "marks.json") && kind == FolderKind::Marks {
        names.retain(|name| !kind.writes(Path::new(name)));
    }
    match names.into_iter().next() {
        Some(entry) => Err(OutputFolderError::NotOurs { path: path.to_owned(), entry }),
        None => Ok(()),
    }
}

fn write_marker(path: &Path, kind: FolderKind) -> Result<(), OutputFolderError> {
    let written_by = format!("fingerpost {}", env!("CARGO_PKG_VERSION"));
    let marker = Marker { version: MARKER_VERSION, kind, written_by };
    let path = path.join(MARKER_FILE);
    let text = serde_json::to_string_pretty(&marker);
    let mut text =
        text.map_err(|cause| OutputFolderError::Marker { path: path.clone(), cause: cause.to_string() })?;
    text.push('\n');
    Ok(write_private_file(&path, text)?)
}

/// Removes the marker of a folder whose results are gone.
pub(crate) fn remove_marker(path: &Path) -> Result<(), FileError> {
    remove_if_there(&path.join(MARKER_FILE))
}

//! Whole files in and out, with errors that say which file, what is wrong and what to do.

use std::{
    fs,
    io::{self, ErrorKind},
    path::{Path, PathBuf},
};

use thiserror::Error;

/// A file or folder that cannot be read or written.
#[derive(Debug, Error)]
pub enum FileError {
    /// It cannot be read.
    #[error("{} cannot be read ({cause}); {}", .path.display(), advice(.cause))]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// It is not UTF-8 text.
    #[error("{} is no UTF-8 text; give the text file that was meant, or save it as UTF-8", .path.display())]
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// It cannot be written.
    #[error("{} cannot be written ({cause}); {}", .path.display(), advice(.cause))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
}

impl FileError {
    /// Turns a system error of reading `path` into a [`FileError::Read`].
    pub(crate) fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |cause| Self::Read { path: path.to_owned(), cause }
    }

    /// Turns a system error of writing `path` into a [`FileError::Write`].
    pub(crate) fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |cause| Self::Write { path: path.to_owned(), cause }
    }
}

/// What to do about a system error.
fn advice(cause: &io::Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotFound => "check the path",
        ErrorKind::PermissionDenied => "check its permissions, or choose another place",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "the disk is full: free some space or choose another place, then run again"
        }
        ErrorKind::FileTooLarge => {
            "a file may not grow further here: raise the limit (ulimit -f) or choose another place, then run again"
        }
        ErrorKind::IsADirectory => "name a file in it",
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file stands where a folder is needed: move it or choose another place"
        }
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only: choose another place",
        _ => "check the disk and the path",
    }
}

/// The text of a file; a byte-order mark at its start is left out.
///
/// # Errors
/// [`FileError::Read`] when it cannot be read, [`FileError::NotText`] when it is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let text = String::from_utf8(read_bytes(path)?);
    let text = text.map_err(|_| FileError::NotText { path: path.to_owned() })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The bytes of a file.
///
/// # Errors
/// [`FileError::Read`] when it cannot be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    fs::read(path).map_err(FileError::reading(path))
}

/// Makes a folder with everything above it; one that exists stays as it is.
///
/// # Errors
/// [`FileError::Write`] when it cannot be made.
pub fn create_folder(path: &Path) -> Result<(), FileError> {
    fs::create_dir_all(path).map_err(FileError::writing(path))
}

/// Removes a file; none there is no error.
pub(crate) fn remove_if_there(path: &Path) -> Result<(), FileError> {
    match fs::remove_file(path) {
        Err(cause) if cause.kind() != ErrorKind::NotFound => {
            Err(FileError::Write { path: path.to_owned(), cause })
        }
        _ => Ok(()),
    }
}

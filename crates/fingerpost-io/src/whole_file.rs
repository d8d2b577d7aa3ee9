//! Files that are written whole or not at all.
//!
//! The contents go into a temporary file beside the target, reach the disk, and then take the target's name. Whatever
//! ends the program, the target holds what it held before or what it was to hold.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, ErrorKind, Write},
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicU64, Ordering},
};

use tempfile::{NamedTempFile, TempPath};

use crate::{file::FileError, private::private_options};

/// How names of temporary files end.
const TEMPORARY_ENDING: &str = ".fingerpost-tmp";

/// Writes a whole file, replacing it where it exists.
///
/// Links are followed, permissions stay as they are, and a new file has those that the system gives files. A device or a pipe is written to as it is.
///
/// # Errors
/// [`FileError::Write`] when it cannot be written, or exists and is write-protected; what was there stays.
pub fn write_file(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), FileError> {
    write_whole(path, contents.as_ref(), File::options().write(true)).map_err(FileError::writing(path))
}

/// The same; a new file is its owner's alone to read.
///
/// # Errors
/// As [`write_file`].
pub fn write_private_file(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), FileError> {
    write_whole(path, contents.as_ref(), &mut private_options()).map_err(FileError::writing(path))
}

/// Writes a whole file; a new one is made with `options`.
fn write_whole(path: &Path, contents: &[u8], options: &mut OpenOptions) -> io::Result<()> {
    let target = match fs::metadata(path) {
        Ok(there) if !there.is_file() => {
            return OpenOptions::new().write(true).open(path)?.write_all(contents);
        }
        Ok(there) if there.permissions().readonly() => {
            return Err(io::Error::new(ErrorKind::PermissionDenied, "it is write-protected"));
        }
        Ok(_) => path.canonicalize()?,
        Err(_) => path.to_owned(),
    };
    let temporary = temporary_beside(&target, options)?;
    // Written as a plain file: errors are to name the target, not this file.
    temporary.as_file().write_all(contents)?;
    put_in_place(temporary, &target)
}

/// Makes an empty temporary file in the target's folder with `options`. It is locked for as long as it is open, which tells it from one
/// whose writer was killed.
fn temporary_beside(target: &Path, options: &mut OpenOptions) -> io::Result<NamedTempFile> {
    /// Makes names of files that are written at the same time differ.
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = target.file_name().ok_or(ErrorKind::IsADirectory)?.to_string_lossy();
    let prefix = temporary_prefix(&name);
    let file = loop {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = folder_of(target).join(format!("{prefix}{}-{count}{TEMPORARY_ENDING}", process::id()));
        match options.create_new(true).open(&path) {
            // Left by a killed process that had the same number.
            Err(cause) if cause.kind() == ErrorKind::AlreadyExists => {}
            file => break NamedTempFile::from_parts(file?, TempPath::try_from_path(path)?),
        }
    };
    file.as_file().lock()?;
    Ok(file)
}

/// Brings a temporary file's contents to the disk and gives it the target's name.
pub(crate) fn put_in_place(temporary: NamedTempFile, target: &Path) -> io::Result<()> {
    if let Ok(replaced) = fs::metadata(target) {
        temporary.as_file().set_permissions(replaced.permissions())?;
    }
    temporary.as_file().sync_all()?;
    temporary.persist(target).map_err(|error| error.error)?;
    sync_folder(folder_of(target))
}

/// Brings the names of a folder's files to the disk, where the system knows that.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

/// Removes what killed programs left beside a file when they were about to write it; what another program is writing just
/// now stays.
///
/// # Errors
/// [`FileError`] when the file's folder cannot be read or such a file cannot be removed. No folder is no error.
pub fn remove_abandoned(path: &Path) -> Result<(), FileError> {
    let Some(name) = path.file_name() else { return Ok(()) };
    let prefix = temporary_prefix(&name.to_string_lossy());
    remove_temporaries(folder_of(path), &prefix)
}

/// Removes the abandoned temporary files of a folder.
pub(crate) fn remove_all_abandoned(folder: &Path) -> Result<(), FileError> {
    remove_temporaries(folder, ".")
}

fn remove_temporaries(folder: &Path, prefix: &str) -> Result<(), FileError> {
    let entries = match fs::read_dir(folder) {
        Err(cause) if cause.kind() == ErrorKind::NotFound => return Ok(()),
        entries => entries.map_err(FileError::reading(folder))?,
    };
    for entry in entries {
        let entry = entry.map_err(FileError::reading(folder))?;
        let name = entry.file_name();
        if is_temporary(&name.to_string_lossy()) && name.to_string_lossy().starts_with(prefix) {
            remove_unless_locked(&entry.path()).map_err(FileError::writing(&entry.path()))?;
        }
    }
    Ok(())
}

fn remove_unless_locked(path: &Path) -> io::Result<()> {
    if !fs::symlink_metadata(path).is_ok_and(|there| there.is_file()) {
        return Ok(());
    }
    let is_abandoned = File::open(path)?.try_lock().is_ok();
    if is_abandoned { fs::remove_file(path) } else { Ok(()) }
}

/// Whether a file's name is that of a temporary file.
pub(crate) fn is_temporary(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(TEMPORARY_ENDING)
}

fn temporary_prefix(name: &str) -> String {
    format!(".{name}.")
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A file that another program writes under a temporary name, until it is whole.
#[derive(Debug)]
pub(crate) struct FileInWork {
    target: PathBuf,
    temporary: NamedTempFile,
}

impl FileInWork {
    /// Makes the temporary file, its owner's alone to read.
    pub(crate) fn begin(target: &Path) -> Result<Self, FileError> {
        let temporary =
            temporary_beside(target, &mut private_options()).map_err(FileError::writing(target))?;
        Ok(Self { target: target.to_owned(), temporary })
    }

    /// The name under which it is written.
    pub(crate) fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// Gives it its name.
    pub(crate) fn finish(self) -> io::Result<()> {
        put_in_place(self.temporary, &self.target)
    }
}

//! One writer a folder: a lock that ends with its process, however that ends, and says who holds it.

use std::{
    fs::{self, File, TryLockError},
    io::{self, Read, Write},
    path::{Path, PathBuf},
    process,
    time::SystemTime,
};

use fingerpost_format::utc_time;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{file::FileError, private::private_options};

/// Name of the file that is locked.
pub(crate) const LOCK_FILE: &str = ".fingerpost.lock";
/// Bytes that are read of what a lock's holder says of itself: a path or two more than what is written.
const MOST_HOLDER_BYTES: u64 = 4096;
/// Characters of the holder's command line that are kept: the subcommand and its first arguments.
const MOST_COMMAND_CHARS: usize = 200;

/// A folder that cannot be locked.
#[derive(Debug, Error)]
pub enum FolderLockError {
    /// Another program writes it.
    #[error("{} is in use by {holder}; wait until that has ended, or choose another folder", .path.display())]
    InUse {
        /// The folder.
        path: PathBuf,
        /// Process, command and since when, as far as they are known.
        holder: String,
    },
    /// The lock cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

/// What a lock's holder says of itself.
#[derive(Debug, Serialize, Deserialize)]
struct Holder {
    pid: u32,
    command: String,
    /// Universal time, RFC 3339.
    since: String,
}

/// A folder that no other program with such a lock writes.
#[derive(Debug)]
pub(crate) struct FolderLock {
    path: PathBuf,
    /// Locked for as long as it is open.
    _file: File,
}

impl FolderLock {
    /// Locks a folder that exists.
    ///
    /// # Errors
    /// [`FolderLockError::InUse`] when another program holds it, [`FolderLockError::File`] when the folder takes no lock.
    pub(crate) fn take(folder: &Path) -> Result<Self, FolderLockError> {
        let path = folder.join(LOCK_FILE);
        loop {
            let mut options = private_options();
            options.read(true).create(true).truncate(false);
            let mut file = options.open(&path).map_err(FileError::writing(&path))?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(FolderLockError::InUse {
                        path: folder.to_owned(),
                        holder: holder(&mut file),
                    });
                }
                Err(TryLockError::Error(cause)) => return Err(FileError::Write { path, cause }.into()),
            }
            // The one who held it before may have removed the file while this one was opening it.
            if is_still_at(&file, &path) {
                write_holder(&mut file).map_err(FileError::writing(&path))?;
                return Ok(Self { path, _file: file });
            }
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // A file that stays is unlocked, and is taken by the next.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(unix)]
fn is_still_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |of: &fs::Metadata| (of.dev(), of.ino());
    matches!((file.metadata(), fs::metadata(path)), (Ok(a), Ok(b)) if identity(&a) == identity(&b))
}

/// Elsewhere a file that is open cannot be removed.
#[cfg(not(unix))]
fn is_still_at(_: &File, _: &Path) -> bool {
    true
}

fn write_holder(file: &mut File) -> io::Result<()> {
    let words: Vec<String> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let holder = Holder {
        pid: process::id(),
        command: words.join(" ").chars().take(MOST_COMMAND_CHARS).collect(),
        since: utc_time(since_1970.as_secs_f64()),
    };
    file.set_len(0)?;
    file.write_all(serde_json::to_string(&holder)?.as_bytes())
}

/// Who holds a lock; what stands in the file may be anything.
fn holder(file: &mut File) -> String {
    let mut text = String::new();
    let read = file.take(MOST_HOLDER_BYTES).read_to_string(&mut text);
    match read.ok().and_then(|_| serde_json::from_str::<Holder>(&text).ok()) {
        Some(Holder { pid, command, since }) => {
            format!("process {pid} ({}) since {}", command.escape_debug(), since.escape_debug())
        }
        None => "another process".to_owned(),
    }
}

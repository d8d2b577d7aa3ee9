//! Whole files in and out, with errors that say which file, what is wrong and what to do.

use std::{
    fs::{self, File},
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use thiserror::Error;

use crate::waiting::Patience;

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
    /// It holds more than any file of its kind, or has no end.
    #[error("{} holds more than the {limit_mb} MB that are read of {kind}; give the file that was meant", .path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// What is read of it at the most, megabytes.
        limit_mb: u64,
        /// What kind of file it is.
        kind: &'static str,
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
        ErrorKind::TimedOut => "check what writes it, or wait longer (--timeout-s)",
        ErrorKind::IsADirectory => "name a file in it",
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file stands where a folder is needed: move it or choose another place"
        }
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only: choose another place",
        _ => "check the disk and the path",
    }
}

/// Most that is read of a file on a disk, bytes: the map of a country has a few hundred million.
const MOST_OF_A_FILE: u64 = 4_000_000_000;
/// The same of a pipe, which does not say how long it is.
const MOST_OF_A_PIPE: u64 = 1_000_000_000;
/// The same of a device: one that has an end, like /dev/null, has it soon.
const MOST_OF_A_DEVICE: u64 = 1_000_000;

/// The text of a file; a byte-order mark at its start is left out.
///
/// # Errors
/// Those of [`read_bytes`], and [`FileError::NotText`] when it is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    read_text_within(path, MOST_OF_A_FILE)
}

/// [`read_text`] of at most `most_bytes`.
///
/// # Errors
/// Those of [`read_text`].
pub fn read_text_within(path: &Path, most_bytes: u64) -> Result<String, FileError> {
    let text = String::from_utf8(read_bytes_within(path, most_bytes)?);
    let text = text.map_err(|_| FileError::NotText { path: path.to_owned() })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The bytes of a file: up to 4 GB of one on a disk, 1 GB of a pipe, and 1 MB of a device.
///
/// # Errors
/// [`FileError::Read`] when it cannot be read or, being a pipe, is waited for longer than the longest wait, in all,
/// [`FileError::TooLong`] when it holds more.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    read_bytes_within(path, MOST_OF_A_FILE)
}

/// [`read_bytes`] of at most `most_bytes`.
///
/// # Errors
/// Those of [`read_bytes`].
pub fn read_bytes_within(path: &Path, most_bytes: u64) -> Result<Vec<u8>, FileError> {
    let file = InputFile::open(path)?;
    let metadata = file.file.metadata().map_err(FileError::reading(path))?;
    let (limit, kind) = match metadata.file_type() {
        kind if kind.is_file() || kind.is_dir() => (MOST_OF_A_FILE, "a file"),
        kind if is_pipe(kind) => (MOST_OF_A_PIPE, "a pipe"),
        _ => (MOST_OF_A_DEVICE, "a device"),
    };
    let limit = limit.min(most_bytes);
    let mut bytes = Vec::new();
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(FileError::reading(path))?;
    if bytes.len() as u64 > limit {
        return Err(FileError::TooLong { path: path.to_owned(), limit_mb: limit / 1_000_000, kind });
    }
    Ok(bytes)
}

/// A file that is read, whose writer, if it is a pipe, is waited for no longer than anybody else.
#[derive(Debug)]
pub(crate) struct InputFile {
    file: File,
    /// For pipes and devices, which may have nothing to give yet.
    patience: Option<Patience>,
    waits: Waits,
}

/// Which waits for a writer may take the longest wait.
#[derive(Debug, Clone, Copy)]
enum Waits {
    /// Each: what is written comes as it is made, for as long as it is.
    Each,
    /// All together, so long until now: what is read is a whole, which a source that goes on bit by bit never gives.
    Together(Duration),
}

impl InputFile {
    /// Opens a file; a pipe that nobody writes yet, too.
    ///
    /// # Errors
    /// [`FileError::Read`] when that cannot be done.
    pub(crate) fn open(path: &Path) -> Result<Self, FileError> {
        let metadata = fs::metadata(path).map_err(FileError::reading(path))?;
        let on_disk = metadata.is_file() || metadata.is_dir();
        let mut options = File::options();
        #[cfg(unix)]
        if !on_disk {
            // Else opening a pipe waits for its writer.
            let flags = rustix::fs::OFlags::NONBLOCK.bits();
            std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, flags as i32);
        }
        let file = options.read(true).open(path).map_err(FileError::reading(path))?;
        let waits = Waits::Together(Duration::ZERO);
        Ok(Self { file, patience: (!on_disk).then(|| Patience::new(None)), waits })
    }

    /// How long it may give nothing, where it is a pipe or a device.
    pub(crate) fn longest_wait(&self) -> Option<Duration> {
        self.patience.as_ref().map(Patience::longest)
    }

    /// The program's standard input.
    ///
    /// # Errors
    /// Those of the system where there is none.
    #[cfg(unix)]
    pub(crate) fn standard_input() -> io::Result<Self> {
        let file = File::from(std::os::fd::AsFd::as_fd(&io::stdin()).try_clone_to_owned()?);
        let on_disk = file.metadata()?.is_file();
        Ok(Self { file, patience: (!on_disk).then(|| Patience::new(None)), waits: Waits::Each })
    }

    /// Reads as [`Read::read`]; while it waits, `meanwhile` is called some twenty times a second and before each piece.
    ///
    /// # Errors
    /// Those of reading and of `meanwhile`.
    #[cfg(unix)]
    pub(crate) fn read_while(
        &mut self,
        buffer: &mut [u8],
        meanwhile: &mut dyn FnMut() -> io::Result<()>,
    ) -> io::Result<usize> {
        loop {
            self.wait(meanwhile)?;
            match self.file.read(buffer) {
                // Another reader was faster.
                Err(cause) if cause.kind() == ErrorKind::WouldBlock && self.patience.is_some() => {}
                read => return read,
            }
        }
    }

    /// Waits until there is something to be read, or the end.
    ///
    /// # Errors
    /// As [`Patience::until`], and those of `meanwhile`.
    #[cfg(unix)]
    fn wait(&mut self, meanwhile: &mut dyn FnMut() -> io::Result<()>) -> io::Result<()> {
        let Some(patience) = &self.patience else { return Ok(()) };
        let (began, longest) = (Instant::now(), patience.longest());
        let before = if let Waits::Together(before) = self.waits { before } else { Duration::ZERO };
        let mut has_asked = false;
        patience.readable(&self.file, || {
            meanwhile()?;
            let is_spent = has_asked && !before.is_zero() && before + began.elapsed() >= longest;
            has_asked = true;
            if is_spent {
                let cause = format!("it has not ended after {} s of waiting for it", longest.as_secs_f64());
                return Err(io::Error::new(ErrorKind::TimedOut, cause));
            }
            Ok(())
        })?;
        if let Waits::Together(waited) = &mut self.waits {
            *waited += began.elapsed();
        }
        Ok(())
    }
}

impl Read for InputFile {
    #[cfg(unix)]
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.read_while(buffer, &mut || Ok(()))
    }

    #[cfg(not(unix))]
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.file.read(buffer)
    }
}

#[cfg(unix)]
fn is_pipe(kind: fs::FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&kind)
}

#[cfg(not(unix))]
fn is_pipe(_: fs::FileType) -> bool {
    false
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

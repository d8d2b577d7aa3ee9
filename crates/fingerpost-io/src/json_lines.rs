//! A file of JSON lines that holds whole lines only, whatever happens.

use std::{
    fs::{File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
    time::Duration,
};

use fingerpost_format::{LinesError, ToJson, to_json_line};
use thiserror::Error;

use crate::{
    file::{FileError, read_bytes},
    periodic_sync::PeriodicSync,
    private::private_file,
    whole_file::sync_folder,
};

/// Time between two syncs of a file of lines: a machine that loses its power loses no more than a second of them, with
/// as much again for a slow disk.
const SYNC_INTERVAL: Duration = Duration::from_millis(500);

/// A record that cannot be added to its file.
#[derive(Debug, Error)]
pub enum AppendError {
    /// The record has no JSON form.
    #[error("{}: {cause}", .path.display())]
    Record {
        /// The file.
        path: PathBuf,
        /// What is wrong with the record.
        cause: LinesError,
    },
    /// The file cannot be written; the lines before are whole.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Something that lines are written to and that can be cut back to a length.
pub trait LineSink: Write {
    /// Forgets everything behind the first `length` bytes and goes on from there.
    ///
    /// # Errors
    /// Whatever the system says.
    fn cut_back(&mut self, length: u64) -> io::Result<()>;
}

impl LineSink for File {
    fn cut_back(&mut self, length: u64) -> io::Result<()> {
        use std::io::Seek;
        self.set_len(length)?;
        self.seek(io::SeekFrom::Start(length)).map(|_| ())
    }
}

/// A file of JSON lines being written.
///
/// Every line goes out in one piece as it comes: a program that ends between two lines leaves a valid file. A line that
/// can be written only in part (a full disk) is cut off again. A file that was made with [`JsonLinesFile::create`] is
/// brought to the disk twice a second and at its end.
#[derive(Debug)]
pub struct JsonLinesFile<S = File> {
    path: PathBuf,
    sink: S,
    whole_bytes: u64,
    torn: bool,
    sync: Option<PeriodicSync>,
}

impl JsonLinesFile {
    /// Starts an empty file, replacing one of that name.
    ///
    /// # Errors
    /// [`FileError::Write`] when it cannot be made.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        let writing = || FileError::writing(path);
        let file = private_file(path).map_err(writing())?;
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            sync_folder(folder).map_err(writing())?;
        }
        Self::synced(path, file)
    }

    /// Goes on with a file of an earlier program, or starts one: gives the whole lines that it holds, and cuts off a last one that
    /// a killed program or a lost machine left without its end.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be read or written.
    pub fn go_on_with(path: &Path) -> Result<(Self, String), FileError> {
        if !path.exists() {
            return Ok((Self::create(path)?, String::new()));
        }
        let mut bytes = read_bytes(path)?;
        bytes.truncate(bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1));
        let whole_bytes = bytes.len() as u64;
        let lines = String::from_utf8(bytes).map_err(|_| FileError::NotText { path: path.to_owned() })?;
        let mut file = OpenOptions::new().write(true).open(path).map_err(FileError::writing(path))?;
        file.cut_back(whole_bytes).map_err(FileError::writing(path))?;
        Ok((Self { whole_bytes, ..Self::synced(path, file)? }, lines))
    }

    fn synced(path: &Path, file: File) -> Result<Self, FileError> {
        let synced = file.try_clone().map_err(FileError::writing(path))?;
        let sync = PeriodicSync::start(SYNC_INTERVAL, move || synced.sync_data());
        Ok(Self { sync: Some(sync.map_err(FileError::writing(path))?), ..Self::over(path, file) })
    }
}

impl<S: LineSink> JsonLinesFile<S> {
    /// Writes to an empty sink; `path` is what messages call it.
    pub fn over(path: &Path, sink: S) -> Self {
        Self { path: path.to_owned(), sink, whole_bytes: 0, torn: false, sync: None }
    }

    /// Adds a record as one line.
    ///
    /// # Errors
    /// [`AppendError`] when the record has no JSON form or the line cannot be written; the lines before stay whole, and
    /// a later line may be tried.
    pub fn append<T: ToJson>(&mut self, record: &T) -> Result<(), AppendError> {
        let line =
            to_json_line(record).map_err(|cause| AppendError::Record { path: self.path.clone(), cause })?;
        Ok(self.append_line(&line)?)
    }

    fn append_line(&mut self, line: &str) -> Result<(), FileError> {
        if let Some(sync) = &self.sync {
            sync.failure().map_err(FileError::writing(&self.path))?;
        }
        if self.torn {
            self.sink.cut_back(self.whole_bytes).map_err(FileError::writing(&self.path))?;
            self.torn = false;
        }
        match self.sink.write_all(line.as_bytes()).and_then(|()| self.sink.flush()) {
            Ok(()) => {
                self.whole_bytes += line.len() as u64;
                Ok(())
            }
            Err(cause) => {
                // Where even that fails it is tried again before the next line.
                self.torn = self.sink.cut_back(self.whole_bytes).is_err();
                Err(FileError::Write { path: self.path.clone(), cause })
            }
        }
    }

    /// Ends the file: its lines are on the disk.
    ///
    /// # Errors
    /// [`FileError::Write`] when they cannot be brought there.
    pub fn finish(mut self) -> Result<(), FileError> {
        self.sync.take().map_or(Ok(()), PeriodicSync::finish).map_err(FileError::writing(&self.path))
    }

    /// The sink, as far as it was written.
    pub fn into_inner(self) -> S {
        self.sink
    }
}

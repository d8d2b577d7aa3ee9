//! A file of lines, each read when it is asked for.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use crate::file::FileError;

/// Longest line that is read, bytes: a thousand times a frame's record.
const LONGEST_LINE: u64 = 8_000_000;

/// The whole lines of a file by their places in it; a last one without its end, which a killed program left, is none.
#[derive(Debug)]
pub struct LineFile {
    path: PathBuf,
    file: Mutex<File>,
    /// Where each line begins, bytes from the file's start, and where the last one ends.
    bounds: Vec<u64>,
}

impl LineFile {
    /// Looks a file through, of which no line is kept.
    ///
    /// # Errors
    /// [`FileError::Read`] when it cannot be read.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let file = File::open(path).map_err(FileError::reading(path))?;
        let mut reader = BufReader::with_capacity(1 << 20, &file);
        let (mut bounds, mut at) = (vec![0], 0);
        loop {
            let read = reader.fill_buf().map_err(FileError::reading(path))?;
            if read.is_empty() {
                break;
            }
            let ends = read.iter().zip(at + 1..).filter(|(byte, _)| **byte == b'\n');
            bounds.extend(ends.map(|(_, behind)| behind));
            let count = read.len();
            at += count as u64;
            reader.consume(count);
        }
        Ok(Self { path: path.to_owned(), file: Mutex::new(file), bounds })
    }

    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.bounds.len() - 1
    }

    /// A line by its index from zero, without its end; none behind the last.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be read, or has more than 8 MB.
    pub fn line(&self, index: usize) -> Result<Option<Vec<u8>>, FileError> {
        let Some(&[start, behind]) = self.bounds.get(index..).and_then(|rest| rest.first_chunk()) else {
            return Ok(None);
        };
        let bytes = behind - start - 1;
        if bytes > LONGEST_LINE {
            let limit_mb = LONGEST_LINE / 1_000_000;
            return Err(FileError::TooLong { path: self.path.clone(), limit_mb, kind: "a line" });
        }
        let mut line = vec![0; bytes as usize];
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let read = file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut line));
        read.map_err(FileError::reading(&self.path))?;
        Ok(Some(line))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn lines_are_read_in_any_order_and_one_without_its_end_is_none() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("frames.jsonl");
        for (text, expected) in
            [("", vec![]), ("torn", vec![]), ("a\n\nlong line\ntorn", vec!["a", "", "long line"])]
        {
            fs::write(&path, text).unwrap();
            let file = LineFile::open(&path).unwrap();
            assert_eq!(file.lines(), expected.len(), "{text:?}");
            for (index, line) in expected.iter().enumerate().rev() {
                assert_eq!(file.line(index).unwrap().as_deref(), Some(line.as_bytes()));
            }
            assert_eq!(file.line(expected.len()).unwrap(), None);
            assert_eq!(file.line(usize::MAX).unwrap(), None);
        }
    }

    #[test]
    fn what_is_gone_or_too_long_is_said() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("frames.jsonl");
        assert!(LineFile::open(&path).unwrap_err().to_string().contains("frames.jsonl"));
        fs::write(&path, format!("{}\nshort\n", "x".repeat(LONGEST_LINE as usize + 1))).unwrap();
        let file = LineFile::open(&path).unwrap();
        assert!(file.line(0).unwrap_err().to_string().contains("a line"));
        assert_eq!(file.line(1).unwrap().as_deref(), Some(&b"short"[..]));
        fs::write(&path, "").unwrap();
        assert!(file.line(1).unwrap_err().to_string().contains("cannot be read"));
    }
}

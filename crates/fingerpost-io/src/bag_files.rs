//! The files of a recording: one of MCAP, or those of a ROS 2 bag.

use std::{
    fs::{self, File},
    io::{BufReader, Read},
    path::{Path, PathBuf},
};

use thiserror::Error;

use crate::{file::FileError, picture_folder::natural_order};

/// A bag whose files cannot be used.
#[derive(Debug, Error)]
pub enum BagFilesError {
    /// The folder cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no MCAP file in it.
    #[error("{} holds no .mcap file{advice}", .path.display())]
    NoMcap {
        /// The folder.
        path: PathBuf,
        /// What it holds instead, and what to do.
        advice: &'static str,
    },
}

/// The MCAP files of a bag in their order, which is that of the numbers in their names; a file is its own only one.
///
/// # Errors
/// [`BagFilesError`] when a folder cannot be read or holds none.
pub fn bag_files(path: &Path) -> Result<Vec<PathBuf>, BagFilesError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(FileError::reading(path))? {
        names.push(entry.map_err(FileError::reading(path))?.file_name().to_string_lossy().into_owned());
    }
    let ends = |ending: &str| names.iter().any(|name| name.ends_with(ending));
    let advice = if ends(".db3") {
        " but an SQLite bag (.db3); convert it with `ros2 bag convert` and storage_id: mcap"
    } else if ends(".mcap.zstd") {
        " but packed ones (.mcap.zstd); unpack them with `zstd -d`"
    } else {
        "; name a ROS 2 bag with MCAP storage"
    };
    names.retain(|name| name.ends_with(".mcap") && !name.starts_with('.'));
    if names.is_empty() {
        return Err(BagFilesError::NoMcap { path: path.to_owned(), advice });
    }
    names.sort_by(|a, b| natural_order(a, b));
    Ok(names.into_iter().map(|name| path.join(name)).collect())
}

/// Opens a file of a recording.
///
/// # Errors
/// [`FileError::Read`] when it cannot be opened.
pub fn open_bag(path: &Path) -> Result<impl Read + use<>, FileError> {
    Ok(BufReader::new(File::open(path).map_err(FileError::reading(path))?))
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    #[test]
    fn files_come_in_the_order_of_their_numbers() {
        let bag = TempDir::new().unwrap();
        for name in ["drive_10.mcap", "drive_9.mcap", "metadata.yaml"] {
            fs::write(bag.path().join(name), "").unwrap();
        }
        let files = bag_files(bag.path()).unwrap();
        assert_eq!(files, ["drive_9.mcap", "drive_10.mcap"].map(|name| bag.path().join(name)));
    }

    #[test]
    fn other_storages_are_named() {
        for (name, word) in [("a_0.db3", "SQLite"), ("a_0.mcap.zstd", "zstd -d"), ("a.txt", "MCAP storage")] {
            let bag = TempDir::new().unwrap();
            fs::write(bag.path().join(name), "").unwrap();
            let error = bag_files(bag.path()).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}

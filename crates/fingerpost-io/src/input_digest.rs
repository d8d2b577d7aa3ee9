//! Whether an input is still what it was: checksums of files and drives.

use std::{fs, path::Path};

use crc32fast::Hasher;

use crate::{
    file::{FileError, read_bytes},
    folder_kind::{BUS_FILES, TRUTH_FILE},
    picture_folder::{PictureFolderError, TIMES_FILE, picture_paths},
};

/// Files of a drive folder, beside its pictures, that what is measured on it depends on.
const DRIVE_FILES: [&str; 5] = ["camera.toml", "route.geojson", TRUTH_FILE, TIMES_FILE, BUS_FILES[2]];

/// The CRC-32 of a file's bytes. It shows that a file was changed; it is no protection against whoever wants to hide that.
///
/// # Errors
/// [`FileError`] when the file cannot be read.
pub fn file_digest(path: &Path) -> Result<u32, FileError> {
    Ok(crc32fast::hash(&read_bytes(path)?))
}

/// The CRC-32 of what is measured on a drive folder: its files, and its pictures' names and sizes. A file that is not there counts
/// as empty.
///
/// # Errors
/// [`PictureFolderError`] when something that is there cannot be read, or the folder holds no picture.
pub fn drive_digest(folder: &Path) -> Result<u32, PictureFolderError> {
    let mut hasher = Hasher::new();
    for name in DRIVE_FILES {
        let path = folder.join(name);
        let bytes = if path.is_file() { read_bytes(&path)? } else { Vec::new() };
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(&bytes);
    }
    for picture in picture_paths(folder)? {
        let size = fs::metadata(&picture).map_err(FileError::reading(&picture))?.len();
        hasher.update(picture.file_name().unwrap_or_default().as_encoded_bytes());
        hasher.update(&size.to_le_bytes());
    }
    Ok(hasher.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_that_was_changed_has_another_digest() {
        let folder = tempfile::TempDir::new().unwrap();
        let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
        let digest = || drive_digest(folder.path()).unwrap();
        assert!(matches!(drive_digest(folder.path()), Err(PictureFolderError::NoPictures { .. })));
        write("000000.png", b"picture");
        write("truth.jsonl", b"{}\n");
        let first = digest();
        assert_eq!(first, digest());
        write("notes.txt", b"not read");
        assert_eq!(first, digest());
        write("truth.jsonl", b"{ }\n");
        let changed = digest();
        assert_ne!(first, changed);
        write("000001.png", b"picture");
        assert_ne!(changed, digest());
        assert_eq!(file_digest(&folder.path().join("notes.txt")).unwrap(), crc32fast::hash(b"not read"));
    }
}

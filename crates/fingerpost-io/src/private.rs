//! What is its owner's alone: pictures of streets and people, and where somebody drove when.
//!
//! New folders have mode 700 and new files 600, less what the user's umask takes away. What is there already keeps what its owner gave it.
//! Systems without such modes have their own rules for new files.

use std::{
    fs::{DirBuilder, File, OpenOptions},
    io,
    path::Path,
};

use crate::file::FileError;

/// Mode of a new file.
#[cfg(unix)]
const FILE_MODE: u32 = 0o600;
/// Mode of a new folder.
#[cfg(unix)]
const FOLDER_MODE: u32 = 0o700;

/// How a file is opened to be written; a new one is its owner's alone.
pub(crate) fn private_options() -> OpenOptions {
    let mut options = File::options();
    options.write(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, FILE_MODE);
    options
}

/// Makes an empty file, or empties one that is there.
pub(crate) fn private_file(path: &Path) -> io::Result<File> {
    private_options().create(true).truncate(true).open(path)
}

/// Makes a folder that is its owner's alone, with everything above it; one that exists stays as it is.
///
/// # Errors
/// [`FileError::Write`] when it cannot be made.
pub fn create_private_folder(path: &Path) -> Result<(), FileError> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, FOLDER_MODE);
    builder.create(path).map_err(FileError::writing(path))
}

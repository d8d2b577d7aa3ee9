//! Inputs are never written to: outputs that would replace one are refused before anything is done.

use std::{
    fs,
    path::{Path, PathBuf},
};

use thiserror::Error;

use crate::{
    folder_kind::FolderKind,
    picture_folder::{FRAMES_FOLDER, TIMES_FILE, pictures_in},
};

/// An output that would replace an input.
#[derive(Debug, Error)]
#[error(
    "{} would be replaced by the results; choose another place than {} for them (--out, or the option that names it)",
    .input.display(), .output.display()
)]
pub struct OverInput {
    /// The input.
    pub input: PathBuf,
    /// The file or folder that was to be written.
    pub output: PathBuf,
}

/// Refuses inputs that stand where results of a kind go in a folder, or that are the folder itself; links are followed.
///
/// Inputs that are no files, such as addresses, are in nobody's way.
///
/// # Errors
/// [`OverInput`] names the first.
pub fn folder_keeps_inputs<'a>(
    folder: &Path,
    kind: FolderKind,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), OverInput> {
    let place = resolved(folder);
    let is_in_the_way = |input: &&Path| {
        let input = resolved(input);
        let inside = input.strip_prefix(&place).ok();
        inside.is_some_and(|inside| inside.as_os_str().is_empty() || kind.writes(inside))
    };
    refuse(folder, inputs.into_iter().find(is_in_the_way))
}

/// Refuses an output file that is one of the inputs, a picture or the times of an input folder, by whatever name or link.
///
/// # Errors
/// [`OverInput`] names the first.
pub fn file_keeps_inputs<'a>(
    output: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), OverInput> {
    let is_in_the_way = |input: &&Path| {
        if !input.is_dir() {
            return is_same_file(output, input);
        }
        // Folders that a drive may be read from; what is none holds no input.
        [input.to_path_buf(), input.join(FRAMES_FOLDER)].iter().any(|folder| {
            let pictures = pictures_in(folder).unwrap_or_default();
            pictures.iter().chain([&folder.join(TIMES_FILE)]).any(|path| is_same_file(output, path))
        })
    };
    // What does not exist yet is nobody's input.
    if output.is_file() { refuse(output, inputs.into_iter().find(is_in_the_way)) } else { Ok(()) }
}

fn refuse(output: &Path, input: Option<&Path>) -> Result<(), OverInput> {
    input.map_or(Ok(()), |input| Err(OverInput { input: input.to_owned(), output: output.to_owned() }))
}

/// A path without links, also of a file that does not exist yet.
fn resolved(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => {
            let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
            resolved(parent).join(name)
        }
        _ => path.to_owned(),
    })
}

#[cfg(unix)]
fn is_same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |path| fs::metadata(path).ok().map(|of| (of.dev(), of.ino()));
    identity(a).is_some_and(|of_a| identity(b) == Some(of_a))
}

#[cfg(not(unix))]
fn is_same_file(a: &Path, b: &Path) -> bool {
    fs::canonicalize(a).ok().is_some_and(|a| fs::canonicalize(b).ok() == Some(a))
}

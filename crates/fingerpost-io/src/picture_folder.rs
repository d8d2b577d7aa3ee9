//! A recorded drive as a folder of pictures with optional times.

use std::{
    cmp::Ordering,
    fs,
    path::{Path, PathBuf},
};

use fingerpost_format::{TimesError, parse_times};
use thiserror::Error;

use crate::file::{FileError, read_text};
use crate::numbered_names::{NumberedNames, TimesDoubt};

/// Name of the file of times.
pub(crate) const TIMES_FILE: &str = "times.txt";
/// Name of the folder of pictures in a drive folder.
pub(crate) const FRAMES_FOLDER: &str = "frames";
/// Ends of the names of pictures, in lower case.
const PICTURE_ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "ppm"];

/// A folder that is no recorded drive.
#[derive(Debug, Error)]
pub enum PictureFolderError {
    /// The folder or its times cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// There are no pictures in it.
    #[error("{} holds no picture (.png, .jpg, .jpeg, .ppm), nor does a folder \"frames\" in it; check the path", .path.display())]
    NoPictures {
        /// The folder.
        path: PathBuf,
    },
    /// The times cannot be used.
    #[error("{}: {cause}", .path.display())]
    Times {
        /// The file of times.
        path: PathBuf,
        /// What is wrong.
        cause: TimesError,
    },
    /// There is not one time for each picture.
    #[error(
        "{} holds {times} times for {pictures} pictures; give one line for each picture, or remove the file to count \
         by frame rate", .path.display()
    )]
    TimesCount {
        /// The file of times.
        path: PathBuf,
        /// Times in it.
        times: usize,
        /// Pictures in the folder.
        pictures: usize,
    },
}

/// The pictures of a drive in their order, with their times.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PictureFolder {
    /// Picture files in the order of their names.
    pub(crate) paths: Vec<PathBuf>,
    /// When they were taken.
    pub(crate) times: PictureTimes,
}

/// Times of a folder's pictures, seconds since the first, one for each.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PictureTimes {
    /// Those of a file of times.
    File {
        /// The file.
        path: PathBuf,
        /// Its times.
        times_s: Vec<f64>,
    },
    /// Those that the pictures are named by.
    Names(Vec<f64>),
    /// Nothing says them; most of the names may be times all the same.
    None(Option<TimesDoubt>),
}

impl PictureFolder {
    /// Lists a folder of pictures, or the folder `frames` in a drive folder.
    ///
    /// The times stand in `times.txt` beside the pictures, or beside a folder of pictures that is called `frames`.
    pub(crate) fn open(folder: &Path) -> Result<Self, PictureFolderError> {
        let inner = folder.join(FRAMES_FOLDER);
        let mut paths = pictures_in(folder)?;
        let mut times_files = vec![folder.join(TIMES_FILE)];
        if paths.is_empty() && inner.is_dir() {
            paths = pictures_in(&inner)?;
            times_files.insert(0, inner.join(TIMES_FILE));
        } else if folder.file_name().is_some_and(|name| name == FRAMES_FOLDER) {
            times_files.extend(folder.parent().map(|parent| parent.join(TIMES_FILE)));
        }
        if paths.is_empty() {
            return Err(PictureFolderError::NoPictures { path: folder.to_owned() });
        }
        let times_file = times_files.into_iter().find(|path| path.exists());
        let times = match times_file {
            Some(path) => PictureTimes::File { times_s: read_times(&path, paths.len())?, path },
            None => times_in_names(&paths),
        };
        Ok(Self { paths, times })
    }
}

/// The picture files of a folder (.png, .jpg, .jpeg, .ppm), or of the folder `frames` in it, in the order of their names: decimal
/// numbers by their values, all else in natural order.
///
/// # Errors
/// [`PictureFolderError`] when the folder or its times cannot be read, or it holds no picture.
pub fn picture_paths(folder: &Path) -> Result<Vec<PathBuf>, PictureFolderError> {
    Ok(PictureFolder::open(folder)?.paths)
}

/// The picture files of one folder, in the order of their names.
pub(crate) fn pictures_in(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    files_ending_in(folder, &PICTURE_ENDINGS)
}

/// The text files (.txt) of one folder, in natural order of their names.
///
/// # Errors
/// [`FileError::Read`] when the folder cannot be read.
pub fn text_files(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    files_ending_in(folder, &["txt"])
}

fn files_ending_in(folder: &Path, endings: &[&str]) -> Result<Vec<PathBuf>, FileError> {
    let entries = fs::read_dir(folder).map_err(FileError::reading(folder))?;
    let mut named = Vec::new();
    for entry in entries {
        let path = entry.map_err(FileError::reading(folder))?.path();
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let is_wanted = ending.is_some_and(|ending| endings.contains(&ending.as_str()));
        // Hidden files that end like these are what file managers leave behind.
        if is_wanted && !name.starts_with('.') {
            named.push((name, path));
        }
    }
    named.sort_by(|(a, _), (b, _)| natural_order(a, b));
    let paths: Vec<PathBuf> = named.into_iter().map(|(_, path)| path).collect();
    let Some(NumberedNames(numbers)) = numbers_in_names(&paths) else { return Ok(paths) };
    let mut numbered: Vec<(i128, PathBuf)> = numbers.into_iter().zip(paths).collect();
    numbered.sort_by_key(|(number, _)| *number);
    Ok(numbered.into_iter().map(|(_, path)| path).collect())
}

fn numbers_in_names(paths: &[PathBuf]) -> Option<NumberedNames> {
    NumberedNames::of(&stems(paths)?)
}

/// Names without their endings; none where one is no text.
fn stems(paths: &[PathBuf]) -> Option<Vec<&str>> {
    paths.iter().map(|path| path.file_stem()?.to_str()).collect()
}

/// The times that pictures are named by, or why they are not.
fn times_in_names(paths: &[PathBuf]) -> PictureTimes {
    let times_s = numbers_in_names(paths).and_then(|numbers| numbers.times_s());
    let doubt = || stems(paths).and_then(|stems| TimesDoubt::of(&stems));
    times_s.map_or_else(|| PictureTimes::None(doubt()), PictureTimes::Names)
}

fn read_times(path: &Path, pictures: usize) -> Result<Vec<f64>, PictureFolderError> {
    let times = parse_times(&read_text(path)?)
        .map_err(|cause| PictureFolderError::Times { path: path.to_owned(), cause })?;
    if times.len() == pictures {
        Ok(times)
    } else {
        Err(PictureFolderError::TimesCount { path: path.to_owned(), times: times.len(), pictures })
    }
}

/// Orders names as people do: runs of digits by their value, all else by its characters.
pub(crate) fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    loop {
        let (digits_a, digits_b) = (leading_digits(rest_a), leading_digits(rest_b));
        let order = if !digits_a.is_empty() && !digits_b.is_empty() {
            let (value_a, value_b) = (digits_a.trim_start_matches('0'), digits_b.trim_start_matches('0'));
            (rest_a, rest_b) = (&rest_a[digits_a.len()..], &rest_b[digits_b.len()..]);
            value_a.len().cmp(&value_b.len()).then_with(|| value_a.cmp(value_b))
        } else {
            let (mut characters_a, mut characters_b) = (rest_a.chars(), rest_b.chars());
            let (next_a, next_b) = (characters_a.next(), characters_b.next());
            if next_a.is_none() && next_b.is_none() {
                // Names that differ in leading zeros alone still have one order.
                return a.cmp(b);
            }
            (rest_a, rest_b) = (characters_a.as_str(), characters_b.as_str());
            next_a.cmp(&next_b)
        };
        if order.is_ne() {
            return order;
        }
    }
}

fn leading_digits(text: &str) -> &str {
    &text[..text.bytes().take_while(u8::is_ascii_digit).count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_by_value() {
        let mut names = ["f10.png", "f9.png", "f009.png", "f1a.png", "f1.png", "F2.png", "é1", "f1", "f"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["F2.png", "f", "f1", "f1.png", "f1a.png", "f009.png", "f9.png", "f10.png", "é1"]);
    }
}

//! Where marks are kept and truth is written.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use fingerpost_format::{MarksFile, marks_to_json, to_json_line};
use fingerpost_mark::{Cause, Keeper, LaneMarks, truth_of_marks, tusimple_of_marks};
use serde::Serialize;

use super::footage::Footage;

/// The folder in which a person marks.
#[derive(Debug)]
pub(super) struct MarksFolder {
    path: PathBuf,
    footage: Footage,
}

impl MarksFolder {
    /// A folder that exists.
    pub(super) fn new(path: PathBuf, footage: Footage) -> Self {
        Self { path, footage }
    }

    /// Where the marks are.
    pub(super) fn marks_path(&self) -> PathBuf {
        self.path.join("marks.json")
    }
}

impl Keeper for MarksFolder {
    fn keep(&mut self, marks: &MarksFile) -> Result<(), Cause> {
        Ok(fingerpost_io::replace_file(&self.marks_path(), marks_to_json(marks)?)?)
    }

    fn export(&mut self, marks: &LaneMarks) -> Result<Vec<String>, Cause> {
        Ok(write_truth(&self.path, marks, &self.footage)?)
    }
}

/// Writes `truth.jsonl` and `tusimple.json` and gives their paths.
pub(super) fn write_truth(folder: &Path, marks: &LaneMarks, footage: &Footage) -> Result<Vec<String>> {
    if folder.join("road_masks").is_dir() {
        bail!(
            "{} is a simulated drive, whose truth would be replaced; choose another folder",
            folder.display()
        );
    }
    let truth = truth_of_marks(marks, |frame| footage.time_s(frame))?;
    let labels = tusimple_of_marks(marks, |frame| footage.label(frame))?;
    fingerpost_io::create_folder(folder)?;
    let files = [("truth.jsonl", lines(&truth)?), ("tusimple.json", lines(&labels)?)];
    files
        .into_iter()
        .map(|(name, text)| {
            let path = folder.join(name);
            fingerpost_io::replace_file(&path, text)?;
            Ok(path.display().to_string())
        })
        .collect()
}

fn lines<T: Serialize>(records: &[T]) -> Result<String> {
    Ok(records.iter().map(to_json_line).collect::<Result<String, _>>()?)
}

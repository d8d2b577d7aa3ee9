//! Where marks are kept and truth is written.

use std::path::PathBuf;

use anyhow::Result;
use fingerpost_format::{MarksFile, ToJson, marks_to_json, to_json_line};
use fingerpost_io::OutputFolder;
use fingerpost_mark::{Keeper, LaneMarks, truth_of_marks, tusimple_of_marks};
use fingerpost_server::Cause;

use super::footage::Footage;

/// The folder in which a person marks; nobody else marks in it meanwhile.
#[derive(Debug)]
pub(super) struct MarksFolder {
    folder: OutputFolder,
    footage: Footage,
}

impl MarksFolder {
    /// Marks in a folder.
    pub(super) fn new(folder: OutputFolder, footage: Footage) -> Self {
        Self { folder, footage }
    }

    /// Where the marks are.
    pub(super) fn marks_path(&self) -> PathBuf {
        self.folder.path().join("marks.json")
    }
}

impl Keeper for MarksFolder {
    fn keep(&mut self, marks: &MarksFile) -> Result<(), Cause> {
        Ok(fingerpost_io::write_private_file(&self.marks_path(), marks_to_json(marks)?)?)
    }

    fn export(&mut self, marks: &LaneMarks) -> Result<Vec<String>, Cause> {
        Ok(TruthTexts::of_marks(marks, &self.footage)?.write(&self.folder)?)
    }
}

/// Truth made of marks, as texts of files.
#[derive(Debug)]
pub(super) struct TruthTexts {
    truth: String,
    labels: String,
}

impl TruthTexts {
    /// Makes truth of marks that say all of every frame.
    pub(super) fn of_marks(marks: &LaneMarks, footage: &Footage) -> Result<Self> {
        let truth = lines(&truth_of_marks(marks, |frame| footage.time_s(frame))?)?;
        let labels = lines(&tusimple_of_marks(marks, |frame| footage.label(frame))?)?;
        Ok(Self { truth, labels })
    }

    /// Writes `truth.jsonl` and `tusimple.json` and gives their paths.
    pub(super) fn write(self, folder: &OutputFolder) -> Result<Vec<String>> {
        let files = [("truth.jsonl", self.truth), ("tusimple.json", self.labels)];
        files
            .into_iter()
            .map(|(name, text)| {
                let path = folder.path().join(name);
                fingerpost_io::write_private_file(&path, text)?;
                Ok(path.display().to_string())
            })
            .collect()
    }
}

fn lines<T: ToJson>(records: &[T]) -> Result<String> {
    Ok(records.iter().map(to_json_line).collect::<Result<String, _>>()?)
}

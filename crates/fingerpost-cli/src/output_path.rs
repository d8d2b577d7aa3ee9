//! Where a command may write.

use std::path::{Path, PathBuf};

use anyhow::Result;
use fingerpost_io::{FolderKind, file_keeps_inputs, folder_keeps_inputs, remove_abandoned};

/// Makes sure that a file to be written is none of a command's inputs, and removes what a killed command left beside it.
pub(crate) fn check_file<'a>(output: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    file_keeps_inputs(output, inputs)?;
    Ok(remove_abandoned(output)?)
}

/// Makes sure that none of a command's inputs stands where its results go.
pub(crate) fn check_folder<'a>(
    output: &Path,
    kind: FolderKind,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    Ok(folder_keeps_inputs(output, kind, inputs)?)
}

/// The files of a run that evaluations read.
pub(crate) fn run_files(run: &Path) -> [PathBuf; 2] {
    ["frames.jsonl", "summary.json"].map(|name| run.join(name))
}

//! Where a command may write.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use fingerpost_format::is_written_camera;
use fingerpost_io::{
    FolderKind, file_keeps_inputs, folder_keeps_inputs, is_signed_png, read_bytes, remove_abandoned,
};
use fingerpost_map::read_route;
use fingerpost_report::is_surface_svg;

use crate::can::CSV_HEAD;
use crate::changed_settings::is_written_settings;

/// What a single file that a command writes holds; by it a file of this program is told from the user's, as folders are by their marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileKind {
    /// A route on a map.
    Route,
    /// A camera's calibration.
    Camera,
    /// Settings.
    Settings,
    /// Samples of the bus's signals.
    Signals,
    /// A surface of accuracies.
    Plot,
    /// A sheet of pictures.
    Sheet,
    /// A page of the manual.
    #[cfg(feature = "completions")]
    Page,
}

impl FileKind {
    /// Whether a file's bytes are of this kind; nothing is anybody's.
    fn is_read_from(self, bytes: &[u8]) -> bool {
        let is_text = |is_ours: fn(&str) -> bool| std::str::from_utf8(bytes).is_ok_and(is_ours);
        bytes.is_empty()
            || match self {
                Self::Route => is_text(|text| read_route(text).is_ok()),
                Self::Camera => is_text(is_written_camera),
                Self::Settings => is_text(is_written_settings),
                Self::Signals => is_text(|text| text.starts_with(CSV_HEAD)),
                Self::Plot => is_text(is_surface_svg),
                Self::Sheet => is_signed_png(bytes),
                #[cfg(feature = "completions")]
                Self::Page => is_text(crate::man::is_page),
            }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Route => "route",
            Self::Camera => "camera",
            Self::Settings => "file of settings",
            Self::Signals => "table of signals",
            Self::Plot => "plot",
            Self::Sheet => "sheet",
            #[cfg(feature = "completions")]
            Self::Page => "page of the manual",
        })
    }
}

/// Makes sure that a file to be written is none of a command's inputs and nothing that may be the user's: what is there is empty or
/// reads as what is to be written. Removes what a killed command left beside it.
pub(crate) fn check_file<'a>(
    output: &Path,
    kind: FileKind,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    check_kept_file(output, inputs)?;
    // A device or a pipe takes anything.
    if output.is_file() && !kind.is_read_from(&read_bytes(output)?) {
        bail!(
            "{} is no {kind} that this program wrote, so it may be yours; choose another file, or remove this one first (plots and sheets of \
             versions that did not sign them are not replaced either)",
            output.display()
        );
    }
    Ok(())
}

/// The same for a file that is also read: reading says whether it is what is to be written.
pub(crate) fn check_kept_file<'a>(output: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> Result<()> {
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

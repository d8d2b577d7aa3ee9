//! A simulated drive as a folder, readable as an input and as truth.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

use fingerpost_format::{LinesError, TruthRecord, from_json_lines};
use fingerpost_vision::{
    jpeg::ChromaSampling,
    picture::{Plane, RgbImage},
};
use thiserror::Error;

use crate::{
    file::{FileError, read_text},
    folder_kind::{BUS_FILES, CLASSES_FOLDER, FolderKind, HEIGHTS_FOLDER, MASKS_FOLDER, TRUTH_FILE},
    json_lines::{AppendError, JsonLinesFile},
    output_folder::{OutputFolder, OutputFolderError},
    picture_file::{PictureFileError, write_deep_png, write_grey_png, write_jpeg, write_png, write_ppm},
    picture_folder::{FRAMES_FOLDER, TIMES_FILE},
    private::create_private_folder,
    whole_file::write_private_file,
};

/// JPEG quality of frames: the noise of a camera survives it. Colour has half the resolution, as in most cameras' recordings.
const FRAME_QUALITY: u8 = 89;

/// A drive that cannot be written.
#[derive(Debug, Error)]
pub enum DriveFolderError {
    /// The folder cannot be taken for a drive.
    #[error(transparent)]
    Folder(#[from] OutputFolderError),
    /// One of its files cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A truth record cannot be added; those before are whole.
    #[error(transparent)]
    Append(#[from] AppendError),
    /// A picture cannot be written.
    #[error(transparent)]
    Picture(#[from] PictureFileError),
}

/// A truth file that cannot be used.
#[derive(Debug, Error)]
pub enum TruthFileError {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// One of its lines is no truth record.
    #[error("{}: {cause}", .path.display())]
    Lines {
        /// The file.
        path: PathBuf,
        /// Which line, and what is wrong with it.
        cause: LinesError,
    },
}

/// How frames are stored.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FrameFormat {
    /// Small and quick to read.
    #[default]
    Jpeg,
    /// Every pixel as it was rendered.
    Png,
    /// The same without being packed: a portable pixmap, which any language reads in a few lines.
    Ppm,
}

/// What a vehicle's bus said on a drive, as texts of files.
#[derive(Debug, Clone, Copy)]
pub struct BusTexts<'a> {
    /// The log, as `candump -L` writes it.
    pub log: &'a str,
    /// The DBC file.
    pub database: &'a str,
    /// The table `can` of a configuration, TOML.
    pub settings: &'a str,
}

/// The folder of a drive being written: `frames/`, `road_masks/`, `times.txt`, `truth.jsonl`, `camera.toml`,
/// `route.geojson`, and the vehicle's bus: `can.log`, `car.dbc`, `can.toml`.
#[derive(Debug)]
pub struct DriveFolder {
    format: FrameFormat,
    truth: JsonLinesFile,
    times: String,
    /// Nobody else writes it meanwhile.
    folder: OutputFolder,
}

impl DriveFolder {
    /// Makes the folder, or takes one of an earlier drive, whose files are removed; see [`OutputFolder::take`].
    ///
    /// # Errors
    /// [`DriveFolderError`] when the folder cannot be made, holds something else or is in use.
    pub fn create(path: &Path, format: FrameFormat) -> Result<Self, DriveFolderError> {
        let folder = OutputFolder::take(path, FolderKind::Drive)?;
        for name in [FRAMES_FOLDER, MASKS_FOLDER] {
            create_private_folder(&path.join(name))?;
        }
        let truth = JsonLinesFile::create(&path.join(TRUTH_FILE))?;
        Ok(Self { format, truth, times: String::new(), folder })
    }

    /// Where `truth.jsonl` is.
    pub fn truth_path(&self) -> PathBuf {
        self.folder.path().join(TRUTH_FILE)
    }

    /// Writes `camera.toml` and gives its path.
    ///
    /// # Errors
    /// [`DriveFolderError::File`] when it cannot be written.
    pub fn write_camera(&self, toml: &str) -> Result<PathBuf, DriveFolderError> {
        self.write_text("camera.toml", toml)
    }

    /// Writes `route.geojson` and gives its path.
    ///
    /// # Errors
    /// [`DriveFolderError::File`] when it cannot be written.
    pub fn write_route(&self, geojson: &str) -> Result<PathBuf, DriveFolderError> {
        self.write_text("route.geojson", geojson)
    }

    /// Writes `can.log`, `car.dbc` and `can.toml`.
    ///
    /// # Errors
    /// [`DriveFolderError::File`] when one of them cannot be written.
    pub fn write_bus(&self, bus: BusTexts<'_>) -> Result<(), DriveFolderError> {
        for (name, text) in BUS_FILES.into_iter().zip([bus.log, bus.database, bus.settings]) {
            self.write_text(name, text)?;
        }
        Ok(())
    }

    /// Writes the picture of frame `index`; frames may be written in any order and from several threads.
    ///
    /// # Errors
    /// [`DriveFolderError::Picture`] when it cannot be written.
    pub fn write_frame(&self, index: u64, picture: &RgbImage) -> Result<(), DriveFolderError> {
        let folder = self.folder.path().join(FRAMES_FOLDER);
        match self.format {
            FrameFormat::Jpeg => {
                let path = folder.join(format!("{index:06}.jpg"));
                write_jpeg(&path, picture, FRAME_QUALITY, ChromaSampling::Halved)?;
            }
            FrameFormat::Png => write_png(&folder.join(format!("{index:06}.png")), picture)?,
            FrameFormat::Ppm => write_ppm(&folder.join(format!("{index:06}.ppm")), picture)?,
        }
        Ok(())
    }

    /// Writes the road-surface mask of frame `index` (255 road, 0 none); in any order and from several threads.
    ///
    /// # Errors
    /// [`DriveFolderError::Picture`] when it cannot be written.
    pub fn write_road_mask(&self, index: u64, mask: &Plane<u8>) -> Result<(), DriveFolderError> {
        let name = format!("{index:06}.png");
        Ok(write_grey_png(&self.folder.path().join(MASKS_FOLDER).join(name), mask)?)
    }

    /// Makes the folder of heights, before the first of them is written.
    ///
    /// # Errors
    /// [`DriveFolderError::File`] when it cannot be made.
    pub fn expect_heights(&self) -> Result<(), DriveFolderError> {
        Ok(create_private_folder(&self.folder.path().join(HEIGHTS_FOLDER))?)
    }

    /// Writes the heights of the ground that frame `index` shows; in any order and from several threads.
    ///
    /// # Errors
    /// [`DriveFolderError::Picture`] when they cannot be written.
    pub fn write_heights(&self, index: u64, heights: &Plane<u16>) -> Result<(), DriveFolderError> {
        let name = format!("{index:06}.png");
        Ok(write_deep_png(&self.folder.path().join(HEIGHTS_FOLDER).join(name), heights)?)
    }

    /// Makes the folder of classes, before the first of them is written.
    ///
    /// # Errors
    /// [`DriveFolderError::File`] when it cannot be made.
    pub fn expect_classes(&self) -> Result<(), DriveFolderError> {
        Ok(create_private_folder(&self.folder.path().join(CLASSES_FOLDER))?)
    }

    /// Writes what the pixels of frame `index` show, by number; in any order and from several threads.
    ///
    /// # Errors
    /// [`DriveFolderError::Picture`] when it cannot be written.
    pub fn write_classes(&self, index: u64, classes: &Plane<u8>) -> Result<(), DriveFolderError> {
        let name = format!("{index:06}.png");
        Ok(write_grey_png(&self.folder.path().join(CLASSES_FOLDER).join(name), classes)?)
    }

    /// Adds the truth of the next frame, and its time to `times.txt`.
    ///
    /// # Errors
    /// [`DriveFolderError`] when it cannot be written; the records before stay whole.
    pub fn append(&mut self, truth: &TruthRecord) -> Result<(), DriveFolderError> {
        self.truth.append(truth)?;
        // Writing to a string does not fail.
        let _ = writeln!(self.times, "{:.6}", truth.t_s);
        Ok(())
    }

    /// Ends the drive: brings `truth.jsonl` to the disk and writes `times.txt`.
    ///
    /// # Errors
    /// [`DriveFolderError::File`] when they cannot be written.
    pub fn finish(self) -> Result<(), DriveFolderError> {
        self.truth.finish()?;
        Ok(write_private_file(&self.folder.path().join(TIMES_FILE), self.times)?)
    }

    fn write_text(&self, name: &str, text: &str) -> Result<PathBuf, DriveFolderError> {
        let path = self.folder.path().join(name);
        write_private_file(&path, text)?;
        Ok(path)
    }
}

/// The truth of a drive, one record a frame.
///
/// # Errors
/// [`TruthFileError`] when the file cannot be read or names the first line that is no truth record.
pub fn read_truth(path: &Path) -> Result<Vec<TruthRecord>, TruthFileError> {
    let text = read_text(path)?;
    from_json_lines(&text).map_err(|cause| TruthFileError::Lines { path: path.to_owned(), cause })
}

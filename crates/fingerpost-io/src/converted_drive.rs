//! A drive made of another's recording, as a folder that `run` and `locate` read.

use std::{fmt::Write as _, path::Path};

use fingerpost_format::{MotionLogRow, PoseLogRow, gps_gpx, motion_log_text, pose_log_text};
use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::{
    file::FileError,
    folder_kind::{CAMERA_FILE, FolderKind, GPS_FILE, MOTION_FILE, POSES_FILE},
    output_folder::{OutputFolder, OutputFolderError},
    picture_file::{PictureFileError, write_png},
    picture_folder::{FRAMES_FOLDER, TIMES_FILE},
    private::create_private_folder,
    whole_file::write_private_file,
};

/// A drive that cannot be written.
#[derive(Debug, Error)]
pub enum ConvertedDriveError {
    /// The folder cannot be taken for a drive.
    #[error(transparent)]
    Folder(#[from] OutputFolderError),
    /// One of its files cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A picture cannot be written.
    #[error(transparent)]
    Picture(#[from] PictureFileError),
}

/// The ending of a packed picture's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureEnding {
    /// `.jpg`
    Jpeg,
    /// `.png`
    Png,
}

/// What was recorded beside the pictures, by time since the first of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConvertedLogs {
    /// GPS positions: seconds, latitude and longitude in degrees.
    pub gps: Vec<(f64, [f64; 2])>,
    /// Speed and yaw rate.
    pub motion: Vec<MotionLogRow>,
    /// True poses.
    pub poses: Vec<PoseLogRow>,
}

/// The folder being written: `frames/`, `times.txt`, `camera.toml`, and where they are known `gps.gpx`, `motion.csv` and
/// `poses.csv`.
#[derive(Debug)]
pub struct ConvertedDrive {
    times: String,
    frames: u64,
    /// Nobody else writes it meanwhile.
    folder: OutputFolder,
}

impl ConvertedDrive {
    /// Makes the folder, or takes one of an earlier conversion, whose files are removed; see [`OutputFolder::take`].
    ///
    /// # Errors
    /// [`ConvertedDriveError`] when the folder cannot be made, holds something else or is in use.
    pub fn create(path: &Path, camera_toml: &str) -> Result<Self, ConvertedDriveError> {
        let folder = OutputFolder::take(path, FolderKind::ConvertedDrive)?;
        create_private_folder(&path.join(FRAMES_FOLDER))?;
        write_private_file(&path.join(CAMERA_FILE), camera_toml)?;
        Ok(Self { times: String::new(), frames: 0, folder })
    }

    /// Frames so far.
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Adds a frame at `t_s`, seconds since the first, as the file it is.
    ///
    /// # Errors
    /// [`ConvertedDriveError::File`] when it cannot be written.
    pub fn add_packed(
        &mut self,
        t_s: f64,
        ending: PictureEnding,
        bytes: &[u8],
    ) -> Result<(), ConvertedDriveError> {
        let ending = match ending {
            PictureEnding::Jpeg => "jpg",
            PictureEnding::Png => "png",
        };
        write_private_file(&self.frame_path(ending), bytes)?;
        self.count(t_s);
        Ok(())
    }

    /// Adds a frame of bare pixels at `t_s`, seconds since the first, without loss.
    ///
    /// # Errors
    /// [`ConvertedDriveError::Picture`] when it cannot be written.
    pub fn add_pixels(&mut self, t_s: f64, picture: &RgbImage) -> Result<(), ConvertedDriveError> {
        write_png(&self.frame_path("png"), picture)?;
        self.count(t_s);
        Ok(())
    }

    /// Ends the drive: writes the times of its frames and what else was recorded.
    ///
    /// # Errors
    /// [`ConvertedDriveError::File`] when they cannot be written.
    pub fn finish(self, logs: &ConvertedLogs) -> Result<(), ConvertedDriveError> {
        let write = |name: &str, text: String| write_private_file(&self.folder.path().join(name), text);
        write(TIMES_FILE, self.times.clone())?;
        if !logs.gps.is_empty() {
            write(GPS_FILE, gps_gpx(&logs.gps))?;
        }
        if !logs.motion.is_empty() {
            write(MOTION_FILE, motion_log_text(&logs.motion))?;
        }
        if !logs.poses.is_empty() {
            write(POSES_FILE, pose_log_text(&logs.poses))?;
        }
        Ok(())
    }

    fn frame_path(&self, ending: &str) -> std::path::PathBuf {
        self.folder.path().join(FRAMES_FOLDER).join(format!("{:06}.{ending}", self.frames))
    }

    fn count(&mut self, t_s: f64) {
        self.frames += 1;
        // Writing to a String does not fail.
        let _ = writeln!(self.times, "{t_s:.6}");
    }
}

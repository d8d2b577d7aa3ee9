//! A camera from its calibration file, whichever of the known kinds it is.

use std::path::{Path, PathBuf};

use fingerpost_format::{CameraFileError, ReadCamera, camera_from_toml, camera_from_yaml, mount_from_toml};
use thiserror::Error;

use crate::file::{FileError, read_text};

/// A calibration file that cannot be used.
#[derive(Debug, Error)]
pub enum CameraReadError {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its name ends in something else than a calibration's does.
    #[error("{} is no known calibration file; give a .toml, .yaml or .yml", .path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// What it says cannot be used.
    #[error("{}: {cause}", .path.display())]
    Contents {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: CameraFileError,
    },
    /// A YAML calibration without a mount.
    #[error(
        "{} does not say where the camera sits on the vehicle; write {} beside it with a table [mount] and in it \
         height_m = METRES ABOVE THE ROAD, and if they are not zero pitch_deg (positive nose down), yaw_deg (positive \
         left), roll_deg (positive left side up), x_m (forward of the rear axle), y_m (left)",
        .path.display(), .mount_path.display()
    )]
    NoMount {
        /// The calibration.
        path: PathBuf,
        /// Where its mount is looked for first.
        mount_path: PathBuf,
    },
}

/// Reads a camera from `camera.toml`, or a YAML of ROS `camera_info`, OpenCV or Kalibr, with what must be known of how it was
/// understood.
///
/// The YAML kinds have no mount of their own. It is read from a table `[mount]`, written as in `camera.toml`, in the
/// file `NAME.mount.toml` beside `NAME.yaml`, else in `mount.toml` beside it, else from a mapping `mount:` in the YAML.
///
/// # Errors
/// [`CameraReadError`] when a file cannot be read, is of no known kind, or its numbers cannot be right.
pub fn read_camera(path: &Path) -> Result<ReadCamera, CameraReadError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let contents = |path: &Path| {
        let path = path.to_owned();
        move |cause| CameraReadError::Contents { path, cause }
    };
    match ending.as_deref() {
        Some("toml") => {
            let camera = camera_from_toml(&read_text(path)?).map_err(contents(path))?;
            Ok(ReadCamera { camera, remarks: Vec::new() })
        }
        Some("yaml" | "yml") => {
            let text = read_text(path)?;
            let own_mount_path = path.with_extension("mount.toml");
            let mount_paths = [own_mount_path.clone(), path.with_file_name("mount.toml")];
            let mount = match mount_paths.iter().find(|path| path.exists()) {
                Some(path) => Some(mount_from_toml(&read_text(path)?).map_err(contents(path))?),
                None => None,
            };
            camera_from_yaml(&text, mount).map_err(|cause| match cause {
                CameraFileError::NoMount => {
                    CameraReadError::NoMount { path: path.to_owned(), mount_path: own_mount_path }
                }
                cause => contents(path)(cause),
            })
        }
        _ => Err(CameraReadError::UnknownKind { path: path.to_owned() }),
    }
}

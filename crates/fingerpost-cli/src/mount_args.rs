//! Where a camera sits, which neither recordings nor ROS say.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{ArgGroup, Args};
use fingerpost_format::mount_from_toml;
use fingerpost_geometry::{Camera, Mount};
use fingerpost_io::read_text;

use crate::arguments::number;
use crate::inputs;

/// The camera's mount, or the whole camera.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("where").args(["height_m", "mount", "camera"]).required(true)))]
pub(crate) struct MountArgs {
    /// Height of a level camera above the road, metres, 0.05 to 20; `calibrate mount` finds pitch and yaw then.
    #[arg(long, value_name = "H", value_parser = number(0.05, 20.0, "height", "metres"))]
    height_m: Option<f64>,
    /// The camera's mount: a file with the table "mount" of a camera.toml.
    #[arg(long, value_name = "FILE")]
    mount: Option<PathBuf>,
    /// The camera, in place of the recorded calibration: camera.toml, or the YAML of ROS camera_info or OpenCV.
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
}

/// What is known of the camera beforehand.
#[derive(Debug)]
pub(crate) enum KnownCamera {
    /// All of it.
    Whole(Box<Camera>),
    /// Where it sits.
    Mount(Mount),
}

impl MountArgs {
    /// Files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.mount, &self.camera].into_iter().flatten()
    }

    /// Reads what is given.
    pub(crate) fn known(&self) -> Result<KnownCamera> {
        match (&self.camera, &self.mount) {
            (Some(path), _) => Ok(KnownCamera::Whole(Box::new(inputs::camera(path)?))),
            (None, Some(path)) => {
                let mount = mount_from_toml(&read_text(path)?).with_context(|| path.display().to_string())?;
                Ok(KnownCamera::Mount(mount))
            }
            (None, None) => Ok(KnownCamera::Mount(Mount::level(self.height_m.unwrap_or_default()))),
        }
    }
}

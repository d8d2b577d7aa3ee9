//! Where a camera sits, which neither recordings nor ROS say.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{ArgGroup, Args};
use fingerpost_format::{PictureKind, mount_from_toml};
use fingerpost_geometry::{Camera, Distortion, Mount, View};
use fingerpost_io::{bag::is_rectified, read_text};

use crate::arguments::number;
use crate::{inputs, output};

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
    /// The camera, in place of the recorded calibration: camera.toml, or the YAML of ROS camera_info, OpenCV or Kalibr.
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
}

/// Whether the lens is still in the pictures.
#[derive(Debug, Args)]
pub(crate) struct PictureKindArgs {
    /// The pictures are rectified: the calibration's projection matrix holds, and there is no lens. This is taken for given of a topic
    /// whose name says so, as image_rect and image_undistorted do.
    #[arg(long, conflicts_with = "camera")]
    rectified: bool,
    /// The pictures are as the lens made them, whatever the topic's name says.
    #[arg(long, conflicts_with_all = ["camera", "rectified"])]
    as_taken: bool,
}

impl PictureKindArgs {
    /// What the pictures of a topic are; what its name decides is said.
    pub(crate) fn of_topic(&self, topic: &str) -> PictureKind {
        if self.rectified {
            return PictureKind::Rectified;
        }
        if self.as_taken || !is_rectified(topic) {
            return PictureKind::AsTaken;
        }
        output::message(&format!(
            "{topic}: rectified pictures by their name; the calibration's projection matrix holds, and there is no lens (--as-taken if there \
             is)"
        ));
        PictureKind::Rectified
    }
}

/// Says where a camera that is given has a lens and the topic's name says that its pictures have none any more.
pub(crate) fn check_lens_against_topic(camera: &Camera, topic: &str) {
    let has_lens = matches!(
        camera.view(),
        View::Calibrated {
            distortion: Distortion::BrownConrady { .. } | Distortion::KannalaBrandt { .. },
            ..
        }
    );
    if has_lens && is_rectified(topic) {
        output::message(&format!(
            "{topic}: rectified pictures by their name, and the camera that is given has a lens, which is taken out once more; leave \
             --camera out, or give the camera of the rectified pictures"
        ));
    }
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

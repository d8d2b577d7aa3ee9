//! What frames of a run are put through the method again with.

use anyhow::Result;
use fingerpost::Config;
use fingerpost_geometry::Camera;

use super::run_files::RunFiles;
use crate::picture_scaling::PictureScaling;

/// The run's settings and camera.
#[derive(Debug, Clone)]
pub(super) struct Method {
    pub(super) config: Config,
    /// That of the drive's pictures.
    camera: Camera,
    /// Width of the pictures as the method got them, where it differs, pixels.
    width: Option<usize>,
}

impl Method {
    /// That of a run, or what it lacks.
    pub(super) fn of(run: &RunFiles, camera: Option<&Camera>) -> Result<Self, &'static str> {
        let config = run.config_toml.as_deref().and_then(|text| Config::from_toml(text).ok());
        let config = config.ok_or("the run needs a config.toml of this version of the program")?;
        let camera = camera.ok_or("give the calibration with --camera")?.clone();
        let sampling = run.summary.as_ref().and_then(|summary| summary.sampling);
        Ok(Self { config, camera, width: sampling.map(|sampling| sampling.picture_px[0] as usize) })
    }

    /// What makes the drive's pictures those of [`Self::scaled_camera`], where they come larger.
    pub(super) fn scaling(&self) -> Result<Option<PictureScaling>> {
        Ok(self.width.map(|width| PictureScaling::to_width(&self.camera, width)).transpose()?.flatten())
    }

    /// The camera of the pictures as the method gets them.
    pub(super) fn scaled_camera(&self, scaling: Option<&PictureScaling>) -> Camera {
        scaling.map_or(&self.camera, PictureScaling::camera).clone()
    }
}

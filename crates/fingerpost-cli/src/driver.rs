//! The method and its recorder together: one frame in, its results in the run folder.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use fingerpost::ground_view::GroundViewError;
use fingerpost::{Config, Pipeline, PipelineError, Sensors};
use fingerpost_geometry::Camera;
use fingerpost_map::Route;
use fingerpost_vision::picture::RgbImage;

use crate::output;
use crate::record::{FrameTime, feature_identities};
use crate::recorder::Recorder;
use crate::stage_clock::{FrameClock, stage_name};

/// What a run is about.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RunSetting<'a> {
    /// Configuration in force.
    pub(crate) config: &'a Config,
    /// The camera.
    pub(crate) camera: &'a Camera,
    /// The route; without one nothing is followed.
    pub(crate) route: Option<&'a Route>,
    /// Distance along the route at the first frame, metres.
    pub(crate) start_m: Option<f64>,
    /// The run folder.
    pub(crate) out: &'a Path,
}

/// A run in hand.
pub(crate) struct Driver {
    pipeline: Pipeline,
    camera_size: (usize, usize),
    /// The results.
    pub(crate) recorder: Recorder,
}

impl Driver {
    /// Sets the method up and makes the run folder, replacing earlier results in it.
    pub(crate) fn new(setting: RunSetting<'_>) -> Result<Self> {
        let RunSetting { config, camera, route, start_m, out } = setting;
        let pipeline = Pipeline::new(config, camera, route, start_m)?;
        let config_toml = toml::to_string(config).context("the configuration cannot be written as TOML")?;
        let recorder = Recorder::create(out, &config_toml, feature_identities(pipeline.tracker().stops()))?;
        Ok(Self { pipeline, camera_size: (camera.width(), camera.height()), recorder })
    }

    /// Takes one frame in.
    pub(crate) fn step(&mut self, time: FrameTime, picture: &RgbImage, sensors: Sensors) -> Result<()> {
        let mut clock = FrameClock::start();
        let done = self.pipeline.step(picture, sensors, &mut |stage| clock.finished(stage_name(stage)));
        match done {
            Ok((output, _)) => self.recorder.add(time, &output, &clock.stage_ms),
            Err(PipelineError::GroundView(GroundViewError::Frame(_))) => self.misfit(time, picture),
            Err(cause) => self.pass_over(time, &cause),
        }
    }

    /// Records a frame that cannot be used.
    pub(crate) fn pass_over(&mut self, time: FrameTime, cause: &dyn std::error::Error) -> Result<()> {
        output::message(&format!("frame {} is passed over: {cause}", time.frame));
        self.recorder.add_broken(time, cause.to_string())
    }

    /// A picture of another size than the calibration's: the first one shows a calibration of another camera, which no
    /// frame will fit; a later one is a broken frame.
    fn misfit(&mut self, time: FrameTime, picture: &RgbImage) -> Result<()> {
        let (width, height) = self.camera_size;
        let cause = anyhow!(
            "the picture has {} x {} pixels and the calibration is for {width} x {height}; give the calibration of this \
             camera at this size",
            picture.width(),
            picture.height()
        );
        if self.recorder.nothing_used() {
            return Err(cause.context(format!("frame {}", time.frame)));
        }
        self.pass_over(time, cause.as_ref())
    }
}

//! The method and its recorder together: one frame in, its results in the run folder.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use fingerpost::ground_view::GroundViewError;
use fingerpost::{Config, Pipeline, PipelineError, Sensors};
use fingerpost_geometry::Camera;
use fingerpost_map::Route;
use fingerpost_report::{Scene, Setting, Thresholds};
use fingerpost_vision::picture::RgbImage;
use indicatif::ProgressBar;

use crate::output;
use crate::record::{FrameTime, feature_identities};
use crate::recorder::{Recorder, Subject, Wishes};
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

impl RunSetting<'_> {
    fn subject(&self, pipeline: &Pipeline) -> Result<Subject> {
        Ok(Subject {
            config_toml: toml::to_string(self.config)
                .context("the configuration cannot be written as TOML")?,
            thresholds: Thresholds {
                detect: self.config.track.detect_threshold,
                confirm: self.config.track.confirm_threshold,
            },
            route: self.route.cloned(),
            features: feature_identities(pipeline.tracker().stops()),
        })
    }
}

/// A run in hand.
pub(crate) struct Driver {
    pipeline: Pipeline,
    drawing: Setting,
    /// The results.
    pub(crate) recorder: Recorder,
    bar: ProgressBar,
}

impl Driver {
    /// Sets the method up and makes the run folder, replacing earlier results in it. `bar` goes on with every frame.
    pub(crate) fn new(setting: RunSetting<'_>, wishes: Wishes, bar: ProgressBar) -> Result<Self> {
        let pipeline = Pipeline::new(setting.config, setting.camera, setting.route, setting.start_m)?;
        let recorder = Recorder::create(setting.out, setting.subject(&pipeline)?, wishes)?;
        Ok(Self { drawing: Setting::new(setting.camera, &pipeline), pipeline, recorder, bar })
    }

    /// The results, when there are no more frames.
    pub(crate) fn into_recorder(self) -> Recorder {
        self.bar.finish_and_clear();
        self.recorder
    }

    /// Takes one frame in.
    pub(crate) fn step(&mut self, time: FrameTime, picture: &RgbImage, sensors: Sensors) -> Result<()> {
        self.bar.inc(1);
        let mut clock = FrameClock::start();
        let done = self.pipeline.step(picture, sensors, &mut |stage| clock.finished(stage_name(stage)));
        match done {
            Ok((output, evidence)) => {
                let FrameTime { frame, t_s } = time;
                let (setting, evidence) = (&self.drawing, &evidence);
                let scene = Scene { setting, frame, t_s, picture, output, evidence };
                self.recorder.add(&scene, &clock.stage_ms)
            }
            Err(PipelineError::GroundView(GroundViewError::Frame(_))) => self.misfit(time, picture),
            Err(cause) => self.pass_over(time, &cause),
        }
    }

    /// Records and reports a frame that cannot be used.
    pub(crate) fn pass_over(&mut self, time: FrameTime, cause: &dyn std::error::Error) -> Result<()> {
        self.bar.suspend(|| output::message(&format!("frame {} is passed over: {cause}", time.frame)));
        self.recorder.add_broken(time, cause.to_string())
    }

    /// A picture of another size than the calibration's: the first one shows a calibration of another camera, which no
    /// frame will fit; a later one is a broken frame.
    fn misfit(&mut self, time: FrameTime, picture: &RgbImage) -> Result<()> {
        let (width, height) = (self.drawing.camera.width(), self.drawing.camera.height());
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

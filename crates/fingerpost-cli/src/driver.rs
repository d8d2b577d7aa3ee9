//! The method on one frame after the other, with all that needs its evidence: what comes out can be written elsewhere.

use std::collections::BTreeMap;

use anyhow::{Result, anyhow};
use fingerpost::advice::Advice;
use fingerpost::fix::NearPlace;
use fingerpost::ground_view::GroundViewError;
use fingerpost::pipeline::Parts;
use fingerpost::road_surface::SurfaceFile;
use fingerpost::track::State;
use fingerpost::{Config, Pipeline, PipelineError, Sensors};
use fingerpost_eval::FeatureIdentity;
use fingerpost_format::FrameRecord;
use fingerpost_geometry::Camera;
use fingerpost_map::{RoadGraph, Route};
use fingerpost_record::recording::{FrameRecorder, RecordedFrame};
use fingerpost_record::{FrameTime, feature_identities, frame_record};
use fingerpost_report::{DrawnFrame, KeyFrameChoice, Scene, Setting, Thresholds, compose};
use fingerpost_vision::picture::RgbImage;

use crate::parts::parts;
use crate::picture_order::OutOfOrder;
use crate::picture_scaling::PictureScaling;
use crate::recorder::{Pictures, Subject, Wishes};
use crate::stage_clock::{FrameClock, stage_name};
use crate::version::WRITTEN_BY;

/// What a run is about.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RunSetting<'a> {
    /// Configuration in force.
    pub(crate) config: &'a Config,
    /// The camera, for the pictures as the method gets them.
    pub(crate) camera: &'a Camera,
    /// The route; without one nothing is followed.
    pub(crate) route: Option<&'a Route>,
    /// Distance along the route at the first frame, metres.
    pub(crate) start_m: Option<f64>,
    /// How the pictures hang together.
    pub(crate) sequence: Sequence,
}

impl RunSetting<'_> {
    /// The method before its first frame.
    pub(crate) fn pipeline(&self) -> Result<Pipeline> {
        self.pipeline_of(parts(self.config)?)
    }

    /// The same with these stages in place of the configuration's.
    fn pipeline_of(&self, parts: Parts) -> Result<Pipeline> {
        let Config { road_surface, motion, lanes, advice, .. } = self.config;
        log::debug!(
            "road detector {}, motion {:?}, lanes {:?}, controller {}",
            road_surface.detector.name(),
            motion.estimator,
            lanes.finder,
            advice.controller.name()
        );
        Ok(Pipeline::with_parts(self.config, self.camera, self.route, self.start_m, parts)?)
    }
}

/// How the pictures of an input hang together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Sequence {
    /// They are a drive.
    #[default]
    Drive,
    /// Each was taken by itself.
    Stills,
}

/// What came of a frame.
#[derive(Debug)]
pub(crate) struct FrameResult {
    /// Which frame.
    pub(crate) time: FrameTime,
    /// Its record and pictures, or why it could not be used.
    pub(crate) outcome: Result<Seen, String>,
    /// Wall time of the work outside the method, milliseconds.
    pub(crate) stage_ms: BTreeMap<String, f64>,
}

/// What is kept of a frame that was processed.
#[derive(Debug)]
pub(crate) struct Seen {
    /// The line of `frames.jsonl`.
    pub(crate) record: FrameRecord,
    /// Its pictures for the report, where it is one of the key frames.
    pub(crate) key_frame: Option<DrawnFrame>,
    /// All panels in one picture, where that is wanted.
    pub(crate) annotated: Option<RgbImage>,
    /// Its messages, where the run is recorded.
    pub(crate) recorded: Option<RecordedFrame>,
}

/// The method with what the results need of it.
pub(crate) struct Driver {
    pipeline: Pipeline,
    sequence: Sequence,
    /// What makes the pictures those of the camera, where they come larger.
    scaling: Option<PictureScaling>,
    drawing: Setting,
    features: Vec<FeatureIdentity>,
    /// None where no frame is drawn for the report.
    key_frames: Option<KeyFrameChoice>,
    pictures: Pictures,
    video: bool,
    /// None where the run is not recorded.
    frame_recorder: Option<FrameRecorder>,
    frames_used: u64,
    /// Time of the last frame that was used, seconds.
    last_t_s: Option<f64>,
    advised: (Advice, State),
}

impl Driver {
    /// Sets the method up for a run of about `frames` frames, where that is known.
    pub(crate) fn new(setting: RunSetting<'_>, wishes: &Wishes, frames: Option<u64>) -> Result<Self> {
        Self::with_parts(setting, wishes, frames, parts(setting.config)?)
    }

    /// The same with these stages in place of the configuration's.
    pub(crate) fn with_parts(
        setting: RunSetting<'_>,
        wishes: &Wishes,
        frames: Option<u64>,
        parts: Parts,
    ) -> Result<Self> {
        let pipeline = setting.pipeline_of(parts)?;
        Ok(Self {
            drawing: Setting::new(setting.camera, &pipeline),
            sequence: setting.sequence,
            scaling: None,
            features: feature_identities(pipeline.tracker().stops()),
            pipeline,
            key_frames: Some(KeyFrameChoice::new(frames)),
            pictures: wishes.pictures.clone(),
            video: wishes.video.is_some(),
            frame_recorder: wishes.messages().then(FrameRecorder::default),
            frames_used: 0,
            last_t_s: None,
            advised: (Advice::default(), State::default()),
        })
    }

    /// Takes pictures that are to be made smaller first; the setting's camera must be that of the smaller ones.
    pub(crate) fn scaling_with(self, scaling: Option<PictureScaling>) -> Self {
        Self { scaling, ..self }
    }

    /// Draws no frame for the report: that takes as long as several frames.
    pub(crate) fn without_key_frames(self) -> Self {
        Self { key_frames: None, ..self }
    }

    /// Says in every frame where the vehicle is on a map, known to be near a place or anywhere.
    pub(crate) fn locating_on(mut self, graph: &RoadGraph, near: Option<NearPlace>) -> Self {
        self.pipeline.locate_on(graph, near);
        self
    }

    /// Width and height of the pictures that are taken, pixels.
    pub(crate) fn input_px(&self) -> (usize, usize) {
        let camera = &self.drawing.camera;
        self.scaling.as_ref().map_or((camera.width(), camera.height()), PictureScaling::input_px)
    }

    /// What the results say about the run as a whole.
    pub(crate) fn subject(&self, setting: RunSetting<'_>) -> Result<Subject> {
        Ok(Subject {
            config_toml: format!("{WRITTEN_BY}{}", setting.config.to_toml()?),
            rules: self.pipeline.advice_rules().map(str::to_owned).collect(),
            thresholds: Thresholds {
                detect: setting.config.track.detect_present,
                lost: setting.config.track.lost_present,
            },
            route: setting.route.cloned(),
            roads: None,
            features: self.features.clone(),
            picture_px: <[usize; 2]>::from(self.input_px()).map(|side| side as u32),
            sampling: None,
            made_from: Vec::new(),
            remarks: Vec::new(),
        })
    }

    /// Takes over surfaces known from earlier drives.
    pub(crate) fn know(&mut self, surfaces: &SurfaceFile) -> Result<()> {
        Ok(self.pipeline.road_detector_mut().know(surfaces)?)
    }

    /// The surfaces that are known by now.
    pub(crate) fn known_surfaces(&self) -> Option<SurfaceFile> {
        self.pipeline.road_detector().known_surfaces()
    }

    /// What is advised after the last frame, and what state the method is in.
    pub(crate) fn advice(&self) -> (Advice, State) {
        self.advised.clone()
    }

    /// What the route's features are called.
    pub(crate) fn features(&self) -> &[FeatureIdentity] {
        &self.features
    }

    /// Takes one frame in; the time since the frame before is known here.
    pub(crate) fn step(
        &mut self,
        time: FrameTime,
        picture: &RgbImage,
        sensors: Sensors,
    ) -> Result<FrameResult> {
        self.step_showing(time, picture, sensors, &mut |_| {})
    }

    /// The same; `at_once` is shown what the method makes of the frame, before anything else is made of that.
    pub(crate) fn step_showing(
        &mut self,
        time: FrameTime,
        picture: &RgbImage,
        sensors: Sensors,
        at_once: &mut dyn FnMut(&Scene<'_>),
    ) -> Result<FrameResult> {
        if self.sequence == Sequence::Stills {
            self.begin_anew()?;
        }
        if let Some(cause) = OutOfOrder::of(self.last_t_s, time.t_s) {
            return Ok(pass_over(time, cause));
        }
        let mut clock = FrameClock::start();
        if let Some(scaling) = &mut self.scaling {
            if !scaling.shrink(picture) {
                return self.misfit(time, picture);
            }
            clock.finished("scale");
        }
        let input = picture;
        let picture = self.scaling.as_ref().map_or(input, PictureScaling::picture);
        // Times that step back say nothing of how long a frame lasted.
        let dt_s = self.last_t_s.map(|last_s| time.t_s - last_s).filter(|dt_s| *dt_s >= 0.0);
        let sensors = Sensors { dt_s, ..sensors };
        let done = self.pipeline.step(picture, sensors, &mut |stage| clock.finished(stage_name(stage)));
        let (output, evidence) = match done {
            Ok(done) => done,
            Err(PipelineError::GroundView(GroundViewError::Frame(_))) => return self.misfit(time, input),
            Err(cause) => return Ok(pass_over(time, &cause)),
        };
        self.frames_used += 1;
        self.last_t_s = Some(time.t_s);
        self.advised.0.clone_from(&output.advice);
        self.advised.1 = output.track.state;
        let FrameTime { frame, t_s } = time;
        let scene = Scene { setting: &self.drawing, frame, t_s, picture, output, evidence: &evidence };
        at_once(&scene);
        let stage_ms = clock.stage_ms;
        let mut record = frame_record(time, output, &evidence, &self.features, stage_ms);
        if let Some(scaling) = &self.scaling {
            scaling.in_input_pixels(&mut record);
        }
        let mut clock = FrameClock::start();
        let key_frames = self.key_frames.as_mut();
        let key_frame = key_frames.and_then(|choice| choice.consider(frame, output, evidence.track));
        let key_frame = key_frame.map(|chosen| chosen.draw(&scene));
        let annotated = (self.video || self.pictures.want(frame)).then(|| compose(&scene));
        clock.finished("drawing");
        let recorded = self.frame_recorder.as_mut().map(|recorder| recorder.record(&scene));
        clock.finished("recording");
        let seen = Seen { record, key_frame, annotated, recorded };
        Ok(FrameResult { time, outcome: Ok(seen), stage_ms: clock.stage_ms })
    }

    /// Puts the method before its first frame.
    fn begin_anew(&mut self) -> Result<()> {
        let config = self.pipeline.config().clone();
        let camera = &self.drawing.camera;
        let setting =
            RunSetting { config: &config, camera, route: None, start_m: None, sequence: self.sequence };
        self.pipeline = setting.pipeline()?;
        self.last_t_s = None;
        Ok(())
    }

    /// A picture of another size than the calibration's: the first one shows a calibration of another camera, which no
    /// frame will fit; a later one is a broken frame.
    fn misfit(&self, time: FrameTime, picture: &RgbImage) -> Result<FrameResult> {
        let cause = self.wrong_size(picture);
        if self.frames_used == 0 {
            return Err(cause.context(format!("frame {}", time.frame)));
        }
        Ok(pass_over(time, cause))
    }

    /// What is wrong with a picture whose size is not [`Driver::input_px`].
    pub(crate) fn wrong_size(&self, picture: &RgbImage) -> anyhow::Error {
        let (width, height) = self.input_px();
        let exchanged = if (picture.height(), picture.width()) == (width, height) {
            "; width and height are exchanged"
        } else {
            ""
        };
        anyhow!(
            "the picture has {} x {} pixels and the calibration is for {width} x {height}{exchanged}; give the calibration of this \
             camera at this size",
            picture.width(),
            picture.height()
        )
    }
}

/// What comes of a frame that cannot be used.
pub(crate) fn pass_over(time: FrameTime, cause: impl std::fmt::Display) -> FrameResult {
    FrameResult { time, outcome: Err(cause.to_string()), stage_ms: BTreeMap::new() }
}

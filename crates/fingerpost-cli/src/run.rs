//! `fingerpost run`: the method on a recorded or live drive.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use fingerpost::ground_view::GroundViewError;
use fingerpost::{Config, Pipeline, PipelineError, Sensors};
use fingerpost_format::TruthRecord;
use fingerpost_io::{FrameError, FrameSource, SourceOptions, read_camera, read_truth};
use fingerpost_map::Route;
use fingerpost_vision::picture::RgbImage;

use crate::gps::GpsTrack;
use crate::interrupt::Interrupt;
use crate::record::{FrameTime, feature_identities};
use crate::recorder::{Recorder, RunEnd};
use crate::stage_clock::{FrameClock, stage_name};
use crate::{inputs, output};

/// Find and follow the junctions of a route in a drive, and write what was found as a run folder: frames.jsonl,
/// summary.json, config.toml and report.html. Without a route: ground view, road surface and motion alone.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// A folder of pictures, a drive folder of `simulate`, or anything ffmpeg reads: a video file, rtsp://..., /dev/video0.
    #[arg(value_name = "INPUT")]
    input: String,
    /// Calibration of the camera: camera.toml, or the YAML of ROS camera_info or OpenCV.
    #[arg(long, value_name = "FILE")]
    camera: PathBuf,
    /// Route, as written by `fingerpost route`.
    #[arg(long, value_name = "FILE")]
    route: Option<PathBuf>,
    /// Distance along the route at the first frame, metres, where it is known.
    #[arg(long, value_name = "M", requires = "route", allow_hyphen_values = true)]
    start_m: Option<f64>,
    /// Configuration; every key is optional. `fingerpost schema` describes them.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// GPS track with times, .gpx; its first position belongs to the first frame.
    #[arg(long, value_name = "FILE", requires = "route")]
    gps: Option<PathBuf>,
    /// Truth to compare with, truth.jsonl; the method never sees it.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Stop after so many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Frames a second of pictures without times.txt (else 10), or in place of the video's own rate.
    #[arg(long, value_name = "N")]
    fps: Option<f64>,
    /// Folder to write; results of an earlier run in it are replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print what summary.json holds on standard output.
    #[arg(long)]
    json: bool,
}

/// Runs the method.
pub(crate) fn run(args: &RunArgs) -> Result<()> {
    let config = inputs::config(args.config.as_deref())?;
    let camera = read_camera(&args.camera)?;
    let route = args.route.as_deref().map(inputs::route).transpose()?;
    check_start(args.start_m, route.as_ref())?;
    let gps = args.gps.as_deref().map(GpsTrack::read).transpose()?.unwrap_or_default();
    let truth = args.truth.as_deref().map(read_truth).transpose()?;
    let pipeline = Pipeline::new(&config, &camera, route.as_ref(), args.start_m)?;
    let source =
        FrameSource::open(&args.input, &SourceOptions { fps: args.fps, ..SourceOptions::default() })?;
    let recorder =
        Recorder::create(&args.out, &config_text(&config)?, feature_identities(pipeline.tracker().stops()))?;
    let camera_size = (camera.width(), camera.height());
    let drive =
        DriveRun { pipeline, recorder, source, gps, camera_size, most: args.frames.unwrap_or(u64::MAX) };
    drive.go(args, truth.as_deref())
}

/// The effective configuration as the run folder holds it.
pub(crate) fn config_text(config: &Config) -> Result<String> {
    toml::to_string(config).context("the configuration cannot be written as TOML")
}

fn check_start(start_m: Option<f64>, route: Option<&Route>) -> Result<()> {
    let Some((start_m, route)) = start_m.zip(route) else {
        return Ok(());
    };
    let length_m = route.polyline()?.length_m();
    if (0.0..=length_m).contains(&start_m) {
        Ok(())
    } else {
        bail!(
            "--start-m {start_m} is not on the route, which is {length_m:.0} m long; give 0 to {length_m:.0}"
        )
    }
}

/// A run in hand.
struct DriveRun {
    pipeline: Pipeline,
    recorder: Recorder,
    source: FrameSource,
    gps: GpsTrack,
    camera_size: (usize, usize),
    most: u64,
}

impl DriveRun {
    fn go(mut self, args: &RunArgs, truth: Option<&[TruthRecord]>) -> Result<()> {
        let interrupt = Interrupt::listen()?;
        let length = self.source.length().map(|length| length.min(self.most)).or(args.frames);
        let bar = output::progress(length, "frames");
        let mut failure = None;
        let mut clock = FrameClock::start();
        while !interrupt.wanted() && (self.recorder.frames() as u64) < self.most {
            let Some(frame) = self.source.next() else { break };
            clock.finished("decode");
            let time = FrameTime { frame: frame.index, t_s: frame.t_s };
            let done = match frame.picture {
                Ok(picture) => self.step(time, picture),
                Err(FrameError::Picture(cause)) => self.pass_over(time, &cause),
                Err(cause @ FrameError::Video(_)) => Err(cause.into()),
            };
            if let Err(error) = done {
                failure = Some(error);
                break;
            }
            self.recorder.add_times(&clock.stage_ms);
            bar.inc(1);
            clock = FrameClock::start();
        }
        bar.finish_and_clear();
        let (frames, unused) = (self.recorder.frames(), self.recorder.nothing_used());
        let stopped = interrupt.wanted() || failure.is_some();
        let summary =
            self.recorder.finish(if stopped { RunEnd::Interrupted } else { RunEnd::Complete }, truth);
        if let Some(failure) = failure {
            return Err(failure);
        }
        if interrupt.wanted() {
            bail!("interrupted after {frames} frames; results so far are in {}", args.out.display());
        }
        if unused {
            bail!("none of the {frames} frames of {} could be used; the messages above say why", args.input);
        }
        let summary = summary?;
        if args.json { output::print_json(&summary) } else { Ok(()) }
    }

    fn step(&mut self, time: FrameTime, picture: RgbImage) -> Result<()> {
        let mut clock = FrameClock::start();
        let sensors = Sensors { gps: self.gps.at(time.t_s) };
        match self.pipeline.step(&picture, sensors, &mut |stage| clock.finished(stage_name(stage))) {
            Ok((output, _)) => self.recorder.add(time, &output, &clock.stage_ms)?,
            Err(PipelineError::GroundView(GroundViewError::Frame(_))) => self.misfit(time, &picture)?,
            Err(cause) => self.pass_over(time, &cause)?,
        }
        self.source.recycle(picture);
        Ok(())
    }

    /// A picture of another size than the calibration's: the first one shows a calibration of another camera, which no
    /// frame will fit; a later one is a broken frame.
    fn misfit(&mut self, time: FrameTime, picture: &RgbImage) -> Result<()> {
        let cause = anyhow!(
            "the picture has {} x {} pixels and the calibration is for {} x {}; give the calibration of this camera at \
             this size",
            picture.width(),
            picture.height(),
            self.camera_size.0,
            self.camera_size.1
        );
        if self.recorder.nothing_used() {
            return Err(cause.context(format!("frame {}", time.frame)));
        }
        self.pass_over(time, cause.as_ref())
    }

    fn pass_over(&mut self, time: FrameTime, cause: &dyn std::error::Error) -> Result<()> {
        output::message(&format!("frame {} is passed over: {cause}", time.frame));
        self.recorder.add_broken(time, cause.to_string())
    }
}

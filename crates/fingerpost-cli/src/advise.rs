//! `fingerpost advise`: steering angle and speed, frame by frame, for any vehicle or simulator.

use std::cell::RefCell;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use fingerpost::vehicle_signals::VehicleSamples;
use fingerpost::{Pipeline, Sensors};
use fingerpost_eval::FeatureIdentity;
use fingerpost_format::{
    AdviceRecord, FrameHeader, FrameRecord, LinesError, SilenceRecord, ToJson, TrackState, to_json_line,
};
use fingerpost_io::{FedFrame, standard_feed};
use fingerpost_map::LatLon;
use fingerpost_record::{DIGITS, FrameTime, broken_record, feature_identities, frame_record, rounded};
use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::arguments::{InputLimit, Place, number};
use crate::driver::{RunSetting, Sequence};
use crate::examples::examples;
use crate::picture_order::OutOfOrder;
use crate::stage_clock::{FrameClock, stage_name};
use crate::watchdog::{Watchdog, WatchdogArgs};
use crate::{inputs, output, start_check};

/// Advise a vehicle or simulator frame by frame. Standard input: for each frame one line of JSON, {"t_s", "width", "height",
/// "speed_mps"?, "yaw_rate_rps"?, "lat"?, "lon"?}, then width x height x 3 bytes, red, green and blue, row by row. Standard output: for
/// each frame its line of frames.jsonl, with "advice": {"steer_rad", "speed_mps", "controller", "line", "because"}, before the next
/// is read. A frame that cannot be used is answered by a line with "error", and the advice to slow down. When no new picture comes, a
/// line without "frame", which answers none, says stop (--watchdog-s): {"silent_s", "advice"}.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "advise --camera camera.toml --route route.geojson --start-m 12",
    "advise --camera camera.toml --route route.geojson --config fingerpost.toml --map town.osm.pbf"
))]
pub(crate) struct AdviseArgs {
    /// Calibration of the camera: camera.toml, or the YAML of ROS camera_info or OpenCV.
    #[arg(long, value_name = "FILE")]
    camera: PathBuf,
    /// Route, as written by `fingerpost route`.
    #[arg(long, value_name = "FILE")]
    route: PathBuf,
    /// Distance along the route at the first frame, metres, where it is known; -1e6 to 1e6.
    #[arg(long, value_name = "M", allow_hyphen_values = true,
          value_parser = number(-1e6, 1e6, "place on a route", "metres"))]
    start_m: Option<f64>,
    /// Configuration; every key is optional. `fingerpost schema` describes them; tables "vehicle" and "advice" are about driving.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// OpenStreetMap data of the area, .osm (XML) or .osm.pbf: every frame then says where the vehicle is on its roads.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Where the drive begins to within some 30 m, degrees; without it the vehicle may be on any road of the map.
    #[arg(long, value_name = "LAT,LON", requires = "map", allow_hyphen_values = true)]
    near: Option<Place>,
    #[command(flatten)]
    watchdog: WatchdogArgs,
    #[command(flatten)]
    limit: InputLimit,
}

/// A line that nobody gets.
#[derive(Debug, Error)]
enum NotSaid {
    #[error("the answer cannot be written as JSON")]
    Json(#[source] LinesError),
    #[error("standard output cannot be written; check who reads it")]
    Output(#[source] io::Error),
}

/// Time between frames where none is known, seconds.
const USUAL_DT_S: f64 = 0.1;

/// Answers frame after frame.
pub(crate) fn advise(args: &AdviseArgs) -> Result<()> {
    let config = inputs::config_of_drive(args.config.as_deref())?;
    let camera = inputs::camera(&args.camera)?;
    let route = inputs::route(&args.route)?;
    let setting = RunSetting {
        config: &config,
        camera: &camera,
        route: Some(&route),
        start_m: args.start_m,
        sequence: Sequence::Drive,
    };
    let mut pipeline = setting.pipeline()?;
    if let Some(map) = &args.map {
        let graph = inputs::road_graph(map, args.limit)?;
        pipeline.locate_on(&graph, start_check::near_place(&graph, args.near)?);
    }
    let adviser = RefCell::new(Adviser {
        features: feature_identities(pipeline.tracker().stops()),
        brakes_mps2: config.advice.deceleration_mps2,
        pipeline,
        frames: 0,
        first_t_s: None,
        last_t_s: None,
        last: None,
        watchdog: Watchdog::new(args.watchdog),
    });
    let meanwhile = || match adviser.borrow_mut().stop_in_silence() {
        Some(stop) => say(&stop).map_err(io::Error::other),
        None => Ok(()),
    };
    let feed = standard_feed([camera.width(), camera.height()], meanwhile);
    let mut feed = feed.context("standard input cannot be read")?;
    loop {
        let frame = feed.next_frame().map_err(no_frame)?;
        let came = Instant::now();
        let mut adviser = adviser.borrow_mut();
        let record = match frame {
            FedFrame::Good(header, picture) => adviser.answer(&header, picture),
            FedFrame::Bad(cause) => adviser.pass_over(&cause),
            FedFrame::End => return Ok(()),
        };
        say(record)?;
        if let Some(taken_s) = record.error.is_none().then_some(record.t_s) {
            adviser.watchdog.restart(came, taken_s, Instant::now());
        }
    }
}

/// Writes a line.
fn say(record: &impl ToJson) -> Result<(), NotSaid> {
    let line = to_json_line(record).map_err(NotSaid::Json)?;
    let mut out = io::stdout().lock();
    out.write_all(line.as_bytes()).and_then(|()| out.flush()).map_err(NotSaid::Output)
}

/// Why there is no frame.
fn no_frame(cause: io::Error) -> anyhow::Error {
    match cause.downcast::<NotSaid>() {
        Ok(while_waiting) => while_waiting.into(),
        Err(cause) => anyhow::Error::new(cause)
            .context("standard input gives no frame; close it to end, or allow more with --timeout-s"),
    }
}

/// The method with what its answers need.
struct Adviser {
    pipeline: Pipeline,
    features: Vec<FeatureIdentity>,
    brakes_mps2: f64,
    /// Frames answered.
    frames: u64,
    /// Time of the first frame, as it was given, seconds.
    first_t_s: Option<f64>,
    /// Time of the last frame that was used, and how long it lasted, seconds.
    last_t_s: Option<(f64, f64)>,
    /// The answer before.
    last: Option<FrameRecord>,
    watchdog: Watchdog,
}

impl Adviser {
    fn time(&mut self, t_s: f64) -> FrameTime {
        let time = FrameTime { frame: self.frames, t_s: t_s - *self.first_t_s.get_or_insert(t_s) };
        self.frames += 1;
        time
    }

    /// The answer to a frame.
    fn answer(&mut self, header: &FrameHeader, picture: &RgbImage) -> &FrameRecord {
        let taken_s = header.t_s - self.first_t_s.unwrap_or(header.t_s);
        if let Some(cause) = OutOfOrder::of(self.last_t_s.map(|(last_s, _)| last_s), taken_s) {
            return self.pass_over(&cause);
        }
        let time = self.time(header.t_s);
        // Times that step back say nothing of how long a frame lasted.
        let dt_s = self.last_t_s.map(|(last_s, _)| time.t_s - last_s).filter(|dt_s| *dt_s >= 0.0);
        let sensors = Sensors {
            gps: header.lat_lon_deg.map(|[lat_deg, lon_deg]| LatLon { lat_deg, lon_deg }),
            signals: VehicleSamples::of_now(header.speed_mps, header.yaw_rate_rps),
            dt_s,
        };
        let mut clock = FrameClock::start();
        let done = self.pipeline.step(picture, sensors, &mut |stage| clock.finished(stage_name(stage)));
        let record = match done {
            Ok((output, evidence)) => {
                Ok(frame_record(time, output, &evidence, &self.features, clock.stage_ms))
            }
            Err(cause) => Err(cause.to_string()),
        };
        self.last_t_s = Some((time.t_s, dt_s.unwrap_or(USUAL_DT_S)));
        let record = record.unwrap_or_else(|cause| self.broken(time, cause));
        self.last.insert(record)
    }

    /// The answer to a frame that cannot be used.
    fn pass_over(&mut self, cause: &dyn std::error::Error) -> &FrameRecord {
        let last_s = self.last_t_s.map_or(0.0, |(last_s, _)| last_s);
        let time = FrameTime { frame: self.frames, t_s: last_s };
        self.frames += 1;
        output::message(&format!("frame {} is passed over: {cause}", time.frame));
        let record = self.broken(time, cause.to_string());
        self.last.insert(record)
    }

    /// The record of such a frame: the vehicle is to slow down, wheels as they are, for as long as none can be used.
    fn broken(&self, time: FrameTime, cause: String) -> FrameRecord {
        let dt_s = self.last_t_s.map_or(USUAL_DT_S, |(_, dt_s)| dt_s);
        let before = self.advised();
        let speed_mps = (before.speed_mps - self.brakes_mps2 * dt_s).max(0.0);
        let advice = AdviceRecord {
            speed_mps: rounded(speed_mps, DIGITS),
            rules: Vec::new(),
            stop: Some("broken_frame".to_owned()),
            because: "slow down: the frame could not be used".to_owned(),
            ..before
        };
        let record = broken_record(time, self.last.as_ref(), TrackState::Searching, cause);
        FrameRecord { advice: Some(advice), ..record }
    }

    /// What is said when no picture comes, once a silence; frames that cannot be used then set nothing going again.
    fn stop_in_silence(&mut self) -> Option<SilenceRecord> {
        let silent_s = self.watchdog.silence(Instant::now())?.as_secs_f64();
        self.watchdog.rest();
        let advice = AdviceRecord {
            speed_mps: 0.0,
            rules: Vec::new(),
            stop: Some("no_picture".to_owned()),
            because: format!("stop: no new picture has come for {silent_s:.1} s"),
            ..self.advised()
        };
        if let Some(last) = &mut self.last {
            last.advice = Some(advice.clone());
        }
        Some(SilenceRecord { silent_s: rounded(silent_s, DIGITS), advice })
    }

    /// What was advised last; before the first frame, to stand.
    fn advised(&self) -> AdviceRecord {
        let before = self.last.as_ref().and_then(|record| record.advice.clone());
        let controller = self.pipeline.config().advice.controller.name();
        before
            .unwrap_or_else(|| AdviceRecord { controller: controller.to_owned(), ..AdviceRecord::default() })
    }
}

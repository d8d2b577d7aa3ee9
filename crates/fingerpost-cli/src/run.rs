//! `fingerpost run`: the method on a recorded or live drive.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{ArgGroup, Args};
use fingerpost::road_surface::SurfaceFile;
use fingerpost::{Config, Sensors};
use fingerpost_format::TruthRecord;
use fingerpost_geometry::Camera;
use fingerpost_io::{
    FfmpegPrograms, FolderKind, Frame, FrameDecoder, FrameError, FrameSource, RunFolder, SourceOptions,
    VideoDecoder, VideoError, without_credentials,
};
use fingerpost_map::{LatLon, RoadGraph, Route};
use fingerpost_record::FrameTime;
use fingerpost_record::live::Origin;
use fingerpost_vision::simd::{CodePath, InstructionSet};

use crate::arguments::{FrameRange, InputLimit, InstructionSetName, Place, Threads, number};
use crate::can_signals::CanFeed;
use crate::driver::{Driver, FrameResult, RunSetting, Sequence, pass_over};
use crate::examples::examples;
use crate::frame_choice::FrameChoice;
use crate::gps::GpsFeed;
use crate::interrupt::{Interrupt, Preparation};
use crate::live_gps::is_live;
use crate::overlap::{self, Overlap};
use crate::picture_scaling::PictureScaling;
use crate::recorder::{LiveWish, Pictures, Recorder, RecordingWish, RunEnd, Subject, VideoWish, Wishes};
use crate::stage_clock::milliseconds;
use crate::{camera_size, facts, inputs, made_from, output, output_path, start_check};

/// How well the place that --near gives is known, standard deviation, metres: two in three are within 30 m.
pub(crate) const NEAR_SIGMA_M: f64 = 20.0;

/// Find and follow the junctions of a route in a drive, and write what was found as a run folder: frames.jsonl,
/// summary.json, config.toml and report.html. Without a route: all but that; ground view, road surface,
/// motion, lanes and the road's middle.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("roads").args(["route", "map"]).multiple(true)))]
#[command(before_long_help = examples!(
    "run drive.mp4 --camera camera.toml --route route.geojson --start-m 12 --video --out run",
    "run /dev/video0 --camera camera.toml --map town.osm.pbf --gps gpsd://127.0.0.1:2947 --out run"
))]
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
    /// Distance along the route at the first frame, metres, where it is known; -1e6 to 1e6. Without it the drive may begin anywhere
    /// on the route, and the first features are used up to find out where.
    #[arg(long, value_name = "M", requires = "route", allow_hyphen_values = true,
          value_parser = number(-1e6, 1e6, "place on a route", "metres"))]
    start_m: Option<f64>,
    /// OpenStreetMap data of the area, .osm (XML) or .osm.pbf: every frame then says where the vehicle is on its roads, with a route
    /// or without.
    #[arg(long, value_name = "FILE", conflicts_with = "stills")]
    map: Option<PathBuf>,
    /// Where the drive begins to within some 30 m, degrees; without it the vehicle may be on any road of the map. Without --start-m it
    /// says where on the route it begins as well.
    #[arg(long, value_name = "LAT,LON", requires = "map", allow_hyphen_values = true)]
    near: Option<Place>,
    /// Configuration; every key is optional. `fingerpost schema` describes them.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// GPS positions with times: a GPX track, or a receiver's log, of NMEA sentences or of gpsd (gpspipe -w); its first position belongs
    /// to the first frame, unless its times are those of 1970-01-01, which count from the first frame. Or a receiver as it speaks: a serial device, as /dev/ttyUSB0, whose speed `stty` sets, or a gpsd, as
    /// gpsd://127.0.0.1:2947; each position then belongs to the frame at hand. Of a file, positions of times more than 12 hours from the
    /// rest are passed over and named.
    #[arg(long, value_name = "FILE", requires = "roads")]
    gps: Option<PathBuf>,
    #[command(flatten)]
    limit: InputLimit,
    /// Signals of the vehicle's bus: a log of `candump -L`, plain or .gz, whose first line belongs to the first frame (else
    /// can.time_offset_s of the configuration); or, built with the feature socketcan, a bus, as in socketcan:can0. The
    /// configuration's table "can" says which signals mean what.
    #[arg(long, value_name = "FILE", requires_all = ["dbc", "config"])]
    can: Option<String>,
    /// Database of the vehicle's bus, .dbc.
    #[arg(long, value_name = "FILE", requires = "can")]
    dbc: Option<PathBuf>,
    /// Road surfaces known from earlier drives, JSON; those learned on this one are added at its end. A file that does not
    /// exist yet is made. "combined", the default, names the surface under way by them; "bank", the papers' own, finds road by them.
    #[arg(long, value_name = "FILE")]
    bank: Option<PathBuf>,
    /// Truth to compare with, truth.jsonl; the method never sees it.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    choice: FrameChoice,
    /// Stop after so many frames that are used.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Frames a second, 0.01 to 1000: of pictures without times.txt (else the times in their names, or 10 as a guess), and of a video in
    /// place of its own times. Bare streams (.h264, .hevc, .mjpeg) have none and need it. Where a times.txt, a camera or a
    /// stream times the frames, it is refused.
    #[arg(long, value_name = "N", value_parser = crate::arguments::frame_rate)]
    fps: Option<f64>,
    /// The pictures have nothing to do with each other: each is taken as a drive's first frame.
    #[arg(long, conflicts_with_all = ["route", "bank"])]
    stills: bool,
    /// Write annotated.mp4: every frame with all that was seen in it. Needs ffmpeg.
    #[arg(long)]
    video: bool,
    /// Write the annotated pictures of these frames into the folder pictures.
    #[arg(long, value_name = "FROM-TO")]
    pictures: Option<FrameRange>,
    /// Folder to write: a new or empty one, or one of an earlier run, whose results are replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Threads that decode, ffmpeg's with them; with 1, decoding, method and writing also take turns in one thread instead
    /// of going on at the same time. At most 512; as many as the machine has by default. Results do not depend
    /// on it.
    #[arg(long, value_name = "N")]
    threads: Option<Threads>,
    /// What decodes a video file: FFmpeg's libraries in this process, where they can, or the program ffmpeg. Results do not
    /// depend on it.
    #[cfg(feature = "libav")]
    #[arg(long, value_enum, value_name = "NAME", default_value = "libraries")]
    decoder: DecoderName,
    /// Instructions of the processor that are used at the most, to compare speeds; the best it has by default. Results do
    /// not depend on it.
    #[arg(long, value_name = "NAME")]
    instruction_set: Option<InstructionSetName>,
    /// Share of the frames, percent, that may be broken, damaged (in part made up by the decoder) or missing where a video breaks
    /// off, in a run that ends well; with more the results are written and the exit code is 1. 10 by default: a camera that loses one frame in ten
    /// is faulty.
    #[arg(long, value_name = "PERCENT", default_value_t = 10, value_parser = clap::value_parser!(u8).range(0..=100))]
    max_broken_pct: u8,
    /// Do not write run.mcap, the recording of all that was seen for Foxglove and Rerun.
    #[arg(long)]
    no_recording: bool,
    /// Let viewers connect while the drive is run, on the loopback address: Foxglove (Open connection, Foxglove WebSocket). They get the
    /// messages of run.mcap.
    #[arg(long, value_enum, value_name = "VIEWER")]
    serve: Option<Viewer>,
    /// Port that viewers connect to; 0 takes any that is free, which is then said.
    #[arg(long, value_name = "PORT", default_value_t = 8765, requires = "serve")]
    serve_port: u16,
    /// A site whose pages may connect, as browsers name it: `https://viewer.example:8443`; may be given several times. Programs always may, and
    /// pages of `https://app.foxglove.dev`, of Foxglove's program for the desktop and of this machine (localhost).
    #[arg(long, value_name = "ORIGIN", requires = "serve")]
    serve_origin: Vec<Origin>,
    /// Print what summary.json holds on standard output.
    #[arg(long)]
    json: bool,
}

/// Who may connect while a drive is run.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Viewer {
    /// Foxglove, by its WebSocket protocol.
    Foxglove,
}

/// What decodes videos.
#[cfg(feature = "libav")]
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum DecoderName {
    /// FFmpeg's libraries.
    Libraries,
    /// The program ffmpeg.
    Ffmpeg,
}

impl RunArgs {
    #[cfg(feature = "libav")]
    fn decoder(&self) -> VideoDecoder {
        match self.decoder {
            DecoderName::Libraries => VideoDecoder::Libraries,
            DecoderName::Ffmpeg => VideoDecoder::Program,
        }
    }

    #[cfg(not(feature = "libav"))]
    fn decoder(&self) -> VideoDecoder {
        VideoDecoder::default()
    }

    fn threads(&self) -> Option<NonZeroUsize> {
        self.threads.map(|Threads(count)| count)
    }
}

/// Runs the method.
pub(crate) fn run(args: &RunArgs) -> Result<()> {
    check_outputs(args)?;
    let preparation = Preparation::listen()?;
    limit_instruction_set(args.instruction_set)?;
    let mut config = inputs::config_of_drive(args.config.as_deref())?;
    let camera = inputs::camera(&args.camera)?;
    let route = args.route.as_deref().map(inputs::route).transpose()?;
    let gps = args.gps.as_deref().map(|name| GpsFeed::open(name, args.limit)).transpose()?;
    let start_m = args.start_m.or_else(|| {
        let Place(near) = args.near?;
        let start_m = start_check::place_on_route(route.as_ref()?, near, NEAR_SIGMA_M)?;
        config.route_progress.start_sigma_m = NEAR_SIGMA_M;
        Some(start_m)
    });
    if route.is_some() {
        let start = start_m.map_or("anywhere".to_owned(), |start_m| format!("at {start_m:.1} m"));
        log::info!("the drive begins {start} on the route");
        if args.near.is_some() && start_m.is_none() {
            output::message("--near lies beside the route, so the drive may begin anywhere on it");
        }
    }
    let remarks = check_start(&config, start_m, route.as_ref(), gps.as_ref())?;
    let can = args.can.as_deref().zip(args.dbc.as_deref());
    let can = can.map(|(can, dbc)| CanFeed::open(can, dbc, &config.can)).transpose()?;
    let truth = args.truth.as_deref().map(inputs::truth).transpose()?;
    // From here on an end that is wanted is one that leaves results.
    let interrupt = preparation.work_begins();
    let programs = FfmpegPrograms { stop: Some(interrupt.shared_flag()), ..inputs::ffmpeg() };
    let options = SourceOptions {
        fps: args.fps,
        sampling: args.choice.sampling(),
        live: args.choice.liveness(),
        threads: args.threads(),
        decoder: args.decoder(),
        programs: programs.clone(),
    };
    let mut source = inputs::frames(&args.input, &options)?;
    let camera = match source.picture_size() {
        Some(size) => camera_size::of_pictures(camera, size, &args.camera.display().to_string())?,
        None => camera,
    };
    let scaling = args.choice.width().map(|width| PictureScaling::to_width(&camera, width));
    let scaling = scaling.transpose()?.flatten();
    let camera = scaling.as_ref().map_or(&camera, PictureScaling::camera).clone();
    say_what_is_used(args, &source, &camera);
    let setting = RunSetting {
        config: &config,
        camera: &camera,
        route: route.as_ref(),
        start_m,
        sequence: if args.stills { Sequence::Stills } else { Sequence::Drive },
    };
    let wishes = Wishes {
        title: without_credentials(&args.input),
        pictures: args.pictures.clone().map_or(Pictures::None, Pictures::Frames),
        video: args.video.then(|| VideoWish { fps: source.fps(), programs }),
        recording: if args.no_recording { RecordingWish::None } else { RecordingWish::Mcap },
        live: args
            .serve
            .map(|Viewer::Foxglove| LiveWish { port: args.serve_port, origins: args.serve_origin.clone() }),
    };
    let most = args.frames.unwrap_or(u64::MAX);
    let frames = source.length().map(|length| length.min(most)).or(args.frames);
    let mut driver = Driver::new(setting, &wishes, frames)?.scaling_with(scaling);
    let mut roads = None;
    if let Some(map) = &args.map {
        let graph = inputs::road_graph(map, args.limit)?;
        let near = start_check::near_place(&graph, args.near)?;
        let positions: Vec<LatLon> = gps.iter().flat_map(GpsFeed::positions).collect();
        start_check::check_on_map(&graph, &positions)?;
        driver = driver.locating_on(&graph, near);
        roads = Some(graph);
    }
    if let Some(bank) = &args.bank {
        learn_from(&mut driver, bank)?;
    }
    let bar = output::progress(frames, "frames");
    let used_px = [camera.width(), camera.height()].map(|side| side as u32);
    let made_from = made_from(args, &camera, route.as_ref(), roads.as_ref());
    let sampling = args.choice.record(used_px);
    let said = remarks.clone();
    let subject = Subject { roads, sampling, made_from, remarks, ..driver.subject(setting)? };
    let recorder = Recorder::create(RunFolder::create(&args.out)?, subject, wishes, bar)?;
    let drive = RecordedDrive {
        driver,
        source,
        gps,
        can,
        left: most,
        interrupt,
        damaged: 0,
        broke_off: None,
        gave_out: None,
        said,
    };
    drive.run(recorder, args, truth.as_deref())
}

/// What the run is made from, as its report says it.
fn made_from(
    args: &RunArgs,
    camera: &Camera,
    route: Option<&Route>,
    roads: Option<&RoadGraph>,
) -> Vec<(&'static str, String)> {
    let mut inputs = vec![
        ("command", made_from::command_line(std::env::args_os())),
        ("camera", made_from::file(&args.camera, &facts::of_camera(camera))),
    ];
    let map = args.map.as_deref().zip(roads);
    inputs.extend(map.map(|(path, roads)| ("map", made_from::file(path, &facts::of_roads(roads)))));
    let route = args.route.as_deref().zip(route);
    inputs.extend(route.map(|(path, route)| ("route", made_from::file(path, &facts::of_route(route)))));
    inputs
}

/// Keeps the kernels to an instruction set that this processor has.
fn limit_instruction_set(most: Option<InstructionSetName>) -> Result<()> {
    let Some(most) = most else { return Ok(()) };
    let set = InstructionSet::from(most);
    if CodePath::with(set).is_none() {
        bail!("this processor does not have the instruction set {set:?}; leave --instruction-set out");
    }
    CodePath::limit(set);
    Ok(())
}

/// Refuses outputs that would replace an input. The file of known surfaces is both: it is read and brought up to date.
fn check_outputs(args: &RunArgs) -> Result<()> {
    let optional = [&args.route, &args.map, &args.config, &args.dbc, &args.truth].into_iter().flatten();
    let gps = args.gps.iter().filter(|name| !is_live(name)).map(PathBuf::as_path);
    let streams = [Some(args.input.as_str()), args.can.as_deref()].into_iter().flatten().map(Path::new);
    let inputs: Vec<&Path> =
        optional.chain([&args.camera]).map(PathBuf::as_path).chain(gps).chain(streams).collect();
    let bank = args.bank.as_deref();
    bank.map_or(Ok(()), |bank| output_path::check_kept_file(bank, inputs.iter().copied()))?;
    output_path::check_folder(&args.out, FolderKind::Run, inputs.into_iter().chain(bank))
}

/// Gives the method the surfaces of an earlier drive, where there was one.
fn learn_from(driver: &mut Driver, bank: &Path) -> Result<()> {
    if driver.known_surfaces().is_none() {
        bail!(
            "the road detector knows no surfaces to keep; set road_surface.detector to \"bank\" or \"combined\""
        );
    }
    if !bank.exists() {
        return Ok(());
    }
    let text = fingerpost_io::read_text(bank)?;
    let surfaces = SurfaceFile::from_json(&text).with_context(|| {
        format!("{} is no file of known surfaces; give another, or remove it", bank.display())
    })?;
    driver.know(&surfaces).with_context(|| bank.display().to_string())
}

fn write_surfaces(bank: &Path, surfaces: &SurfaceFile) -> Result<()> {
    let text = surfaces.to_json().context("the known surfaces cannot be written as JSON")?;
    Ok(fingerpost_io::write_file(bank, text)?)
}

/// Refuses a start or a GPS track that the route cannot have, and says where the two contradict each other.
fn check_start(
    config: &Config,
    start_m: Option<f64>,
    route: Option<&Route>,
    gps: Option<&GpsFeed>,
) -> Result<Vec<String>> {
    let Some(route) = route else { return Ok(Vec::new()) };
    let positions: Vec<LatLon> = gps.into_iter().flat_map(GpsFeed::positions).collect();
    let contradictions = start_check::check(&config.route_progress, route, start_m, &positions)?;
    contradictions.iter().for_each(|contradiction| output::message(contradiction));
    Ok(contradictions)
}

/// A drive that is run on.
struct RecordedDrive {
    driver: Driver,
    source: FrameSource,
    gps: Option<GpsFeed>,
    can: Option<CanFeed>,
    /// Frames still wanted.
    left: u64,
    interrupt: Interrupt,
    /// Frames that were used although the decoder had to make up parts of them.
    damaged: u64,
    /// Why the input ended before it should have, where it did.
    broke_off: Option<VideoError>,
    /// Why nothing more can be used of what the input still has or may have: it stalls, or goes on in another form.
    gave_out: Option<String>,
    /// Remarks that were said before the first frame.
    said: Vec<String>,
}

/// Frames of a run that are not what the camera saw.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Unusable {
    /// How many: broken ones, damaged ones, and those that are missing behind the place where the input broke off.
    count: u64,
    /// Of so many that there should be.
    of: u64,
}

impl Unusable {
    /// Of `frames` that came, `bad` ones that are broken or damaged, and what is missing of `expected` ones where the input
    /// `broke_off`: one at the least, since something could not be read.
    fn new(frames: u64, bad: u64, broke_off: bool, expected: Option<u64>) -> Self {
        let missing = if broke_off { expected.unwrap_or(0).saturating_sub(frames).max(1) } else { 0 };
        Self { count: bad.saturating_add(missing), of: frames.saturating_add(missing) }
    }

    /// Whether they are more than so many percent.
    fn exceed(self, most_pct: u8) -> bool {
        u128::from(self.count) * 100 > u128::from(self.of) * u128::from(most_pct)
    }
}

impl RecordedDrive {
    fn run(mut self, mut recorder: Recorder, args: &RunArgs, truth: Option<&[TruthRecord]>) -> Result<()> {
        let overlap =
            if args.threads() == Some(NonZeroUsize::MIN) { Overlap::None } else { Overlap::Writing };
        let failure = overlap::each(overlap, self.by_ref(), |result| recorder.add(result)).err();
        let learned = args.bank.as_deref().zip(self.driver.known_surfaces());
        let kept = learned.map_or(Ok(()), |(bank, surfaces)| write_surfaces(bank, &surfaces));
        let interrupted = self.interrupt.wanted();
        let (frames, unused) = (recorder.frames(), recorder.nothing_used());
        let expected =
            self.source.expected_length().map(|length| length.min(args.frames.unwrap_or(u64::MAX)));
        let damaged = self.damaged;
        recorder.note_damaged(damaged);
        let dropped = self.source.dropped();
        recorder.note_dropped(dropped);
        let complaint = self.source.complaint().filter(|_| self.broke_off.is_none());
        let bad = recorder.broken_frames().saturating_add(damaged);
        let unusable = Unusable::new(frames, bad, self.broke_off.is_some(), expected);
        let broke_off = self.broke_off.map(|cause| cause.to_string());
        let too_many = unusable.exceed(args.max_broken_pct);
        let stopped = interrupted || failure.is_some() || (broke_off.is_some() && too_many);
        let end = if stopped { RunEnd::Interrupted } else { RunEnd::Complete };
        let summary = recorder.finish(end, broke_off.clone().or(self.gave_out), truth);
        if let (true, Err(error)) = (stopped || unused || too_many, &summary) {
            output::error(&format!("the results are incomplete: {}", output::cause_chain(error)));
        }
        say_what_was_dropped(&args.input, dropped);
        inputs::say_stamp_faults(&args.input, self.source.stamp_faults());
        if let Some(unused) = self.gps.as_ref().and_then(GpsFeed::unused).filter(|_| frames > 0) {
            output::message(&unused);
        }
        if let Some(failure) = failure {
            return Err(failure.context(format!(
                "the run ended after {frames} frames; results so far are in {}",
                args.out.display()
            )));
        }
        if interrupted {
            bail!("interrupted after {frames} frames; results so far are in {}", args.out.display());
        }
        if unused {
            bail!("none of the {frames} frames of {} could be used; the messages above say why", args.input);
        }
        if too_many {
            let Unusable { count, of } = unusable;
            let because = broke_off.map(|cause| format!(" ({cause})")).unwrap_or_default();
            bail!(
                "{count} of {of} frames of {} are broken, damaged or missing, more than {} %{because}; results so far are in {}; mend the \
                 input, or allow more with --max-broken-pct",
                args.input,
                args.max_broken_pct,
                args.out.display()
            );
        }
        let summary = summary?;
        kept?;
        if let Some(cause) = broke_off {
            output::message(&cause);
        }
        if damaged > 0 {
            output::message(&format!(
                "{damaged} of {frames} frames of {} are damaged, and the decoder made up parts of them; copy or record it again",
                args.input
            ));
        } else if let Some(complaint) = complaint.filter(|_| dropped == 0) {
            output::message(&format!("{} has faults, but all its frames came ({complaint})", args.input));
        }
        output::print_summary(&summary, &self.said, &args.out);
        if args.json { output::print_json(&summary) } else { Ok(()) }
    }

    /// Runs the method on a frame.
    fn result(&mut self, frame: Frame) -> Result<FrameResult> {
        self.damaged += u64::from(frame.damaged);
        let time = FrameTime { frame: frame.index, t_s: frame.t_s };
        let mut result = match frame.picture {
            Ok(picture) => {
                let signals = self.can.as_mut().map(|can| can.at(time.t_s));
                let gps = self.gps.as_mut().and_then(|gps| gps.at(time.t_s));
                let sensors = Sensors { gps, signals, ..Sensors::default() };
                let result = self.driver.step(time, &picture, sensors)?;
                self.source.recycle(picture);
                result
            }
            Err(FrameError::Picture(cause)) => pass_over(time, &cause),
            Err(cause @ FrameError::Video(_)) => {
                self.gave_out = Some(cause.to_string());
                return Err(cause.into());
            }
        };
        result.stage_ms.insert("decode".to_owned(), milliseconds(frame.decoding));
        Ok(result)
    }
}

/// The results of frame after frame.
impl Iterator for RecordedDrive {
    type Item = Result<FrameResult>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.interrupt.wanted() {
            return None;
        }
        self.left = self.left.checked_sub(1)?;
        let frame = self.source.next()?;
        if let Err(FrameError::Video(VideoError::BrokenOff { .. })) = &frame.picture {
            // What came before is a drive; how much is missing decides how the run ends.
            self.broke_off = frame.picture.err().and_then(|cause| match cause {
                FrameError::Video(cause) => Some(cause),
                FrameError::Picture(_) => None,
            });
            return None;
        }
        Some(self.result(frame))
    }
}

/// Says what of the input is used, and with what of the machine.
fn say_what_is_used(args: &RunArgs, source: &FrameSource, camera: &Camera) {
    let length = source
        .length()
        .map_or("a number of frames that it does not say".to_owned(), |length| format!("{length} frames"));
    let decoder = match source.decoder() {
        FrameDecoder::Pictures => "picture by picture",
        FrameDecoder::Libraries => "by FFmpeg's libraries",
        FrameDecoder::Program => "by the program ffmpeg",
    };
    log::info!("{}: {length}, {:.3} a second, decoded {decoder}", args.input, source.fps());
    log::info!("pictures are used at {} x {} pixels", camera.width(), camera.height());
    let threads = args
        .threads()
        .map_or("as many threads as the machine runs".to_owned(), |count| format!("{count} threads"));
    log::info!(
        "decoding takes {threads}; kernels use {:?} instructions",
        CodePath::fastest().instruction_set()
    );
}

/// Says how many frames of a live input were passed over.
fn say_what_was_dropped(input: &str, frames: u64) {
    if frames > 0 {
        output::message(&format!(
            "{frames} frames of {input} came faster than they could be used and were passed over for later ones; fewer pixels \
             (--width) and no --video take less time, and --rate says how many frames are wanted"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_counts_like_what_is_broken() {
        // 200 good ones and damaged bytes behind them: one that nobody promised is missing.
        let unusable = Unusable::new(200, 0, true, None);
        assert_eq!((unusable.count, unusable.of), (1, 201));
        assert!(!unusable.exceed(10) && unusable.exceed(0));
        let halfway = Unusable::new(100, 0, true, Some(200));
        assert!(halfway.exceed(10) && halfway.exceed(49) && !halfway.exceed(50));
        assert!(Unusable::new(200, 159, false, Some(200)).exceed(10));
        assert!(!Unusable::new(0, 0, false, None).exceed(0));
        assert!(Unusable::new(u64::MAX, u64::MAX, true, Some(u64::MAX)).exceed(99));
        // The limit itself is allowed.
        for frames in 1..200 {
            for broken in 0..=frames {
                let share_pct = 100.0 * broken as f64 / frames as f64;
                assert_eq!(Unusable::new(frames, broken, false, None).exceed(10), share_pct > 10.0 + 1e-9);
            }
        }
    }
}

//! `fingerpost ros2`: the method as a node of ROS 2.

mod drive;
mod topics;

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::{ArgGroup, Args};
use fingerpost_geometry::Camera;
use fingerpost_io::{FolderKind, RunFolder};
use fingerpost_map::TangentPlane;
use fingerpost_ros2::RosNode;

use crate::arguments::{InputLimit, Place, number};
use crate::driver::{Driver, RunSetting, Sequence};
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::mount_args::{KnownCamera, MountArgs, PictureKindArgs, check_lens_against_topic};
use crate::overlap;
use crate::recorder::{Pictures, Recorder, RecordingWish, RunEnd, Subject, Wishes};
use crate::run::NEAR_SIGMA_M;
use crate::watchdog::{Watchdog, WatchdogArgs};
use crate::{inputs, output, output_path, start_check};
use drive::RosDrive;
use topics::TopicArgs;

/// How long a picture is waited for before inputs are looked after and Ctrl-C is heeded.
const GLANCE: Duration = Duration::from_millis(50);

/// Run as a node of ROS 2, without ROS: pictures come over DDS, and odometry, paths, steering commands, the followed feature and
/// diagnostics go out. Goes on until Ctrl-C; with --out it then leaves a run folder.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("roads").args(["route", "map"]).multiple(true)))]
#[command(before_long_help = examples!(
    "ros2 --height-m 1.4 --route route.geojson --start-m 12",
    "ros2 --camera camera.toml --image-topic /front/image_raw/compressed --map town.osm.pbf --tf --out run"
))]
pub(crate) struct Ros2Args {
    #[command(flatten)]
    topics: TopicArgs,
    #[command(flatten)]
    mount: MountArgs,
    #[command(flatten)]
    pictures: PictureKindArgs,
    /// Route, as written by `fingerpost route`.
    #[arg(long, value_name = "FILE")]
    route: Option<PathBuf>,
    /// Distance along the route at the first picture, metres, where it is known; -1e6 to 1e6.
    #[arg(long, value_name = "M", requires = "route", allow_hyphen_values = true,
          value_parser = number(-1e6, 1e6, "place on a route", "metres"))]
    start_m: Option<f64>,
    /// OpenStreetMap data of the area, .osm (XML) or .osm.pbf: every picture then says where the vehicle is on its roads.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Where the drive begins to within some 30 m, degrees.
    #[arg(long, value_name = "LAT,LON", requires = "map", allow_hyphen_values = true)]
    near: Option<Place>,
    /// Configuration; every key is optional. `fingerpost schema` describes them.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    watchdog: WatchdogArgs,
    #[command(flatten)]
    limit: InputLimit,
    /// Stop after so many pictures, those that cannot be used with them.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Run folder to write as `run` does: a new or empty one, or one of an earlier run, whose results are replaced.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Do not write run.mcap into the run folder.
    #[arg(long, requires = "out")]
    no_recording: bool,
}

/// Runs the node.
pub(crate) fn ros2(args: &Ros2Args) -> Result<()> {
    check_outputs(args)?;
    let mut config = inputs::config_of_drive(args.config.as_deref())?;
    let known = args.mount.known()?;
    let route = args.route.as_deref().map(inputs::route).transpose()?;
    let roads = args.map.as_deref().map(|map| inputs::road_graph(map, args.limit)).transpose()?;
    let near = roads.as_ref().map(|roads| start_check::near_place(roads, args.near)).transpose()?.flatten();
    let start_m = args.start_m.or_else(|| {
        let Place(near) = args.near?;
        let start_m = start_check::place_on_route(route.as_ref()?, near, NEAR_SIGMA_M)?;
        config.route_progress.start_sigma_m = NEAR_SIGMA_M;
        Some(start_m)
    });
    if let Some(route) = &route {
        start_check::check(&config.route_progress, route, start_m, &[])?;
    }
    let origin = route.as_ref().and_then(|route| route.plane().as_ref().map(TangentPlane::origin));
    let inputs = args.topics.inputs(&known);
    let setting = args.topics.setting()?;
    let mut node = RosNode::begin(&setting, &inputs, &args.topics.outputs(), origin)?;
    output::message(&format!(
        "node {} listens for pictures on {} in domain {}; Ctrl-C ends it",
        setting.name, inputs.pictures, setting.domain
    ));
    let interrupt = Interrupt::listen()?;
    let Some(camera) = wait_for_camera(&mut node, known, args, &interrupt)? else {
        bail!("interrupted before the calibration came; nothing was written");
    };
    let run = RunSetting {
        config: &config,
        camera: &camera,
        route: route.as_ref(),
        start_m,
        sequence: Sequence::Drive,
    };
    let recording = args.out.is_some() && !args.no_recording;
    let wishes = Wishes {
        title: inputs.pictures.clone(),
        pictures: Pictures::None,
        video: None,
        recording: if recording { RecordingWish::Mcap } else { RecordingWish::None },
        live: None,
    };
    let mut driver = Driver::new(run, &wishes, args.frames)?.without_key_frames();
    if let Some(roads) = &roads {
        driver = driver.locating_on(roads, near);
    }
    let subject = Subject { roads, ..driver.subject(run)? };
    let watchdog = Watchdog::at_any_pace(args.watchdog);
    let drive = RosDrive::new(driver, node, inputs.twist.is_some(), args.frames, watchdog, interrupt);
    match &args.out {
        Some(out) => {
            let bar = output::progress(args.frames, "frames");
            record(drive, Recorder::create(RunFolder::create(out)?, subject, wishes, bar)?, out)
        }
        None => only_send(drive),
    }
}

/// Refuses an output that would replace an input.
fn check_outputs(args: &Ros2Args) -> Result<()> {
    let Some(out) = &args.out else { return Ok(()) };
    let optional = [&args.route, &args.map, &args.config].into_iter().flatten();
    let inputs = optional.chain(args.mount.inputs()).map(PathBuf::as_path);
    output_path::check_folder(out, FolderKind::Run, inputs)
}

/// The camera: as it is given, or on its mount with the calibration that comes. None where the user ends the waiting.
fn wait_for_camera(
    node: &mut RosNode,
    known: KnownCamera,
    args: &Ros2Args,
    interrupt: &Interrupt,
) -> Result<Option<Camera>> {
    let topic = args.topics.pictures();
    let mount = match known {
        KnownCamera::Whole(camera) => {
            check_lens_against_topic(&camera, topic);
            return Ok(Some(*camera));
        }
        KnownCamera::Mount(mount) => mount,
    };
    let pictures = args.pictures.of_topic(topic);
    while !interrupt.wanted() {
        if let Some(info) = node.calibration() {
            let read = info.camera(pictures, mount).context(
                "the calibration that came cannot be that of a camera; calibrate it, or give one with --camera",
            )?;
            return Ok(Some(inputs::say_remarks(read, "the calibration that came")));
        }
        node.look_after().iter().for_each(|text| output::message(text));
        std::thread::sleep(GLANCE);
    }
    Ok(None)
}

/// Runs on and writes a run folder.
fn record(mut drive: RosDrive, mut recorder: Recorder, out: &Path) -> Result<()> {
    // A full disk or one that hangs holds the pictures up, and must not hold up the command to stop.
    let attend = |drive: &mut &mut RosDrive| drive.watch();
    let failure = overlap::each_attended(&mut drive, attend, |result| recorder.add(result)).err();
    if failure.is_some() {
        drive.stop_vehicle();
    }
    let (frames, unused) = (recorder.frames(), recorder.nothing_used());
    recorder.note_dropped(drive.dropped());
    let end = if failure.is_some() { RunEnd::Interrupted } else { RunEnd::Complete };
    let summary = recorder.finish(end, None, None);
    drive.say_what_was_dropped();
    if let Some(failure) = failure {
        return Err(failure.context(format!(
            "the run ended after {frames} pictures; results so far are in {}",
            out.display()
        )));
    }
    let summary = summary?;
    if frames == 0 {
        bail!("interrupted before a picture came");
    }
    if unused {
        bail!("none of the {frames} pictures that came could be used; the messages above say why");
    }
    output::print_summary(&summary, &[], out);
    Ok(())
}

/// Runs on and writes nothing.
fn only_send(mut drive: RosDrive) -> Result<()> {
    let (mut frames, mut broken) = (0_u64, 0_u64);
    let ended = drive.try_for_each(|result| -> Result<()> {
        frames += 1;
        if let Err(cause) = result?.outcome {
            broken += 1;
            output::message(&format!("picture {} of those that came is passed over: {cause}", frames - 1));
        }
        Ok(())
    });
    ended?;
    drive.say_what_was_dropped();
    if frames == 0 {
        bail!("interrupted before a picture came");
    }
    if broken == frames {
        bail!("none of the {frames} pictures that came could be used; the messages above say why");
    }
    output::message(&format!("{frames} pictures ({broken} broken)"));
    Ok(())
}

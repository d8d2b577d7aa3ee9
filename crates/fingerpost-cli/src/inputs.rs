//! Reading the files that subcommands are given.

use std::path::Path;

use anyhow::{Context, Result};
use fingerpost::Config;
use fingerpost::advice::{AdviceConfig, ControllerName};
use fingerpost_format::{ReadCamera, TruthRecord};
use fingerpost_geometry::Camera;
use fingerpost_io::{
    FfmpegPrograms, FrameClock, FrameSource, SourceOptions, StampFaults, read_camera, read_truth,
};
use fingerpost_map::{GpsLog, OsmData, RoadGraph, Route, parse_gps_log_within, read_route};
use log::{Level, log_enabled};

use crate::arguments::InputLimit;
use crate::{facts, output};

/// The frames of an input; what their times are guessed from is said.
pub(crate) fn frames(input: &str, options: &SourceOptions) -> Result<FrameSource> {
    let source = FrameSource::open(input, options)?;
    let fps = source.unsampled_fps();
    if let Some(doubt) = source.times_doubt() {
        output::message(&format!("{input}: {doubt}"));
    }
    match source.clock() {
        FrameClock::Guessed => output::message(&format!(
            "{input} does not say when its frames were taken, nor at which rate: {fps} a second is a guess, and speeds go wrong with it; \
             give the rate (--fps)"
        )),
        FrameClock::Names => output::message(&format!(
            "{input}: the pictures are named by numbers that are taken as times, {fps:.3} a second; give the rate (--fps) or a times.txt \
             where they are not"
        )),
        FrameClock::Own | FrameClock::Given | FrameClock::Stated => {}
    }
    Ok(source)
}

/// Says which stamps of a video are no times.
pub(crate) fn say_stamp_faults(input: &str, faults: StampFaults) {
    let StampFaults { back, stray, repeated, missing, first } = faults;
    if let Some(first) = first {
        output::message(&format!(
            "{input}: {back} of its frames are stamped before the frame before them, {stray} after frames that follow them, {repeated} with \
             the same time, and {missing} not at all, frame {first} first; their times are made to go on; give the rate (--fps) where it \
             is constant"
        ));
    }
}

/// A camera's calibration; what must be known of how it was understood is said.
pub(crate) fn camera(path: &Path) -> Result<Camera> {
    let camera = say_remarks(read_camera(path)?, &path.display().to_string());
    log::info!("{}: {}", path.display(), facts::of_camera(&camera));
    Ok(camera)
}

/// The camera alone, once its remarks are said of `source`.
pub(crate) fn say_remarks(ReadCamera { camera, remarks }: ReadCamera, source: &str) -> Camera {
    remarks.iter().for_each(|remark| output::message(&format!("{source}: {remark}")));
    camera
}

/// The data of an OpenStreetMap file that takes no more than the limit.
pub(crate) fn osm(path: &Path, limit: InputLimit) -> Result<OsmData> {
    let bytes = fingerpost_io::read_bytes_within(path, limit.bytes() as u64)?;
    let osm = OsmData::from_bytes_within(&bytes, limit.bytes());
    osm.with_context(|| path.display().to_string())
}

/// The roads of an OpenStreetMap file that takes no more than the limit; what of it was not understood is said.
pub(crate) fn road_graph(path: &Path, limit: InputLimit) -> Result<RoadGraph> {
    roads_of(&osm(path, limit)?, path)
}

/// The roads of a file's data; what of it was not understood is said.
pub(crate) fn roads_of(osm: &OsmData, path: &Path) -> Result<RoadGraph> {
    let graph = RoadGraph::from_osm(osm).with_context(|| path.display().to_string())?;
    for notice in graph.notices() {
        output::message(&format!("{}: {notice}", path.display()));
    }
    log::info!("{}: {}", path.display(), facts::of_roads(&graph));
    Ok(graph)
}

/// The positions of a GPX file or a receiver's log that takes no more than the limit; what is damaged in it is said.
pub(crate) fn gps_log(path: &Path, limit: InputLimit) -> Result<GpsLog> {
    let bytes = fingerpost_io::read_bytes_within(path, limit.bytes() as u64)?;
    let log = parse_gps_log_within(&bytes, limit.bytes()).with_context(|| path.display().to_string())?;
    if let Some(first) = &log.damaged.first {
        output::message(&format!(
            "{}: {} of its reports of position or time cannot be read and are passed over, {first}",
            path.display(),
            log.damaged.count
        ));
    }
    if log.unchecked > 0 {
        output::message(&format!(
            "{}: {} of its sentences are believed without a checksum, which would show that they are damaged",
            path.display(),
            log.unchecked
        ));
    }
    log::info!("{}: {} GPS positions", path.display(), log.points.len());
    Ok(log)
}

/// The truth of a drive.
pub(crate) fn truth(path: &Path) -> Result<Vec<TruthRecord>> {
    let truth = read_truth(path)?;
    log::info!("{}: truth of {} frames", path.display(), truth.len());
    Ok(truth)
}

/// A route file.
pub(crate) fn route(path: &Path) -> Result<Route> {
    let text = fingerpost_io::read_text(path)?;
    let route = read_route(&text).with_context(|| path.display().to_string())?;
    route.polyline().with_context(|| path.display().to_string())?;
    log::info!("{}: {}", path.display(), facts::of_route(&route));
    Ok(route)
}

/// The same for a drive, which one controller steers: what it leaves unused is said.
pub(crate) fn config_of_drive(path: Option<&Path>) -> Result<Config> {
    let config = config(path)?;
    let AdviceConfig { controller, rules, .. } = &config.advice;
    if rules.is_some() && *controller != ControllerName::Fuzzy {
        output::message(&format!(
            "advice.rules are the fuzzy controller's, and {} steers: set advice.controller = \"fuzzy\", or take them out",
            controller.name()
        ));
    }
    Ok(config)
}

/// The configuration of a file, or the default one.
pub(crate) fn config(path: Option<&Path>) -> Result<Config> {
    let Some(path) = path else {
        return Ok(Config::default());
    };
    let text = fingerpost_io::read_text(path)?;
    let config = Config::from_toml(&text).with_context(|| {
        format!("{} is no valid configuration; `fingerpost schema` prints every key", path.display())
    })?;
    config.check().with_context(|| path.display().to_string())?;
    if log_enabled!(Level::Info) {
        let changed = facts::of_settings(&config);
        log::info!("{}: settings that are not the default: {}", path.display(), changed.len());
        changed.iter().for_each(|setting| log::info!("{setting}"));
    }
    Ok(config)
}

/// ffmpeg and ffprobe as this program runs them: they end with it.
pub(crate) fn ffmpeg() -> FfmpegPrograms {
    // What this process was started from, even if the file has another name by now.
    let itself = Path::new("/proc/self/exe");
    FfmpegPrograms { tether: itself.exists().then(|| itself.to_owned()), ..FfmpegPrograms::default() }
}

//! Reading the files that subcommands are given.

use std::path::Path;

use anyhow::{Context, Result};
use fingerpost::Config;
use fingerpost_io::FfmpegPrograms;
use fingerpost_map::{GpxPoint, OsmData, RoadGraph, Route, parse_gps_log_within, read_route};

use crate::arguments::InputLimit;
use crate::output;

/// The data of an OpenStreetMap file that takes no more than the limit.
pub(crate) fn osm(path: &Path, limit: InputLimit) -> Result<OsmData> {
    let bytes = fingerpost_io::read_bytes_within(path, limit.bytes() as u64)?;
    let osm = OsmData::from_bytes_within(&bytes, limit.bytes());
    osm.with_context(|| path.display().to_string())
}

/// The roads of an OpenStreetMap file that takes no more than the limit.
pub(crate) fn road_graph(path: &Path, limit: InputLimit) -> Result<RoadGraph> {
    RoadGraph::from_osm(&osm(path, limit)?).with_context(|| path.display().to_string())
}

/// The positions of a GPX file or a receiver's log that takes no more than the limit; what is damaged in it is said.
pub(crate) fn gps_points(path: &Path, limit: InputLimit) -> Result<Vec<GpxPoint>> {
    let bytes = fingerpost_io::read_bytes_within(path, limit.bytes() as u64)?;
    let log = parse_gps_log_within(&bytes, limit.bytes()).with_context(|| path.display().to_string())?;
    if log.damaged > 0 {
        output::message(&format!(
            "{}: {} of its reports of position are damaged and passed over",
            path.display(),
            log.damaged
        ));
    }
    Ok(log.points)
}

/// A route file.
pub(crate) fn route(path: &Path) -> Result<Route> {
    let text = fingerpost_io::read_text(path)?;
    let route = read_route(&text).with_context(|| path.display().to_string())?;
    route.polyline().with_context(|| path.display().to_string())?;
    Ok(route)
}

/// The configuration of a file, or the default one.
pub(crate) fn config(path: Option<&Path>) -> Result<Config> {
    let Some(path) = path else {
        return Ok(Config::default());
    };
    let text = fingerpost_io::read_text(path)?;
    let config: Config = toml::from_str(&text).with_context(|| {
        format!("{} is no valid configuration; `fingerpost schema` prints every key", path.display())
    })?;
    config.check().with_context(|| path.display().to_string())?;
    Ok(config)
}

/// ffmpeg and ffprobe as this program runs them: they end with it.
pub(crate) fn ffmpeg() -> FfmpegPrograms {
    // What this process was started from, even if the file has another name by now.
    let itself = Path::new("/proc/self/exe");
    FfmpegPrograms { tether: itself.exists().then(|| itself.to_owned()), ..FfmpegPrograms::default() }
}

//! Reading the files that subcommands are given.

use std::path::Path;

use anyhow::{Context, Result};
use fingerpost::Config;
use fingerpost_map::{OsmData, RoadGraph, Route, read_route};

/// The data of an OpenStreetMap file.
pub(crate) fn osm(path: &Path) -> Result<OsmData> {
    let bytes = fingerpost_io::read_bytes(path)?;
    OsmData::from_bytes(&bytes).with_context(|| path.display().to_string())
}

/// The roads of an OpenStreetMap file.
pub(crate) fn road_graph(path: &Path) -> Result<RoadGraph> {
    RoadGraph::from_osm(&osm(path)?).with_context(|| path.display().to_string())
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

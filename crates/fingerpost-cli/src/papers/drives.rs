//! The simulated drives that the papers' claims are measured on.

use anyhow::{Context, Result};
use fingerpost::Config;
use fingerpost::vehicle::Traffic;
use fingerpost_geometry::Camera;
use fingerpost_map::{OsmData, RoadGraph, Route};
use fingerpost_sim::{
    Conditions, RandomRouteOptions, SimConfig, Simulator, TOWN_OSM, TrafficSide, random_drive, random_route,
};

use crate::arguments::PictureSize;
use crate::simulate::{Lens, default_camera};

/// The papers' own settings.
const PAPERS_TOML: &str = include_str!("../../papers.toml");

/// Pictures of the widest kind that the papers tested (paper 2, 2, 1.2), in the shape of theirs and of most cameras.
pub(super) const SIZE: PictureSize = PictureSize { width: 512, height: 384 };
/// Rate at which drives are rendered, frames a second: the highest that is compared, of which the others use some.
pub(super) const RENDERED_FPS: f64 = 30.0;

/// A kind of roads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RoadKind {
    /// Name in the file of measurements.
    pub(super) name: &'static str,
    /// What it is called on the page.
    pub(super) words: &'static str,
    /// The same in a plot's key.
    pub(super) short: &'static str,
    conditions: &'static str,
    traffic: TrafficSide,
}

/// The roads on which every claim about features is measured.
pub(super) const ROADS: [RoadKind; 3] = [
    // Paper 1, VII: "designed around a single lane remote application".
    RoadKind {
        name: "single_lane",
        words: "single-lane roads without markings",
        short: "single lane, no markings",
        conditions: "unmarked",
        traffic: TrafficSide::Centre,
    },
    RoadKind {
        name: "two_way",
        words: "two-way roads with markings",
        short: "two ways, marked",
        conditions: "clear",
        traffic: TrafficSide::Right,
    },
    // Paper 1, VII-B: "moving from one surface to another".
    RoadKind {
        name: "changing",
        words: "two-way roads whose surface changes",
        short: "two ways, surface changes",
        conditions: "mixed",
        traffic: TrafficSide::Right,
    },
];

/// A drive, and what the method is told of it.
pub(super) struct Planned {
    pub(super) simulator: Simulator,
    pub(super) camera: Camera,
    pub(super) route: Route,
    pub(super) start_m: f64,
    /// The papers' settings for this side of the road, without the stages that no claim about features is about.
    pub(super) config: Config,
}

/// The papers' settings.
pub(super) fn papers_settings() -> Result<Config> {
    toml::from_str(PAPERS_TOML).context("papers.toml")
}

impl RoadKind {
    /// The drive of a seed in the built-in town, of at most so many frames.
    pub(super) fn plan(&self, seed: u64, frames: usize) -> Result<Planned> {
        let graph = RoadGraph::from_osm(&OsmData::from_bytes(TOWN_OSM)?)?;
        let route = random_route(&graph, seed, &RandomRouteOptions::default())?;
        let drawn = random_drive(seed, &Conditions::named(self.conditions)?);
        let drawn = SimConfig { fps: RENDERED_FPS, frames: Some(frames), traffic: self.traffic, ..drawn };
        let camera = default_camera(SIZE, Lens::None)?;
        let mut config = papers_settings()?;
        config.vehicle.traffic = match self.traffic {
            TrafficSide::Left => Traffic::Left,
            TrafficSide::Right => Traffic::Right,
            TrafficSide::Centre => Traffic::Centre,
        };
        config.centreline.enabled = false;
        config.lanes.finder = fingerpost::lanes::LaneMethod::Off;
        Ok(Planned {
            simulator: Simulator::new(&graph, &route, &camera, &drawn)?,
            start_m: drawn.start_m,
            camera,
            route,
            config,
        })
    }
}

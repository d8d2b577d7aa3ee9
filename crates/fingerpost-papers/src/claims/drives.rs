//! The simulated drives that the papers' claims are measured on.

use fingerpost::Config;
use fingerpost::vehicle::Traffic;
use fingerpost_geometry::Camera;
use fingerpost_map::{GraphError, OsmData, OsmError, RoadGraph, Route};
use fingerpost_sim::{
    Conditions, RandomRouteOptions, SimConfig, SimError, Simulator, TOWN_OSM, TrafficSide, random_drive,
    random_route,
};
use thiserror::Error;

/// Pictures of the widest kind that the papers tested (paper 2, 2, 1.2), in the shape of theirs and of most cameras.
pub const SIZE_PX: [usize; 2] = [512, 384];
/// Rate at which drives are rendered, frames a second: the highest that is compared, of which the others use some.
pub const RENDERED_FPS: f64 = 30.0;

/// A kind of roads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoadKind {
    /// Name in the file of measurements.
    pub name: &'static str,
    /// What it is called on the page.
    pub(super) words: &'static str,
    /// The same in a plot's key.
    pub(super) short: &'static str,
    conditions: &'static str,
    traffic: TrafficSide,
}

/// The roads on which every claim about features is measured.
pub const ROADS: [RoadKind; 3] = [
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
pub struct Planned {
    /// What renders it.
    pub simulator: Simulator,
    /// The camera.
    pub camera: Camera,
    /// The route that is driven.
    pub route: Route,
    /// Distance along the route at the first frame, metres.
    pub start_m: f64,
    /// The papers' settings for this side of the road, without the stages that no claim about features is about.
    pub config: Config,
}

/// A drive that cannot be planned.
#[derive(Debug, Error)]
pub enum DriveError {
    /// The built-in town cannot be read.
    #[error(transparent)]
    Osm(#[from] OsmError),
    /// It has no roads.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// The drive cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] SimError),
}

impl RoadKind {
    /// The drive of a seed in the built-in town, of at most so many frames, seen by `camera`; `settings` are the papers'.
    ///
    /// # Errors
    /// [`DriveError`] when it cannot be simulated.
    pub fn plan(
        &self,
        (settings, camera): (&Config, &Camera),
        seed: u64,
        frames: usize,
    ) -> Result<Planned, DriveError> {
        let graph = RoadGraph::from_osm(&OsmData::from_bytes(TOWN_OSM)?)?;
        let route = random_route(&graph, seed, &RandomRouteOptions::default())?;
        let drawn = random_drive(seed, &Conditions::named(self.conditions)?);
        let drawn = SimConfig { fps: RENDERED_FPS, frames: Some(frames), traffic: self.traffic, ..drawn };
        let mut config = settings.clone();
        config.vehicle.traffic = match self.traffic {
            TrafficSide::Left => Traffic::Left,
            TrafficSide::Right => Traffic::Right,
            TrafficSide::Centre => Traffic::Centre,
        };
        config.centreline.enabled = false;
        config.lanes.finder = fingerpost::lanes::LaneMethod::Off;
        Ok(Planned {
            simulator: Simulator::new(&graph, &route, camera, &drawn)?,
            start_m: drawn.start_m,
            camera: camera.clone(),
            route,
            config,
        })
    }
}

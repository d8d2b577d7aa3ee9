//! What a drive of a campaign is, as its seed draws it.

use std::path::Path;

use anyhow::Result;
use fingerpost::Config;
use fingerpost_geometry::Camera;
use fingerpost_map::{OsmData, RoadGraph, Route};
use fingerpost_sim::{
    Conditions, RandomRouteOptions, SimConfig, Simulator, World, WorldOptions, random_drive, random_route,
};

use crate::arguments::{InputLimit, PictureSize};
use crate::demo::TOWN_OSM;
use crate::inputs;
use crate::simulate::{Lens, corners, default_camera, known_vehicle};

/// Name of the drives that have a world of their own.
pub(crate) const WORLD: &str = "world";
/// Worlds, and the difficult days of one world.
pub(crate) const DEFAULT_CONDITIONS: [&str; 8] =
    [WORLD, "shadows", "wet", "mixed", "dusk", "dust", "street", "street_shade"];
/// Pictures of the one world.
const SIZE: PictureSize = PictureSize { width: 480, height: 360 };
/// Their rate, frames a second.
const FPS: f64 = 10.0;

/// What drives are drawn from.
pub(crate) struct Drawing {
    osm: OsmData,
    graph: RoadGraph,
    camera: Camera,
    size: Option<PictureSize>,
    fps: Option<f64>,
    config: Config,
}

impl Drawing {
    /// Drives on a map, or in the built-in town, with pictures and settings as given.
    pub(crate) fn new(
        map: Option<&Path>,
        limit: InputLimit,
        size: Option<PictureSize>,
        fps: Option<f64>,
        config: Config,
    ) -> Result<Self> {
        let osm = match map {
            Some(map) => inputs::osm(map, limit)?,
            None => OsmData::from_bytes(TOWN_OSM)?,
        };
        let camera = default_camera(size.unwrap_or(SIZE), Lens::None)?;
        Ok(Self { graph: RoadGraph::from_osm(&osm)?, osm, camera, size, fps, config })
    }
}

/// What is driven, and what the method is told of it.
pub(crate) struct Plan {
    pub(crate) simulator: Simulator,
    pub(crate) fps: f64,
    pub(crate) config: Config,
    pub(crate) camera: Camera,
    pub(crate) route: Route,
    pub(crate) start_m: f64,
}

impl Plan {
    /// The drive of a seed.
    pub(crate) fn new(drawing: &Drawing, seed: u64, conditions: &str) -> Result<Self> {
        if conditions == WORLD {
            let size_px = drawing.size.map(|size| [size.width, size.height]);
            let options = WorldOptions { size_px, fps: drawing.fps };
            let world = World::draw(seed, &drawing.osm, &options)?;
            return Ok(Self {
                simulator: world.simulator()?,
                fps: world.config.fps,
                config: Config {
                    vehicle: known_vehicle(&world, &drawing.config.vehicle),
                    ..drawing.config.clone()
                },
                camera: world.calibration,
                route: world.route,
                start_m: world.start_m,
            });
        }
        let route = random_route(&drawing.graph, seed, &RandomRouteOptions::default())?;
        let conditions = Conditions::named(conditions)?;
        let drawn = random_drive(seed, &conditions);
        let fps = drawing.fps.unwrap_or(FPS);
        let config = SimConfig { fps, corners: corners(&conditions), ..drawn };
        Ok(Self {
            simulator: Simulator::new(&drawing.graph, &route, &drawing.camera, &config)?,
            fps: config.fps,
            config: drawing.config.clone(),
            camera: drawing.camera.clone(),
            route,
            start_m: config.start_m,
        })
    }
}

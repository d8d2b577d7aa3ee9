//! What a drive of a campaign is, as its seed draws it.

use std::path::Path;

use anyhow::{Result, bail};
use fingerpost::Config;
use fingerpost_geometry::Camera;
use fingerpost_map::{OsmData, RoadGraph, Route};
use fingerpost_sim::{
    Conditions, DrivingHabits, MapFault, RandomRouteOptions, SimConfig, Simulator, TOWN_OSM, World,
    WorldOptions, misled_route, random_drive, random_route,
};

use crate::arguments::{InputLimit, PictureSize};
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
/// Length of the routes of steered vehicles, metres.
const STEERED_M: [f64; 2] = [150.0, 700.0];
/// Features that a route may have more than asked for.
const MORE_FEATURES: usize = 3;

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
        let (osm, graph) = match map {
            Some(map) => {
                let osm = inputs::osm(map, limit)?;
                let graph = inputs::roads_of(&osm, map)?;
                (osm, graph)
            }
            None => {
                let osm = OsmData::from_bytes(TOWN_OSM)?;
                let graph = RoadGraph::from_osm(&osm)?;
                (osm, graph)
            }
        };
        let camera = default_camera(size.unwrap_or(SIZE), Lens::None)?;
        Ok(Self { graph, osm, camera, size, fps, config })
    }
}

impl Drawing {
    fn world_options(&self) -> WorldOptions {
        let size_px = self.size.map(|size| [size.width, size.height]);
        WorldOptions { size_px, fps: self.fps, ..WorldOptions::default() }
    }

    /// A day of the one world.
    fn day(&self, seed: u64, conditions: &str) -> Result<SimConfig> {
        let conditions = Conditions::named(conditions)?;
        let drawn = random_drive(seed, &conditions);
        Ok(SimConfig { fps: self.fps.unwrap_or(FPS), corners: corners(&conditions), ..drawn })
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
            let world = World::draw(seed, &drawing.osm, &drawing.world_options())?;
            return Self::in_world(drawing, world);
        }
        let route = random_route(&drawing.graph, seed, &RandomRouteOptions::default())?;
        let config = drawing.day(seed, conditions)?;
        let roads = (&drawing.graph, &route);
        Self::in_one_world(drawing, roads, config, route.clone())
    }

    /// The drive of a seed for a vehicle that is steered, which neither wanders nor keeps aside: a route of `features` or up to
    /// three more, on a map with a fault where one is given. Of a world the map has its own.
    pub(crate) fn steered(
        drawing: &Drawing,
        seed: u64,
        conditions: &str,
        features: usize,
        fault: Option<MapFault>,
    ) -> Result<Self> {
        let [shortest_m, longest_m] = STEERED_M;
        if conditions == WORLD {
            if fault.is_some() {
                bail!(
                    "a world has errors of its map of its own; give no --fault of the map, or other conditions"
                );
            }
            let options = WorldOptions {
                features: Some([features, features + MORE_FEATURES]),
                route_m: Some(STEERED_M),
                ..drawing.world_options()
            };
            let mut world = World::draw(seed, &drawing.osm, &options)?;
            world.config.habits = DrivingHabits::default();
            world.config.conditions.wander_m = 0.0;
            return Self::in_world(drawing, world);
        }
        let wanted = RandomRouteOptions {
            length_m: shortest_m..=longest_m,
            features: features..=features + MORE_FEATURES,
            ..RandomRouteOptions::default()
        };
        let (route, driven) = match fault {
            Some(fault) => misled_route(&drawing.osm, fault, seed, &wanted)?,
            None => {
                let route = random_route(&drawing.graph, seed, &wanted)?;
                (route.clone(), route)
            }
        };
        let mut config = drawing.day(seed, conditions)?;
        config.conditions.wander_m = 0.0;
        config.vehicle.turning_radius_m = drawing.config.vehicle.turning_radius_m;
        config.vehicle.wheelbase_m = drawing.config.vehicle.wheelbase_m;
        config.vehicle.width_m = drawing.config.vehicle.width_m;
        Self::in_one_world(drawing, (&drawing.graph, &driven), config, route)
    }

    fn in_world(drawing: &Drawing, world: World) -> Result<Self> {
        Ok(Self {
            simulator: world.simulator()?,
            fps: world.config.fps,
            config: Config {
                vehicle: known_vehicle(&world, &drawing.config.vehicle),
                ..drawing.config.clone()
            },
            camera: world.calibration,
            route: world.route,
            start_m: world.start_m,
        })
    }

    /// On these roads along this route; `route` is the one that is known.
    fn in_one_world(
        drawing: &Drawing,
        (roads, driven): (&RoadGraph, &Route),
        config: SimConfig,
        route: Route,
    ) -> Result<Self> {
        Ok(Self {
            simulator: Simulator::new(roads, driven, &drawing.camera, &config)?,
            fps: config.fps,
            config: drawing.config.clone(),
            camera: drawing.camera.clone(),
            route,
            start_m: config.start_m,
        })
    }
}

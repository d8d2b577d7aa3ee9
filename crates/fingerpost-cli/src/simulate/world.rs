//! A drive in a world of its own: `simulate --world`.

use anyhow::Result;
use clap::{Args, ValueEnum};
use fingerpost::vehicle::{Traffic, VehicleConfig};
use fingerpost_map::OsmData;
use fingerpost_sim::{BUS_SETTINGS, TOWN_OSM, TrafficSide, World, WorldOptions, WorldRanges};

use super::{Plan, SimulateArgs};
use crate::{inputs, output};

/// Whether there is one.
#[derive(Debug, Args)]
pub(super) struct WorldArgs {
    /// Draw everything from the seed: route, camera, vehicle, driver, day, streets, corners, paint, and the errors of the map, of
    /// the calibration and of the start that the drive's owner believes in; on the built-in town, or in the place of --map.
    /// camera.toml and route.geojson are what the owner knows, can.toml holds the vehicle too.
    #[arg(long, conflicts_with_all = ["route", "course", "conditions", "camera", "traffic", "lens"])]
    world: bool,
    /// What it is drawn from: usual, as drives of road vehicles are; wide, for pictures to learn from, in which every camera and every
    /// kind of street and light comes up often. With a low --fps every frame shows another place.
    #[arg(long, value_enum, default_value = "usual", requires = "world")]
    world_ranges: Ranges,
}

/// How much worlds differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Ranges {
    Usual,
    Wide,
}

impl WorldArgs {
    pub(super) fn is_wanted(&self) -> bool {
        self.world
    }

    /// The drive that the seed draws.
    pub(super) fn plan(&self, args: &SimulateArgs) -> Result<Plan> {
        let osm = match &args.map {
            Some(map) => {
                let osm = inputs::osm(map, args.limit)?;
                // Says what of the map is not understood; the world draws roads of its own from it.
                inputs::roads_of(&osm, map)?;
                osm
            }
            None => OsmData::from_bytes(TOWN_OSM)?,
        };
        let size_px = args.size.map(|size| [size.width, size.height]);
        let ranges = match self.world_ranges {
            Ranges::Usual => WorldRanges::Usual,
            Ranges::Wide => WorldRanges::Wide,
        };
        let options = WorldOptions { size_px, fps: args.fps, ranges, ..WorldOptions::default() };
        let mut world = World::draw(args.seed, &osm, &options)?;
        world.config.frames = args.frames();
        let vehicle = fingerpost::vehicle_to_toml(&known_vehicle(&world, &VehicleConfig::default()))?;
        output::message(&format!("the first frame is believed to be at --start-m {:.1}", world.start_m));
        Ok(Plan {
            simulator: world.simulator()?,
            camera: world.calibration,
            route: world.route,
            settings: format!("{BUS_SETTINGS}\n{vehicle}"),
        })
    }
}

/// The vehicle of a world as its owner knows it; all else is as given.
pub(crate) fn known_vehicle(world: &World, given: &VehicleConfig) -> VehicleConfig {
    let traffic = match world.config.traffic {
        TrafficSide::Left => Traffic::Left,
        TrafficSide::Right => Traffic::Right,
        TrafficSide::Centre => Traffic::Centre,
    };
    let vehicle = world.config.vehicle;
    VehicleConfig {
        width_m: vehicle.width_m,
        turning_radius_m: vehicle.turning_radius_m,
        traffic,
        ..given.clone()
    }
}

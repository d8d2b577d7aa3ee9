//! A world of a drive's own: another camera, vehicle, driver, day, streets and map in every drive.
//!
//! There are two maps. The *world's* has the roads as they are: nothing but it is rendered, and the truth is measured on it.
//! The *known* map is what a mapper made of them: places are off, widths are those of the tags, roads are missing and others
//! were never built. A route is planned on the known map along roads that are there, and driven in the world from node to
//! node. Likewise there are two cameras: the one that looks, and the one that its calibration says.
//!
//! Limits: the map is copied for every world, which suits a town; what is drawn of a street does not change along it.
//!
//! Every range and share that is drawn from is in [`ranges`], with where it comes from; those of pictures to learn from are in [`wide`].

mod drawn_camera;
mod drawn_map;
mod drawn_route;
mod map_fault;
mod ranges;
mod wide;

use std::f64::consts::PI;

use fingerpost_geometry::Camera;
use fingerpost_map::{OsmData, RoadGraph, Route};

use self::drawn_camera::DrawnCamera;
pub use self::map_fault::{MapFault, misled_route};
use crate::noise::Stream;
use crate::{
    Conditions, CornerStyle, DrivingHabits, Markings, RandomRouteOptions, SimConfig, SimError, SimVehicle,
    Simulator, TrafficSide,
};

/// How much worlds differ.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum WorldRanges {
    /// As drives of road vehicles do.
    #[default]
    Usual,
    /// As pictures to learn from must: every camera and every kind of street and light is drawn often.
    Wide,
}

/// What of a world is given and not drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WorldOptions {
    /// Width and height of the pictures, pixels.
    pub size_px: Option<[usize; 2]>,
    /// Frames a second.
    pub fps: Option<f64>,
    /// Features of the route.
    pub features: Option<[usize; 2]>,
    /// Its length, metres.
    pub route_m: Option<[f64; 2]>,
    /// What the rest is drawn from.
    pub ranges: WorldRanges,
}

/// A drawn world with a drive in it.
#[derive(Debug, Clone)]
pub struct World {
    /// The roads as they are.
    pub roads: RoadGraph,
    /// The route as it is driven, on these roads; its features are those of the known route that are there, where they are.
    pub driven: Route,
    /// The camera that looks.
    pub camera: Camera,
    /// The drive.
    pub config: SimConfig,
    /// The route as it is planned on the known map.
    pub route: Route,
    /// The camera as it is known.
    pub calibration: Camera,
    /// Where on the route the first frame is believed to be taken, metres.
    pub start_m: f64,
}

impl World {
    /// The world that `seed` draws in the place of a map.
    ///
    /// # Errors
    /// [`SimError::Map`] for a map without roads, [`SimError::NoRandomRoute`] for one without a fitting route,
    /// [`SimError::NoDrawnCamera`], [`SimError::OutOfRange`] and [`SimError::Geometry`] for options that make no drive.
    pub fn draw(seed: u64, osm: &OsmData, options: &WorldOptions) -> Result<Self, SimError> {
        let broadness = match options.ranges {
            WorldRanges::Usual => 1.0,
            WorldRanges::Wide => wide::broadness(seed),
        };
        let built = drawn_map::as_built(osm, seed, broadness);
        let roads = RoadGraph::from_osm(&built)?;
        let known = RoadGraph::from_osm(&drawn_map::as_mapped(osm, &roads, seed))?;
        let usual = RandomRouteOptions::default();
        let [shortest_m, longest_m] = options.route_m.unwrap_or(ranges::ROUTE_M);
        let wanted = RandomRouteOptions {
            length_m: shortest_m..=longest_m,
            features: options.features.map_or(usual.features, |[fewest, most]| fewest..=most),
            first_feature_m: ranges::FIRST_FEATURE_M[0]..=ranges::FIRST_FEATURE_M[1],
            ..usual
        };
        let (route, driven) = drawn_route::drawn(&known, &roads, seed, &wanted)?;
        let mut stream = Stream::new(seed, 0x574f_524c);
        let (vehicles, aims) = match options.ranges {
            WorldRanges::Usual => (&ranges::VEHICLES, &ranges::CAMERA),
            WorldRanges::Wide => (&wide::VEHICLES, &wide::CAMERA),
        };
        let carrier = stream.choose(vehicles).unwrap_or(ranges::CAR);
        let DrawnCamera { camera, calibration } =
            DrawnCamera::draw(&mut Stream::new(seed, 0x4341_4d45), &carrier, aims, options.size_px)?;
        let config = config(seed, &mut stream, &carrier, options);
        config.check()?;
        let start_m = (config.start_m + stream.normal(ranges::START_SIGMA_M)).max(0.0);
        Ok(Self { roads, driven, camera, config, route, calibration, start_m })
    }

    /// The drive.
    ///
    /// # Errors
    /// As [`Simulator::new`].
    pub fn simulator(&self) -> Result<Simulator, SimError> {
        Simulator::new(&self.roads, &self.driven, &self.camera, &self.config)
    }
}

fn config(seed: u64, stream: &mut Stream, carrier: &ranges::Carrier, options: &WorldOptions) -> SimConfig {
    let mut within = |range: [f64; 2]| stream.between(range[0], range[1]);
    let wheelbase_m = within(carrier.wheelbase_m);
    let width_m = within(carrier.width_m);
    let vehicle = SimVehicle {
        wheelbase_m,
        // Tyres are some 0.2 m wide.
        track_m: width_m - 0.2,
        width_m,
        turning_radius_m: within(carrier.turning_radius_m),
    };
    let cruise_speed_mps = within(ranges::SPEED_MPS);
    let corner_cutting = within(ranges::CORNER_CUTTING);
    let habits = DrivingHabits { aside_m: stream.normal(ranges::ASIDE_SIGMA_M), corner_cutting };
    let traffic = stream.choose(&ranges::TRAFFIC_SIDES).unwrap_or(TrafficSide::Right);
    let fps = stream.choose(&ranges::FPS).unwrap_or(10.0);
    SimConfig {
        seed,
        fps: options.fps.unwrap_or(fps),
        conditions: match options.ranges {
            WorldRanges::Usual => conditions(stream),
            WorldRanges::Wide => wide::conditions(stream),
        },
        traffic,
        corners: CornerStyle::Drawn,
        vehicle,
        habits,
        cruise_speed_mps,
        start_m: ranges::START_M,
        ..SimConfig::default()
    }
}

/// A day, with streets of their own.
fn conditions(stream: &mut Stream) -> Conditions {
    let day = stream.choose(&ranges::DAYS).unwrap_or(Conditions::CLEAR);
    let mut within = |range: [f64; 2]| stream.between(range[0], range[1]);
    let mut drawn = Conditions {
        markings: Markings::Streets,
        sun_azimuth_rad: within([-PI, PI]),
        wander_m: within(ranges::WANDER_M),
        undulation_m: within(ranges::UNDULATION_M),
        suspension_rms_rad: within(ranges::SUSPENSION_RMS_RAD),
        suspension_rad_per_mps2: within(ranges::SUSPENSION_RAD_PER_MPS2),
        noise_levels: within(ranges::NOISE_LEVELS),
        vignette: within(ranges::VIGNETTE),
        trees_per_100_m: within(ranges::TREES_PER_100_M),
        houses_per_100_m: within(ranges::HOUSES_PER_100_M),
        pavements: within(ranges::PAVEMENTS),
        parked_per_100_m: within(ranges::PARKED_PER_100_M),
        ..day
    };
    drawn.lanes.worn = within(ranges::WORN);
    drawn
}

/// A number drawn from a range's logarithms: as likely to be doubled from its low end as halved from its high one.
fn log_between(stream: &mut Stream, range: [f64; 2]) -> f64 {
    libm::exp(stream.between(libm::log(range[0]), libm::log(range[1])))
}

#[cfg(test)]
mod tests;

//! Painted scenes in a steady state, in which allocations are counted.
#![allow(unreachable_pub, dead_code, reason = "shared by several test programs, each of which uses a part")]
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

#[path = "../painted/mod.rs"]
mod painted;

use allocation_counter::measure;
use fingerpost::pipeline::Parts;
use fingerpost::track::State;
use fingerpost::vehicle::Traffic;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_geometry::Camera;
use fingerpost_map::{FeatureKind, LatLon};
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Isometry2, Vector2};
use painted::{World, camera_of_width, route};

pub use painted::{Junction, Place};

pub const WIDTH_M: f64 = 5.5;
pub const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
pub const NORTH: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
pub const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
pub const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];

/// Where the painted worlds lie, and metres of a degree of latitude there.
pub const NODE_LAT_DEG: f64 = 47.1;
pub const NODE_LON_DEG: f64 = 9.5;
pub const METRES_PER_DEGREE: f64 = 111_180.0;
/// Offsets along the road of the pictures that are shown round and round, metres.
pub const FORTH_AND_BACK_M: [f64; 6] = [0.0, 0.3, 0.7, 1.0, 0.6, 0.3];
/// Distance of one frame of the way there, metres.
pub const STEP_M: f64 = 0.6;
/// Frames before the count: until every buffer has its size and every heading of the round has its masks.
pub const SETTLING_FRAMES: usize = 120;
pub const COUNTED_FRAMES: usize = 60;

/// A coarse view: the buffers are the same, only smaller.
pub fn coarse() -> Config {
    let mut config = Config::default();
    config.ground_view.metres_per_pixel = 0.1;
    // The painted roads meet at sharp corners.
    config.track.kerb_radius_m = 0.0;
    config.vehicle.traffic = Traffic::Centre;
    config
}

/// A world with a vehicle on the road from the south in it.
pub struct Scene {
    world: World,
    camera: Camera,
    pipeline: Pipeline,
}

impl Scene {
    pub fn new(config: &Config, roads: &[&[Place]], junction: Option<&Junction<'_>>) -> Self {
        Self::with_parts(config, roads, junction, Parts::default())
    }

    /// With stages of the test's own in place of the configuration's.
    pub fn with_parts(
        config: &Config,
        roads: &[&[Place]],
        junction: Option<&Junction<'_>>,
        parts: Parts,
    ) -> Self {
        let camera = camera_of_width(320);
        let route = junction.map(|junction| route(junction).0);
        let roads: Vec<(&[Place], f64)> = roads.iter().map(|&road| (road, WIDTH_M)).collect();
        let pipeline = Pipeline::with_parts(config, &camera, route.as_ref(), None, parts).unwrap();
        Self { world: World::new(&roads), camera, pipeline }
    }

    /// A T-junction that is left to the right.
    pub fn t_junction(config: &Config) -> Self {
        let kind = FeatureKind::Junction;
        let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
        Self::new(config, &[SOUTH, EAST, WEST], Some(&junction))
    }

    pub fn picture(&self, before_m: f64) -> RgbImage {
        let map_from_vehicle = Isometry2::new(Vector2::new(0.0, -before_m), std::f64::consts::FRAC_PI_2);
        self.world.picture(&self.camera, &map_from_vehicle)
    }

    /// Shows a picture that was taken so far before the node, with the GPS position of a place nearby.
    pub fn step(&mut self, before_m: f64, picture: &RgbImage) -> State {
        let gps =
            Some(LatLon { lat_deg: NODE_LAT_DEG - before_m / METRES_PER_DEGREE, lon_deg: NODE_LON_DEG });
        self.pipeline.step(picture, Sensors { gps, ..Sensors::default() }, &mut |_| {}).unwrap().0.track.state
    }

    /// Drives on until `state` is reached; returns how far before the node that is.
    pub fn drive_until(&mut self, state: State) -> f64 {
        let mut before_m = 28.0;
        while self.step(before_m, &self.picture(before_m)) != state {
            before_m -= STEP_M;
            assert!(before_m > -10.0, "{state:?} is never reached");
        }
        before_m
    }

    /// The pictures of the round that starts so far before the node.
    pub fn round(&self, before_m: f64) -> Vec<RgbImage> {
        FORTH_AND_BACK_M.iter().map(|forward_m| self.picture(before_m - forward_m)).collect()
    }

    /// Settles on the round, then counts allocations while `state` lasts.
    pub fn check(&mut self, state: State, before_m: f64) {
        let round = self.round(before_m);
        let mut pictures = round.iter().cycle();
        for picture in pictures.by_ref().take(SETTLING_FRAMES) {
            self.step(before_m, picture);
        }
        for (frame, picture) in pictures.take(COUNTED_FRAMES).enumerate() {
            let mut reached = None;
            let counted = measure(|| reached = Some(self.step(before_m, picture)));
            assert_eq!(reached, Some(state), "frame {frame}");
            assert_eq!(counted.count_total, 0, "{state:?}, frame {frame}: {} bytes", counted.bytes_total);
        }
    }
}

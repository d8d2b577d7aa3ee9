//! Memory: a frame in a steady state allocates nothing, and ten thousand of them do not grow what is held.
//!
//! Every state is held by pictures that are driven forth and back, so that the vehicle moves and yet stays where the
//! state lasts. What a change of state costs once (masks drawn at a heading for the first time, buffers that reach
//! their size) falls into the frames before the count.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod painted;

use allocation_counter::measure;
use fingerpost::height::HeightUse;
use fingerpost::lanes::LaneMethod;
use fingerpost::matching::MatchedSurface;
use fingerpost::motion::MotionMethod;
use fingerpost::road_surface::{RoadError, RoadMethod, RoadNetwork, RoadPicture};
use fingerpost::track::{State, TrackMethod};
use fingerpost::vehicle::Traffic;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_geometry::Camera;
use fingerpost_map::{FeatureKind, LatLon};
use fingerpost_vision::picture::{Plane, RgbImage};
use nalgebra::{Isometry2, Vector2};
use painted::{Junction, Place, World, camera_of_width, route};

const WIDTH_M: f64 = 5.5;
const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const NORTH: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];

/// Where the painted worlds lie, and metres of a degree of latitude there.
const NODE_LAT_DEG: f64 = 47.1;
const NODE_LON_DEG: f64 = 9.5;
const METRES_PER_DEGREE: f64 = 111_180.0;
/// Offsets along the road of the pictures that are shown round and round, metres.
const FORTH_AND_BACK_M: [f64; 6] = [0.0, 0.3, 0.7, 1.0, 0.6, 0.3];
/// Distance of one frame of the way there, metres.
const STEP_M: f64 = 0.6;
/// Frames before the count: until every buffer has its size and every heading of the round has its masks.
const SETTLING_FRAMES: usize = 120;
const COUNTED_FRAMES: usize = 60;

/// A coarse view: the buffers are the same, only smaller.
fn coarse() -> Config {
    let mut config = Config::default();
    config.ground_view.metres_per_pixel = 0.1;
    // The painted roads meet at sharp corners.
    config.track.alignment.kerb_radius_m = 0.0;
    config.vehicle.traffic = Traffic::Centre;
    config
}

/// The same by the belief.
fn coarse_belief() -> Config {
    let mut config = coarse();
    config.track.method = TrackMethod::Belief;
    config
}

/// In place of a network, whose own memory is not the method's.
struct AllIsRoad;

impl RoadNetwork for AllIsRoad {
    fn segment(&mut self, _: &RgbImage, probability: &mut Plane<u8>) -> Result<(), RoadError> {
        if probability.size() != (80, 60) {
            probability.reset(80, 60, 255);
        }
        Ok(())
    }
}

/// A world with a vehicle on the road from the south in it.
struct Scene {
    world: World,
    camera: Camera,
    pipeline: Pipeline,
}

impl Scene {
    fn new(config: &Config, roads: &[&[Place]], junction: Option<&Junction<'_>>) -> Self {
        let camera = camera_of_width(320);
        let route = junction.map(|junction| route(junction).0);
        let roads: Vec<(&[Place], f64)> = roads.iter().map(|&road| (road, WIDTH_M)).collect();
        let detector = config.road_surface.detector_with(Some(Box::new(AllIsRoad))).unwrap();
        let pipeline = Pipeline::with_road_detector(config, &camera, route.as_ref(), None, detector).unwrap();
        Self { world: World::new(&roads), camera, pipeline }
    }

    /// A T-junction that is left to the right.
    fn t_junction(config: &Config) -> Self {
        let kind = FeatureKind::Junction;
        let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
        Self::new(config, &[SOUTH, EAST, WEST], Some(&junction))
    }

    fn picture(&self, before_m: f64) -> RgbImage {
        let map_from_vehicle = Isometry2::new(Vector2::new(0.0, -before_m), std::f64::consts::FRAC_PI_2);
        self.world.picture(&self.camera, &map_from_vehicle)
    }

    /// Shows a picture that was taken so far before the node, with the GPS position of a place nearby.
    fn step(&mut self, before_m: f64, picture: &RgbImage) -> State {
        let gps =
            Some(LatLon { lat_deg: NODE_LAT_DEG - before_m / METRES_PER_DEGREE, lon_deg: NODE_LON_DEG });
        self.pipeline.step(picture, Sensors { gps, ..Sensors::default() }, &mut |_| {}).unwrap().0.track.state
    }

    /// Drives on until `state` is reached; returns how far before the node that is.
    fn drive_until(&mut self, state: State) -> f64 {
        let mut before_m = 28.0;
        while self.step(before_m, &self.picture(before_m)) != state {
            before_m -= STEP_M;
            assert!(before_m > -10.0, "{state:?} is never reached");
        }
        before_m
    }

    /// The pictures of the round that starts so far before the node.
    fn round(&self, before_m: f64) -> Vec<RgbImage> {
        FORTH_AND_BACK_M.iter().map(|forward_m| self.picture(before_m - forward_m)).collect()
    }

    /// Settles on the round, then counts allocations while `state` lasts.
    fn check(&mut self, state: State, before_m: f64) {
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

#[test]
fn without_a_route_nothing_is_allocated() {
    Scene::new(&coarse(), &[SOUTH, NORTH], None).check(State::NoRoute, 28.0);
}

#[test]
fn the_papers_motion_surface_and_lanes_allocate_nothing() {
    let mut config = coarse();
    config.lanes.finder = LaneMethod::Sections;
    config.motion.estimator = MotionMethod::Farneback;
    config.matching.surface = MatchedSurface::Binary;
    Scene::new(&config, &[SOUTH, NORTH], None).check(State::NoRoute, 28.0);
}

#[test]
fn no_road_detector_allocates_anything() {
    for detector in RoadMethod::ALL {
        let mut config = coarse();
        config.road_surface.detector = detector;
        Scene::new(&config, &[SOUTH, NORTH], None).check(State::NoRoute, 28.0);
    }
}

#[test]
fn detectors_that_see_the_camera_picture_allocate_nothing() {
    for detector in [RoadMethod::Backprojection, RoadMethod::Bank] {
        let mut config = coarse();
        config.road_surface.detector = detector;
        config.road_surface.picture = RoadPicture::Camera;
        Scene::new(&config, &[SOUTH, NORTH], None).check(State::NoRoute, 28.0);
    }
}

#[test]
fn the_ground_s_height_allocates_nothing() {
    let mut config = coarse();
    config.height.used = HeightUse::Surface;
    Scene::new(&config, &[SOUTH, NORTH], None).check(State::NoRoute, 28.0);
}

#[test]
fn searching_allocates_nothing() {
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    for mut config in [coarse(), coarse_belief()] {
        // A place so sure that the junction, which is not there, is looked for far ahead alone.
        config.route_progress.gps_sigma_m = 1.0;
        Scene::new(&config, &[SOUTH, NORTH], Some(&junction)).check(State::Searching, 18.0);
    }
}

#[test]
fn tracking_allocates_nothing() {
    for config in [coarse(), coarse_belief()] {
        let mut scene = Scene::t_junction(&config);
        let before_m = scene.drive_until(State::Tracking);
        scene.check(State::Tracking, before_m);
    }
}

#[test]
fn arriving_allocates_nothing() {
    for config in [coarse(), coarse_belief()] {
        let mut scene = Scene::t_junction(&config);
        let before_m = scene.drive_until(State::Arrived);
        scene.check(State::Arrived, before_m);
    }
}

#[test]
fn ten_thousand_frames_hold_no_more_memory_than_one_thousand() {
    let mut scene = Scene::t_junction(&coarse());
    let before_m = scene.drive_until(State::Tracking);
    let round = scene.round(before_m);
    let mut pictures = round.iter().cycle();
    for picture in pictures.by_ref().take(1_000) {
        scene.step(before_m, picture);
    }
    let grown = measure(|| {
        for picture in pictures.take(9_000) {
            scene.step(before_m, picture);
        }
    });
    assert_eq!((grown.bytes_current, grown.count_current), (0, 0));
}

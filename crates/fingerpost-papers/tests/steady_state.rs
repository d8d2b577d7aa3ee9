//! Memory: the papers' own stages allocate nothing in a frame in a steady state, as the method's.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

#[path = "../../fingerpost/tests/steady/mod.rs"]
mod steady;

use fingerpost::Config;
use fingerpost::lanes::LaneMethod;
use fingerpost::matching::MatchedSurface;
use fingerpost::motion::MotionMethod;
use fingerpost::road_surface::{RoadMethod, RoadPicture};
use fingerpost::track::State;
use steady::{NORTH, SOUTH, Scene, coarse};

fn check(config: &Config) {
    let parts = fingerpost_papers::parts(config).unwrap();
    Scene::with_parts(config, &[SOUTH, NORTH], None, parts).check(State::NoRoute, 28.0);
}

#[test]
fn the_papers_motion_surface_and_lanes_allocate_nothing() {
    let mut config = coarse();
    config.lanes.finder = LaneMethod::Sections;
    config.motion.estimator = MotionMethod::Farneback;
    config.matching.surface = MatchedSurface::Binary;
    check(&config);
}

#[test]
fn the_bank_allocates_nothing() {
    let mut config = coarse();
    config.road_surface.detector = RoadMethod::Bank;
    check(&config);
}

#[test]
fn detectors_that_see_the_camera_picture_allocate_nothing() {
    for detector in [RoadMethod::Backprojection, RoadMethod::Bank] {
        let mut config = coarse();
        config.road_surface.detector = detector;
        config.road_surface.picture = RoadPicture::Camera;
        check(&config);
    }
}

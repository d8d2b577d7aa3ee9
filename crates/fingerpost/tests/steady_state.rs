//! Memory: a frame in a steady state allocates nothing, and ten thousand of them do not grow what is held.
//!
//! Every state is held by pictures that are driven forth and back, so that the vehicle moves and yet stays where the
//! state lasts. What a change of state costs once (masks drawn at a heading for the first time, buffers that reach
//! their size) falls into the frames before the count.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod steady;

use allocation_counter::measure;
use fingerpost::pipeline::Parts;
use fingerpost::road_surface::{Onnx, RoadDetector, RoadError, RoadMethod, UserNetwork};
use fingerpost::track::State;
use fingerpost_map::FeatureKind;
use fingerpost_vision::picture::{Plane, RgbImage};
use steady::{EAST, Junction, NORTH, SOUTH, Scene, WEST, WIDTH_M, coarse};

/// In place of a network, whose own memory is not the method's.
struct AllIsRoad;

impl UserNetwork for AllIsRoad {
    fn segment(&mut self, _: &RgbImage, probability: &mut Plane<u8>) -> Result<(), RoadError> {
        if probability.size() != (80, 60) {
            probability.reset(80, 60, 255);
        }
        Ok(())
    }
}

#[test]
fn without_a_route_nothing_is_allocated() {
    Scene::new(&coarse(), &[SOUTH, NORTH], None).check(State::NoRoute, 28.0);
}

#[test]
fn no_road_detector_allocates_anything() {
    // The bank is the papers' own and is looked at in `fingerpost-papers`.
    for detector in RoadMethod::ALL.into_iter().filter(|method| *method != RoadMethod::Bank) {
        let mut config = coarse();
        config.road_surface.detector = detector;
        let network = Some(Onnx::new(Box::new(AllIsRoad))).filter(|_| config.road_surface.needs_onnx());
        let seeing = network.map(|network| -> Box<dyn RoadDetector> { Box::new(network) });
        let road_detector = Some(config.road_surface.detector_with(seeing).unwrap());
        let parts = Parts { road_detector, ..Parts::default() };
        Scene::with_parts(&config, &[SOUTH, NORTH], None, parts).check(State::NoRoute, 28.0);
    }
}

#[test]
fn searching_allocates_nothing() {
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    let mut config = coarse();
    // A place so sure that the junction, which is not there, is looked for far ahead alone.
    config.route_progress.gps_sigma_m = 1.0;
    Scene::new(&config, &[SOUTH, NORTH], Some(&junction)).check(State::Searching, 18.0);
}

#[test]
fn tracking_allocates_nothing() {
    let mut scene = Scene::t_junction(&coarse());
    let before_m = scene.drive_until(State::Tracking);
    scene.check(State::Tracking, before_m);
}

#[test]
fn arriving_allocates_nothing() {
    let mut scene = Scene::t_junction(&coarse());
    let before_m = scene.drive_until(State::Arrived);
    scene.check(State::Arrived, before_m);
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

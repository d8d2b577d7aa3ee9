//! Detectors by colour on the camera picture, laid into the ground view (paper 1, figure 4), on a painted road.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

#[path = "../../fingerpost/tests/painted/mod.rs"]
mod painted;

use fingerpost::road_surface::{RememberedMethod, RoadMethod, RoadPicture};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_vision::picture::Plane;
use nalgebra::{Isometry2, Point2};
use painted::{World, camera_of_width};

/// A road that goes on ahead, and a side road to the right 14 m ahead of the vehicle.
const ROADS: [(&[painted::Place], f64); 2] =
    [(&[(-30.0, 0.0), (60.0, 0.0)], 5.5), (&[(14.0, 0.0), (14.0, -40.0)], 4.0)];
const FRAMES: usize = 3;
/// The vehicle ends at the map's origin.
const STEP_M: f64 = 0.3;

fn settings(detector: RoadMethod, picture: RoadPicture) -> Config {
    let mut config = Config::default();
    config.road_surface.detector = detector;
    config.road_surface.memory.of = RememberedMethod::Backprojection;
    config.road_surface.picture = picture;
    config
}

/// The surface after some frames, and its probabilities at places in metres ahead and to the left, 0 to 1.
fn surface(config: &Config, places: &[(f64, f64)]) -> (Plane<u8>, Vec<f64>) {
    let camera = camera_of_width(480);
    let world = World::new(&ROADS);
    let parts = fingerpost_papers::parts(config).unwrap();
    let mut pipeline = Pipeline::with_parts(config, &camera, None, None, parts).unwrap();
    let mut found = Plane::default();
    for before in (0..FRAMES).rev() {
        // A picture that comes again would be a frozen camera's.
        let map_from_vehicle = Isometry2::translation(-STEP_M * before as f64, 0.0);
        let picture = world.picture(&camera, &map_from_vehicle);
        let (_, evidence) = pipeline.step(&picture, Sensors::default(), &mut |_| {}).unwrap();
        assert!(
            evidence.road.sample_probability > 0.5,
            "the sample is road: {}",
            evidence.road.sample_probability
        );
        found = evidence.surface.probability.clone();
    }
    let at = |&(forward_m, left_m): &(f64, f64)| {
        let pixel = pipeline.view().grid().ground_from_vehicle(Point2::new(forward_m, left_m));
        f64::from(found.get(pixel.column.round() as usize, pixel.row.round() as usize).unwrap()) / 255.0
    };
    let values = places.iter().map(at).collect();
    (found, values)
}

#[test]
fn road_found_in_the_camera_picture_lies_where_it_is_in_the_ground_view() {
    let (road, grass) = ([(8.0, 0.0), (12.0, 1.5), (14.0, -6.0)], [(10.0, 6.0), (10.0, -5.0), (18.0, -6.0)]);
    for detector in [RoadMethod::Backprojection, RoadMethod::Bank, RoadMethod::Memory] {
        let (_, values) =
            surface(&settings(detector, RoadPicture::Camera), &[road.as_slice(), grass.as_slice()].concat());
        assert!(values[..3].iter().all(|p| *p > 0.6), "{detector:?}: road is {values:?}");
        assert!(values[3..].iter().all(|p| *p < 0.4), "{detector:?}: grass is {values:?}");
    }
}

#[test]
fn the_order_of_the_stages_changes_what_is_found() {
    for detector in [RoadMethod::Backprojection, RoadMethod::Bank, RoadMethod::Memory] {
        let [above, camera] = [RoadPicture::GroundView, RoadPicture::Camera]
            .map(|picture| surface(&settings(detector, picture), &[]).0);
        assert_ne!(above.as_slice(), camera.as_slice(), "{detector:?}");
    }
}

#[test]
fn what_is_asked_for_and_not_given_is_refused_with_what_to_do() {
    let camera = camera_of_width(480);
    for (config, asked) in [
        (settings(RoadMethod::Bank, RoadPicture::GroundView), "\"bank\""),
        (settings(RoadMethod::Memory, RoadPicture::Camera), "road_surface.picture = \"camera\""),
    ] {
        let refused = Pipeline::new(&config, &camera, None, None).err().unwrap().to_string();
        assert!(refused.contains(asked) && refused.contains("fingerpost_papers::parts"), "{refused}");
    }
}

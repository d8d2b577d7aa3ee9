//! Streets with kerbs: what the picture and the truth have of their heights.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use common::{camera, graph, route};
use fingerpost_geometry::Distortion;
use fingerpost_sim::{Conditions, CornerStyle, SimConfig, Simulator};
use nalgebra::Point3;

/// A kerbed street without anything that moves or hides.
const STREET: Conditions = Conditions {
    kerbs: 1.0,
    cross_fall: 0.0,
    parking_bays: 0.0,
    pavements_like_road: 1.0,
    trees_per_100_m: 0.0,
    houses_per_100_m: 0.0,
    ..Conditions::IDEAL
};

fn simulator(conditions: Conditions) -> Simulator {
    let graph = graph();
    let config = SimConfig { conditions, corners: CornerStyle::Drawn, seed: 3, ..SimConfig::default() };
    let camera = camera(320, 240, Distortion::None);
    Simulator::new(&graph, &route(&graph), &camera, &config).unwrap()
}

#[test]
fn kerbs_stand_at_the_road_s_edges() {
    let simulator = simulator(STREET);
    // Main Street is 6 m wide and straight on for 40 m; the car keeps a quarter of that to the right.
    for frame in [0, 10, 20] {
        let truth = simulator.truth(frame);
        assert!(truth.kerb_left_m.len() > 12 && truth.kerb_right_m.len() > 8, "{truth:?}");
        for [forward_m, left_m, height_m] in truth.kerb_left_m {
            assert!((left_m - 4.5).abs() < 0.05, "{left_m} at {forward_m}");
            assert!((0.02..=0.16).contains(&height_m), "{height_m}");
        }
        assert!(truth.kerb_right_m.iter().all(|kerb| (kerb[1] + 1.5).abs() < 0.05));
    }
}

#[test]
fn heights_in_the_picture_are_those_of_the_kerbs() {
    let simulator = simulator(STREET);
    let (heights, camera) = (simulator.frame(10).heights.unwrap(), simulator.camera_at(10).unwrap());
    let height_at = |forward_m: f64, left_m: f64, up_m: f64| {
        let pixel = camera.project(Point3::new(forward_m, left_m, up_m)).unwrap();
        let steps = heights.get(pixel.u.round() as usize, pixel.v.round() as usize).unwrap();
        (f64::from(steps) - 32_768.0) / 1000.0
    };
    let mut compared = 0;
    for kerbs in simulator.truth(10).kerb_left_m.windows(3) {
        let [before, [forward_m, left_m, kerb_m], after] = [kerbs[0], kerbs[1], kerbs[2]];
        // A pixel shows half a metre of a ramp at this distance.
        if (before[2] - kerb_m).abs().max((after[2] - kerb_m).abs()) > 0.005 {
            continue;
        }
        assert!(height_at(forward_m, left_m - 0.4, 0.0).abs() < 0.005, "the road at {forward_m}");
        let behind_m = height_at(forward_m, left_m + 0.4, kerb_m + 0.008);
        assert!((behind_m - kerb_m - 0.008).abs() < 0.01, "{behind_m} and not {kerb_m} at {forward_m}");
        compared += 1;
    }
    assert!(compared > 6, "{compared}");
    assert!((0..320).all(|u| heights.get(u, 2) == Some(0)), "the sky has none");
}

#[test]
fn a_pavement_is_seen_where_its_height_puts_it() {
    // The same street flat and kerbed: the road's mask loses what the near kerb's face and rise hide.
    let flat = simulator(Conditions { kerbs: 0.0, ..STREET });
    let kerbed = simulator(STREET);
    assert!(flat.frame(10).heights.is_none() && flat.truth(10).kerb_left_m.is_empty());
    let roads = [flat.frame(10).road, kerbed.frame(10).road];
    let areas = roads.map(|road| road.as_slice().iter().filter(|value| **value == 255).count());
    assert!(areas[1] < areas[0] && areas[1] > areas[0] * 9 / 10, "{areas:?}");
}

#[test]
fn a_car_on_a_falling_road_leans_with_it() {
    let level = simulator(STREET);
    let falling = simulator(Conditions { cross_fall: 0.03, ..STREET });
    let lean = |simulator: &Simulator| {
        let heights = simulator.frame(10).heights.unwrap();
        let camera = simulator.camera_at(10).unwrap();
        let pixel = camera.project(Point3::new(8.0, 0.4, 0.0)).unwrap();
        (f64::from(heights.get(pixel.u.round() as usize, pixel.v.round() as usize).unwrap()) - 32_768.0)
            / 1000.0
    };
    // The plane is that below the wheels, so that the ground between them lies in it either way.
    assert!(lean(&level).abs() < 0.005 && lean(&falling).abs() < 0.03);
    assert_ne!(level.frame(10).picture, falling.frame(10).picture);
}

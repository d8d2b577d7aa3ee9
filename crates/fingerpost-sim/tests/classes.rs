//! What each pixel shows, at known places.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use common::{camera, graph, route};
use fingerpost_geometry::Distortion;
use fingerpost_sim::{Conditions, CornerStyle, PixelClass, SimConfig, SimFrame, Simulator};
use nalgebra::Point3;

/// Streets with everything that has a class, on flat ground.
const STREET: Conditions =
    Conditions { kerbs: 1.0, cross_fall: 0.0, parking_bays: 0.0, ..Conditions::STREET };

fn simulator(conditions: Conditions) -> Simulator {
    let graph = graph();
    let config = SimConfig { conditions, corners: CornerStyle::Drawn, seed: 3, ..SimConfig::default() };
    Simulator::new(&graph, &route(&graph), &camera(320, 240, Distortion::None), &config).unwrap()
}

/// The class of the pixel that shows a place, metres in the vehicle frame.
fn class_at(simulator: &Simulator, index: usize, place: [f64; 3]) -> u8 {
    let pixel = simulator.camera_at(index).unwrap().project(Point3::from(place)).unwrap();
    simulator.frame(index).classes.get(pixel.u.round() as usize, pixel.v.round() as usize).unwrap()
}

/// How many pixels show a class.
fn area(frame: &SimFrame, class: PixelClass) -> usize {
    frame.classes.as_slice().iter().filter(|&&number| number == class as u8).count()
}

#[test]
fn road_kerb_pavement_verge_and_sky_are_where_they_are() {
    let bare = Conditions {
        trees_per_100_m: 0.0,
        houses_per_100_m: 0.0,
        walls: 0.0,
        parked_per_100_m: 0.0,
        ..STREET
    };
    // Main Street is 6 m wide; the car keeps 1.5 m to the right of its axis.
    let kerbed = simulator(Conditions { undulation_m: 0.0, suspension_rms_rad: 0.0, ..bare });
    for [forward_m, left_m, up_m] in [[8.0, 0.0, 0.0], [8.0, 3.0, 0.0], [12.0, -1.0, 0.0]] {
        assert_eq!(class_at(&kerbed, 10, [forward_m, left_m, up_m]), PixelClass::Road as u8);
    }
    let kerbs = kerbed.truth(10).kerb_left_m;
    let [forward_m, left_m, height_m] = kerbs[kerbs.len() / 2];
    let behind = |far_m: f64| class_at(&kerbed, 10, [forward_m, left_m + far_m, height_m]);
    assert_eq!([behind(0.1), behind(0.8)], [PixelClass::Raised as u8; 2]);
    assert_eq!(class_at(&kerbed, 10, [forward_m, left_m + 4.5, height_m]), PixelClass::Verge as u8);
    assert_eq!(class_at(&kerbed, 10, [30.0, 0.0, 12.0]), PixelClass::Sky as u8);
    let unkerbed = simulator(Conditions { kerbs: 0.0, ..Conditions::IDEAL });
    assert_eq!(class_at(&unkerbed, 10, [forward_m, 5.5, 0.0]), PixelClass::Verge as u8);
}

#[test]
fn paint_is_found_on_the_edge_line_and_between_the_lines_is_road() {
    let marked = simulator(Conditions { trees_per_100_m: 0.0, ..Conditions::IDEAL });
    // The axis is 1.5 m to the left of the car, the edges 3 m from it, the line on the right one 0.25 m inside of that.
    let is_paint = |left_m: &f64| class_at(&marked, 10, [6.0, *left_m, 0.0]) == PixelClass::Paint as u8;
    let painted: Vec<f64> = (0..28).map(|i| -1.5 + 0.1 * f64::from(i)).filter(is_paint).collect();
    assert!(painted.iter().any(|left_m| (left_m + 1.25).abs() < 0.1), "{painted:?}");
    assert!(painted.iter().all(|left_m| !(-1.0..1.35).contains(left_m)), "{painted:?}");
}

#[test]
fn the_mask_of_the_road_is_its_classes_without_the_bays() {
    let is_paved = |class: u8| class == PixelClass::Road as u8 || class == PixelClass::Paint as u8;
    for (conditions, has_bays) in [
        (Conditions::CLEAR, false),
        (STREET, false),
        (Conditions { pavements: 0.8, ..Conditions::MIXED }, false),
        (Conditions { parking_bays: 1.0, ..STREET }, true),
    ] {
        let simulator = simulator(conditions);
        let mut bays = 0;
        for index in [10, 40, 90] {
            let frame = simulator.frame(index);
            for (&road, &class) in frame.road.as_slice().iter().zip(frame.classes.as_slice()) {
                assert!(road == 0 || is_paved(class), "class {class} in the mask of the road");
                bays += usize::from(road == 0 && is_paved(class));
            }
        }
        assert_eq!(bays > 0, has_bays, "{bays} pixels of bays");
    }
}

#[test]
fn cars_hide_the_ground_and_houses_and_trees_are_structures() {
    let bare = Conditions {
        trees_per_100_m: 0.0,
        houses_per_100_m: 0.0,
        walls: 0.0,
        parked_per_100_m: 0.0,
        ..STREET
    };
    let built = Conditions { trees_per_100_m: 10.0, houses_per_100_m: 6.0, ..bare };
    let parked = Conditions { parked_per_100_m: 8.0, ..bare };
    let [bare, built, parked] = [bare, built, parked].map(|conditions| simulator(conditions).frame(10));
    assert_eq!(area(&bare, PixelClass::Thing), 0);
    assert!(area(&parked, PixelClass::Thing) > 200, "{}", area(&parked, PixelClass::Thing));
    let structures = [&bare, &built].map(|frame| area(frame, PixelClass::Structure));
    assert!(structures[1] > structures[0] + 2000, "{structures:?}");
    assert_eq!(area(&bare, PixelClass::Nothing), 0);
}

//! What lines streets: house fronts, avenues, furniture, rows of parked vehicles.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use common::{camera, graph, route};
use fingerpost_geometry::Distortion;
use fingerpost_sim::{
    Conditions, CornerStyle, Markings, PixelClass, SimConfig, SimFrame, Simulator, Streetscape, TrafficSide,
};
use nalgebra::Point3;

const BARE: Conditions = Conditions {
    markings: Markings::None,
    kerbs: 1.0,
    trees_per_100_m: 0.0,
    houses_per_100_m: 0.0,
    ..Conditions::IDEAL
};

fn simulator(traffic: TrafficSide, conditions: Conditions) -> Simulator {
    let graph = graph();
    let config =
        SimConfig { conditions, traffic, corners: CornerStyle::Drawn, seed: 3, ..SimConfig::default() };
    Simulator::new(&graph, &route(&graph), &camera(320, 240, Distortion::None), &config).unwrap()
}

fn lined(streetscape: Streetscape) -> Conditions {
    Conditions { streetscape, ..BARE }
}

/// Share of the pixels in a half of the picture, 0 the left and 1 the right one, that show a class.
fn share(frame: &SimFrame, half: usize, class: PixelClass) -> f64 {
    let (width, height) = frame.classes.size();
    let side = width / 2;
    let rows = (0..height).map(|v| &frame.classes.row(v)[half * side..(half + 1) * side]);
    let shown = rows.flatten().filter(|&&number| number == class as u8).count();
    shown as f64 / (side * height) as f64
}

#[test]
fn rows_of_vehicles_stand_on_both_sides_and_never_in_the_way() {
    let streetscape = Streetscape { parked_rows: 1.0, ..Streetscape::USUAL };
    for traffic in [TrafficSide::Right, TrafficSide::Left, TrafficSide::Centre] {
        let simulator = simulator(traffic, lined(streetscape));
        for index in [5, 15, 25] {
            let frame = simulator.frame(index);
            for half in [0, 1] {
                let things = share(&frame, half, PixelClass::Thing);
                assert!(things > 0.01, "{traffic:?}, half {half}: {things}");
            }
            let camera = simulator.camera_at(index).unwrap();
            for forward_m in [4.5, 6.0, 9.0, 12.0] {
                for left_m in [-0.9, 0.0, 0.9] {
                    let pixel = camera.project(Point3::new(forward_m, left_m, 0.0)).unwrap();
                    let class = frame.classes.get(pixel.u.round() as usize, pixel.v.round() as usize);
                    assert_eq!(class, Some(PixelClass::Road as u8), "{traffic:?} at {forward_m}, {left_m}");
                }
            }
        }
    }
}

#[test]
fn houses_walls_and_hedges_line_the_street_and_keep_off_it() {
    let plain = simulator(TrafficSide::Right, BARE).frame(10);
    let streetscape = Streetscape { frontage: 1.0, ..Streetscape::USUAL };
    let built = simulator(TrafficSide::Right, lined(streetscape)).frame(10);
    for half in [0, 1] {
        let [before, after] = [&plain, &built].map(|frame| share(frame, half, PixelClass::Structure));
        assert!(after > before + 0.08, "half {half}: {before} and {after}");
    }
    let near = |frame: &SimFrame| -> Vec<u8> {
        let (width, height) = frame.road.size();
        (3 * height / 4..height).flat_map(|v| frame.road.row(v)[..width].to_vec()).collect()
    };
    assert_eq!(near(&plain), near(&built), "nothing stands on the road before the camera");
}

#[test]
fn an_avenue_shades_the_road() {
    let sunny = Conditions { shadow_strength: 1.0, shadow_detail: 1.0, ..BARE };
    let streetscape = Streetscape { avenue_per_100_m: 12.0, ..Streetscape::USUAL };
    let level = |conditions: Conditions| {
        let frame = simulator(TrafficSide::Right, conditions).frame(12);
        let pixels = frame.picture.as_slice().chunks_exact(3).zip(frame.classes.as_slice());
        let road: Vec<f64> = pixels
            .filter(|(_, class)| **class == PixelClass::Road as u8)
            .map(|(pixel, _)| f64::from(pixel[1]))
            .collect();
        road.iter().sum::<f64>() / road.len() as f64
    };
    let [open, shaded] = [sunny, Conditions { streetscape, ..sunny }].map(level);
    assert!(shaded < open - 8.0, "{open} and {shaded}");
}

#[test]
fn people_and_bins_are_things() {
    let streetscape = Streetscape { furniture_per_100_m: 30.0, ..Streetscape::USUAL };
    let frame = simulator(TrafficSide::Right, lined(streetscape)).frame(10);
    assert!(share(&frame, 0, PixelClass::Thing) > 0.001 && share(&frame, 1, PixelClass::Thing) > 0.001);
}

//! The same input gives the same bytes; motion is consistent; bad input is refused.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use fingerpost_geometry::{Camera, Distortion, Pixel, wrap_angle};
use fingerpost_sim::{Conditions, SimConfig, SimError, SimFrame, Simulator, TrafficSide};
use nalgebra::{Point2, Vector2};

fn camera() -> Camera {
    common::camera(320, 240, Distortion::None)
}

fn simulator(config: &SimConfig) -> Simulator {
    let graph = common::graph();
    Simulator::new(&graph, &common::route(&graph), &camera(), config).unwrap()
}

fn on_threads(threads: usize, config: &SimConfig, indices: &[usize]) -> Vec<SimFrame> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let simulator = simulator(config);
        indices.iter().map(|&index| simulator.frame(index)).collect()
    })
}

#[test]
fn bytes_do_not_depend_on_threads_or_order() {
    let config = SimConfig { conditions: Conditions::SHADOWS, ..SimConfig::default() };
    let one = on_threads(1, &config, &[3, 60, 130]);
    let mut other = on_threads(2, &config, &[130, 60, 3]);
    other.reverse();
    assert!(one == other, "the frames differ");
}

#[test]
fn another_seed_is_another_drive_on_the_same_roads() {
    let frame = |seed| simulator(&SimConfig { seed, ..SimConfig::default() }).frame(40);
    let (one, other) = (frame(1), frame(2));
    let differing =
        one.picture.as_slice().iter().zip(other.picture.as_slice()).filter(|(a, b)| a != b).count();
    assert!(differing > one.picture.as_slice().len() / 2);
    let moved = Vector2::new(one.truth.x_m - other.truth.x_m, one.truth.y_m - other.truth.y_m).norm();
    assert!(moved > 1e-3 && moved < 0.5, "{moved} m apart: the wander alone");
}

/// Mean grey level of the pixels that show road.
fn road_brightness(frame: &SimFrame) -> f64 {
    let pixels = frame.picture.as_slice().chunks_exact(3).zip(frame.road.as_slice());
    let road: Vec<f64> =
        pixels.filter(|(_, road)| **road > 0).map(|(pixel, _)| f64::from(pixel[1])).collect();
    road.iter().sum::<f64>() / road.len() as f64
}

#[test]
fn a_day_changes_the_light_and_leaves_the_road_where_it_is() {
    let frame =
        |conditions: Conditions| simulator(&SimConfig { conditions, ..SimConfig::default() }).frame(40);
    let [clear, wet, dusk, dust] =
        [Conditions::CLEAR, Conditions::WET, Conditions::DUSK, Conditions::DUST].map(frame);
    for other in [&wet, &dusk, &dust] {
        assert_eq!(other.road, clear.road);
        assert!((other.truth.x_m - clear.truth.x_m).abs() < 1e-9);
    }
    let [clear, wet, dusk] = [&clear, &wet, &dusk].map(road_brightness);
    assert!(dusk < 0.6 * clear && wet < 0.95 * clear, "{clear} {wet} {dusk}");
}

#[test]
fn dirt_stays_on_the_lens_and_a_covering_on_the_road() {
    let bare = Conditions { trees_per_100_m: 0.0, houses_per_100_m: 0.0, ..Conditions::IDEAL };
    let frames = |conditions: Conditions| {
        let simulator = simulator(&SimConfig { conditions, ..SimConfig::default() });
        [30, 60].map(|index| simulator.frame(index))
    };
    let differing = |one: &SimFrame, other: &SimFrame| -> Vec<usize> {
        let bytes = one.picture.as_slice().iter().zip(other.picture.as_slice()).enumerate();
        bytes.filter(|(_, (a, b))| a != b).map(|(i, _)| i / 3).collect()
    };
    let clean = frames(bare);
    let dirty = frames(Conditions { lens_dirt: 0.1, ..bare });
    assert_eq!(dirty[0].road, clean[0].road);
    let spots = [0, 1].map(|i| differing(&clean[i], &dirty[i]));
    assert!(spots[0].len() > 500);
    let common = spots[0].iter().filter(|pixel| spots[1].binary_search(pixel).is_ok()).count();
    assert!(common * 10 > spots[0].len() * 8, "{common} of {} pixels", spots[0].len());
    let mixed = frames(Conditions { stretch_m: 20.0, ..bare });
    let changed = differing(&clean[0], &mixed[0]);
    let on_road = changed.iter().filter(|&&pixel| clean[0].road.as_slice()[pixel] > 0).count();
    assert!(on_road > 2000, "{on_road} road pixels have another covering");
}

#[test]
fn noise_changes_from_frame_to_frame() {
    let simulator = simulator(&SimConfig { fps: 1000.0, ..SimConfig::default() });
    // A millisecond apart the scene is the same, the noise is not.
    let (one, other) = (simulator.frame(0), simulator.frame(1));
    let differing =
        one.picture.as_slice().iter().zip(other.picture.as_slice()).filter(|(a, b)| a != b).count();
    assert!(differing > one.picture.as_slice().len() / 2);
}

#[test]
fn positions_are_the_integral_of_speed_and_heading() {
    let simulator = simulator(&SimConfig { fps: 100.0, ..SimConfig::default() });
    let mut place: Option<Point2<f64>> = None;
    let mut heading_rad = 0.0;
    for index in 0..simulator.frames() {
        let truth = simulator.truth(index);
        assert!(truth.speed_mps * truth.yaw_rate_rps.abs() <= 2.5, "lateral acceleration in frame {index}");
        let here = Point2::new(truth.x_m, truth.y_m);
        if let Some(last) = place {
            heading_rad += truth.yaw_rate_rps * 0.01;
            let predicted = last
                + Vector2::new(libm::cos(truth.heading_rad), libm::sin(truth.heading_rad))
                    * truth.speed_mps
                    * 0.01;
            assert!((predicted - here).norm() < 2e-3, "frame {index}");
        } else {
            heading_rad = truth.heading_rad;
        }
        place = Some(here);
    }
    let last = simulator.truth(simulator.frames() - 1);
    // The yaw rate's rectangles over the whole drive, a left and a right corner and a bend.
    assert!(wrap_angle(heading_rad - last.heading_rad).abs() < 0.01);
}

#[test]
fn turns_have_their_sign() {
    let simulator = simulator(&SimConfig::default());
    let rate_near = |x: f64, y: f64| {
        let distance = |i: &usize| {
            let truth = simulator.truth(*i);
            libm::hypot(truth.x_m - x, truth.y_m - y)
        };
        let nearest = (0..simulator.frames()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        simulator.truth(nearest).yaw_rate_rps
    };
    assert!(rate_near(119.0, 1.0) > 0.4, "left at the T");
    assert!(rate_near(123.0, 67.0) < -0.4, "right at the crossroads");
}

#[test]
fn traffic_keeps_to_its_side() {
    let left_of_axis = |traffic| simulator(&SimConfig { traffic, ..SimConfig::default() }).truth(20).y_m;
    assert!((left_of_axis(TrafficSide::Right) + 1.5).abs() < 0.15);
    assert!(left_of_axis(TrafficSide::Centre).abs() < 0.15);
    assert!((left_of_axis(TrafficSide::Left) - 1.5).abs() < 0.15);
}

#[test]
fn places_do_not_depend_on_the_frame_rate() {
    let truth = |fps: f64, index| simulator(&SimConfig { fps, ..SimConfig::default() }).truth(index);
    let (slow, fast) = (truth(5.0, 30), truth(30.0, 180));
    assert!(libm::hypot(slow.x_m - fast.x_m, slow.y_m - fast.y_m) < 1e-9);
}

#[test]
fn bad_input_is_refused_with_its_cause() {
    let graph = common::graph();
    let route = common::route(&graph);
    let refused =
        |config: &SimConfig| Simulator::new(&graph, &route, &camera(), config).unwrap_err().to_string();
    assert!(refused(&SimConfig { fps: f64::NAN, ..SimConfig::default() }).starts_with("fps = NaN"));
    assert!(refused(&SimConfig { start_m: 1e5, ..SimConfig::default() }).contains("plan a longer one"));
    let mut elsewhere = route.clone();
    for point in &mut elsewhere.line {
        point.at.lat_deg += 0.002;
    }
    let off = Simulator::new(&graph, &elsewhere, &camera(), &SimConfig::default()).unwrap_err();
    assert!(matches!(off, SimError::RouteOffTheMap { .. }), "{off}");
    let mut empty = route.clone();
    empty.line.clear();
    assert!(Simulator::new(&graph, &empty, &camera(), &SimConfig::default()).is_err());
    let corners =
        [(0.0, 239.0), (319.0, 239.0), (200.0, 120.0), (120.0, 120.0)].map(|(u, v)| Pixel::new(u, v));
    let places = [(4.0, 2.0), (4.0, -2.0), (20.0, -3.0), (20.0, 3.0)].map(|(x, y)| Point2::new(x, y));
    let by_points = Camera::from_points(320, 240, corners, places).unwrap();
    let refused = Simulator::new(&graph, &route, &by_points, &SimConfig::default()).unwrap_err();
    assert_eq!(refused, SimError::CameraWithoutLens);
}

#[test]
fn the_number_of_frames_is_bounded_by_the_route() {
    let all = simulator(&SimConfig::default()).frames();
    assert_eq!(simulator(&SimConfig { frames: Some(7), ..SimConfig::default() }).frames(), 7);
    assert_eq!(simulator(&SimConfig { frames: Some(100_000), ..SimConfig::default() }).frames(), all);
    assert!((300..800).contains(&all), "{all} frames for 360 m at 10 frames a second");
}

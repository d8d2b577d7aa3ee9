//! The picture by known places: what the map says is where the camera sees it.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use fingerpost_format::TruthRecord;
use fingerpost_geometry::{Camera, Distortion, Pixel};
use fingerpost_sim::{Conditions, SimConfig, SimFrame, Simulator};
use fingerpost_vision::picture::Plane;
use nalgebra::{Isometry2, Point2, Vector2};

/// A scene without objects, so that nothing hides the road.
fn bare() -> SimConfig {
    let conditions = Conditions { trees_per_100_m: 0.0, houses_per_100_m: 0.0, ..Conditions::IDEAL };
    SimConfig { conditions, ..SimConfig::default() }
}

fn simulator(camera: &Camera, config: &SimConfig) -> Simulator {
    let graph = common::graph();
    Simulator::new(&graph, &common::route(&graph), camera, config).unwrap()
}

fn pose(truth: &TruthRecord) -> Isometry2<f64> {
    Isometry2::new(Vector2::new(truth.x_m, truth.y_m), truth.heading_rad)
}

/// Where a place of the map appears.
fn pixel_of(camera: &Camera, truth: &TruthRecord, p_in_map: Point2<f64>) -> Pixel {
    camera.pixel_of_ground(pose(truth).inverse_transform_point(&p_in_map)).unwrap()
}

/// Column at which a row of the mask changes between `from` and `to`, interpolated to the boundary between pixels.
fn edge_column(mask: &Plane<u8>, row: usize, from: usize, to: usize) -> f64 {
    let row = &mask.row(row)[from..to];
    let changes: Vec<usize> = (1..row.len()).filter(|&i| row[i] != row[i - 1]).collect();
    assert_eq!(changes.len(), 1, "one edge between columns {from} and {to}");
    (from + changes[0]) as f64 - 0.5
}

/// The frame when the vehicle is about `x` metres east on Main Street, before its first corner.
fn frame_on_main_street(simulator: &Simulator, x: f64) -> SimFrame {
    let index = (0..simulator.frames()).find(|&i| simulator.truth(i).x_m >= x).unwrap();
    simulator.frame(index)
}

fn check_main_street_edges(camera: &Camera) {
    let frame = frame_on_main_street(&simulator(camera, &bare()), 70.0);
    let mut checked = 0;
    // Main Street is 6 m wide and runs along the x axis.
    for ahead_m in [7.0, 10.0, 14.0] {
        for edge_m in [3.0, -3.0] {
            let place = Point2::new(frame.truth.x_m + ahead_m, edge_m);
            let expected = pixel_of(camera, &frame.truth, place);
            if !(12.0..camera.width() as f64 - 12.0).contains(&expected.u)
                || expected.v > camera.height() as f64 - 2.0
            {
                continue;
            }
            // The edge at the row's centre: intersect the edge's picture with that row.
            let row = expected.v.round();
            let nearby = pixel_of(camera, &frame.truth, place + Vector2::new(0.05, 0.0));
            let slope = (nearby.u - expected.u) / (nearby.v - expected.v);
            let at_row = expected.u + slope * (row - expected.v);
            let found = edge_column(&frame.road, row as usize, at_row as usize - 9, at_row as usize + 10);
            assert!(
                (found - at_row).abs() < 1.0,
                "{ahead_m} m ahead: edge in column {found}, expected {at_row}"
            );
            checked += 1;
        }
    }
    assert!(checked >= 4, "only {checked} places were in the picture");
}

#[test]
fn the_roads_edge_is_where_the_map_has_it() {
    check_main_street_edges(&common::camera(640, 480, Distortion::None));
    check_main_street_edges(&common::camera(1241, 376, Distortion::None));
}

#[test]
fn the_roads_edge_is_bent_as_the_lens_bends_it() {
    let barrel = Distortion::brown_conrady(&[-0.25, 0.05, 0.0, 0.0]).unwrap();
    check_main_street_edges(&common::camera(640, 480, barrel));
    let fish_eye = Distortion::kannala_brandt(&[-0.02, 0.004, -0.003, 0.0005]).unwrap();
    check_main_street_edges(&common::camera(640, 480, fish_eye));
}

#[test]
fn the_far_edge_of_a_t_junction_is_where_the_map_has_it() {
    let camera = common::camera(640, 480, Distortion::None);
    let frame = frame_on_main_street(&simulator(&camera, &bare()), 100.0);
    // North Road is 6 m wide about x = 120 m: its far edge at x = 123 m, straight ahead.
    let expected = pixel_of(&camera, &frame.truth, Point2::new(123.0, frame.truth.y_m));
    let column = expected.u.round() as usize;
    let rows: Vec<u8> = (0..480).map(|v| frame.road.get(column, v).unwrap()).collect();
    let first = rows.iter().position(|&value| value == 255).unwrap();
    assert!((first as f64 - 0.5 - expected.v).abs() < 1.0, "row {first}, expected {}", expected.v);
    assert!(rows[first..].iter().all(|&value| value == 255), "road all the way from there to the vehicle");
}

#[test]
fn dashes_begin_where_the_road_counts_them() {
    let camera = common::camera(640, 480, Distortion::None);
    let frame = frame_on_main_street(&simulator(&camera, &bare()), 70.0);
    // Dashes of 3 m every 9 m from the chain's start at node 1: one from 81 to 84 m, then a gap to 90 m.
    let brightness = |x: f64| {
        let pixel = pixel_of(&camera, &frame.truth, Point2::new(x, 0.0));
        let [r, g, b] = frame.picture.get(pixel.u.round() as usize, pixel.v.round() as usize).unwrap();
        u32::from(r) + u32::from(g) + u32::from(b)
    };
    assert!(brightness(81.3) > 500 && brightness(83.7) > 500, "paint at both ends of the dash");
    assert!(brightness(80.5) < 450 && brightness(84.6) < 450, "asphalt before and after it");
}

#[test]
fn body_motion_and_undulation_are_in_camera_at() {
    let camera = common::camera(640, 480, Distortion::None);
    let conditions =
        Conditions { undulation_m: 0.0, trees_per_100_m: 0.0, houses_per_100_m: 0.0, ..Conditions::ROUGH };
    let simulator = simulator(&camera, &SimConfig { conditions, ..SimConfig::default() });
    let index = (0..simulator.frames()).find(|&i| simulator.truth(i).x_m >= 75.0).unwrap();
    let frame = simulator.frame(index);
    let tilted = simulator.camera_at(index).unwrap();
    let place = Point2::new(frame.truth.x_m + 10.0, -3.0);
    let expected = pixel_of(&tilted, &frame.truth, place);
    let row = expected.v.round() as usize;
    let nearby = pixel_of(&tilted, &frame.truth, place + Vector2::new(0.05, 0.0));
    let at_row = expected.u + (nearby.u - expected.u) / (nearby.v - expected.v) * (row as f64 - expected.v);
    let found = edge_column(&frame.road, row, at_row as usize - 9, at_row as usize + 10);
    assert!((found - at_row).abs() < 1.0, "edge in column {found}, expected {at_row}");
}

#[test]
fn the_next_feature_is_where_the_node_is() {
    let camera = common::camera(640, 480, Distortion::None);
    let simulator = simulator(&camera, &bare());
    let graph = common::graph();
    let route = common::route(&graph);
    let plane = route.plane().unwrap();
    let mut seen = Vec::new();
    for index in 0..simulator.frames() {
        let truth = simulator.truth(index);
        let Some(id) = truth.feature_id else { continue };
        let node = plane.map_from_wgs84(graph.nodes()[graph.node_index(id).unwrap()].at);
        let p_in_vehicle = pose(&truth).inverse_transform_point(&node);
        assert!((p_in_vehicle.x - truth.feature_forward_m.unwrap()).abs() < 1e-6);
        assert!((p_in_vehicle.y - truth.feature_left_m.unwrap()).abs() < 1e-6);
        if seen.last() != Some(&id) {
            seen.push(id);
        }
    }
    assert_eq!(seen, route.features.iter().map(|feature| feature.id).collect::<Vec<_>>());
    // On Main Street the node of the side road only comes nearer, and it is to the left: traffic keeps right.
    let start = (simulator.truth(0), simulator.truth(10));
    assert!(start.1.feature_forward_m < start.0.feature_forward_m);
    assert!((start.0.feature_left_m.unwrap() - 1.5).abs() < 0.1, "a quarter of six metres");
}

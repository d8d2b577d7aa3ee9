//! Roads and route lie where the start has them.

use fingerpost_geometry::{Distortion, Intrinsics, Mount};

use super::*;

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 319.5, cy: 239.5 };
    Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(1.5)).expect("a camera")
}

fn places(points: &[[f64; 2]]) -> Vec<Point2<f64>> {
    points.iter().map(|&[east, north]| Point2::new(east, north)).collect()
}

/// 100 m to the east and 100 m to the north, with a road through the corner and a junction there; a road far away.
fn map() -> RouteMap {
    let line = Polyline::new(places(&[[0.0, 0.0], [100.0, 0.0], [100.0, 100.0]])).expect("a line");
    let roads = vec![places(&[[-5000.0, 0.0], [5000.0, 0.0]]), places(&[[9000.0, 0.0], [9000.0, 50.0]])];
    let junction = RoutePlace { p_in_map: Point2::new(100.0, 0.0), label: "junction at 100 m".to_owned() };
    RouteMap::new(line, roads, vec![junction])
}

fn of_kind(shapes: Vec<Shape>, kind: ShapeKind) -> Vec<Shape> {
    shapes.into_iter().filter(|shape| shape.kind == kind).collect()
}

#[test]
fn the_junction_comes_nearer_as_the_start_moves_to_it() {
    for start_m in [30.0, 50.0, 99.0] {
        let seen = of_kind(map().shapes(&camera(), start_m), ShapeKind::Feature);
        let [forward_m, left_m] = seen[0].ground_m[0];
        assert!((forward_m - (100.0 - start_m)).abs() < 1e-3 && left_m.abs() < 1e-3, "{start_m}: {seen:?}");
    }
    // Too far away, behind, and to the left behind the corner.
    assert!(of_kind(map().shapes(&camera(), 10.0), ShapeKind::Feature).is_empty());
    assert!(of_kind(map().shapes(&camera(), 120.0), ShapeKind::Feature).is_empty());
}

#[test]
fn the_route_turns_to_the_left_where_it_goes_north() {
    let route = &of_kind(map().shapes(&camera(), 80.0), ShapeKind::Route)[0];
    let first = route.ground_m[0];
    let last = route.ground_m[route.ground_m.len() - 1];
    assert!(first[0].abs() < 1e-3 && first[1].abs() < 1e-3, "{first:?}");
    assert!((last[0] - 20.0).abs() < 1e-3 && (last[1] - 60.0).abs() < 1e-3, "{last:?}");
    // Ahead in the picture's middle, below the horizon.
    let pixel = route.picture_px[0][10];
    assert!((pixel[0] - 319.5).abs() < 0.5 && pixel[1] > 239.5, "{pixel:?}");
    let beyond = map().shapes(&camera(), 200.0);
    assert!(of_kind(beyond, ShapeKind::Route).is_empty());
}

#[test]
fn of_a_long_road_the_part_about_the_vehicle_is_drawn() {
    let roads = of_kind(map().shapes(&camera(), 40.0), ShapeKind::Road);
    let [road] = &roads[..] else { panic!("one road is near: {roads:?}") };
    let ends = [road.ground_m[0], road.ground_m[road.ground_m.len() - 1]];
    assert!((ends[0][0] + SEEN_M).abs() < 1e-3 && (ends[1][0] - SEEN_M).abs() < 1e-3, "{ends:?}");
    assert!(road.ground_m.windows(2).all(|pair| pair[1][0] - pair[0][0] <= STEP_M + 1e-3));
    // What lies far from the whole route is not on the page.
    assert_eq!(map().roads.len(), 1);
}

#[test]
fn roads_of_no_length_and_stacked_points_are_no_harm() {
    let line = Polyline::new(places(&[[0.0, 0.0], [10.0, 0.0]])).expect("a line");
    let roads = vec![places(&[[5.0, 1.0]]), places(&[[5.0, 1.0], [5.0, 1.0], [6.0, 1.0]]), Vec::new()];
    let shapes = RouteMap::new(line, roads, Vec::new()).shapes(&camera(), 0.0);
    assert_eq!(of_kind(shapes, ShapeKind::Road).len(), 1);
}

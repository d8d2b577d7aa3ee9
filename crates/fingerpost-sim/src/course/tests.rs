//! Made-up roads against their own numbers.

use super::*;

#[test]
fn a_bend_turns_as_far_as_it_says() {
    for turn_rad in [0.3, -1.0] {
        let bend = CoursePiece::Bend { radius_m: 60.0, turn_rad };
        let course = RoadCourse { pieces: vec![bend], ..RoadCourse::straight(1.0) };
        let axis = course.axis();
        let last = axis[axis.len() - 1];
        assert!((last.heading_rad - turn_rad).abs() < 1e-9);
        assert!(axis.iter().all(|point| point.curvature_per_m.abs() < 1.0 / 59.99));
        let tightest = axis.iter().map(|point| point.curvature_per_m.abs()).fold(0.0, f64::max);
        assert!((tightest * 60.0 - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_maps_pieces_stay_on_the_axis_and_the_route_on_the_map() {
    let course = RoadCourse::country(3, 2000.0);
    let (graph, route) = course.roads().unwrap();
    let plane = route.plane().unwrap();
    let nodes: Vec<Point2<f64>> = graph.nodes().iter().map(|node| plane.map_from_wgs84(node.at)).collect();
    let map = fingerpost_geometry::Polyline::new(nodes).unwrap();
    let line = route.polyline().unwrap();
    assert!((line.length_m() - course.length_m()).abs() < 0.1);
    for point in line.points().iter().step_by(37) {
        assert!(map.nearest(*point).left_m.abs() < 2.0 * SAG_M);
    }
}

#[test]
fn a_highway_has_two_carriageways_that_never_meet() {
    let course = RoadCourse::highway(5, 4000.0);
    assert!(course.length_m() > 4000.0 && course.length_m() < 6000.0);
    let (graph, route) = course.roads().unwrap();
    assert_eq!(graph.ways().len(), 2);
    let line = route.polyline().unwrap();
    let plane = route.plane().unwrap();
    for &node in &graph.ways()[1].nodes {
        let aside_m = line.nearest(plane.map_from_wgs84(graph.nodes()[node].at)).left_m;
        assert!((aside_m - 15.4).abs() < 0.05, "{aside_m}");
    }
    assert_eq!(course, RoadCourse::highway(5, 4000.0));
    assert_ne!(course, RoadCourse::highway(6, 4000.0));
}

#[test]
fn courses_that_make_no_road_are_refused() {
    let bend = CoursePiece::Bend { radius_m: 10.0, turn_rad: 1.0 };
    let course = RoadCourse { pieces: vec![bend], ..RoadCourse::straight(1.0) };
    assert!(course.roads().unwrap_err().to_string().contains("radius_m = 10"));
    assert!(RoadCourse::straight(f64::NAN).roads().is_err());
}

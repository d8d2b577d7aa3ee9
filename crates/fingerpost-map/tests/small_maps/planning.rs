//! Shortest routes, one-way streets, stops, and why there is none.

use fingerpost_map::{FeatureOptions, LatLon, RoadGraph, Route, RouteError, plan};

use crate::town::{Town, at};

/// A block of streets 100 m by 60 m with a dead end of 50 m to the east of node 3 and an island of its own far east.
///
/// ```text
/// 4 ------- 3 --- 5        8 -- 9
/// |         |
/// 1 ------- 2
/// ```
fn block(south_tags: &[&str]) -> RoadGraph {
    Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 100.0, 0.0)
        .node(3, 100.0, 60.0)
        .node(4, 0.0, 60.0)
        .node(5, 150.0, 60.0)
        .node(8, 500.0, 60.0)
        .node(9, 550.0, 60.0)
        .way(10, &[1, 2], south_tags)
        .way(11, &[2, 3, 4, 1], &["highway=residential"])
        .way(12, &[3, 5], &["highway=service"])
        .way(13, &[8, 9], &["highway=residential"])
        .graph()
}

fn route(graph: &RoadGraph, stops: &[(f64, f64)]) -> Result<Route, RouteError> {
    let stops: Vec<LatLon> = stops.iter().map(|&(x, y)| at(x, y)).collect();
    plan(graph, &stops, &FeatureOptions::default())
}

fn nodes(route: &Route) -> Vec<Option<i64>> {
    route.line.iter().map(|point| point.node).collect()
}

fn length_m(route: &Route) -> f64 {
    route.polyline().unwrap().length_m()
}

#[test]
fn the_shorter_way_round_from_between_nodes() {
    let graph = block(&["highway=residential"]);
    let route = route(&graph, &[(20.0, -3.0), (98.0, 50.0)]).unwrap();
    assert_eq!(nodes(&route), [None, Some(2), None]);
    assert!((length_m(&route) - 130.0).abs() < 1e-3, "{}", length_m(&route));
    let start = route.line[0].at;
    assert!((start.lat_deg - at(20.0, 0.0).lat_deg).abs() < 1e-9, "the start lies on the road");
}

#[test]
fn one_way_streets_are_gone_round() {
    let graph = block(&["highway=residential", "oneway=-1"]);
    let way_there = route(&graph, &[(20.0, 0.0), (98.0, 50.0)]).unwrap();
    assert_eq!(nodes(&way_there), [None, Some(1), Some(4), Some(3), None]);
    let way_back = route(&graph, &[(98.0, 50.0), (20.0, 0.0)]).unwrap();
    assert_eq!(nodes(&way_back), [None, Some(2), None]);
    let round_the_block = route(&graph, &[(20.0, 0.0), (60.0, 0.0)]).unwrap();
    assert!(
        (length_m(&round_the_block) - 280.0).abs() < 1e-3,
        "the stop ahead is behind on a one-way street"
    );
}

#[test]
fn stops_at_nodes_are_those_nodes() {
    let graph = block(&["highway=residential"]);
    let route = route(&graph, &[(0.0, 0.0), (100.0, 0.0), (100.0, 60.0)]).unwrap();
    assert_eq!(nodes(&route), [Some(1), Some(2), Some(3)]);
    assert!((length_m(&route) - 160.0).abs() < 1e-3);
}

#[test]
fn at_a_stop_the_route_goes_on_and_turns_only_at_dead_ends() {
    let graph = block(&["highway=residential"]);
    let onwards = route(&graph, &[(50.0, 0.0), (100.0, 20.0), (50.0, 0.0)]).unwrap();
    assert!((length_m(&onwards) - 320.0).abs() < 1e-3, "round the block, {}", length_m(&onwards));
    let dead_end = route(&graph, &[(100.0, 30.0), (140.0, 60.0), (50.0, 60.0)]).unwrap();
    assert_eq!(nodes(&dead_end), [None, Some(3), Some(5), Some(3), None]);
    assert!((length_m(&dead_end) - 180.0).abs() < 1e-3, "{}", length_m(&dead_end));
}

#[test]
fn why_there_is_no_route() {
    let graph = block(&["highway=residential"]);
    assert_eq!(route(&graph, &[(0.0, 0.0)]), Err(RouteError::TooFewStops { found: 1 }));
    assert_eq!(route(&graph, &[(5.0, 0.0), (5.0, 0.0)]), Err(RouteError::NoLength));
    let unreachable = route(&graph, &[(0.0, 0.0), (50.0, 60.0), (520.0, 60.0)]).unwrap_err();
    assert_eq!(unreachable, RouteError::Unreachable { from_stop: 2, to_stop: 3 });
    assert!(unreachable.to_string().contains("from stop 2 to stop 3"));
    let off_road = route(&graph, &[(0.0, 0.0), (0.0, 2000.0)]).unwrap_err();
    let RouteError::StopOffRoad { stop: 2, off } = off_road.clone() else { panic!("{off_road}") };
    assert!((off.nearest_m.unwrap() - 1940.0).abs() < 0.1, "{off}");
    assert!(off_road.to_string().contains("1940 m from the nearest road"), "{off_road}");
}

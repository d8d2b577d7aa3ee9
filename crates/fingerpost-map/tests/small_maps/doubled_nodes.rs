//! Nodes at one place, and junctions with more roads than there are.

use fingerpost_map::{
    FeatureKind, FeatureOptions, GraphError, MapNoticeKind, RoadGraph, plan, read_route, write_route,
};

use crate::town::{Town, at, plane};

/// A road to the east whose node at 100 m is there so often as `row` says, with a side road from the last of them; the ways
/// between them, if there are any, have no length.
fn road(row: &[i64], joined: bool) -> Town {
    let (first, last) = (row[0], row[row.len() - 1]);
    let town = Town::default().node(100, 0.0, 0.0).node(101, 200.0, 0.0).node(102, 100.0, 80.0);
    let town = row.iter().fold(town, |town, &id| town.node(id, 100.0, 0.0));
    let town = if joined { town.way(50, row, &["highway=residential"]) } else { town };
    town.way(51, &[100, first], &["highway=residential"]).way(52, &[last, 101], &["highway=residential"]).way(
        53,
        &[last, 102],
        &["highway=residential"],
    )
}

#[test]
fn nodes_that_a_way_joins_at_one_place_are_one_junction() {
    for row in [&[1, 2][..], &[2, 1], &[1, 2, 3, 4], &[4, 2, 3, 1], &[3, 1, 3, 2]] {
        let route =
            plan(&road(row, true).graph(), &[at(5.0, 0.0), at(195.0, 0.0)], &FeatureOptions::default());
        let features = route.unwrap().features;
        assert_eq!(features.len(), 1, "{row:?}");
        assert_eq!((features[0].kind, features[0].arms.len()), (FeatureKind::SideRoad, 3), "{row:?}");
        assert!((features[0].route_m - 95.0).abs() < 1e-3, "{row:?}");
    }
}

#[test]
fn a_barrier_on_one_of_them_closes_all() {
    let graph = road(&[1, 2], true).barrier(2, &["barrier=bollard"]).graph();
    assert!(plan(&graph, &[at(5.0, 0.0), at(195.0, 0.0)], &FeatureOptions::default()).is_err());
}

#[test]
fn nodes_that_no_way_joins_are_said() {
    let graph = road(&[1, 2], false).graph();
    let notice = &graph.notices()[0];
    assert_eq!(
        (notice.kind, notice.count, notice.first.as_str()),
        (MapNoticeKind::UnjoinedNodes, 1, "nodes 1 and 2")
    );
    assert!(plan(&graph, &[at(5.0, 0.0), at(195.0, 0.0)], &FeatureOptions::default()).is_err());
}

#[test]
fn a_row_of_near_nodes_is_still_a_road() {
    // 4 mm apart, 400 of them: 1.6 m.
    let town = (0..400).fold(Town::default(), |town, i| town.node(i, 0.004 * i as f64, 0.0));
    let ids: Vec<i64> = (0..400).collect();
    let graph = town.way(1, &ids, &["highway=residential"]).graph();
    let length_m: f64 = graph.segments().iter().map(|segment| segment.length_m).sum();
    assert!((length_m - 1.6).abs() < 0.01, "{length_m}");
}

#[test]
fn a_map_of_one_place_has_no_roads() {
    let town = Town::default().node(1, 0.0, 0.0).node(2, 0.0, 0.0).way(1, &[1, 2], &["highway=residential"]);
    let refused = RoadGraph::from_osm(&town.data()).unwrap_err();
    assert_eq!(refused, GraphError::NoRoads { highways: 1, notices: Vec::new() });
}

/// A star of so many roads.
fn star(roads: u16) -> Result<RoadGraph, GraphError> {
    let mut town = Town::default().node(1, 0.0, 0.0);
    for road in 0..roads {
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(road) / f64::from(roads));
        let id = i64::from(road) + 2;
        town = town.node(id, 100.0 * cosine, 100.0 * sine).way(id, &[1, id], &["highway=residential"]);
    }
    RoadGraph::from_osm_at(&town.data(), plane().origin())
}

#[test]
fn a_junction_that_is_planned_can_be_read_and_a_larger_one_is_refused() {
    for roads in [3, 4, 15, 16] {
        let graph = star(roads).unwrap();
        let route = plan(&graph, &[at(90.0, 0.0), graph.nodes()[2].at], &FeatureOptions::default()).unwrap();
        let read = read_route(&write_route(&route).unwrap()).unwrap();
        assert_eq!(read.features[0].arms.len(), usize::from(roads));
    }
    for roads in [17, 100, 3000] {
        let refused = star(roads).unwrap_err();
        assert_eq!(refused, GraphError::Crowded { node: 1, roads: roads.into() });
    }
}

#[test]
fn a_route_that_would_not_be_read_is_not_written() {
    let graph = star(4).unwrap();
    let stops = [at(90.0, 0.0), graph.nodes()[2].at];
    let mut route = plan(&graph, &stops, &FeatureOptions::default()).unwrap();
    route.features[0].arms[2].width_m = 61.0;
    let refused = write_route(&route).unwrap_err().to_string();
    assert!(refused.contains("cannot be written") && refused.contains("61"), "{refused}");
}

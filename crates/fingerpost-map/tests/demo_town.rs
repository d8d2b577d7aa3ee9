//! The shipped demo town yields the shipped route, with the features that the demo promises.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use fingerpost_map::{
    FeatureKind, FeatureOptions, LatLon, OsmData, RoadGraph, Route, RouteFeature, plan, read_route,
    write_route,
};

const TOWN: &[u8] = include_bytes!("../../fingerpost-sim/assets/town.osm");
const ROUTE: &str = include_str!("../../fingerpost-sim/assets/town_route.geojson");
/// Stops of the demo's route, latitude and longitude.
const STOPS: [(f64, f64); 3] = [(47.217850, 9.539682), (47.216070, 9.537432), (47.221489, 9.536800)];
/// A feature nearer to the one before would share its ground view, metres.
const CLEARANCE_M: f64 = 40.0;

fn demo_route() -> Route {
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(TOWN).unwrap()).unwrap();
    let stops = STOPS.map(|(lat_deg, lon_deg)| LatLon::new(lat_deg, lon_deg).unwrap());
    let mut route = plan(&graph, &stops, &FeatureOptions::default()).unwrap();
    route.name = "Mauren".to_owned();
    route
}

fn side_is_left(feature: &RouteFeature) -> bool {
    libm::sin(feature.arms[2].bearing_rad - feature.arms[1].bearing_rad) > 0.0
}

#[test]
fn the_shipped_route_is_the_planned_one() {
    assert_eq!(write_route(&demo_route()).unwrap(), ROUTE);
    assert_eq!(write_route(&read_route(ROUTE).unwrap()).unwrap(), ROUTE);
}

#[test]
fn the_route_passes_every_kind_of_feature() {
    let route = demo_route();
    let seen: Vec<(i64, FeatureKind, usize)> =
        route.features.iter().map(|feature| (feature.id, feature.kind, feature.arms.len())).collect();
    use FeatureKind::{Bend, Junction, SideRoad};
    let expected = [
        (12_090, Junction, 4),
        (52_649, SideRoad, 3),
        (5_051, Junction, 3),
        (12_054, Junction, 4),
        (52_667, SideRoad, 3),
        (5_062, Junction, 4),
        (5_063, Junction, 3),
        (5_065, Bend, 2),
        (3_425, SideRoad, 3),
    ];
    assert_eq!(seen, expected);
    assert!(route.features[2].turn_rad < -1.0, "right at a T-junction");
    assert!(route.features[6].turn_rad > 1.0, "left at a T-junction");
    assert_eq!([1, 4, 8].map(|index| side_is_left(&route.features[index])), [true, false, false]);
}

#[test]
fn the_features_are_apart_and_the_roads_wide_enough() {
    let route = demo_route();
    let length_m = route.polyline().unwrap().length_m();
    assert!((900.0..1400.0).contains(&length_m), "{length_m} m");
    let mut last_m = 0.0;
    for feature in &route.features {
        assert!(feature.route_m - last_m > CLEARANCE_M, "{} at {} m", feature.id, feature.route_m);
        assert!(feature.arms.iter().all(|arm| arm.width_m >= 4.5), "{}", feature.id);
        last_m = feature.route_m;
    }
    assert!(length_m - last_m > CLEARANCE_M);
}

#[test]
fn every_route_that_is_planned_is_read_back() {
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(TOWN).unwrap()).unwrap();
    let places: Vec<LatLon> = graph.nodes().iter().map(|node| node.at).collect();
    let mut read_back = 0;
    for (i, from) in places.iter().enumerate().step_by(5) {
        // A stride that has no factor in common with most counts of nodes: all parts of the town are paired.
        let to = places[(i * 37 + 11) % places.len()];
        let Ok(route) = plan(&graph, &[*from, to], &FeatureOptions::default()) else { continue };
        let text = write_route(&route).unwrap();
        let read = read_route(&text).unwrap_or_else(|error| panic!("{from:?} to {to:?}: {error}"));
        assert_eq!(write_route(&read).unwrap(), text);
        read_back += 1;
    }
    assert!(read_back > 40, "{read_back} routes");
}

//! Real maps and drives. `FINGERPOST_DATA` names the folder that holds them; without it these tests fail.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::PathBuf;

use fingerpost_map::{
    ArmRole, FeatureKind, FeatureOptions, LatLon, OsmData, RoadGraph, Route, match_track, plan, read_route,
    write_route,
};

/// Places of the drive of KITTI odometry 00, frames 0 to 129, about every fourteenth (latitude, longitude).
const DRIVE_00: [(f64, f64); 11] = [
    (48.982545, 8.390366),
    (48.982638, 8.390440),
    (48.982738, 8.390518),
    (48.982849, 8.390606),
    (48.982962, 8.390693),
    (48.983067, 8.390773),
    (48.983153, 8.390836),
    (48.983212, 8.390882),
    (48.983241, 8.390945),
    (48.983233, 8.391021),
    (48.983232, 8.391038),
];
/// Places of the drive of KITTI odometry 06 on its first street.
const DRIVE_06: [(f64, f64); 7] = [
    (49.053493, 8.397220),
    (49.053465, 8.396783),
    (49.053433, 8.396324),
    (49.053411, 8.395877),
    (49.053389, 8.395409),
    (49.053357, 8.394926),
    (49.053324, 8.394450),
];

fn map_bytes(name: &str) -> Vec<u8> {
    let folder =
        std::env::var("FINGERPOST_DATA").expect("set FINGERPOST_DATA to the folder of the real data");
    let path = PathBuf::from(folder).join("osm").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn graph(name: &str) -> RoadGraph {
    RoadGraph::from_osm(&OsmData::from_bytes(&map_bytes(name)).unwrap()).unwrap()
}

fn places(drive: &[(f64, f64)]) -> Vec<LatLon> {
    drive.iter().map(|&(lat_deg, lon_deg)| LatLon::new(lat_deg, lon_deg).unwrap()).collect()
}

fn check_route_00(route: &Route) {
    let feature = route.features.iter().find(|feature| feature.id == 24_546_162).unwrap();
    assert_eq!(feature.kind, FeatureKind::Junction);
    assert_eq!(feature.arms.len(), 4);
    let turn_deg = feature.turn_rad.to_degrees();
    assert!((-105.0..-75.0).contains(&turn_deg), "a right turn, {turn_deg} degrees");
    assert!(feature.name.contains("Neckarstra") && feature.name.contains("Kniebisstra"), "{}", feature.name);
    // The drive comes from the south-west; the exit is to its right, the rest in front and to the left.
    let roles: Vec<ArmRole> = feature.arms.iter().map(|arm| arm.role).collect();
    assert_eq!(roles, [ArmRole::Approach, ArmRole::Exit, ArmRole::Side, ArmRole::Side]);
    assert!(feature.arms.iter().all(|arm| arm.points[0] == feature.at));
    assert!((60.0..110.0).contains(&feature.route_m), "{} m along the route", feature.route_m);
}

#[test]
fn kitti_00_turns_right_at_a_four_armed_junction() {
    let graph = graph("kitti_00.osm");
    let drive = places(&DRIVE_00);
    let ends = [drive[0], drive[10]];
    check_route_00(&plan(&graph, &ends, &FeatureOptions::default()).unwrap());
    let matched = match_track(&graph, &drive, &FeatureOptions::default()).unwrap();
    check_route_00(&matched);
    let text = write_route(&matched).unwrap();
    let read = read_route(&text).unwrap();
    check_route_00(&read);
    assert_eq!(write_route(&read).unwrap(), text);
}

#[test]
fn kitti_06_passes_a_side_road_on_the_right() {
    let route = match_track(&graph("kitti_06.osm"), &places(&DRIVE_06), &FeatureOptions::default()).unwrap();
    let feature = route.features.iter().find(|feature| feature.id == 25_344_948).unwrap();
    assert_eq!(feature.kind, FeatureKind::SideRoad);
    assert_eq!(feature.arms.len(), 3);
    let [exit, side] = [1, 2].map(|index| feature.arms[index].bearing_rad);
    let left_deg = (side - exit).to_degrees().rem_euclid(360.0);
    assert!((240.0..300.0).contains(&left_deg), "the side road leaves {left_deg} degrees left of the route");
}

#[test]
fn whole_extracts_make_road_graphs() {
    for (name, ways_at_least) in [("liechtenstein-2013-08-03.osm.pbf", 2000), ("Helsinki.osm.pbf", 500)] {
        let graph = graph(name);
        assert!(graph.ways().len() > ways_at_least, "{name}: {} ways", graph.ways().len());
        let place = graph.nodes()[graph.nodes().len() / 2].p_in_map;
        assert!(graph.nearest(place, 1.0).is_some(), "{name}: a node lies on its own road");
    }
}

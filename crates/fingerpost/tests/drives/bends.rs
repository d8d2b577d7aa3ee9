//! Bends of a road that nothing else meets, from the map's nodes to the tracked feature, on painted drives.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use std::f64::consts::FRAC_PI_2;

use crate::painted::{Place, World, camera_of_width};
use fingerpost::track::State;
use fingerpost::vehicle::Traffic;
use fingerpost::{Pipeline, Sensors};
use fingerpost_geometry::{Polyline, heading_of};
use fingerpost_map::{
    FeatureKind, FeatureOptions, LatLon, OsmData, OsmNode, OsmWay, RoadGraph, Route, TangentPlane, plan,
};
use nalgebra::{Isometry2, Point2};

const WIDTH_M: f64 = 6.0;
/// Length of road before and behind the bend, metres.
const STRAIGHT_M: f64 = 60.0;
/// Distance between frames, metres.
const STEP_M: f64 = 0.8;

/// A road that goes north, turns by an angle (degrees, positive left) on an arc of this radius (metres) and goes straight on; a node
/// every 3 m of the arc.
fn bent_road(radius_m: f64, turn_deg: f64) -> Vec<Place> {
    let turn = turn_deg.to_radians();
    let mut road = vec![(0.0, -STRAIGHT_M), (0.0, 0.0)];
    let pieces = (radius_m * turn.abs() / 3.0).ceil();
    for i in 1..=pieces as i32 {
        let turned = turn.abs() * f64::from(i) / pieces;
        road.push((-turn.signum() * radius_m * (1.0 - libm::cos(turned)), radius_m * libm::sin(turned)));
    }
    let (heading, (x, y)) = (FRAC_PI_2 + turn, road[road.len() - 1]);
    road.push((x + STRAIGHT_M * libm::cos(heading), y + STRAIGHT_M * libm::sin(heading)));
    road
}

/// The route along a road by the map's own means, and the road in the route's frame.
fn planned(road: &[Place]) -> (Route, Vec<Place>) {
    let plane = TangentPlane::new(LatLon { lat_deg: 47.1, lon_deg: 9.5 });
    let at = |&(x, y): &Place| plane.wgs84_from_map(Point2::new(x, y));
    let ids: Vec<i64> = (1..=road.len() as i64).collect();
    let tags = [("highway", "residential"), ("width", "6")].map(|(k, v)| (k.to_owned(), v.to_owned()));
    let data = OsmData {
        nodes: ids.iter().zip(road).map(|(&id, place)| OsmNode { id, at: at(place) }).collect(),
        ways: vec![OsmWay { id: 1, nodes: ids, tags: tags.into_iter().collect() }],
        ..OsmData::default()
    };
    let graph = RoadGraph::from_osm(&data).unwrap();
    let ends = [at(&road[0]), at(&road[road.len() - 1])];
    let route = plan(&graph, &ends, &FeatureOptions::default()).unwrap();
    let in_route = road.iter().map(|(x, y)| (x - road[0].0, y - road[0].1)).collect();
    (route, in_route)
}

/// How a bend was met on a drive.
#[derive(Debug, Default)]
struct Met {
    detected_ahead_m: Option<f64>,
    errors_m: Vec<f64>,
    arrived: bool,
}

/// Drives along the middle of `driven` and looks for the bends of `route`, which begins where it does.
fn drive(route: &Route, driven: &[Place]) -> Met {
    let mut config = crate::painted::config();
    config.vehicle.traffic = Traffic::Centre;
    let camera = camera_of_width(400);
    let world = World::new(&[(driven, WIDTH_M)]);
    let line = Polyline::new(driven.iter().map(|&(x, y)| Point2::new(x, y))).unwrap();
    let feature = &route.features[0];
    let node = TangentPlane::new(route.line[0].at).map_from_wgs84(feature.at);
    let mut pipeline = Pipeline::new(&config, &camera, Some(route), Some(26.0)).unwrap();
    let mut met = Met::default();
    for i in 0.. {
        let at_m = 26.0 + STEP_M * f64::from(i);
        if at_m > feature.route_m + 6.0 {
            break;
        }
        // A vehicle turns over its length.
        let (behind, ahead) = (line.at(at_m - 1.5).0, line.at(at_m + 1.5).0);
        let map_from_vehicle = Isometry2::new(line.at(at_m).0.coords, heading_of(ahead - behind));
        let frame = world.picture(&camera, &map_from_vehicle);
        let (output, _) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
        let Some(followed) = output.track.followed.as_ref().filter(|followed| followed.index == 0) else {
            continue;
        };
        met.detected_ahead_m.get_or_insert(feature.route_m - at_m);
        met.arrived |= output.track.state == State::Arrived;
        let truth = map_from_vehicle.inverse() * node;
        met.errors_m.push((followed.vehicle_from_feature.translation.vector - truth.coords).norm());
    }
    met
}

#[test]
fn a_smooth_bend_that_is_listed_is_detected_and_placed() {
    let mut listed = 0;
    for (radius_m, turn_deg) in [(20.0, 70.0), (20.0, -80.0), (20.0, 90.0), (20.0, -60.0), (15.0, -50.0)] {
        let (route, road) = planned(&bent_road(radius_m, turn_deg));
        if route.features.is_empty() {
            continue;
        }
        listed += 1;
        assert_eq!(route.features[0].kind, FeatureKind::Bend);
        let met = drive(&route, &road);
        let worst_m = met.errors_m.iter().copied().fold(0.0, f64::max);
        let of = format!("{radius_m} m, {turn_deg} degrees: {met:?}");
        assert!(met.detected_ahead_m.is_some_and(|ahead_m| ahead_m > 8.0) && met.arrived, "{of}");
        assert!(worst_m < 1.2, "off by {worst_m} m, {of}");
    }
    assert!(listed >= 4, "{listed} of 5 are listed");
}

#[test]
fn a_straight_road_is_no_smooth_bend() {
    let straight = [(0.0, 0.0), (0.0, 140.0)];
    for turn_deg in [70.0, -90.0] {
        let (route, _) = planned(&bent_road(20.0, turn_deg));
        assert_eq!(drive(&route, &straight).detected_ahead_m, None);
    }
}

#[test]
fn a_bend_too_smooth_to_be_told_is_not_listed() {
    for (radius_m, turn_deg) in [(40.0, 60.0), (60.0, -90.0), (200.0, 45.0)] {
        assert_eq!(planned(&bent_road(radius_m, turn_deg)).0.features, [], "{radius_m} m");
    }
}

//! The drive through the built-in town.

use fingerpost_geometry::{Distortion, Intrinsics};
use fingerpost_map::{OsmData, read_route};

use nalgebra::Point3;

use super::*;
use crate::TrafficSide;

const TOWN: &str = include_str!("../../assets/town.osm");

pub(crate) fn in_town(config: &SimConfig) -> Simulator {
    on_map(TOWN, config)
}

fn on_map(map: &str, config: &SimConfig) -> Simulator {
    let town = OsmData::from_bytes(map.as_bytes()).unwrap();
    let graph = RoadGraph::from_osm(&town).unwrap();
    let route = read_route(include_str!("../../assets/town_route.geojson")).unwrap();
    let intrinsics = Intrinsics { fx: 42.0, fy: 42.0, cx: 31.5, cy: 23.5 };
    let camera = Camera::calibrated(64, 48, intrinsics, Distortion::None, Mount::level(1.5)).unwrap();
    Simulator::new(&graph, &route, &camera, config).unwrap()
}

#[test]
fn all_wheels_stay_on_the_towns_roads() {
    for traffic in [TrafficSide::Right, TrafficSide::Left, TrafficSide::Centre] {
        let simulator = in_town(&SimConfig { traffic, ..SimConfig::default() });
        let (mut worst_m, mut where_m) = (f32::NEG_INFINITY, 0.0);
        for index in 0..simulator.frames() {
            let state = simulator.state(index);
            let map_from_vehicle = simulator.map_from_vehicle(&state);
            // The outer faces of the tyres of a car 1.8 m wide.
            for (x, y) in [(0.0, 0.9), (0.0, -0.9), (2.7, 0.9), (2.7, -0.9)] {
                let wheel = map_from_vehicle * Point3::new(x, y, 0.0);
                let edge_m = simulator.renderer.ground.at(wheel.x as f32, wheel.y as f32).edge_m;
                if edge_m > worst_m {
                    (worst_m, where_m) = (edge_m, state.route_m);
                }
            }
        }
        assert!(worst_m < 0.0, "{traffic:?}: {worst_m} m off the road at {where_m} m of the route");
    }
}

#[test]
fn islands_are_no_road() {
    let secondary = r#"<tag k="highway" v="secondary"/>"#;
    let wide = TOWN.replace(secondary, &format!(r#"{secondary}<tag k="width" v="12"/>"#));
    let config = SimConfig { conditions: crate::Conditions::STREET, ..SimConfig::default() };
    let simulator = on_map(&wide, &config);
    let places = (0..1600).flat_map(|i| (0..1600).map(move |j| [i, j].map(|k| 0.25 * f64::from(k) - 200.0)));
    let (mut road, mut islands) = (0, 0);
    for [x, y] in places {
        let is_road = simulator.is_on_road(Point2::new(x, y));
        if simulator.renderer.ground.at(x as f32, y as f32).edge_m < 0.0 {
            let on_island =
                simulator.renderer.street_at(x as f32, y as f32).is_some_and(|at| at.behind_kerb_m > 0.0);
            assert_eq!(is_road, !on_island, "{x}, {y}");
            road += 1;
            islands += i32::from(on_island);
        } else {
            assert!(!is_road, "{x}, {y}: beside the road, be it a parking bay");
        }
    }
    assert!(islands > 50 && islands * 20 < road, "{islands} of {road}");
}

#[test]
fn the_town_has_its_features_in_order() {
    let simulator = in_town(&SimConfig::default());
    let mut seen: Vec<i64> = (0..simulator.frames()).filter_map(|i| simulator.truth(i).feature_id).collect();
    seen.dedup();
    let wanted: Vec<i64> = simulator.targets.iter().map(|target| target.id).collect();
    assert_eq!(seen, wanted);
    assert!(wanted.len() >= 8, "{} features", wanted.len());
}

#[test]
fn nothing_stands_on_or_near_the_roads() {
    let town = OsmData::from_bytes(include_bytes!("../../assets/town.osm")).unwrap();
    let graph = RoadGraph::from_osm(&town).unwrap();
    let (low, high) = (Point2::new(-200.0, -200.0), Point2::new(200.0, 200.0));
    let roads = RoadNetwork::new(&graph, graph.plane(), low, high);
    let relief = Relief::new(1, 0.0);
    let scenery = Scenery::new(1, &crate::Conditions::SHADOWS, &roads, &relief, |_| true);
    assert!(scenery.objects().len() > 100, "{} objects", scenery.objects().len());
    for object in scenery.objects() {
        let foot = Point2::new(f64::from(object.foot[0]), f64::from(object.foot[1]));
        let free_m = 1.5 + f64::from(object.radius_m());
        assert!(roads.within(foot, free_m).is_empty(), "{object:?}");
    }
}

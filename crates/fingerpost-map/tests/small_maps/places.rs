//! Places on the earth: across the antimeridian, off the map, and with latitude and longitude exchanged.

use fingerpost_map::{
    FeatureOptions, LatLon, OsmData, OsmNode, OsmWay, RoadGraph, TangentPlane, match_track, plan,
};
use nalgebra::Point2;

/// A road of 590 m to the east through a place, with a side road to the north behind two thirds.
fn road(middle: LatLon) -> RoadGraph {
    let plane = TangentPlane::new(middle);
    let places = [(-295.0, 0.0), (-100.0, 0.0), (100.0, 0.0), (295.0, 0.0), (100.0, 150.0)];
    let nodes =
        (1..).zip(places).map(|(id, (x, y))| OsmNode { id, at: plane.wgs84_from_map(Point2::new(x, y)) });
    let way = |id, nodes: &[i64]| OsmWay {
        id,
        nodes: nodes.to_vec(),
        tags: [("highway".to_owned(), "residential".to_owned())].into(),
    };
    let ways = vec![way(9, &[1, 2, 3, 4]), way(10, &[3, 5])];
    RoadGraph::from_osm(&OsmData { nodes: nodes.collect(), ways, ..OsmData::default() }).unwrap()
}

#[test]
fn a_road_is_as_long_on_every_meridian() {
    for lat_deg in [-16.8, 0.0, 65.0] {
        for lon_deg in [-180.0, -179.9995, -0.0005, 0.0, 9.0, 90.0, 179.9985, 179.9999, 180.0] {
            let graph = road(LatLon { lat_deg, lon_deg });
            let ends = [0, 3].map(|node| graph.nodes()[node].at);
            let route = plan(&graph, &ends, &FeatureOptions::default()).unwrap();
            let length_m = route.polyline().unwrap().length_m();
            assert!((length_m - 590.0).abs() < 1e-3, "{lat_deg}, {lon_deg}: {length_m}");
            assert_eq!(route.features.len(), 1, "{lat_deg}, {lon_deg}");
            assert!((route.features[0].route_m - 395.0).abs() < 1e-3, "{lat_deg}, {lon_deg}");
            for point in &route.line {
                assert!((point.at.lat_deg - lat_deg).abs() < 1e-3 && point.at.lon_deg.abs() <= 180.0);
            }
            let along = graph.nodes()[..4].iter().map(|node| node.at).collect::<Vec<_>>();
            let matched = match_track(&graph, &along, &FeatureOptions::default()).unwrap();
            assert!((matched.polyline().unwrap().length_m() - 590.0).abs() < 1e-3, "{lat_deg}, {lon_deg}");
            assert!(graph.bounds().contains(ends[0]) && graph.bounds().contains(ends[1]));
            let aside =
                LatLon { lat_deg, lon_deg: if lon_deg > 0.0 { lon_deg - 1.0 } else { lon_deg + 1.0 } };
            assert!(!graph.bounds().contains(aside), "{lat_deg}, {lon_deg}");
        }
    }
}

#[test]
fn a_place_on_the_map_is_a_road_and_others_say_how_far_they_are() {
    let graph = road(LatLon { lat_deg: 47.0, lon_deg: 9.0 });
    let place = |lat_deg: f64, lon_deg: f64| graph.place_on_road(LatLon { lat_deg, lon_deg });
    assert!((place(46.9995, 9.0).unwrap().distance_m - 55.6).abs() < 0.1);
    let off = place(46.998, 9.0).unwrap_err();
    assert!((off.nearest_m.unwrap() - 222.3).abs() < 0.5 && !off.is_exchanged(), "{off}");
    let message = off.to_string();
    assert!(message.contains("222 m from the nearest road") && message.contains("take a map"), "{message}");
    assert!(message.contains("latitudes 47.00000 to 47.00135, longitudes 8.99612 to 9.00388"), "{message}");
    let exchanged = place(9.0, 47.0005).unwrap_err();
    assert!(exchanged.is_exchanged(), "{exchanged}");
    assert!(exchanged.to_string().contains("exchanged?") && exchanged.to_string().contains(" km from"));
    // The other side of the earth lies below the middle of the map.
    assert!(place(-47.0, -171.0).unwrap_err().nearest_m.unwrap() > 1.2e7);
    for (lat_deg, lon_deg) in [(f64::NAN, 9.0), (f64::INFINITY, 9.0), (47.0, f64::NAN)] {
        let message = place(lat_deg, lon_deg).unwrap_err().to_string();
        assert!(message.contains("no place on earth") && !message.contains("inf m"), "{message}");
    }
}

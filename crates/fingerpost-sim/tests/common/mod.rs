//! A made-up hamlet: a side road, a T-junction, a crossroads and a bend, by coordinates in metres.

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost_map::{FeatureOptions, LatLon, OsmData, RoadGraph, Route, TangentPlane, plan};
use nalgebra::Point2;

/// OSM number, metres east and north of the start.
pub(crate) const NODES: [(i64, f64, f64); 12] = [
    (1, 0.0, 0.0),
    (2, 60.0, 0.0),
    (3, 120.0, 0.0),
    (4, 120.0, 70.0),
    (5, 190.0, 70.0),
    (6, 225.0, 130.0),
    (7, 250.0, 172.0),
    (20, 60.0, -70.0),
    (30, 120.0, -80.0),
    (40, 50.0, 70.0),
    (42, 120.0, 140.0),
    (50, 190.0, 20.0),
];

/// OSM number, name, width in metres, nodes.
const WAYS: [(i64, &str, f64, &[i64]); 5] = [
    (101, "Main Street", 6.0, &[1, 2, 3]),
    (102, "South Lane", 5.0, &[2, 20]),
    (103, "North Road", 6.0, &[30, 3, 4, 42]),
    (104, "Bend Street", 5.5, &[40, 4, 5, 6, 7]),
    (105, "Mill Lane", 4.5, &[5, 50]),
];

/// Where the hamlet lies.
pub(crate) fn plane() -> TangentPlane {
    TangentPlane::new(LatLon::new(47.1, 9.5).unwrap())
}

fn place(id: i64) -> LatLon {
    let (_, x, y) = NODES.into_iter().find(|node| node.0 == id).unwrap();
    plane().wgs84_from_map(Point2::new(x, y))
}

/// The hamlet's map.
pub(crate) fn graph() -> RoadGraph {
    let mut xml = String::from("<?xml version=\"1.0\"?><osm version=\"0.6\">");
    for (id, ..) in NODES {
        let at = place(id);
        xml += &format!("<node id=\"{id}\" lat=\"{:.9}\" lon=\"{:.9}\"/>", at.lat_deg, at.lon_deg);
    }
    for (id, name, width, nodes) in WAYS {
        xml += &format!("<way id=\"{id}\">");
        nodes.iter().for_each(|node| xml += &format!("<nd ref=\"{node}\"/>"));
        for (key, value) in [("highway", "residential"), ("name", name), ("width", &width.to_string())] {
            xml += &format!("<tag k=\"{key}\" v=\"{value}\"/>");
        }
        xml += "</way>";
    }
    xml += "</osm>";
    RoadGraph::from_osm(&OsmData::from_bytes(xml.as_bytes()).unwrap()).unwrap()
}

/// From node 1 to node 7: past a side road, left at a T, right at a crossroads, round a bend.
pub(crate) fn route(graph: &RoadGraph) -> Route {
    plan(graph, &[place(1), place(7)], &FeatureOptions::default()).unwrap()
}

/// The demo's camera, with any lens and size.
pub(crate) fn camera(width: usize, height: usize, distortion: Distortion) -> Camera {
    let focal = 420.0 * width as f64 / 640.0;
    let intrinsics =
        Intrinsics { fx: focal, fy: focal, cx: 0.5 * (width as f64 - 1.0), cy: 0.5 * (height as f64 - 1.0) };
    let mount = Mount { pitch_rad: 8_f64.to_radians(), x_m: 1.5, ..Mount::level(1.5) };
    Camera::calibrated(width, height, intrinsics, distortion, mount).unwrap()
}

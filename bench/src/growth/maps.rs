//! Maps and routes: reading them, a frame on them, and where on them the vehicle is.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::Result;
use fingerpost::{Config, Pipeline};
use fingerpost_locate::{Locator, MotionSample, Start, Traffic};
use fingerpost_map::{
    FeatureOptions, LatLon, OsmData, OsmNode, OsmWay, RoadGraph, Route, TangentPlane, plan, read_route,
    write_route,
};
use nalgebra::Point2;

use super::cost::{Cost, Growth, Powers};
use super::views::frame_ms;
use crate::footage::Footage;
use crate::measure::{Effort, median, processor_ms};

/// Sides of square maps, kilometres: 1 to 2,500 square kilometres.
const SIDES_KM: [usize; 4] = [1, 5, 15, 50];
/// Distance between roads of the maps, and between their nodes, metres: some 8 km of road in a square kilometre, as towns have.
const ROADS_EVERY_M: usize = 250;
const NODES_EVERY_M: usize = 25;
/// Features of routes.
const FEATURES: [usize; 4] = [10, 100, 1_000, 10_000];
/// Distance between the features of a route, metres.
const FEATURE_EVERY_M: f64 = 60.0;
/// Length of the side road at each of them, metres.
const SIDE_ROAD_M: f64 = 50.0;
/// Motion of a town's drive while the vehicle is looked for: metres a second, and seconds between rows.
const SPEED_MPS: f64 = 10.0;
const ROW_S: f64 = 0.25;
/// Rows that are timed: 100 m of driving.
const ROWS: usize = 40;
/// How well a place is known where one is given, metres.
const NEAR_SIGMA_M: f64 = 15.0;
/// Number of the first node beside the route, above all on it.
const FIRST_SIDE_NODE: i64 = 1_000_000;
/// Times that something short is measured.
const TIMES: usize = 3;

/// Reading a map grows no faster than its area.
pub fn reading_maps() -> Growth {
    let cost = |side_km: usize| {
        let text = town_xml(side_km);
        let read =
            || OsmData::from_bytes(text.as_bytes()).ok().and_then(|osm| RoadGraph::from_osm(&osm).ok());
        Cost::of(area_km2(side_km), TIMES, read)
    };
    let costs = SIDES_KM.map(cost).to_vec();
    Growth::new("reading a map, by its area", "km2", costs, Powers { ms: 1.0, bytes: 1.0 })
}

/// The step of a locator that knows about where it is takes as long on every map; of one that may be anywhere, its time grows with
/// the map. The memory of both does: they keep the roads of the whole map, on any of which they may look for the vehicle again.
pub fn locating() -> Result<[Growth; 2]> {
    let (mut near, mut anywhere) = (Vec::new(), Vec::new());
    for side_km in SIDES_KM {
        let graph = RoadGraph::from_osm(&OsmData::from_bytes(town_xml(side_km).as_bytes())?)?;
        let place_m = graph.plane().map_from_wgs84(plane().origin());
        let start = Start { place_m, sigma_m: NEAR_SIGMA_M, heading_rad: None };
        near.push(of_locator(area_km2(side_km), || Locator::near(&graph, Traffic::Right, 1, &start))?);
        anywhere.push(of_locator(area_km2(side_km), || Locator::new(&graph, Traffic::Right, 1))?);
    }
    Ok([
        Growth::new(
            "step of the place on a map, start known, by the map's area",
            "km2",
            near,
            Powers { ms: 0.0, bytes: 1.0 },
        ),
        Growth::new(
            "step of the place on a map, start anywhere, by its area",
            "km2",
            anywhere,
            Powers { ms: 1.0, bytes: 1.0 },
        ),
    ])
}

/// Reading a route grows no faster than the number of its features, and a frame on it costs the same.
pub fn routes(effort: Effort, footage: &Footage) -> Result<[Growth; 2]> {
    let (mut reading, mut frames) = (Vec::new(), Vec::new());
    for features in FEATURES {
        let route = staircase(features)?;
        let text = write_route(&route)?;
        reading.push(Cost::of(features as f64, TIMES, || read_route(&text)));
        let mut made = None;
        let taken = allocation_counter::measure(|| {
            made = Some(Pipeline::new(&Config::default(), &footage.camera, Some(&route), Some(0.0)));
        });
        let Some(pipeline) = made else { continue };
        let ms = frame_ms(effort, &mut pipeline?, footage)?;
        frames.push(Cost { size: features as f64, ms, bytes: taken.bytes_max as f64 });
    }
    Ok([
        Growth::new("reading a route, by its features", "features", reading, Powers { ms: 1.0, bytes: 1.0 }),
        Growth::new(
            "frame of the whole method on a route, by its features",
            "features",
            frames,
            Powers { ms: 0.0, bytes: 1.0 },
        ),
    ])
}

fn of_locator(size: f64, make: impl FnOnce() -> Locator) -> Result<Cost> {
    let mut laps_ms = Vec::new();
    let mut stepped = Ok(None);
    let taken = allocation_counter::measure(|| {
        let mut locator = make();
        for row in 0..ROWS {
            let sample = MotionSample { t_s: ROW_S * row as f64, speed_mps: SPEED_MPS, yaw_rate_rps: 0.0 };
            let start_ms = processor_ms();
            stepped = locator.step(sample);
            laps_ms.push(processor_ms() - start_ms);
            if stepped.is_err() {
                break;
            }
        }
    });
    stepped?;
    Ok(Cost { size, ms: median(&mut laps_ms), bytes: taken.bytes_max as f64 })
}

fn area_km2(side_km: usize) -> f64 {
    (side_km * side_km) as f64
}

/// A square town of streets that cross at right angles, its middle the middle of the map, as OSM XML.
fn town_xml(side_km: usize) -> String {
    let steps = 1_000 * side_km / NODES_EVERY_M;
    let every = ROADS_EVERY_M / NODES_EVERY_M;
    let plane = plane();
    let number = |column: usize, row: usize| 1 + row * (steps + 1) + column;
    let mut text = String::from("<osm version=\"0.6\">\n");
    for row in 0..=steps {
        for column in (0..=steps).filter(|column| row % every == 0 || column % every == 0) {
            let off = |step: usize| (step as f64 - 0.5 * steps as f64) * NODES_EVERY_M as f64;
            let at = plane.wgs84_from_map(Point2::new(off(column), off(row)));
            let _ = writeln!(
                text,
                "<node id=\"{}\" lat=\"{:.7}\" lon=\"{:.7}\"/>",
                number(column, row),
                at.lat_deg,
                at.lon_deg
            );
        }
    }
    let mut way = 0;
    let mut street = |nodes: &mut dyn Iterator<Item = usize>| {
        way += 1;
        let _ = writeln!(text, "<way id=\"{way}\">");
        for node in nodes {
            let _ = writeln!(text, "<nd ref=\"{node}\"/>");
        }
        text.push_str("<tag k=\"highway\" v=\"residential\"/></way>\n");
    };
    for along in (0..=steps).step_by(every) {
        street(&mut (0..=steps).map(|column| number(column, along)));
        street(&mut (0..=steps).map(|row| number(along, row)));
    }
    text.push_str("</osm>\n");
    text
}

/// A route of so many corners, left and right by turns, at each of which a side road goes straight on.
fn staircase(features: usize) -> Result<Route> {
    let plane = plane();
    let corner = |step: usize| Point2::new(step.div_ceil(2) as f64, (step / 2) as f64) * FEATURE_EVERY_M;
    let node = |id: i64, place: Point2<f64>| OsmNode { id, at: plane.wgs84_from_map(place) };
    let road = |id: i64, nodes: Vec<i64>| OsmWay {
        id,
        nodes,
        tags: BTreeMap::from([("highway".to_owned(), "residential".to_owned())]),
    };
    let steps = features + 1;
    let mut nodes: Vec<OsmNode> = (0..=steps).map(|step| node(1 + step as i64, corner(step))).collect();
    let mut ways = vec![road(1, (0..=steps).map(|step| 1 + step as i64).collect())];
    for step in 1..steps {
        let on = (corner(step) - corner(step - 1)).normalize() * SIDE_ROAD_M;
        let side = FIRST_SIDE_NODE + step as i64;
        nodes.push(node(side, corner(step) + on));
        ways.push(road(1 + step as i64, vec![1 + step as i64, side]));
    }
    let graph = RoadGraph::from_osm_at(&OsmData { nodes, ways, ..OsmData::default() }, plane.origin())?;
    let ends = [0, steps].map(|step| plane.wgs84_from_map(corner(step)));
    Ok(plan(&graph, &ends, &FeatureOptions::default())?)
}

/// A plane about a place in the middle of Europe.
fn plane() -> TangentPlane {
    TangentPlane::new(LatLon { lat_deg: 47.0, lon_deg: 9.0 })
}

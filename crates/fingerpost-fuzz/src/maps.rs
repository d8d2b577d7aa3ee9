//! Maps, tracks and routes.

use std::io::Read;

use fingerpost_map::{OsmData, RoadGraph, parse_gps_log_within, parse_gpx, read_route, write_route};

use crate::must;

/// Memory that a map may take here, bytes.
const MAP_BYTES: usize = 8_000_000;
const TINY_XML: &[u8] = include_bytes!("../../fingerpost-map/tests/data/tiny.osm");
const TINY_PBF: &[u8] = include_bytes!("../../fingerpost-map/tests/data/tiny.osm.pbf");
/// A made-up road network of two streets.
const STREETS: &[u8] = br#"<osm><node id="1" lat="48.5" lon="8.25"/><node id="2" lat="48.501" lon="8.25"/>
<node id="3" lat="48.501" lon="8.2515"/><way id="7"><nd ref="1"/><nd ref="2"/><nd ref="3"/>
<tag k="highway" v="residential"/><tag k="width" v="6.5 m"/><tag k="lanes" v="2"/><tag k="oneway" v="-1"/></way></osm>"#;

/// A map's numbers ascend, its places are places, and its roads are of finite width.
fn check_map(data: &OsmData) {
    assert!(data.nodes.is_sorted_by(|a, b| a.id < b.id));
    assert!(data.ways.is_sorted_by(|a, b| a.id < b.id));
    assert!(data.nodes.iter().all(|node| node.at.lat_deg.abs() <= 90.0 && node.at.lon_deg.abs() <= 180.0));
    if let Ok(graph) = RoadGraph::from_osm(data) {
        assert!(graph.nodes().iter().all(|node| node.p_in_map.x.is_finite() && node.p_in_map.y.is_finite()));
    }
}

fn map(bytes: &[u8]) -> bool {
    if let Ok(data) = OsmData::from_bytes_within(bytes, MAP_BYTES) {
        check_map(&data);
        return true;
    }
    false
}

pub(crate) fn osm_xml(bytes: &[u8]) -> bool {
    map(bytes)
}

pub(crate) fn osm_xml_seeds() -> Vec<Vec<u8>> {
    vec![TINY_XML.to_vec(), STREETS.to_vec()]
}

pub(crate) fn osm_pbf(bytes: &[u8]) -> bool {
    map(bytes)
}

pub(crate) fn osm_pbf_seeds() -> Vec<Vec<u8>> {
    vec![TINY_PBF.to_vec(), pbf(&tiny_block())]
}

/// The bytes are a block of data, not packed, in a file that is whole.
pub(crate) fn osm_pbf_block(bytes: &[u8]) -> bool {
    map(&pbf(bytes))
}

pub(crate) fn osm_pbf_block_seeds() -> Vec<Vec<u8>> {
    vec![tiny_block()]
}

/// A map of one block.
fn pbf(block: &[u8]) -> Vec<u8> {
    [blob("OSMHeader", &[]), blob("OSMData", block)].concat()
}

/// A blob with its header, not packed.
fn blob(kind: &str, block: &[u8]) -> Vec<u8> {
    let blob = field(1, block);
    let header = [field(1, kind.as_bytes()), vec![3 << 3], varint(blob.len())].concat();
    [&(header.len() as u32).to_be_bytes(), header.as_slice(), &blob].concat()
}

/// A field of bytes with its number.
fn field(number: u8, body: &[u8]) -> Vec<u8> {
    [vec![number << 3 | 2], varint(body.len()), body.to_vec()].concat()
}

/// A number in base 128, as protocol buffers have it.
fn varint(mut value: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 128 {
        bytes.push(value as u8 | 128);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

/// The longest block of the small map, unpacked.
fn tiny_block() -> Vec<u8> {
    let starts = TINY_PBF.windows(2).enumerate().filter(|(_, bytes)| bytes[0] == 0x78);
    let blocks = starts.filter_map(|(at, _)| {
        let mut block = Vec::new();
        flate2::read::ZlibDecoder::new(&TINY_PBF[at..]).read_to_end(&mut block).ok().map(|_| block)
    });
    blocks.max_by_key(Vec::len).unwrap_or_default()
}

/// A track's times are finite.
pub(crate) fn gpx(bytes: &[u8]) -> bool {
    if let Ok(text) = str::from_utf8(bytes)
        && let Ok(points) = parse_gpx(text).map(|track| track.points)
    {
        assert!(!points.is_empty());
        assert!(points.iter().filter_map(|point| point.time_s).all(f64::is_finite));
        return true;
    }
    false
}

pub(crate) fn gpx_seeds() -> Vec<Vec<u8>> {
    vec![include_bytes!("../seeds/track.gpx").to_vec()]
}

/// A log's times are finite.
pub(crate) fn gps_log(bytes: &[u8]) -> bool {
    let Ok(log) = parse_gps_log_within(bytes, MAP_BYTES) else { return false };
    assert!(!log.points.is_empty());
    assert!(log.points.iter().filter_map(|point| point.time_s).all(f64::is_finite));
    true
}

pub(crate) fn gps_log_seeds() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../seeds/receiver.nmea").to_vec(),
        include_bytes!("../seeds/gpsd.json").to_vec(),
        include_bytes!("../seeds/track.gpx").to_vec(),
    ]
}

/// A route that is read is written, and reads back with all of its points and features.
pub(crate) fn route(bytes: &[u8]) -> bool {
    if let Ok(text) = str::from_utf8(bytes)
        && let Ok(route) = read_route(text)
    {
        let written = must(write_route(&route), "a route that was read");
        let again = must(read_route(&written), "a route that was written");
        // Places are rounded when they are written, so a bearing between two near ones may differ in its last digits.
        assert_eq!((again.line.len(), again.features.len()), (route.line.len(), route.features.len()));
        must(write_route(&again), "a route that was read again");
        return true;
    }
    false
}

pub(crate) fn route_seeds() -> Vec<Vec<u8>> {
    vec![include_bytes!("../../fingerpost-sim/assets/town_route.geojson").to_vec()]
}

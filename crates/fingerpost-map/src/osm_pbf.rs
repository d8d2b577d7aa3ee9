//! OSM PBF.

use std::collections::BTreeMap;
use std::io::Cursor;

use osmpbf::{Element, ElementReader};

use crate::LatLon;
use crate::osm::{OsmData, OsmError, OsmNode, OsmWay};

/// Reads nodes and highways in the file's order.
pub(crate) fn read(bytes: &[u8]) -> Result<OsmData, OsmError> {
    let mut data = OsmData::default();
    let mut fault = None;
    let mut add_node = |nodes: &mut Vec<OsmNode>, id, nano_lat: i64, nano_lon: i64| match LatLon::new(
        degrees(nano_lat),
        degrees(nano_lon),
    ) {
        Ok(at) => nodes.push(OsmNode { id, at }),
        Err(error) => {
            fault.get_or_insert(format!("node {id}: {error}"));
        }
    };
    ElementReader::new(Cursor::new(bytes))
        .for_each(|element| match element {
            Element::Node(node) => add_node(&mut data.nodes, node.id(), node.nano_lat(), node.nano_lon()),
            Element::DenseNode(node) => {
                add_node(&mut data.nodes, node.id(), node.nano_lat(), node.nano_lon())
            }
            Element::Way(way) => {
                let tags: BTreeMap<String, String> =
                    way.tags().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
                if tags.contains_key("highway") {
                    data.ways.push(OsmWay { id: way.id(), nodes: way.refs().collect(), tags });
                }
            }
            Element::Relation(_) => {}
        })
        .map_err(|error| OsmError::Pbf { cause: error.to_string() })?;
    fault.map_or(Ok(data), |cause| Err(OsmError::Pbf { cause }))
}

/// Degrees from the format's billionths; the division rounds to the f64 that the decimal number in OSM XML reads as.
fn degrees(nano_degrees: i64) -> f64 {
    nano_degrees as f64 / 1e9
}

//! OSM PBF.

use std::io::Cursor;

use osmpbf::{Element, ElementReader};

use crate::LatLon;
use crate::osm::{OsmData, OsmError, OsmNode, OsmWay};

/// Reads nodes and highways in the file's order.
pub(crate) fn read(bytes: &[u8]) -> Result<OsmData, OsmError> {
    let mut data = OsmData::default();
    let mut fault = None;
    let mut add_node = |nodes: &mut Vec<OsmNode>, id, lat_deg, lon_deg| match LatLon::new(lat_deg, lon_deg) {
        Ok(at) => nodes.push(OsmNode { id, at }),
        Err(error) => {
            fault.get_or_insert(format!("node {id}: {error}"));
        }
    };
    ElementReader::new(Cursor::new(bytes))
        .for_each(|element| match element {
            Element::Node(node) => add_node(&mut data.nodes, node.id(), node.lat(), node.lon()),
            Element::DenseNode(node) => add_node(&mut data.nodes, node.id(), node.lat(), node.lon()),
            Element::Way(way) => {
                let tags: std::collections::BTreeMap<String, String> =
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

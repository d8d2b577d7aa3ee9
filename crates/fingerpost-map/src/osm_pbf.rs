//! OSM PBF.

use std::collections::BTreeMap;
use std::io::Cursor;

use osmpbf::{BlobDecode, BlobError, BlobReader, Element, ErrorKind, PrimitiveBlock};

use crate::LatLon;
use crate::osm::{OsmData, OsmError, OsmNode, OsmWay};
use crate::osm_budget::Budget;

/// Reads nodes and highways in the file's order, block by block; what the decoder takes for a block is not counted.
pub(crate) fn read(bytes: &[u8], memory_bytes: usize) -> Result<OsmData, OsmError> {
    let mut reading = Reading { data: OsmData::default(), budget: Budget::new(memory_bytes) };
    for blob in BlobReader::new(Cursor::new(bytes)) {
        let blob = blob.map_err(broken)?;
        if let BlobDecode::OsmData(block) = blob.decode().map_err(broken)? {
            reading.block(&block)?;
        }
    }
    Ok(reading.data)
}

fn broken(error: osmpbf::Error) -> OsmError {
    match error.kind() {
        // A block of a known packing is never empty.
        ErrorKind::Blob(BlobError::Empty) => OsmError::PackedBlocks,
        _ => OsmError::Pbf { cause: error.to_string() },
    }
}

struct Reading {
    data: OsmData,
    budget: Budget,
}

impl Reading {
    fn block(&mut self, block: &PrimitiveBlock) -> Result<(), OsmError> {
        for element in block.elements() {
            match element {
                Element::Node(node) => self.node(node.id(), node.nano_lat(), node.nano_lon())?,
                Element::DenseNode(node) => self.node(node.id(), node.nano_lat(), node.nano_lon())?,
                Element::Way(way) => {
                    if way.tags().any(|(key, _)| key == "highway") {
                        self.budget.take_way()?;
                        let mut tags = BTreeMap::new();
                        for (key, value) in way.tags() {
                            self.budget.take_tag(key, value)?;
                            tags.insert(key.to_owned(), value.to_owned());
                        }
                        let mut nodes = Vec::new();
                        for node in way.refs() {
                            self.budget.take_reference()?;
                            nodes.push(node);
                        }
                        let way = OsmWay { id: way.id(), nodes, tags };
                        self.data.ways.push(way);
                    }
                }
                Element::Relation(_) => {}
            }
        }
        Ok(())
    }

    fn node(&mut self, id: i64, nano_lat: i64, nano_lon: i64) -> Result<(), OsmError> {
        let at = LatLon::new(degrees(nano_lat), degrees(nano_lon));
        let at = at.map_err(|error| OsmError::Pbf { cause: format!("node {id}: {error}") })?;
        self.budget.take_node()?;
        self.data.nodes.push(OsmNode { id, at });
        Ok(())
    }
}

/// Degrees from the format's billionths; the division rounds to the f64 that the decimal number in OSM XML reads as.
fn degrees(nano_degrees: i64) -> f64 {
    nano_degrees as f64 / 1e9
}

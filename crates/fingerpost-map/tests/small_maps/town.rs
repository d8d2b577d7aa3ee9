//! Small maps for tests, laid out in metres.

use std::collections::BTreeMap;

use fingerpost_map::{LatLon, OsmBarrier, OsmData, OsmNode, OsmWay, RoadGraph, TangentPlane};
use nalgebra::Point2;

/// A map under construction: nodes by number at metres east and north of the origin.
#[derive(Default)]
pub(crate) struct Town {
    data: OsmData,
}

/// Where the test maps lie.
pub(crate) fn plane() -> TangentPlane {
    TangentPlane::new(LatLon { lat_deg: 48.98, lon_deg: 8.39 })
}

/// The place so many metres east and north of the origin.
pub(crate) fn at(x: f64, y: f64) -> LatLon {
    plane().wgs84_from_map(Point2::new(x, y))
}

impl Town {
    /// Adds a node.
    pub(crate) fn node(mut self, id: i64, x: f64, y: f64) -> Self {
        self.data.nodes.push(OsmNode { id, at: at(x, y) });
        self
    }

    /// Adds a way; tags as "key=value".
    pub(crate) fn way(mut self, id: i64, nodes: &[i64], tags: &[&str]) -> Self {
        self.data.ways.push(OsmWay { id, nodes: nodes.to_vec(), tags: tags_of(tags) });
        self
    }

    /// Adds the tags of a node with a barrier, as "key=value".
    pub(crate) fn barrier(mut self, node: i64, tags: &[&str]) -> Self {
        self.data.barriers.push(OsmBarrier { node, tags: tags_of(tags) });
        self
    }

    /// The map as data.
    pub(crate) fn data(self) -> OsmData {
        self.data
    }

    /// The map as a graph in [`plane`].
    pub(crate) fn graph(self) -> RoadGraph {
        RoadGraph::from_osm_at(&self.data, plane().origin()).expect("a town has roads")
    }
}

fn tags_of(tags: &[&str]) -> BTreeMap<String, String> {
    let tags = tags.iter().filter_map(|tag| tag.split_once('='));
    tags.map(|(key, value)| (key.to_owned(), value.to_owned())).collect()
}

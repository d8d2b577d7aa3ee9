//! The road graph: nodes and straight segments between consecutive OSM nodes of drivable ways, in metres.
//!
//! Nodes are in ascending order of OSM's numbers, ways likewise, segments in the order of their ways; everything that
//! walks the graph does so in these orders and is therefore the same every time.

use std::collections::BTreeMap;

use nalgebra::Point2;
use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};
use thiserror::Error;

use crate::feature::MOST_ARMS;
use crate::roads::Roads;
use crate::{LatLon, MapBounds, MapNotice, OsmData, RoadAttributes, TangentPlane, Travel};

/// A place where segments meet.
#[derive(Debug, Clone, PartialEq)]
pub struct RoadNode {
    /// OSM's number.
    pub id: i64,
    /// Where it is.
    pub at: LatLon,
    /// Where it is in the graph's plane, metres.
    pub p_in_map: Point2<f64>,
    /// Indices of the segments that end here, ascending.
    pub segments: Vec<usize>,
    /// Whether a barrier lets no car through.
    pub is_closed: bool,
}

/// A drivable way. A way that leaves an extract and comes back is several of these with one number.
#[derive(Debug, Clone, PartialEq)]
pub struct RoadWay {
    /// OSM's number.
    pub id: i64,
    /// Indices of its nodes, in the way's direction; two at least.
    pub nodes: Vec<usize>,
    /// What the map says about it.
    pub attributes: RoadAttributes,
}

/// The straight piece of a way between two consecutive nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadSegment {
    /// Index of its way.
    pub way: usize,
    /// Index of the node where it starts, in the way's direction.
    pub start: usize,
    /// Index of the node where it ends.
    pub end: usize,
    /// Length, metres.
    pub length_m: f64,
}

/// Direction of going along a segment, against its way's direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// From start to end.
    Forward,
    /// From end to start.
    Backward,
}

/// The place of a road nearest to a given place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snap {
    /// Index of the segment.
    pub segment: usize,
    /// Distance along the segment from its start, metres.
    pub along_m: f64,
    /// The place on the road, metres in the graph's plane.
    pub p_in_map: Point2<f64>,
    /// Distance of the given place from it, metres.
    pub distance_m: f64,
}

/// Why data makes no road graph.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GraphError {
    /// No way in it is for motor vehicles.
    #[error(
        "the map has no roads: of its {highways} ways tagged highway none is open to motor vehicles with two nodes in \
         the extract; export an area with roads, with the nodes of its ways{}", listed(.notices)
    )]
    NoRoads {
        /// How many ways carry a `highway` tag.
        highways: usize,
        /// What of the map was not understood, one a kind; a server's remark may say why it is empty.
        notices: Vec<MapNotice>,
    },
    /// More roads at a node than any junction has.
    #[error(
        "{roads} pieces of road meet at node {node} of the map, and no junction has more than {MOST_ARMS}: the map is damaged \
         there; correct it, or cut out another area"
    )]
    Crowded {
        /// OSM's number of the node.
        node: i64,
        /// How many meet there.
        roads: usize,
    },
}

/// Notices behind a message.
fn listed(notices: &[MapNotice]) -> String {
    notices.iter().map(|notice| format!(" ({notice})")).collect()
}

type IndexedSegment = GeomWithData<Line<[f64; 2]>, usize>;

/// Drivable roads as a graph in a tangent plane.
#[derive(Debug, Clone)]
pub struct RoadGraph {
    plane: TangentPlane,
    nodes: Vec<RoadNode>,
    ways: Vec<RoadWay>,
    segments: Vec<RoadSegment>,
    index: RTree<IndexedSegment>,
    bounds: MapBounds,
    notices: Vec<MapNotice>,
}

impl RoadGraph {
    /// The drivable roads of the data, in the plane that touches the earth in the middle of the roads' nodes.
    ///
    /// # Errors
    /// [`GraphError::NoRoads`] and [`GraphError::Crowded`].
    pub fn from_osm(osm: &OsmData) -> Result<Self, GraphError> {
        let roads = Roads::of(osm)?;
        let origin = roads.bounds.middle();
        Self::of(roads, TangentPlane::new(origin))
    }

    /// The drivable roads of the data in the plane of `origin`, such as a route's.
    ///
    /// # Errors
    /// As [`Self::from_osm`].
    pub fn from_osm_at(osm: &OsmData, origin: LatLon) -> Result<Self, GraphError> {
        Self::of(Roads::of(osm)?, TangentPlane::new(origin))
    }

    fn of(roads: Roads, plane: TangentPlane) -> Result<Self, GraphError> {
        let index_of: BTreeMap<i64, usize> =
            roads.places.keys().enumerate().map(|(index, id)| (*id, index)).collect();
        let node = |(&id, &at): (&i64, &LatLon)| RoadNode {
            id,
            at,
            p_in_map: plane.map_from_wgs84(at),
            segments: Vec::new(),
            is_closed: roads.closed.contains(&id),
        };
        let mut nodes: Vec<RoadNode> = roads.places.iter().map(node).collect();
        let mut segments = Vec::new();
        let mut ways = Vec::with_capacity(roads.ways.len());
        for (id, way_nodes, attributes) in roads.ways {
            let way_nodes: Vec<usize> = way_nodes.iter().map(|id| index_of[id]).collect();
            for ends in way_nodes.windows(2) {
                let length_m = (nodes[ends[1]].p_in_map - nodes[ends[0]].p_in_map).norm();
                for &end in ends {
                    nodes[end].segments.push(segments.len());
                }
                segments.push(RoadSegment { way: ways.len(), start: ends[0], end: ends[1], length_m });
            }
            ways.push(RoadWay { id, nodes: way_nodes, attributes });
        }
        if let Some(crowded) = nodes.iter().find(|node| node.segments.len() > MOST_ARMS) {
            return Err(GraphError::Crowded { node: crowded.id, roads: crowded.segments.len() });
        }
        let entries = segments.iter().enumerate().map(|(index, segment)| {
            let [start, end] = [segment.start, segment.end].map(|node| nodes[node].p_in_map);
            GeomWithData::new(Line::new([start.x, start.y], [end.x, end.y]), index)
        });
        let index = RTree::bulk_load(entries.filter(|entry| segments[entry.data].length_m > 0.0).collect());
        Ok(Self { plane, nodes, ways, segments, index, bounds: roads.bounds, notices: roads.notices })
    }

    /// The plane that the graph's metres are counted in.
    pub fn plane(&self) -> &TangentPlane {
        &self.plane
    }

    /// What the roads cover.
    pub const fn bounds(&self) -> &MapBounds {
        &self.bounds
    }

    /// What of the map was not understood, one a kind.
    pub fn notices(&self) -> &[MapNotice] {
        &self.notices
    }

    /// All nodes, ascending OSM numbers.
    pub fn nodes(&self) -> &[RoadNode] {
        &self.nodes
    }

    /// All ways, ascending OSM numbers.
    pub fn ways(&self) -> &[RoadWay] {
        &self.ways
    }

    /// All segments, in the order of their ways.
    pub fn segments(&self) -> &[RoadSegment] {
        &self.segments
    }

    /// Index of the node with OSM's number; `None` when no road has it.
    pub fn node_index(&self, id: i64) -> Option<usize> {
        self.nodes.binary_search_by_key(&id, |node| node.id).ok()
    }

    /// The line of a way of this graph, metres in the graph's plane.
    pub fn way_line(&self, way: &RoadWay) -> Vec<Point2<f64>> {
        way.nodes.iter().map(|&node| self.nodes[node].p_in_map).collect()
    }

    /// What the map says about the road that a segment belongs to.
    pub fn attributes_of(&self, segment: usize) -> &RoadAttributes {
        &self.ways[self.segments[segment].way].attributes
    }

    /// The place of any road nearest to `p_in_map` (metres in the graph's plane) within `reach_m`; of equally near
    /// segments the first.
    pub fn nearest(&self, p_in_map: Point2<f64>, reach_m: f64) -> Option<Snap> {
        let nearest = self.index.nearest_neighbor([p_in_map.x, p_in_map.y])?;
        let distance_m = self.snap_to(nearest.data, p_in_map).distance_m;
        if distance_m > reach_m {
            return None;
        }
        self.within(p_in_map, distance_m).into_iter().next()
    }

    /// The nearest place of each segment within `reach_m` of `p_in_map` (metres in the graph's plane), nearest first,
    /// equally near ones in the graph's order.
    pub fn within(&self, p_in_map: Point2<f64>, reach_m: f64) -> Vec<Snap> {
        // The tree measures by its own arithmetic; the margin keeps a segment at exactly the reach.
        let reach_m = reach_m + REACH_MARGIN_M;
        let corner = |sign: f64| [p_in_map.x + sign * reach_m, p_in_map.y + sign * reach_m];
        let around = AABB::from_corners(corner(-1.0), corner(1.0));
        let mut snaps: Vec<Snap> = self
            .index
            .locate_in_envelope_intersecting(around)
            .map(|entry| self.snap_to(entry.data, p_in_map))
            .filter(|snap| snap.distance_m <= reach_m)
            .collect();
        snaps.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m).then(a.segment.cmp(&b.segment)));
        snaps
    }

    /// The nearest place of one segment to `p_in_map`, metres in the graph's plane.
    pub fn snap_to(&self, segment: usize, p_in_map: Point2<f64>) -> Snap {
        let RoadSegment { start, end, length_m, .. } = self.segments[segment];
        let (start, end) = (self.nodes[start].p_in_map, self.nodes[end].p_in_map);
        let along = (p_in_map - start).dot(&(end - start)) / length_m;
        let along_m = if length_m > 0.0 { along.clamp(0.0, length_m) } else { 0.0 };
        let on_road = if length_m > 0.0 { start + (end - start) * (along_m / length_m) } else { start };
        Snap { segment, along_m, p_in_map: on_road, distance_m: (p_in_map - on_road).norm() }
    }

    /// Whether a segment may be driven in a direction, now and always.
    pub fn permits(&self, segment: usize, direction: Direction) -> bool {
        self.attributes_of(segment).travel != Travel::Unsure && !self.forbids(segment, direction)
    }

    /// Whether a segment is never driven in a direction.
    pub fn forbids(&self, segment: usize, direction: Direction) -> bool {
        match self.attributes_of(segment).travel {
            Travel::Both | Travel::Unsure => false,
            Travel::Forward => direction == Direction::Backward,
            Travel::Backward => direction == Direction::Forward,
        }
    }

    /// The node at a segment's end when it is gone along in a direction.
    pub fn head(&self, segment: usize, direction: Direction) -> usize {
        match direction {
            Direction::Forward => self.segments[segment].end,
            Direction::Backward => self.segments[segment].start,
        }
    }

    /// The direction of going along a segment away from a node at one of its ends.
    pub fn away_from(&self, segment: usize, node: usize) -> Direction {
        if self.segments[segment].start == node { Direction::Forward } else { Direction::Backward }
    }
}

/// Slack of the search for segments within reach, metres; far below the map's resolution.
const REACH_MARGIN_M: f64 = 1e-9;

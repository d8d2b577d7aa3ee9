//! The two maps of a world: roads as they are, and as a map has them.

use fingerpost_map::{OsmData, OsmNode, OsmWay, RoadAttributes, RoadGraph};
use nalgebra::{Point2, Vector2};

use super::ranges;
use crate::noise::{Stream, mix, value_noise};

/// The map with each street as wide as it is: wider or narrower than tagged, the same along a name; all of them `broadness` times as
/// wide.
pub(super) fn as_built(osm: &OsmData, seed: u64, broadness: f64) -> OsmData {
    let mut built = osm.clone();
    for way in &mut built.ways {
        let Some(attributes) = RoadAttributes::from_tags(&way.tags) else { continue };
        let street = attributes.name.as_deref().map_or(mix(way.id as u64), |name| {
            name.bytes().fold(0, |hash, byte| mix(hash ^ u64::from(byte)))
        });
        let factor =
            broadness * libm::exp(Stream::new(seed ^ 0x5749_4454, street).normal(ranges::WIDTH_LOG_SIGMA));
        way.tags.insert("width".to_owned(), format!("{:.3}", factor * attributes.width_m));
    }
    built
}

/// The map as it is known: places off, ways missing, side roads invented. Invented ways and nodes have negative numbers.
pub(super) fn as_mapped(osm: &OsmData, roads: &RoadGraph, seed: u64) -> OsmData {
    let errors = MapErrors::new(seed);
    let mut mapped = osm.clone();
    mapped.ways.retain(|way| RoadAttributes::from_tags(&way.tags).is_none() || !errors.misses(way.id));
    let (nodes, ways) = errors.invented(osm, &mapped, roads);
    for node in &mut mapped.nodes {
        let p_in_map = roads.plane().map_from_wgs84(node.at);
        node.at = roads.plane().wgs84_from_map(p_in_map + errors.offset_m(node.id, p_in_map));
    }
    mapped.nodes.extend(nodes);
    mapped.ways.extend(ways);
    mapped.nodes.sort_by_key(|node| node.id);
    mapped.ways.sort_by_key(|way| way.id);
    mapped
}

/// What is wrong with a map.
struct MapErrors {
    seed: u64,
    /// Largest shift to the east and to the north, metres.
    shift_m: f64,
}

impl MapErrors {
    fn new(seed: u64) -> Self {
        let seed = seed ^ 0x4d41_5045;
        let shift_m = Stream::new(seed, 0).between(0.0, ranges::SHIFT_M) / std::f64::consts::SQRT_2;
        Self { seed, shift_m }
    }

    /// From where a node is to where the map has it, metres.
    fn offset_m(&self, id: i64, p_in_map: Point2<f64>) -> Vector2<f64> {
        let [x, y] = [p_in_map.x, p_in_map.y].map(|m| (m / ranges::SHIFT_LENGTH_M) as f32);
        let smooth = |topic: u64| 2.0 * f64::from(value_noise(mix(self.seed ^ topic), x, y)) - 1.0;
        let mut stream = Stream::new(self.seed ^ 1, id as u64);
        let mut jitter_m = || stream.normal(ranges::NODE_SIGMA_M);
        Vector2::new(self.shift_m * smooth(2) + jitter_m(), self.shift_m * smooth(3) + jitter_m())
    }

    /// Whether nobody has mapped a way.
    fn misses(&self, way: i64) -> bool {
        Stream::new(self.seed ^ 4, way as u64).unit() < ranges::MISSING_WAYS
    }

    /// The side roads that are on the map alone, with their nodes; they begin where the map has the roads that they leave.
    fn invented(&self, osm: &OsmData, mapped: &OsmData, roads: &RoadGraph) -> (Vec<OsmNode>, Vec<OsmWay>) {
        // Below all numbers there are; a file that an editor has saved has negative ones.
        let lowest = osm.nodes.iter().map(|node| node.id).chain(osm.ways.iter().map(|way| way.id)).min();
        let mut number = lowest.unwrap_or(0).min(0);
        let (mut nodes, mut ways) = (Vec::new(), Vec::new());
        for way in &mapped.ways {
            let Some(attributes) = RoadAttributes::from_tags(&way.tags) else { continue };
            for inside in way.nodes.windows(3) {
                let mut stream = Stream::new(self.seed ^ 5, inside[1] as u64);
                let Some(from) = roads.node_index(inside[1]).map(|index| &roads.nodes()[index]) else {
                    continue;
                };
                if stream.unit() >= ranges::INVENTED_ARMS || from.segments.len() != 2 {
                    continue;
                }
                let Some(next) = roads.node_index(inside[2]).map(|index| &roads.nodes()[index]) else {
                    continue;
                };
                let along = next.p_in_map - from.p_in_map;
                let side = if stream.unit() < 0.5 { 1.0 } else { -1.0 };
                let [low_deg, high_deg] = ranges::INVENTED_DEG;
                let turn_rad = side * stream.between(low_deg, high_deg).to_radians();
                let length_m = stream.between(ranges::INVENTED_M[0], ranges::INVENTED_M[1]);
                let direction = nalgebra::Rotation2::new(turn_rad) * along.normalize();
                let end = from.p_in_map + self.offset_m(from.id, from.p_in_map) + direction * length_m;
                number -= 1;
                nodes.push(OsmNode { id: number, at: roads.plane().wgs84_from_map(end) });
                let highway = if attributes.class.as_str() == "track" { "track" } else { "service" };
                ways.push(OsmWay {
                    id: number,
                    nodes: vec![from.id, number],
                    tags: [("highway".to_owned(), highway.to_owned())].into(),
                });
            }
        }
        (nodes, ways)
    }
}

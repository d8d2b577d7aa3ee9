//! The road graph as a vehicle drives it: directed edges from junction to junction.

use fingerpost_geometry::Polyline;
use fingerpost_map::{Direction, RoadGraph};
use nalgebra::Vector2;

/// How probable it is, against another exit, that a vehicle enters a one-way street from its wrong end: directions that are wrong in
/// the map and forbidden driving together. A judgement; small enough not to double the hypotheses' weight, and not zero.
const WRONG_WAY: f64 = 0.01;

/// Width of a two-way road from which on it has two lanes, metres: the widths that this map reader assumes for tertiary roads and
/// above. Narrower ones are driven in the middle, along parked cars.
const TWO_LANES_M: f64 = 6.0;

/// The side of the road that is driven on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Traffic {
    /// As in most of the world.
    #[default]
    Right,
    /// As in Britain and Japan.
    Left,
    /// The middle, as on single-lane tracks.
    Centre,
}

/// A road between two junctions or ends, in one direction.
#[derive(Debug, Clone)]
pub(crate) struct Edge {
    /// The line that is driven, in the graph's plane and the direction of travel: the road's own, or the middle of its lane.
    pub(crate) line: Polyline,
    /// The edges that go on from its end, without its own reverse, with the probability of each.
    pub(crate) exits: Vec<(u32, f64)>,
    /// How probable it is to be on it, against a road that may be driven this way.
    pub(crate) prior: f64,
}

/// Turn from which on a bend counts as a corner, radians.
const CORNER_FROM_RAD: f64 = std::f64::consts::FRAC_PI_6;

/// How roads bend between their corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kind {
    /// Its part of all roads, by length.
    pub(crate) part: f64,
    /// Variance of the heading that a metre adds, square radians.
    pub(crate) rad2_per_m: f64,
}

/// How the roads of a map bend, on a drive that takes every exit as often as the hypotheses do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bends {
    /// Corners on a metre.
    pub(crate) corners_per_m: f64,
    /// Junctions and ends on a metre, where a road of another kind may go on.
    pub(crate) ends_per_m: f64,
    /// Roads that bend less than the mean and those that bend more.
    pub(crate) kinds: [Kind; 2],
}

/// All directed edges.
#[derive(Debug, Clone)]
pub(crate) struct Roads {
    edges: Vec<Edge>,
    bends: Bends,
}

impl Roads {
    pub(crate) fn of(graph: &RoadGraph, traffic: Traffic) -> Self {
        let mut chains = Chains::of(graph, traffic);
        chains.link();
        let bends = Bends::of(&chains.edges);
        Self { edges: chains.edges, bends }
    }

    pub(crate) const fn bends(&self) -> Bends {
        self.bends
    }

    pub(crate) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    pub(crate) fn edge(&self, edge: u32) -> &Edge {
        &self.edges[edge as usize]
    }
}

impl Bends {
    fn of(edges: &[Edge]) -> Self {
        let mut all = Bending::default();
        let each: Vec<Bending> = edges.iter().map(|edge| Bending::of(edge, edges)).collect();
        each.iter().for_each(|edge| all.add(edge));
        let mut kinds = [Bending::default(); 2];
        for edge in &each {
            kinds[usize::from(edge.rad2_per_m() > all.rad2_per_m())].add(edge);
        }
        let kinds = kinds.map(|kind| Kind {
            part: kind.driven_m / all.driven_m.max(f64::MIN_POSITIVE),
            rad2_per_m: kind.rad2_per_m(),
        });
        let per_m = |count: f64| count / all.driven_m.max(f64::MIN_POSITIVE);
        Self { corners_per_m: per_m(all.corners), ends_per_m: per_m(all.ends), kinds }
    }
}

/// What bends there are along edges, each as often as it is driven.
#[derive(Debug, Clone, Copy, Default)]
struct Bending {
    driven_m: f64,
    ends: f64,
    corners: f64,
    rad2: f64,
}

impl Bending {
    /// Those of an edge and of the exits at its end.
    fn of(edge: &Edge, edges: &[Edge]) -> Self {
        let mut bending =
            Self { driven_m: edge.line.length_m() * edge.prior, ends: edge.prior, ..Self::default() };
        for corner in edge.line.points().windows(3) {
            bending.count(corner[1] - corner[0], corner[2] - corner[1], edge.prior);
        }
        let end = edge.line.at(edge.line.length_m()).1;
        for &(exit, probability) in &edge.exits {
            bending.count(end, edges[exit as usize].line.at(0.0).1, edge.prior * probability);
        }
        bending
    }

    fn count(&mut self, before: Vector2<f64>, after: Vector2<f64>, often: f64) {
        let turn_rad = libm::atan2(before.perp(&after), before.dot(&after));
        if turn_rad.abs() > CORNER_FROM_RAD {
            self.corners += often;
        } else {
            self.rad2 += turn_rad * turn_rad * often;
        }
    }

    fn add(&mut self, other: &Self) {
        self.driven_m += other.driven_m;
        self.ends += other.ends;
        self.corners += other.corners;
        self.rad2 += other.rad2;
    }

    fn rad2_per_m(&self) -> f64 {
        self.rad2 / self.driven_m.max(f64::MIN_POSITIVE)
    }
}

struct Chains<'a> {
    graph: &'a RoadGraph,
    traffic: Traffic,
    edges: Vec<Edge>,
    /// Node at each edge's start and end.
    ends: Vec<[usize; 2]>,
    /// Whether a segment of the graph is part of an edge already.
    taken: Vec<bool>,
}

impl<'a> Chains<'a> {
    fn of(graph: &'a RoadGraph, traffic: Traffic) -> Self {
        let mut chains = Self {
            graph,
            traffic,
            edges: Vec::new(),
            ends: Vec::new(),
            taken: vec![false; graph.segments().len()],
        };
        // From junctions and ends first; what is left then are closed rings.
        for ring in [false, true] {
            for segment in 0..graph.segments().len() {
                for direction in [Direction::Forward, Direction::Backward] {
                    let start = chains.tail(segment, direction);
                    let begins = ring || !chains.goes_through(start);
                    if begins && !chains.taken[segment] {
                        chains.follow(segment, direction);
                    }
                }
            }
        }
        chains
    }

    fn tail(&self, segment: usize, direction: Direction) -> usize {
        match direction {
            Direction::Forward => self.graph.head(segment, Direction::Backward),
            Direction::Backward => self.graph.head(segment, Direction::Forward),
        }
    }

    /// Whether a road just goes on at a node: two segments that may be driven the same way.
    fn goes_through(&self, node: usize) -> bool {
        let segments = &self.graph.nodes()[node].segments;
        let [one, other] = segments[..] else { return false };
        let into = self.graph.away_from(one, node);
        let (onto, back) = (self.graph.away_from(other, node), self.graph.away_from(one, node));
        let allowed = |segment: usize, away: Direction| {
            let towards = opposite(away);
            [away, towards].map(|direction| !self.graph.forbids(segment, direction))
        };
        let ([one_away, one_towards], [other_away, other_towards]) =
            (allowed(one, into), allowed(other, onto));
        one != other && back == into && one_towards == other_away && one_away == other_towards
    }

    fn follow(&mut self, segment: usize, direction: Direction) {
        let first = segment;
        let (mut segment, mut direction) = (segment, direction);
        let start = self.tail(segment, direction);
        let travel =
            [direction, opposite(direction)].map(|direction| !self.graph.forbids(segment, direction));
        let mut points = vec![self.graph.nodes()[start].p_in_map];
        let end = loop {
            self.taken[segment] = true;
            let head = self.graph.head(segment, direction);
            points.push(self.graph.nodes()[head].p_in_map);
            if head == start || !self.goes_through(head) {
                break head;
            }
            let Some(&next) = self.graph.nodes()[head].segments.iter().find(|&&next| next != segment) else {
                break head;
            };
            (segment, direction) = (next, self.graph.away_from(next, head));
        };
        let Ok(line) = Polyline::new(points) else { return };
        let prior = |allowed: bool| if allowed { 1.0 } else { WRONG_WAY };
        let width_m = self.graph.attributes_of(first).width_m;
        let has_lanes = travel[0] && travel[1] && width_m >= TWO_LANES_M;
        let left_m = match self.traffic {
            Traffic::Right => -0.25 * width_m,
            Traffic::Left => 0.25 * width_m,
            Traffic::Centre => 0.0,
        };
        let [line, reverse] = [line.clone(), line.reversed()]
            .map(|line| if has_lanes { line.offset(left_m).unwrap_or(line) } else { line });
        self.edges.push(Edge { line, exits: Vec::new(), prior: prior(travel[0]) });
        self.edges.push(Edge { line: reverse, exits: Vec::new(), prior: prior(travel[1]) });
        self.ends.extend([[start, end], [end, start]]);
    }

    fn link(&mut self) {
        let mut leaving: Vec<Vec<u32>> = vec![Vec::new(); self.graph.nodes().len()];
        for (edge, [start, _]) in self.ends.iter().enumerate() {
            leaving[*start].push(edge as u32);
        }
        for edge in 0..self.edges.len() {
            let onward = leaving[self.ends[edge][1]].iter().filter(|&&next| next != edge as u32 ^ 1);
            let exits: Vec<(u32, f64)> =
                onward.map(|&next| (next, self.edges[next as usize].prior)).collect();
            let total: f64 = exits.iter().map(|(_, prior)| prior).sum();
            self.edges[edge].exits = exits.into_iter().map(|(next, prior)| (next, prior / total)).collect();
        }
    }
}

const fn opposite(direction: Direction) -> Direction {
    match direction {
        Direction::Forward => Direction::Backward,
        Direction::Backward => Direction::Forward,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingerpost_map::OsmData;

    /// A road of three nodes from west to east, with a one-way street to the north at its east end and a road on to the east.
    fn crossing() -> Roads {
        let node = |id: i64, lat: f64, lon: f64| format!("<node id=\"{id}\" lat=\"{lat}\" lon=\"{lon}\"/>");
        let way = |id: i64, nodes: &[i64], tags: &str| {
            let nodes: String = nodes.iter().map(|id| format!("<nd ref=\"{id}\"/>")).collect();
            format!("<way id=\"{id}\">{nodes}<tag k=\"highway\" v=\"residential\"/>{tags}</way>")
        };
        let nodes = [(1, 0.0, 0.0), (2, 0.0, 0.001), (3, 0.0, 0.002), (4, 0.001, 0.002), (5, 0.0, 0.003)];
        let nodes: String = nodes.iter().map(|&(id, lat, lon)| node(id, lat, lon)).collect();
        let ways =
            way(1, &[1, 2, 3], "") + &way(2, &[3, 4], "<tag k=\"oneway\" v=\"yes\"/>") + &way(3, &[3, 5], "");
        let text = format!("<osm version=\"0.6\">{nodes}{ways}</osm>");
        Roads::of(
            &RoadGraph::from_osm(&OsmData::from_bytes(text.as_bytes()).unwrap()).unwrap(),
            Traffic::Right,
        )
    }

    #[test]
    fn a_node_of_one_road_is_no_junction() {
        let roads = crossing();
        assert_eq!(roads.edges().len(), 6);
        let lengths: Vec<f64> = roads.edges().iter().map(|edge| edge.line.length_m().round()).collect();
        assert_eq!(lengths.iter().filter(|length_m| (**length_m - 223.0).abs() < 0.5).count(), 2);
    }

    #[test]
    fn exits_leave_where_the_edge_ends_and_never_turn_back() {
        let roads = crossing();
        for (index, edge) in roads.edges().iter().enumerate() {
            let end = edge.line.points().last().unwrap();
            let total: f64 = edge.exits.iter().map(|(_, probability)| probability).sum();
            assert!(edge.exits.is_empty() || (total - 1.0).abs() < 1e-12);
            for &(exit, _) in &edge.exits {
                assert_ne!(exit, index as u32 ^ 1);
                assert!((roads.edge(exit).line.points()[0] - end).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn nobody_expects_a_one_way_street_to_be_entered_from_its_end() {
        let roads = crossing();
        let northward = |edge: &Edge| edge.line.points()[1].y - edge.line.points()[0].y > 50.0;
        let southward = |edge: &Edge| edge.line.points()[1].y - edge.line.points()[0].y < -50.0;
        assert!(roads.edges().iter().filter(|edge| northward(edge)).all(|edge| edge.prior > 0.9));
        assert!(roads.edges().iter().filter(|edge| southward(edge)).all(|edge| edge.prior < 0.1));
        // From the west: straight on or to the north.
        let from_west =
            roads.edges().iter().find(|edge| edge.line.length_m() > 200.0 && edge.exits.len() == 2);
        let exits = &from_west.unwrap().exits;
        assert!((exits[0].1 - 0.5).abs() < 1e-12 && (exits[1].1 - 0.5).abs() < 1e-12);
    }
}

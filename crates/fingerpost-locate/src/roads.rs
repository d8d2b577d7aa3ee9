//! The road graph as a vehicle drives it: directed edges from junction to junction.

use fingerpost_geometry::Polyline;
use fingerpost_map::{Direction, RoadGraph};

/// How probable it is, against another exit, that a vehicle enters a one-way street from its wrong end: map errors and forbidden
/// driving together are of this order (OpenStreetMap's own quality checks find about one wrong direction in a hundred).
const WRONG_WAY: f64 = 0.01;

/// A road between two junctions or ends, in one direction.
#[derive(Debug, Clone)]
pub(crate) struct Edge {
    /// Its line in the graph's plane, in the direction of travel.
    pub(crate) line: Polyline,
    /// The edges that go on from its end, without its own reverse, with the probability of each.
    pub(crate) exits: Vec<(u32, f64)>,
    /// How probable it is to be on it, against a road that may be driven this way.
    pub(crate) prior: f64,
}

/// All directed edges, and which of them a segment of the graph belongs to.
#[derive(Debug, Clone)]
pub(crate) struct Roads {
    edges: Vec<Edge>,
    /// For each segment of the graph: its edge in the segment's own direction, the reverse edge, and the arc length of the
    /// segment's start on the former, metres.
    of_segment: Vec<([u32; 2], f64)>,
}

impl Roads {
    pub(crate) fn of(graph: &RoadGraph) -> Self {
        let mut chains = Chains::of(graph);
        chains.link();
        Self { edges: chains.edges, of_segment: chains.of_segment }
    }

    pub(crate) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    pub(crate) fn edge(&self, edge: u32) -> &Edge {
        &self.edges[edge as usize]
    }

    /// The directed edges through a place of the graph's segment: each with the arc length of the place, metres.
    pub(crate) fn through(&self, segment: usize, along_m: f64) -> [(u32, f64); 2] {
        let (edges, start_m) = self.of_segment[segment];
        let forward_m = start_m + along_m;
        [(edges[0], forward_m), (edges[1], self.edge(edges[1]).line.length_m() - forward_m)]
    }
}

struct Chains<'a> {
    graph: &'a RoadGraph,
    edges: Vec<Edge>,
    /// Node at each edge's start and end.
    ends: Vec<[usize; 2]>,
    of_segment: Vec<([u32; 2], f64)>,
}

impl<'a> Chains<'a> {
    fn of(graph: &'a RoadGraph) -> Self {
        let unset = ([u32::MAX; 2], 0.0);
        let mut chains =
            Self { graph, edges: Vec::new(), ends: Vec::new(), of_segment: vec![unset; graph.segments().len()] };
        // From junctions and ends first; what is left then are closed rings.
        for ring in [false, true] {
            for segment in 0..graph.segments().len() {
                for direction in [Direction::Forward, Direction::Backward] {
                    let start = chains.tail(segment, direction);
                    let begins = ring || !chains.goes_through(start);
                    if begins && chains.of_segment[segment].0[0] == u32::MAX {
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
            [self.graph.permits(segment, away), self.graph.permits(segment, towards)]
        };
        let ([one_away, one_towards], [other_away, other_towards]) = (allowed(one, into), allowed(other, onto));
        one != other && back == into && one_towards == other_away && one_away == other_towards
    }

    fn follow(&mut self, segment: usize, direction: Direction) {
        let index = self.edges.len() as u32;
        let (mut segment, mut direction) = (segment, direction);
        let start = self.tail(segment, direction);
        let travel = [self.graph.permits(segment, direction), self.graph.permits(segment, opposite(direction))];
        let mut points = vec![self.graph.nodes()[start].p_in_map];
        let mut placed: Vec<(usize, Direction, f64)> = Vec::new();
        let mut along_m = 0.0;
        let end = loop {
            placed.push((segment, direction, along_m));
            along_m += self.graph.segments()[segment].length_m;
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
        let length_m = line.length_m();
        for (segment, direction, along_m) in placed {
            self.of_segment[segment] = match direction {
                Direction::Forward => ([index, index + 1], along_m),
                Direction::Backward => {
                    ([index + 1, index], length_m - along_m - self.graph.segments()[segment].length_m)
                }
            };
        }
        let prior = |allowed: bool| if allowed { 1.0 } else { WRONG_WAY };
        let reverse = line.reversed();
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

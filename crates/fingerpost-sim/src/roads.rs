//! The road network as strokes: straight pieces with a width, strung into chains.
//!
//! A chain runs on through a junction along its straightest continuation; the other arms end there. So a chain is what
//! a driver calls one road, its edge is smooth across the mouths of side roads, and kerbs are rounded only between
//! different chains.

use std::collections::BTreeMap;

use fingerpost_map::{RoadClass, RoadGraph, TangentPlane, Travel};
use nalgebra::{Point2, Vector2};

use crate::junctions::{ChainEnd, Junction};
use crate::street_paint::StreetPaint;

/// What a road is covered with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Surface {
    /// Asphalt, concrete, paving.
    Paved,
    /// Gravel, earth and everything else that is loose.
    Loose,
}

/// A straight piece of a road, map frame, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    /// Start of the axis.
    pub(crate) start: Point2<f64>,
    /// Unit vector along the axis.
    pub(crate) direction: Vector2<f64>,
    /// Length of the axis.
    pub(crate) length_m: f64,
    /// Half of the road's width.
    pub(crate) half_width_m: f64,
    /// Distance of the start from the chain's start.
    pub(crate) along_m: f64,
    /// Which chain it belongs to.
    pub(crate) chain: u32,
    /// Whether both directions use it, so that it has two sides.
    pub(crate) two_way: bool,
    /// Its covering.
    pub(crate) surface: Surface,
    /// Its lines, where each street has its own.
    pub(crate) paint: StreetPaint,
}

impl Stroke {
    /// Distance from the edge of the stroke, negative on it; its ends are round.
    pub(crate) fn edge_distance_m(&self, p_in_map: Point2<f64>) -> f64 {
        let offset = p_in_map - self.start;
        let along = offset.dot(&self.direction).clamp(0.0, self.length_m);
        (offset - self.direction * along).norm() - self.half_width_m
    }
}

/// Two arms of a junction that differ by less from straight on are one road, radians (40 degrees).
const STRAIGHT_ON_RAD: f64 = 0.7;
/// A bend sharper than this splits a chain, so that its inner kerb is rounded, radians (30 degrees).
const SHARP_BEND_RAD: f64 = 0.52;
/// Narrowest road drawn, metres: a car must fit.
const MIN_WIDTH_M: f64 = 2.6;

/// All strokes inside a rectangle, chain by chain.
#[derive(Debug, Clone)]
pub(crate) struct RoadNetwork {
    strokes: Vec<Stroke>,
    junctions: Vec<Junction>,
}

impl RoadNetwork {
    /// The roads of `graph` with a node between `low` and `high` (metres in `plane`).
    pub(crate) fn new(graph: &RoadGraph, plane: &TangentPlane, low: Point2<f64>, high: Point2<f64>) -> Self {
        let places: Vec<Point2<f64>> =
            graph.nodes().iter().map(|node| plane.map_from_wgs84(node.at)).collect();
        let inside = |node: usize| {
            let p = places[node];
            p.x >= low.x && p.y >= low.y && p.x <= high.x && p.y <= high.y
        };
        let links = Links::new(graph, &places);
        let mut strokes = Vec::new();
        let mut meeting: BTreeMap<usize, Vec<ChainEnd>> = BTreeMap::new();
        for (chain, walk) in links.chains(graph).into_iter().enumerate() {
            if walk.iter().any(|step| step.nodes(graph).into_iter().any(inside)) {
                strokes.extend(chain_strokes(graph, &places, &links, &walk, chain as u32));
                for (node, leaves) in links.nodes_of(graph, &places, &walk) {
                    let chains = meeting.entry(node).or_default();
                    if chains.iter().all(|(met, _)| *met != chain as u32) {
                        chains.push((chain as u32, leaves));
                    }
                }
            }
        }
        let meeting =
            meeting.into_iter().map(|(node, chains)| (graph.nodes()[node].id, places[node], chains));
        let junctions = Junction::all(meeting, &strokes);
        Self { strokes, junctions }
    }

    /// The same with the lines that `seed` draws for each chain; a share of them has edges marked as anywhere.
    pub(crate) fn painted(mut self, seed: u64, edge_paint: f64) -> Self {
        for stroke in &mut self.strokes {
            stroke.paint = StreetPaint::drawn(seed, stroke.chain, edge_paint);
        }
        self
    }

    /// The strokes; those of one chain follow each other.
    pub(crate) fn strokes(&self) -> &[Stroke] {
        &self.strokes
    }

    /// The places where chains meet.
    pub(crate) fn junctions(&self) -> &[Junction] {
        &self.junctions
    }

    /// Indices of the strokes whose edge is within `reach_m` of a place, ascending.
    pub(crate) fn within(&self, p_in_map: Point2<f64>, reach_m: f64) -> Vec<u32> {
        (0..self.strokes.len() as u32)
            .filter(|&i| self.strokes[i as usize].edge_distance_m(p_in_map) <= reach_m)
            .collect()
    }

    /// The stroke nearest to a place among those that run along `direction`, and the distance to its axis.
    pub(crate) fn along(&self, p_in_map: Point2<f64>, direction: Vector2<f64>) -> Option<(&Stroke, f64)> {
        // Half of the circle: 45 degrees to either side tells the way driven from the ways that cross it.
        let parallel = self.strokes.iter().filter(|s| s.direction.dot(&direction).abs() > 0.7);
        parallel
            .map(|stroke| (stroke, stroke.edge_distance_m(p_in_map) + stroke.half_width_m))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// A segment walked from one of its ends to the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Step {
    segment: usize,
    /// 0: from the segment's start to its end; 1: the other way.
    from_end: usize,
}

impl Step {
    /// The nodes walked from and to.
    fn nodes(self, graph: &RoadGraph) -> [usize; 2] {
        let segment = graph.segments()[self.segment];
        if self.from_end == 0 { [segment.start, segment.end] } else { [segment.end, segment.start] }
    }

    fn reversed(self) -> Self {
        Self { from_end: 1 - self.from_end, ..self }
    }
}

/// How segments go on at their ends.
struct Links {
    /// For each segment and each of its ends the step that continues the road there.
    next: Vec<[Option<Step>; 2]>,
    /// For each node the half width of the widest road that runs through it; zero without one.
    through_m: Vec<f64>,
}

impl Links {
    fn new(graph: &RoadGraph, places: &[Point2<f64>]) -> Self {
        let mut links =
            Self { next: vec![[None; 2]; graph.segments().len()], through_m: vec![0.0; places.len()] };
        for (index, node) in graph.nodes().iter().enumerate() {
            let arms: Vec<(Step, Vector2<f64>)> = node
                .segments
                .iter()
                .filter(|&&segment| graph.segments()[segment].length_m > 1e-3)
                .map(|&segment| {
                    let from_end = usize::from(graph.segments()[segment].start != index);
                    let step = Step { segment, from_end };
                    let [from, to] = step.nodes(graph);
                    (step, (places[to] - places[from]).normalize())
                })
                .collect();
            links.pair(graph, index, &arms);
        }
        links
    }

    fn pair(&mut self, graph: &RoadGraph, node: usize, arms: &[(Step, Vector2<f64>)]) {
        let limit = if arms.len() == 2 { SHARP_BEND_RAD } else { STRAIGHT_ON_RAD };
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for i in 0..arms.len() {
            for j in i + 1..arms.len() {
                let bend = libm::acos((-arms[i].1).dot(&arms[j].1).clamp(-1.0, 1.0));
                if bend < limit && arms[i].0.segment != arms[j].0.segment {
                    pairs.push((bend, i, j));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut taken = vec![false; arms.len()];
        for (_, i, j) in pairs {
            if taken[i] || taken[j] {
                continue;
            }
            (taken[i], taken[j]) = (true, true);
            let (one, other) = (arms[i].0, arms[j].0);
            self.next[one.segment][one.from_end] = Some(other);
            self.next[other.segment][other.from_end] = Some(one);
            for step in [one, other] {
                let half = 0.5 * graph.attributes_of(step.segment).width_m;
                self.through_m[node] = self.through_m[node].max(half);
            }
        }
    }

    /// The nodes of a walk; with those at which its chain ends, the direction in which it leaves them.
    fn nodes_of(
        &self,
        graph: &RoadGraph,
        places: &[Point2<f64>],
        walk: &[Step],
    ) -> Vec<(usize, Option<Vector2<f64>>)> {
        let (Some(&first), Some(&last)) = (walk.first(), walk.last()) else { return Vec::new() };
        let end = |step: Step| {
            let [from, to] = step.nodes(graph);
            let ends = self.next[step.segment][step.from_end].is_none();
            (from, ends.then(|| (places[to] - places[from]).normalize()))
        };
        let between = walk.iter().skip(1).map(|step| (step.nodes(graph)[0], None));
        std::iter::once(end(first)).chain(between).chain(std::iter::once(end(last.reversed()))).collect()
    }

    /// Every segment once, in walks from road end to road end; rings are cut at their first segment.
    fn chains(&self, graph: &RoadGraph) -> Vec<Vec<Step>> {
        let mut walked: Vec<bool> = graph.segments().iter().map(|segment| segment.length_m <= 1e-3).collect();
        let mut chains = Vec::new();
        let ends = (0..self.next.len())
            .flat_map(|segment| [0, 1].map(|from_end| Step { segment, from_end }))
            .filter(|step| self.next[step.segment][step.from_end].is_none());
        let rings = (0..self.next.len()).map(|segment| Step { segment, from_end: 0 });
        for first in ends.chain(rings) {
            let mut walk = Vec::new();
            let mut step = Some(first);
            while let Some(here) = step.filter(|here| !walked[here.segment]) {
                walked[here.segment] = true;
                walk.push(here);
                step = self.next[here.segment][here.reversed().from_end];
            }
            if !walk.is_empty() {
                chains.push(walk);
            }
        }
        chains
    }
}

fn chain_strokes(
    graph: &RoadGraph,
    places: &[Point2<f64>],
    links: &Links,
    walk: &[Step],
    chain: u32,
) -> Vec<Stroke> {
    let mut along_m = 0.0;
    let mut strokes = Vec::with_capacity(walk.len());
    for step in walk {
        let [from, to] = step.nodes(graph).map(|node| places[node]);
        let attributes = graph.attributes_of(step.segment);
        let length_m = (to - from).norm();
        strokes.push(Stroke {
            start: from,
            direction: (to - from) / length_m,
            length_m,
            half_width_m: 0.5 * attributes.width_m.max(MIN_WIDTH_M),
            along_m,
            chain,
            two_way: attributes.travel == Travel::Both,
            surface: surface_of(attributes.surface.as_deref(), attributes.class),
            paint: StreetPaint::USUAL,
        });
        along_m += length_m;
    }
    // A side road that began at the node itself would bulge through the far kerb of the road it joins.
    let end_trim = |step: Step| {
        let joined = links.next[step.segment][step.from_end].is_some();
        if joined { 0.0 } else { links.through_m[step.nodes(graph)[0]] }
    };
    if let (Some(&first), Some(&last)) = (walk.first(), walk.last()) {
        trim_start(&mut strokes, end_trim(first));
        trim_end(&mut strokes, end_trim(last.reversed()));
    }
    strokes
}

fn trim_start(strokes: &mut Vec<Stroke>, mut trim_m: f64) {
    while let Some(first) = strokes.first_mut() {
        if first.length_m > trim_m {
            first.start += first.direction * trim_m;
            first.along_m += trim_m;
            first.length_m -= trim_m;
            return;
        }
        trim_m -= first.length_m;
        strokes.remove(0);
    }
}

fn trim_end(strokes: &mut Vec<Stroke>, mut trim_m: f64) {
    while let Some(last) = strokes.last_mut() {
        if last.length_m > trim_m {
            last.length_m -= trim_m;
            return;
        }
        trim_m -= last.length_m;
        strokes.pop();
    }
}

fn surface_of(tag: Option<&str>, class: RoadClass) -> Surface {
    const LOOSE: [&str; 12] = [
        "unpaved",
        "gravel",
        "fine_gravel",
        "compacted",
        "dirt",
        "earth",
        "ground",
        "grass",
        "sand",
        "mud",
        "pebblestone",
        "rock",
    ];
    match tag {
        Some(tag) if LOOSE.contains(&tag) => Surface::Loose,
        Some(_) => Surface::Paved,
        None if class == RoadClass::Track => Surface::Loose,
        None => Surface::Paved,
    }
}

//! Stop and give-way lines: across the side of a road on which traffic comes to a junction where another road goes first.
//!
//! They lie at a distance from the edge of that other road, as if its kerbs were not rounded, and are drawn by it and the
//! distance along their own road, so that roads that meet askew have askew lines, as is usual.

use crate::TrafficSide;
use crate::junctions::{ChainAt, Junction};
use crate::noise::Stream;
use crate::roads::{RoadNetwork, Stroke};

/// What is painted across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MouthKind {
    /// A bar without gaps.
    Stop,
    /// Short dashes.
    GiveWay,
    /// Triangles that point at who comes.
    Teeth,
}

/// A line at the mouth of a road, as a stroke of that road needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MouthLine {
    /// What it is.
    pub(crate) kind: MouthKind,
    /// Distance of the junction's node from the chain's start, metres.
    pub(crate) node_m: f32,
    /// 1 where traffic to the junction drives in the chain's direction, else -1.
    pub(crate) towards: f32,
    /// Distances from the edge of the road that goes first at which it begins and ends, metres.
    pub(crate) span_m: [f32; 2],
    /// From where to where it reaches, metres to the left of the axis.
    pub(crate) across_m: [f32; 2],
}

// How many mouths are painted is an assumption, like the streets' lines: half of them, so that either comes up in most drives.

/// Kinds by their share of the mouths; the rest has none.
const KINDS: [(f64, Option<MouthKind>); 4] = [
    (0.5, None),
    (0.2, Some(MouthKind::Stop)),
    (0.2, Some(MouthKind::GiveWay)),
    (0.1, Some(MouthKind::Teeth)),
];
/// Distance from the edge of the road that goes first, metres: right at it, or behind a crossing for people on foot.
const SETBACKS_M: [f64; 2] = [0.2, 2.5];
/// Depth of a stop line, of a give-way line and of the triangles, metres: German RMS-1 has 0.5 m for both lines, the Dutch
/// triangles are as deep.
const DEPTHS_M: [f32; 3] = [0.5, 0.5, 0.6];
/// Mark and gap of dashes and triangles along the line, metres.
const MARK_M: [f32; 2] = [0.5, 0.75];
/// A line reaches to this far from axis and edge, metres.
const SPARE_M: f32 = 0.15;
/// Lines are within this distance of the junction's node along the road, metres: half of a wide road met at an angle of 20
/// degrees.
const REACH_M: f32 = 30.0;

impl MouthLine {
    /// The lines of all mouths that `seed` draws, with the stroke that each is on.
    pub(crate) fn drawn(seed: u64, roads: &RoadNetwork, traffic: TrafficSide) -> Vec<(usize, Self)> {
        let mut lines = Vec::new();
        for junction in roads.junctions() {
            let first = goes_first(junction, roads);
            for met in junction.chains.iter().filter(|met| Some(met.chain) != first) {
                let own = (0..).zip(roads.strokes()).filter(|(_, stroke)| stroke.chain == met.chain);
                let own: Vec<(usize, &Stroke)> = own.collect();
                let by_distance = |a: &&(usize, &Stroke), b: &&(usize, &Stroke)| {
                    let m = |stroke: &Stroke| stroke.edge_distance_m(junction.p_in_map);
                    m(a.1).total_cmp(&m(b.1))
                };
                let Some((_, nearest)) = own.iter().min_by(by_distance) else { continue };
                let along_m = (junction.p_in_map - nearest.start).dot(&nearest.direction);
                let node_m = (nearest.along_m + along_m) as f32;
                for towards in [1.0, -1.0] {
                    let topic = (junction.id as u64).rotate_left(24) ^ (u64::from(met.chain) << 1);
                    let mut stream = Stream::new(seed ^ 0x4d4f_5554, topic ^ u64::from(towards > 0.0));
                    let Some(kind) = stream.choose(&KINDS).flatten() else { continue };
                    let setback_m = stream.between(SETBACKS_M[0], SETBACKS_M[1]) as f32;
                    let span_m = [setback_m, setback_m + DEPTHS_M[kind as usize]];
                    for (index, stroke) in &own {
                        if !stroke.two_way || !reaches(stroke, node_m, towards) {
                            continue;
                        }
                        let across_m = coming_side_m(stroke, towards, traffic);
                        lines.push((*index, Self { kind, node_m, towards, span_m, across_m }));
                    }
                }
            }
        }
        lines
    }

    /// Share of the depth and of the length of the line that is painted at a place: `along_m` from the chain's start, `left_m`
    /// left of its axis, `other_m` from the edge of the other road; `extents_m` of the pixel along and across the road.
    #[inline]
    pub(crate) fn covers(
        &self,
        [along_m, left_m, other_m]: [f32; 3],
        extents_m: [f32; 2],
        covered: impl Fn(f32, f32, f32) -> f32,
    ) -> f32 {
        let ahead_m = (self.node_m - along_m) * self.towards;
        let [from_m, to_m] = self.across_m;
        if !(0.0..REACH_M).contains(&ahead_m) || left_m < from_m || left_m > to_m {
            return 0.0;
        }
        let [near_m, far_m] = self.span_m;
        let depth_m = far_m - near_m;
        let deep = covered(other_m - 0.5 * (near_m + far_m), depth_m, extents_m[0]);
        if deep <= 0.0 || self.kind == MouthKind::Stop {
            return deep;
        }
        let [mark_m, period_m] = MARK_M;
        let in_period = (left_m - from_m).rem_euclid(period_m) - 0.5 * mark_m;
        let width_m = match self.kind {
            // A triangle is as wide as a mark at the junction's side and comes to a point on the other.
            MouthKind::Teeth => mark_m * (1.0 - ((other_m - near_m) / depth_m).clamp(0.0, 1.0)),
            MouthKind::Stop | MouthKind::GiveWay => mark_m,
        };
        deep * covered(in_period, width_m, extents_m[1])
    }
}

/// The chain of a junction that goes first: of those that run through the widest, else the widest.
fn goes_first(junction: &Junction, roads: &RoadNetwork) -> Option<u32> {
    let width_m = |met: &ChainAt| {
        let own = roads.strokes().iter().filter(|stroke| stroke.chain == met.chain);
        own.map(|stroke| stroke.half_width_m).fold(0.0, f64::max)
    };
    let widest = |a: &&ChainAt, b: &&ChainAt| {
        let runs_through = |met: &ChainAt| met.leaves.is_none();
        runs_through(a)
            .cmp(&runs_through(b))
            .then(width_m(a).total_cmp(&width_m(b)))
            .then(b.chain.cmp(&a.chain))
    };
    junction.chains.iter().max_by(widest).map(|met| met.chain)
}

/// Whether a stroke lies before a junction, as traffic comes to it, and near.
fn reaches(stroke: &Stroke, node_m: f32, towards: f32) -> bool {
    let ends_m = [stroke.along_m as f32, (stroke.along_m + stroke.length_m) as f32];
    let ahead_m = ends_m.map(|end_m| (node_m - end_m) * towards);
    ahead_m.iter().any(|m| *m > 0.0) && ahead_m.iter().any(|m| *m < REACH_M)
}

/// The part of the road on which traffic comes to a junction, metres to the left of the axis.
fn coming_side_m(stroke: &Stroke, towards: f32, traffic: TrafficSide) -> [f32; 2] {
    let reach_m = stroke.half_width_m as f32 - SPARE_M;
    let side = match traffic {
        TrafficSide::Left => towards,
        TrafficSide::Right => -towards,
        TrafficSide::Centre => return [-reach_m, reach_m],
    };
    if side > 0.0 { [SPARE_M, reach_m] } else { [-reach_m, -SPARE_M] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the middle of a small pixel is painted.
    fn inside(from_middle_m: f32, width_m: f32, _extent_m: f32) -> f32 {
        f32::from(u8::from(from_middle_m.abs() <= 0.5 * width_m))
    }

    fn line(kind: MouthKind) -> MouthLine {
        MouthLine { kind, node_m: 100.0, towards: 1.0, span_m: [1.0, 1.5], across_m: [-2.5, -0.25] }
    }

    #[test]
    fn a_stop_line_lies_before_the_other_road_on_the_side_of_who_comes() {
        let painted = |place: [f32; 3]| line(MouthKind::Stop).covers(place, [0.01; 2], inside) > 0.5;
        assert!(painted([95.0, -1.0, 1.2]));
        assert!(!painted([95.0, 1.0, 1.2]), "the side of who leaves");
        assert!(!painted([105.0, -1.0, 1.2]), "behind the junction");
        assert!(!painted([95.0, -1.0, 0.8]) && !painted([95.0, -1.0, 1.6]), "before and behind the line");
        assert!(!painted([60.0, -1.0, 1.2]), "another junction");
    }

    #[test]
    fn half_of_a_towns_mouths_are_painted_and_no_road_that_goes_first() {
        let town = fingerpost_map::OsmData::from_bytes(include_bytes!("../assets/town.osm")).unwrap();
        let graph = fingerpost_map::RoadGraph::from_osm(&town).unwrap();
        let (low, high) = (nalgebra::Point2::new(-2e3, -2e3), nalgebra::Point2::new(2e3, 2e3));
        let roads = RoadNetwork::new(&graph, graph.plane(), low, high);
        let lines = MouthLine::drawn(3, &roads, TrafficSide::Right);
        let of_junction = |junction: &Junction| {
            let first = goes_first(junction, &roads);
            let ways = junction.chains.iter().filter(|met| Some(met.chain) != first).map(|met| met.arms);
            ways.flatten().flatten().count()
        };
        let mouths: usize = roads.junctions().iter().map(of_junction).sum();
        let mut painted: Vec<_> = lines
            .iter()
            .map(|(stroke, line)| (roads.strokes()[*stroke].chain, line.node_m.to_bits(), line.towards > 0.0))
            .collect();
        painted.sort();
        painted.dedup();
        let share = painted.len() as f64 / mouths as f64;
        assert!((0.35..0.65).contains(&share), "{} of {mouths} mouths", painted.len());
        for kind in [MouthKind::Stop, MouthKind::GiveWay, MouthKind::Teeth] {
            assert!(lines.iter().any(|(_, line)| line.kind == kind), "{kind:?}");
        }
        assert!(lines.iter().all(|(stroke, _)| roads.strokes()[*stroke].two_way));
    }

    #[test]
    fn give_way_lines_have_gaps_and_teeth_come_to_a_point() {
        let share = |kind, other_m: f32| {
            let places = (0..200).map(|i| -2.5 + 0.01 * i as f32);
            places.map(|left_m| line(kind).covers([95.0, left_m, other_m], [0.01; 2], inside)).sum::<f32>()
                / 200.0
        };
        assert!((share(MouthKind::GiveWay, 1.2) - 0.67).abs() < 0.1);
        assert!(share(MouthKind::Teeth, 1.05) > 0.5 && share(MouthKind::Teeth, 1.45) < 0.15);
    }

    #[test]
    fn traffic_comes_on_its_own_side() {
        let stroke = Stroke {
            start: nalgebra::Point2::origin(),
            direction: nalgebra::Vector2::x(),
            length_m: 50.0,
            half_width_m: 3.0,
            along_m: 0.0,
            chain: 0,
            two_way: true,
            surface: crate::roads::Surface::Paved,
            paint: crate::street_paint::StreetPaint::USUAL,
        };
        assert!(coming_side_m(&stroke, 1.0, TrafficSide::Right)[1] < 0.0);
        assert!(coming_side_m(&stroke, -1.0, TrafficSide::Right)[0] > 0.0);
        assert!(coming_side_m(&stroke, 1.0, TrafficSide::Left)[0] > 0.0);
        assert!(reaches(&stroke, 45.0, 1.0) && reaches(&stroke, 45.0, -1.0) && !reaches(&stroke, 90.0, 1.0));
    }
}

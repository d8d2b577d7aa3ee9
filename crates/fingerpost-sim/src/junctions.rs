//! Where chains of strokes meet, and the ways out from there.

use std::collections::BTreeMap;

use nalgebra::{Point2, Vector2};

use crate::roads::Stroke;

/// A place where chains meet.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Junction {
    /// OSM's number of the node.
    pub(crate) id: i64,
    /// Where it is, map frame, metres.
    pub(crate) p_in_map: Point2<f64>,
    /// The chains that meet, two at least, none of them twice.
    pub(crate) chains: Vec<ChainAt>,
}

/// A chain at a junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ChainAt {
    /// Which chain.
    pub(crate) chain: u32,
    /// Unit vector along the chain away from the junction, where it ends there; none where it runs through.
    pub(crate) leaves: Option<Vector2<f64>>,
    /// Its arms there, in and against its direction.
    pub(crate) arms: [Option<Arm>; 2],
}

/// A way out of a junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arm {
    /// The stroke that gives it its direction, beyond the junction's own width.
    pub(crate) stroke: u32,
    /// Unit vector along that away from the junction.
    pub(crate) away: Vector2<f64>,
    /// How far from the node the road goes that way straight on, without another junction, metres.
    pub(crate) straight_m: f64,
}

/// A chain at a node, and the unit vector along it away from the node where it ends there.
pub(crate) type ChainEnd = (u32, Option<Vector2<f64>>);

impl Junction {
    /// The junctions among nodes, each with its number, its place and the chains that are there; `strokes` are sorted by chain.
    pub(crate) fn all(
        nodes: impl Iterator<Item = (i64, Point2<f64>, Vec<ChainEnd>)>,
        strokes: &[Stroke],
    ) -> Vec<Self> {
        let mut junctions: Vec<Self> = nodes
            .filter(|(_, _, chains)| chains.len() >= 2)
            .map(|(id, p_in_map, chains)| {
                let at = |(chain, leaves)| ChainAt { chain, leaves, arms: arms_at(strokes, chain, p_in_map) };
                Self { id, p_in_map, chains: chains.into_iter().map(at).collect() }
            })
            .collect();
        end_arms_at_the_next_junction(&mut junctions);
        junctions
    }
}

impl ChainAt {
    /// The arm on whose side of the junction's node an offset from it is.
    pub(crate) fn arm_towards(&self, offset: Vector2<f64>) -> Option<Arm> {
        let along = |arm: &Arm| arm.away.dot(&offset);
        self.arms.into_iter().flatten().max_by(|a, b| along(a).total_cmp(&along(b)))
    }
}

/// An arm's direction is that of its road so far from the node, metres.
const ARM_M: f64 = 6.0;
/// A road goes straight on as long as its axis is within this distance of a line, metres.
const STRAIGHT_WITHIN_M: f64 = 0.5;

/// The arms of a chain at a place on it.
fn arms_at(strokes: &[Stroke], chain: u32, p_in_map: Point2<f64>) -> [Option<Arm>; 2] {
    let first = strokes.partition_point(|stroke| stroke.chain < chain);
    let own = &strokes[first..strokes.partition_point(|stroke| stroke.chain <= chain)];
    let distance_m = |stroke: &&Stroke| stroke.edge_distance_m(p_in_map) + stroke.half_width_m;
    let Some(nearest) = own.iter().min_by(|a, b| distance_m(a).total_cmp(&distance_m(b))) else {
        return [None; 2];
    };
    let node_m = nearest.along_m + (p_in_map - nearest.start).dot(&nearest.direction);
    [1.0, -1.0].map(|sign| {
        let wanted_m = node_m + sign * ARM_M;
        let index = own.partition_point(|stroke| stroke.along_m <= wanted_m).saturating_sub(1);
        let stroke = own.get(index)?;
        let out_m = |along_m: f64| (along_m - node_m) * sign;
        let ends = |stroke: &Stroke| {
            let end = stroke.start + stroke.direction * stroke.length_m;
            [(out_m(stroke.along_m), stroke.start), (out_m(stroke.along_m + stroke.length_m), end)]
        };
        if ends(stroke).iter().all(|(end_m, _)| *end_m <= 0.5) {
            return None;
        }
        let mut kinks: Vec<(f64, Point2<f64>)> =
            own.iter().flat_map(ends).filter(|(m, _)| *m > 0.0).collect();
        kinks.push((0.0, p_in_map));
        kinks.sort_by(|a, b| a.0.total_cmp(&b.0));
        let beside_m = |p: Point2<f64>| stroke.direction.perp(&(p - stroke.start)).abs();
        let straight = kinks.iter().take_while(|(_, p)| beside_m(*p) <= STRAIGHT_WITHIN_M);
        let straight_m = straight.last().map_or(0.0, |(m, _)| *m);
        Some(Arm { stroke: (first + index) as u32, away: stroke.direction * sign, straight_m })
    })
}

/// No arm is longer than to the next junction of its chain.
fn end_arms_at_the_next_junction(junctions: &mut [Junction]) {
    let mut of_chain: BTreeMap<u32, Vec<Point2<f64>>> = BTreeMap::new();
    for junction in junctions.iter() {
        for met in &junction.chains {
            of_chain.entry(met.chain).or_default().push(junction.p_in_map);
        }
    }
    for junction in junctions {
        for met in &mut junction.chains {
            let others = of_chain.get(&met.chain).map_or(&[][..], Vec::as_slice);
            for arm in met.arms.iter_mut().flatten() {
                let ahead_m = others.iter().map(|p| arm.away.dot(&(p - junction.p_in_map)));
                let next_m = ahead_m.filter(|m| *m > 0.5).fold(f64::INFINITY, f64::min);
                arm.straight_m = arm.straight_m.min(next_m);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roads::Surface;
    use crate::street_paint::StreetPaint;

    /// The strokes of a chain along these places.
    fn chain(number: u32, places: &[(f64, f64)]) -> Vec<Stroke> {
        let mut along_m = 0.0;
        let strokes = places.windows(2).map(|pair| {
            let [start, end] = [pair[0], pair[1]].map(|(x, y)| Point2::new(x, y));
            let length_m = (end - start).norm();
            let stroke = Stroke {
                start,
                direction: (end - start) / length_m,
                length_m,
                half_width_m: 3.0,
                along_m,
                chain: number,
                two_way: true,
                surface: Surface::Paved,
                paint: StreetPaint::USUAL,
            };
            along_m += length_m;
            stroke
        });
        strokes.collect()
    }

    /// A street to the east, from whose middle a lane goes south, bends after 10 m and joins another street.
    fn junctions() -> Vec<Junction> {
        let mut strokes = chain(0, &[(0.0, 0.0), (60.0, 0.0), (90.0, 0.0), (90.0, 40.0)]);
        strokes.extend(chain(1, &[(60.0, 0.0), (60.0, -10.0), (75.0, -25.0)]));
        strokes.extend(chain(2, &[(75.0, -40.0), (75.0, 0.0)]));
        let south = Some(Vector2::new(0.0, -1.0));
        let back = Some(Vector2::new(-1.0, 1.0).normalize());
        let nodes = [
            (7, Point2::new(60.0, 0.0), vec![(0, None), (1, south)]),
            (8, Point2::new(60.0, -10.0), vec![(1, None)]),
            (9, Point2::new(75.0, -25.0), vec![(1, back), (2, None)]),
            (10, Point2::new(75.0, 0.0), vec![(0, None), (2, Some(Vector2::new(0.0, -1.0)))]),
        ];
        Junction::all(nodes.into_iter(), &strokes)
    }

    #[test]
    fn a_place_with_one_chain_is_no_junction() {
        assert_eq!(junctions().iter().map(|junction| junction.id).collect::<Vec<_>>(), [7, 9, 10]);
    }

    #[test]
    fn arms_lead_away_and_end_at_bends_and_at_the_next_junction() {
        let junction = &junctions()[0];
        let arm =
            |chain: usize, x: f64, y: f64| junction.chains[chain].arm_towards(Vector2::new(x, y)).unwrap();
        let [west, east, south] = [arm(0, -5.0, 1.0), arm(0, 5.0, 1.0), arm(1, 0.0, -5.0)];
        assert!((west.away - Vector2::new(-1.0, 0.0)).norm() < 1e-9 && (west.straight_m - 60.0).abs() < 1e-9);
        assert!((east.away - Vector2::new(1.0, 0.0)).norm() < 1e-9);
        assert!((east.straight_m - 15.0).abs() < 1e-9, "to the next junction: {} m", east.straight_m);
        assert!((south.away - Vector2::new(0.0, -1.0)).norm() < 1e-9);
        assert!((south.straight_m - 10.0).abs() < 1e-9, "to its bend: {} m", south.straight_m);
        assert_eq!(junction.chains[1].arms.iter().flatten().count(), 1, "it ends here");
    }
}

//! What lines a street of a town: house fronts, walls, fences and hedges close to it, avenues of trees, bins, bollards, signs, people.
//!
//! Everything follows from the seed, the road (its chain of strokes), the side and the distance along it.

use nalgebra::Point2;

use crate::conditions::Streetscape;
use crate::noise::{Stream, mix};
use crate::object::{Object, Part, Shape};
use crate::relief::Relief;
use crate::roads::{RoadNetwork, Stroke};
use crate::roadside::beside;

/// Length of a roadside that is lined by one kind, metres.
const STRETCH_M: f64 = 36.0;
/// Kinds by their share: real streets are mostly lined by houses, and by hedges and fences where these stand back.
const KINDS: [(f64, Kind); 4] =
    [(0.45, Kind::Houses), (0.2, Kind::Wall), (0.15, Kind::Fence), (0.2, Kind::Hedge)];
/// Distance from the road's edge at which they begin, metres: from a narrow pavement's width to a front garden's.
const ASIDE_M: [f64; 2] = [1.6, 6.5];
/// Nothing stands nearer to any other road, metres.
const CLEAR_M: f64 = 1.3;
/// Widths of house fronts, their depth, heights of their eaves and of the roof on these, metres.
const FRONTS_M: [f64; 2] = [5.0, 13.0];
const DEPTH_M: f64 = 8.0;
const EAVES_M: [f64; 2] = [3.0, 14.0];
const ROOFS_M: [f64; 2] = [0.3, 3.5];
/// Share of the plots that are gaps.
const GAPS: f64 = 0.1;
/// Length of a piece of wall, fence or hedge; half thicknesses and heights of each, metres.
const PIECE_M: f64 = 4.0;
const WALL_M: (f64, [f64; 2]) = (0.12, [0.5, 3.0]);
const FENCE_M: (f64, [f64; 2]) = (0.03, [0.8, 2.0]);
const HEDGE_M: (f64, [f64; 2]) = (0.4, [0.6, 2.4]);
/// An avenue's trees: distance from the road's edge, radius of the trunk, half of a crown's width and height, and free height below
/// it, metres. Over a road 4.5 m are kept free.
const TREE_ASIDE_M: [f64; 2] = [0.6, 1.5];
const TRUNK_M: [f64; 2] = [0.1, 0.3];
const CROWN_M: [[f64; 2]; 2] = [[1.8, 4.5], [1.4, 3.2]];
const FREE_M: [f64; 2] = [3.2, 4.5];
/// Distance of furniture from the road's edge, metres.
const FURNITURE_ASIDE_M: [f64; 2] = [0.3, 1.6];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Houses,
    Wall,
    Fence,
    Hedge,
}

/// All that lines the roads where `wanted` says so.
pub(crate) fn standing(
    seed: u64,
    streetscape: &Streetscape,
    roads: &RoadNetwork,
    relief: &Relief,
    wanted: impl Fn(Point2<f64>) -> bool,
) -> Vec<Object> {
    let mut builder = Builder { roads, relief, objects: Vec::new() };
    for chain in roads.strokes().chunk_by(|a, b| a.chain == b.chain) {
        let (Some(first), Some(last)) = (chain.first(), chain.last()) else { continue };
        let span_m = [first.along_m, last.along_m + last.length_m];
        for side in [-1.0, 1.0] {
            let topic = mix(u64::from(first.chain) << 1 | u64::from(side > 0.0));
            let stream = |kind: u64| Stream::new(seed ^ mix(kind), topic);
            let road = Roadside { chain, side, span_m, wanted: &wanted };
            builder.fronts(&road, stream(0x4652), streetscape.frontage);
            builder.avenue(&road, stream(0x4156), streetscape.avenue_per_100_m);
            builder.furniture(&road, stream(0x4655), streetscape.furniture_per_100_m);
        }
    }
    builder.objects
}

/// One side of a road.
struct Roadside<'a> {
    chain: &'a [Stroke],
    side: f64,
    /// Distances along the chain, metres.
    span_m: [f64; 2],
    wanted: &'a dyn Fn(Point2<f64>) -> bool,
}

impl Roadside<'_> {
    /// The place so far along the road and beside its edge, metres.
    fn place(&self, along_m: f64, aside_m: f64) -> Option<Point2<f64>> {
        beside(self.chain, along_m, (self.side * aside_m) as f32)
    }
}

struct Builder<'a> {
    roads: &'a RoadNetwork,
    relief: &'a Relief,
    objects: Vec<Object>,
}

impl Builder<'_> {
    fn fronts(&mut self, road: &Roadside<'_>, mut stream: Stream, share: f64) {
        let [mut from_m, to_m] = road.span_m;
        while share > 0.0 && from_m < to_m {
            let end_m = (from_m + STRETCH_M).min(to_m);
            let kind = stream.choose(&KINDS).unwrap_or(Kind::Hedge);
            let aside_m = stream.between(ASIDE_M[0], ASIDE_M[1]);
            let number = (stream.unit() * 1e9) as u64;
            if stream.unit() < share {
                let plots = Stream::new(number, 0x504c);
                self.line(road, [from_m, end_m], kind, aside_m, plots);
            }
            from_m = end_m;
        }
    }

    /// One kind from one distance along the road to another, metres.
    fn line(
        &mut self,
        road: &Roadside<'_>,
        [mut at_m, end_m]: [f64; 2],
        kind: Kind,
        aside_m: f64,
        mut stream: Stream,
    ) {
        let own = (stream.unit() * 1e9) as u64;
        let height = stream.unit();
        while at_m < end_m {
            let length_m =
                if kind == Kind::Houses { stream.between(FRONTS_M[0], FRONTS_M[1]) } else { PIECE_M };
            let plot = [at_m, (at_m + length_m).min(end_m)];
            at_m += length_m;
            let is_gap = stream.unit() < GAPS;
            let [eaves, roof, hash] = [stream.unit(), stream.unit(), stream.unit()];
            let within = |[low, high]: [f64; 2], share: f64| low + (high - low) * share;
            let beam = |(half_m, heights_m): (f64, [f64; 2]), part| Front {
                half_depth_m: half_m,
                height_m: [within(heights_m, height); 2],
                part,
                hash: own,
            };
            let front = match kind {
                Kind::Houses => Front {
                    half_depth_m: 0.5 * DEPTH_M,
                    // Neighbours are about as high.
                    height_m: [within(EAVES_M, 0.7 * height + 0.3 * eaves), within(ROOFS_M, roof)],
                    part: Part::Wall,
                    hash: (hash * 1e9) as u64,
                },
                Kind::Wall => beam(WALL_M, Part::Masonry),
                Kind::Fence => beam(FENCE_M, Part::Fence),
                Kind::Hedge => beam(HEDGE_M, Part::Crown),
            };
            if !is_gap {
                self.front(road, plot, aside_m, &front);
            }
        }
    }

    /// Builds a front along a plot.
    fn front(&mut self, road: &Roadside<'_>, [from_m, to_m]: [f64; 2], aside_m: f64, front: &Front) {
        let middle_m = aside_m + front.half_depth_m;
        let ends = [from_m, to_m].map(|at_m| road.place(at_m, middle_m));
        let [Some(start), Some(end)] = ends else { return };
        let (middle, ahead) = (nalgebra::center(&start, &end), end - start);
        let reach_m = front.half_depth_m + CLEAR_M;
        let is_clear = |p: Point2<f64>| self.roads.within(p, reach_m).is_empty();
        if ahead.norm() < 1.0 || !(road.wanted)(middle) || ![start, middle, end].into_iter().all(is_clear) {
            return;
        }
        let direction = [ahead.x / ahead.norm(), ahead.y / ahead.norm()].map(|x| x as f32);
        let half_m = [0.5 * ahead.norm(), front.half_depth_m].map(|x| x as f32);
        let [low, more] = front.height_m.map(|x| x as f32);
        let shape = match front.part {
            Part::Wall => Shape::House { ridge: direction, half_m, height_m: [low, low + more] },
            part => Shape::Beam { direction, half_m, height_m: [0.0, low], part },
        };
        self.stand(middle, shape, mix(front.hash));
    }

    fn avenue(&mut self, road: &Roadside<'_>, mut stream: Stream, per_100_m: f64) {
        if per_100_m <= 0.0 {
            return;
        }
        let every_m = 100.0 / per_100_m;
        let aside_m = stream.between(TREE_ASIDE_M[0], TREE_ASIDE_M[1]);
        let size = stream.unit();
        let mut at_m = road.span_m[0] + every_m * stream.unit();
        while at_m < road.span_m[1] {
            // Trees of an avenue were planted together.
            let mut near = |[low, high]: [f64; 2]| low + (high - low) * (0.7 * size + 0.3 * stream.unit());
            let crown_m = CROWN_M.map(&mut near).map(|x| x as f32);
            let (trunk_m, free_m) = (near(TRUNK_M) as f32, near(FREE_M) as f32);
            let shape = Shape::Tree { trunk_m, crown_m, middle_m: free_m + crown_m[1] };
            let hash = mix((stream.unit() * 1e9) as u64);
            let place = road.place(at_m, aside_m).filter(|place| (road.wanted)(*place));
            if let Some(place) = place.filter(|place| self.roads.within(*place, 0.5).is_empty()) {
                self.stand(place, shape, hash);
            }
            at_m += every_m * stream.between(0.8, 1.2);
        }
    }

    fn furniture(&mut self, road: &Roadside<'_>, mut stream: Stream, per_100_m: f64) {
        if per_100_m <= 0.0 {
            return;
        }
        let every_m = 100.0 / per_100_m;
        let mut at_m = road.span_m[0] + every_m * stream.unit();
        while at_m < road.span_m[1] {
            let aside_m = stream.between(FURNITURE_ASIDE_M[0], FURNITURE_ASIDE_M[1]);
            let turned = stream.between(0.0, std::f64::consts::PI);
            let pieces =
                stream.choose(&[(1.0, BOLLARD), (1.0, BIN), (0.7, SIGN), (1.3, PERSON)]).unwrap_or(BIN);
            let size = stream.between(0.85, 1.15) as f32;
            let hash = mix((stream.unit() * 1e9) as u64);
            let place = road.place(at_m, aside_m).filter(|place| (road.wanted)(*place));
            if let Some(place) = place.filter(|place| self.roads.within(*place, 0.2).is_empty()) {
                let (sin, cos) = libm::sincos(turned);
                for (half_m, height_m, part) in pieces.iter().copied() {
                    let shape = Shape::Beam {
                        direction: [cos as f32, sin as f32],
                        half_m,
                        height_m: height_m.map(|x| x * size),
                        part,
                    };
                    self.stand(place, shape, hash);
                }
            }
            at_m += every_m * stream.between(0.4, 1.6);
        }
    }

    fn stand(&mut self, place: Point2<f64>, shape: Shape, hash: u64) {
        let foot = [place.x as f32, place.y as f32, self.relief.height_m(place) as f32];
        self.objects.push(Object { foot, shape, hash });
    }
}

/// What stands on a plot.
struct Front {
    half_depth_m: f64,
    /// Of the eaves and of the roof on them; of a beam the first.
    height_m: [f64; 2],
    part: Part,
    hash: u64,
}

/// Half sizes over ground, lower and upper end, metres, and what it is of.
type Piece = ([f32; 2], [f32; 2], Part);

const BOLLARD: &[Piece] = &[([0.07, 0.07], [0.0, 0.9], Part::Metal)];
const BIN: &[Piece] = &[([0.3, 0.28], [0.0, 1.05], Part::Painted)];
const SIGN: &[Piece] = &[([0.03, 0.03], [0.0, 2.3], Part::Metal), ([0.32, 0.02], [2.0, 2.6], Part::Painted)];
const PERSON: &[Piece] = &[([0.24, 0.15], [0.0, 1.72], Part::Person)];

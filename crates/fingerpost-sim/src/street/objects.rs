//! Walls and hedges behind pavements.

use nalgebra::Point2;

use super::Street;
use super::side::STRETCH_M;
use crate::noise::{floor_int, mix};
use crate::object::{Object, Part, Shape};
use crate::relief::Relief;
use crate::roads::{RoadNetwork, Stroke};
use crate::roadside::beside;

/// Length of a piece of wall or hedge, metres: so much of a bend is straight.
const PIECE_M: f64 = 4.0;
/// Distance from the road's edge, metres: behind the widest pavement with a bay before it.
const ASIDE_M: f32 = 5.6;
/// Heights and half thicknesses of walls and of hedges, metres.
const WALL_HEIGHTS_M: [f32; 2] = [0.6, 2.0];
const HEDGE_HEIGHTS_M: [f32; 2] = [0.8, 2.2];
const WALL_HALF_M: f32 = 0.12;
const HEDGE_HALF_M: f32 = 0.4;
/// Share of pieces that are gates: nothing stands there.
const GATES: f32 = 0.12;

/// Walls and hedges along the roads where `wanted` says so; `share` of the stretches have one or the other.
pub(crate) fn standing(
    street: &Street,
    share: f32,
    roads: &RoadNetwork,
    relief: &Relief,
    wanted: impl Fn(Point2<f64>) -> bool,
) -> Vec<Object> {
    let mut objects = Vec::new();
    for chain in roads.strokes().chunk_by(|a, b| a.chain == b.chain) {
        let (Some(first), Some(last)) = (chain.first(), chain.last()) else { continue };
        let (from_m, to_m) = (first.along_m, last.along_m + last.length_m);
        let pieces = ((to_m - from_m) / PIECE_M) as usize;
        for side in [-1.0_f32, 1.0] {
            for along_m in (0..pieces).map(|i| from_m + i as f64 * PIECE_M) {
                let piece = Piece { along_m, side, share };
                let Some(object) = street.piece(piece, chain, relief) else { continue };
                let place = Point2::new(f64::from(object.foot[0]), f64::from(object.foot[1]));
                if wanted(place) && roads.within(place, f64::from(ASIDE_M) - 1.0).is_empty() {
                    objects.push(object);
                }
            }
        }
    }
    objects
}

/// A piece of roadside in which a wall or hedge may stand.
#[derive(Debug, Clone, Copy)]
struct Piece {
    along_m: f64,
    side: f32,
    share: f32,
}

impl Street {
    fn piece(&self, piece: Piece, chain: &[Stroke], relief: &Relief) -> Option<Object> {
        let Piece { along_m, side, share } = piece;
        let number = chain.first()?.chain;
        let topic = if side > 0.0 { 0x574C } else { 0x5752 };
        let stretch = floor_int(along_m as f32 / STRETCH_M);
        let draw = |i: u64| self.draw(topic ^ (i << 16), number, stretch);
        let gate = self.draw(topic ^ 0xFF_0000, number, (along_m / PIECE_M) as i32) < GATES;
        if gate || draw(1) >= share {
            return None;
        }
        let ends = [along_m, along_m + PIECE_M].map(|at_m| beside(chain, at_m, side * ASIDE_M));
        let [Some(start), Some(end)] = ends else { return None };
        let (middle, ahead) = (nalgebra::center(&start, &end), end - start);
        if ahead.norm() < 0.5 * PIECE_M {
            return None;
        }
        let is_hedge = draw(2) < 0.5;
        let [low, high] = if is_hedge { HEDGE_HEIGHTS_M } else { WALL_HEIGHTS_M };
        let half_thickness_m = if is_hedge { HEDGE_HALF_M } else { WALL_HALF_M };
        let shape = Shape::Beam {
            direction: [(ahead.x / ahead.norm()) as f32, (ahead.y / ahead.norm()) as f32],
            half_m: [0.5 * ahead.norm() as f32, half_thickness_m],
            height_m: [0.0, low + (high - low) * draw(3)],
            part: if is_hedge { Part::Crown } else { Part::Masonry },
        };
        let foot = [middle.x as f32, middle.y as f32, relief.height_m(middle) as f32];
        Some(Object { foot, shape, hash: mix(self.seed ^ u64::from(number) ^ (stretch as u64) << 32) })
    }
}

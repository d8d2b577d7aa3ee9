//! Islands in the middle of wide roads.

use super::Street;
use crate::ground::GroundPoint;
use crate::noise::floor_int;
use crate::surface::LocalPlace;

/// Half of the width of a road that has islands, at the least, metres: a lorry passes on either side.
const LEAST_HALF_WIDTH_M: f32 = 4.2;
/// A road has at most one island in so many metres, and has it in so many of them.
const EVERY_M: f32 = 60.0;
const ISLANDS: f32 = 0.5;
/// Half lengths and half widths of islands, metres.
const HALF_LENGTHS_M: [f32; 2] = [3.0, 8.0];
const HALF_WIDTHS_M: [f32; 2] = [0.45, 0.8];
/// Islands keep so far from the edges of other roads, metres.
const FROM_OTHERS_M: f32 = 9.0;

impl Street {
    /// The ground at a place where an island's edge is nearer than the road's: on it and in the half of the road about it.
    pub(super) fn island(&self, ground: &GroundPoint, place: &LocalPlace) -> Option<GroundPoint> {
        if place.half_width_m < LEAST_HALF_WIDTH_M || ground.other_m < FROM_OTHERS_M {
            return None;
        }
        let number = floor_int(place.along_m / EVERY_M);
        let draw = |topic: u64| self.draw(0x4953_0000 | topic, place.chain, number);
        if draw(0) >= ISLANDS {
            return None;
        }
        let between = |topic: u64, [low, high]: [f32; 2]| low + (high - low) * draw(topic);
        let (half_length_m, half_width_m) = (between(1, HALF_LENGTHS_M), between(2, HALF_WIDTHS_M));
        let along_m = place.along_m - EVERY_M * (number as f32 + 0.5);
        // A strip with round ends: the distance from its axis.
        let beyond_m = along_m - along_m.clamp(half_width_m - half_length_m, half_length_m - half_width_m);
        let from_axis_m = (beyond_m * beyond_m + place.left_m * place.left_m).sqrt();
        let edge_m = half_width_m - from_axis_m;
        if edge_m < ground.edge_m {
            return None;
        }
        // Away from the axis the distance to the road grows smaller.
        let (lengthwise, sideways) =
            (-beyond_m / from_axis_m.max(1e-3), -place.left_m / from_axis_m.max(1e-3));
        let [x, y] = place.direction;
        let edge_slope = [lengthwise * x - sideways * y, lengthwise * y + sideways * x];
        Some(GroundPoint { edge_m, edge_slope, ..*ground })
    }
}

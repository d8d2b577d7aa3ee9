//! What is beside a road at a place: kerb, driveway, crossing, parking bay.

use super::Street;
use crate::ground::GroundPoint;
use crate::noise::floor_int;
use crate::surface::LocalPlace;

/// Length of a roadside of one kind, metres, and the length over which one kind goes over into the next.
pub(super) const STRETCH_M: f32 = 40.0;
const CHANGES_M: f32 = 1.5;
/// Depth of a parking bay, the length at either end of its stretch that has none, and the length of its slanted ends, metres.
const BAY_M: f32 = 2.1;
const BAY_FROM_END_M: f32 = 6.0;
const BAY_SLANT_M: f32 = 1.5;
/// Widths of pavements, metres.
const PAVEMENTS_M: [f32; 2] = [1.5, 3.0];
/// A stretch of roadside has at most one driveway in so many metres, and has it in so many of them.
const DRIVEWAY_EVERY_M: f32 = 18.0;
const DRIVEWAYS: f32 = 0.4;
/// Half lengths of lowered kerbs at driveways, and the length of the ramps beside them, metres.
const DRIVEWAY_HALF_M: [f32; 2] = [1.4, 2.3];
const RAMP_M: f32 = 0.8;
/// Height of a lowered kerb, metres.
const LOWERED_M: f32 = 0.025;
/// Where people cross, as distances from the edge of the road that is joined, metres; beyond the corner's arc at the least.
const CROSSING_M: [f32; 2] = [4.5, 7.0];
/// Near another road a roadside is kerbed without bays and driveways: up to the first distance from its edge wholly, from the second on
/// not at all, metres.
const CORNER_M: [f32; 2] = [8.0, 11.0];

/// A place beside a road.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    /// Whether there is a kerb at all, from 0 to 1 where one begins.
    pub(super) kerbed: f32,
    /// Share of its full height that the kerb has.
    pub(super) raised: f32,
    /// What it has besides, where it is lowered, metres.
    pub(super) lowered_to_m: f32,
    /// Depth of the parking bay before the kerb, metres.
    pub(super) bay_m: f32,
    /// Width of the pavement behind it, metres.
    pub(super) pavement_m: f32,
}

impl Side {
    /// The roadside on the side of the axis where the place is; `crossed`, 0 to 1, says how much people cross in this quarter.
    pub(super) fn of(street: &Street, ground: &GroundPoint, place: &LocalPlace, crossed: f32) -> Self {
        let [from_m, to_m] = CORNER_M;
        let at_corner = ((to_m - ground.other_m) / (to_m - from_m)).clamp(0.0, 1.0);
        let topic = if place.left_m > 0.0 { 0x4C00 } else { 0x5200 };
        let kerbed = street.kerbed(topic, place).max(at_corner);
        let driveway = street.driveway(topic, place) * (1.0 - at_corner);
        let lowered = driveway.max(crossing(ground.other_m, crossed)) * kerbed;
        let width = street.draw(topic | 1, place.chain, 0);
        Self {
            kerbed,
            raised: kerbed * (1.0 - lowered),
            lowered_to_m: LOWERED_M * lowered,
            bay_m: street.bay_m(topic, place) * (1.0 - at_corner),
            pavement_m: PAVEMENTS_M[0] + (PAVEMENTS_M[1] - PAVEMENTS_M[0]) * width,
        }
    }
}

impl Street {
    fn has_kerb(&self, topic: u64, chain: u32, number: i32) -> bool {
        self.draw(topic | 2, chain, number) < self.kerbs
    }

    /// Whether a roadside has a kerb: 0 or 1, and between them where one kind goes over into the other.
    fn kerbed(&self, topic: u64, place: &LocalPlace) -> f32 {
        let number = floor_int(place.along_m / STRETCH_M);
        let in_stretch_m = place.along_m - STRETCH_M * number as f32;
        let kind = |number: i32| if self.has_kerb(topic, place.chain, number) { 1.0 } else { 0.0 };
        let here = kind(number);
        // Half of a change lies in either stretch.
        let (other, from_end_m) = if in_stretch_m < 0.5 * STRETCH_M {
            (kind(number - 1), in_stretch_m)
        } else {
            (kind(number + 1), STRETCH_M - in_stretch_m)
        };
        let share = (0.5 + from_end_m / CHANGES_M).min(1.0);
        other + (here - other) * share
    }

    /// How much a kerb is lowered for a driveway, 0 to 1.
    fn driveway(&self, topic: u64, place: &LocalPlace) -> f32 {
        let number = floor_int(place.along_m / DRIVEWAY_EVERY_M);
        if self.draw(topic | 3, place.chain, number) >= DRIVEWAYS {
            return 0.0;
        }
        let [least, most] = DRIVEWAY_HALF_M;
        let half_m = least + (most - least) * self.draw(topic | 4, place.chain, number);
        let from_middle_m = place.along_m - DRIVEWAY_EVERY_M * (number as f32 + 0.5);
        ((half_m + RAMP_M - from_middle_m.abs()) / RAMP_M).clamp(0.0, 1.0)
    }

    /// Depth of a parking bay, metres.
    fn bay_m(&self, topic: u64, place: &LocalPlace) -> f32 {
        let number = floor_int(place.along_m / STRETCH_M);
        let has_bay = self.has_kerb(topic, place.chain, number)
            && self.draw(topic | 5, place.chain, number) < self.bays;
        if !has_bay {
            return 0.0;
        }
        let in_stretch_m = place.along_m - STRETCH_M * number as f32;
        let from_end_m = in_stretch_m.min(STRETCH_M - in_stretch_m) - BAY_FROM_END_M;
        BAY_M * (from_end_m / BAY_SLANT_M).clamp(0.0, 1.0)
    }
}

/// How much a kerb is lowered where people cross, so far from the edge of another road, metres.
fn crossing(other_m: f32, crossed: f32) -> f32 {
    let inside_m = (other_m - CROSSING_M[0]).min(CROSSING_M[1] - other_m);
    (inside_m / RAMP_M).clamp(0.0, 1.0) * (6.0 * (crossed - 0.4)).clamp(0.0, 1.0)
}

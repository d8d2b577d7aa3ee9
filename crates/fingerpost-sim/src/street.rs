//! Kerbed streets: how high the ground lies beside and on the road, and what of it is pavement, parking bay or island.
//!
//! A road has a fall of its own, to both sides from a crown or to one. Beside it stretches with kerb and pavement take turns with ones that
//! have none; kerbs are 6 to 16 cm high, are lowered at driveways and where people cross, and stand back behind parking bays. Wide roads
//! have islands in their middle. Everything follows from the seed, the road (its chain of strokes) and the distance along it, and is
//! continuous but for the kerb's face: near another road the two roads' own falls, bays and gaps fade out, so that a corner has one kerb.

mod islands;
mod objects;
mod side;

pub(crate) use self::objects::standing;
use self::side::Side;
use crate::conditions::Conditions;
use crate::ground::GroundPoint;
use crate::noise::{mix, unit, value_noise};
use crate::surface::LocalPlace;

/// Heights of kerbs, metres: from worn to what buses need.
const KERB_HEIGHTS_M: [f32; 2] = [0.06, 0.16];
/// Length over which a kerb's height changes, metres.
const KERB_WAVE_M: f32 = 40.0;
/// A kerb's face leans back by so much, metres.
const FACE_M: f32 = 0.02;
/// Pavements fall towards the road by so much a metre.
const PAVEMENT_FALL: f32 = 0.02;
/// Least fall of a road, as a share of the largest.
const LEAST_FALL_SHARE: f32 = 0.33;
/// A road's fall fades out over so many metres before another road, so that both are level where they meet.
const FALL_FADES_M: f32 = 8.0;
/// Highest and lowest that a street's ground lies against the waves that it follows, metres.
pub(crate) const HIGHEST_M: f32 = 0.25;
pub(crate) const LOWEST_M: f32 = -0.20;

/// The seed's streets.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Street {
    seed: u64,
    /// Share of the roadsides with a kerb.
    kerbs: f32,
    /// Share of those with parking bays.
    bays: f32,
    /// Largest fall across a road.
    fall: f32,
    /// How much the pavement is of the road's own tone, share.
    pub(crate) alike: f32,
    /// Brightness of the pavement against the road where it is of its tone.
    pub(crate) shade: f32,
}

/// A place of a street.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StreetPoint {
    /// The ground there; its edge is the nearer of the road's and an island's.
    pub(crate) ground: GroundPoint,
    /// How far behind the kerb's face it is, metres; negative before it.
    pub(crate) behind_kerb_m: f32,
    /// Height of the kerb, metres; 0 where there is none.
    pub(crate) kerb_m: f32,
    /// Width of the pavement behind it, metres.
    pub(crate) pavement_m: f32,
    /// Height above the ground's waves, metres.
    pub(crate) height_m: f32,
}

impl Street {
    /// None where no roadside has a kerb.
    pub(crate) fn new(seed: u64, conditions: &Conditions) -> Option<Self> {
        // As bright as the road, give or take what nobody could tell by.
        let shade = 0.94 + 0.12 * unit(mix(seed ^ mix(0x5348_4144)));
        (conditions.kerbs > 0.0).then_some(Self {
            seed,
            kerbs: conditions.kerbs as f32,
            bays: conditions.parking_bays as f32,
            fall: conditions.cross_fall as f32,
            alike: conditions.pavements_like_road as f32,
            shade,
        })
    }

    /// A number of a road's own, of its side's own or of a stretch's.
    fn draw(&self, topic: u64, chain: u32, number: i32) -> f32 {
        unit(mix(self.seed ^ mix(topic ^ mix((u64::from(chain) << 32) | u64::from(number as u32)))))
    }

    /// The street at a place (map frame) that is on or beside a road.
    pub(crate) fn at(&self, [x, y]: [f32; 2], ground: &GroundPoint, place: &LocalPlace) -> StreetPoint {
        let fallen_m = self.fallen_m(ground, place);
        let wave = |i: u64| value_noise(self.seed ^ i, x / KERB_WAVE_M, y / KERB_WAVE_M);
        // Noise keeps to the middle of its range; this makes low and high ones as frequent.
        let share = (1.8 * (wave(0x4B45) - 0.5) + 0.5).clamp(0.0, 1.0);
        let full_m = KERB_HEIGHTS_M[0] + (KERB_HEIGHTS_M[1] - KERB_HEIGHTS_M[0]) * share;
        if let Some(island) = self.island(ground, place) {
            let raised_m = full_m * (island.edge_m / FACE_M).clamp(0.0, 1.0);
            return StreetPoint {
                ground: island,
                behind_kerb_m: island.edge_m,
                kerb_m: full_m,
                pavement_m: f32::INFINITY,
                height_m: fallen_m + raised_m,
            };
        }
        let side = Side::of(self, ground, place, wave(0x4352));
        let behind_kerb_m = ground.edge_m - side.bay_m;
        let kerb_m = full_m * side.raised + side.lowered_to_m;
        let face = (behind_kerb_m / FACE_M).clamp(0.0, 1.0);
        let rise_m = PAVEMENT_FALL * behind_kerb_m.clamp(0.0, side.pavement_m);
        StreetPoint {
            ground: *ground,
            behind_kerb_m,
            kerb_m,
            pavement_m: side.pavement_m,
            height_m: fallen_m + (kerb_m + rise_m * side.kerbed) * face,
        }
    }

    /// The ground at a place, with an island's edge where that is nearer than the road's.
    pub(crate) fn ground(&self, ground: &GroundPoint, place: &LocalPlace) -> GroundPoint {
        self.island(ground, place).unwrap_or(*ground)
    }

    /// Height above the ground's waves, metres: that of [`Self::at`], for less where the place is on the road.
    pub(crate) fn height_m(&self, p: [f32; 2], ground: &GroundPoint, place: &LocalPlace) -> f32 {
        if ground.edge_m <= 0.0 && self.island(ground, place).is_none() {
            return self.fallen_m(ground, place);
        }
        self.at(p, ground, place).height_m
    }

    /// How high the road's plane lies at a place, against its axis; beside the road as at its edge.
    fn fallen_m(&self, ground: &GroundPoint, place: &LocalPlace) -> f32 {
        let left_m = place.left_m.clamp(-place.half_width_m, place.half_width_m);
        let share = LEAST_FALL_SHARE + (1.0 - LEAST_FALL_SHARE) * self.draw(0x4641, place.chain, 0);
        let fades = (ground.other_m / FALL_FADES_M).clamp(0.0, 1.0);
        let fall = self.fall * share * fades;
        match self.draw(0x4352_4F57, place.chain, 0) {
            draw if draw < 0.5 => -fall * left_m.abs(),
            draw if draw < 0.75 => fall * left_m,
            _ => -fall * left_m,
        }
    }
}

#[cfg(test)]
mod tests;

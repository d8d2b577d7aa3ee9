//! Roads whose covering changes along the way, repairs in them, and roadsides of several kinds.
//!
//! Everything follows from the seed, the road (its chain of strokes) and the distance along it: a stretch has one covering,
//! a stretch of a roadside one kind of verge, a trench one place.

use super::{Colour, Footprint, LocalPlace, MadeGround};
use crate::ground::GroundPoint;
use crate::light::mixed;
use crate::noise::{floor_int, mix, unit};
use crate::shown::PixelClass;

/// What a stretch of road is covered with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Covering {
    /// As the map has it.
    Map,
    /// Asphalt of many summers: light grey, worn.
    OldAsphalt,
    /// Asphalt of last year: nearly black, even.
    NewAsphalt,
    /// Slabs of concrete with joints.
    Concrete,
    /// Grey gravel.
    Gravel,
    /// Trodden earth.
    Earth,
}

/// How a covering looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// Colour in full light.
    pub(super) base: Colour,
    /// Strength of stains and grain, where 1 is the map's asphalt.
    pub(super) wear: f32,
    /// Loose ground: stones in place of chippings, no paint.
    pub(super) loose: bool,
}

impl Covering {
    pub(super) fn look(self) -> Option<Look> {
        let look = |base, wear, loose| Some(Look { base, wear, loose });
        match self {
            Self::Map => None,
            Self::OldAsphalt => look([0.238, 0.238, 0.234], 1.2, false),
            Self::NewAsphalt => look([0.072, 0.075, 0.082], 0.7, false),
            Self::Concrete => look([0.370, 0.362, 0.335], 0.6, false),
            Self::Gravel => look([0.330, 0.305, 0.265], 1.1, true),
            Self::Earth => look([0.235, 0.170, 0.110], 1.3, true),
        }
    }
}

/// Coverings with the upper ends of their shares.
const COVERINGS: [(f32, Covering); 6] = [
    (0.20, Covering::Map),
    (0.45, Covering::OldAsphalt),
    (0.63, Covering::NewAsphalt),
    (0.77, Covering::Concrete),
    (0.90, Covering::Gravel),
    (1.00, Covering::Earth),
];

/// Length of concrete slabs and width of the joints between them, metres.
const SLAB_M: f32 = 5.0;
const JOINT_M: f32 = 0.03;
/// Length of road in which at most one trench was dug, and share of those in which one was.
const TRENCH_EVERY_M: f32 = 16.0;
const TRENCH_SHARE: f32 = 0.45;
/// Width of a tar seam, metres, and its colour.
const SEAM_M: f32 = 0.05;
const TAR: Colour = [0.030, 0.030, 0.033];
/// Asphalt that trenches are filled with.
const FILLING: Colour = [0.105, 0.108, 0.115];

/// Length of a roadside of one kind, metres.
const SIDE_STRETCH_M: f32 = 55.0;
/// Share of the roadsides without pavement that are gravel, where coverings change.
const GRAVEL_SIDES: f32 = 0.35;
/// Width of a kerb stone, of a pavement and of a gravel shoulder, metres.
pub(super) const KERB_M: f32 = 0.15;
const PAVEMENT_M: f32 = 2.0;
const SHOULDER_M: f32 = 1.6;
/// Size of a pavement's slabs, metres.
const FLAG_M: f32 = 0.5;
/// Colours of kerb stones, pavement and shoulder.
const KERB: Colour = [0.40, 0.40, 0.39];
const PAVEMENT: Colour = [0.262, 0.258, 0.250];
const SHOULDER: Colour = [0.310, 0.285, 0.245];

/// What stands in for the road's own verge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Pavement,
    Gravel,
    Grass,
}

/// The seed's choice of coverings, repairs and roadsides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Varied {
    seed: u64,
    stretch_m: f32,
    pavements: f32,
}

impl Varied {
    /// None where neither coverings change nor pavements are.
    pub(super) fn new(seed: u64, stretch_m: f32, pavements: f32) -> Option<Self> {
        (stretch_m > 0.0 || pavements > 0.0).then_some(Self { seed, stretch_m, pavements })
    }

    fn hash(&self, topic: u64, chain: u32, number: i32) -> u64 {
        mix(self.seed ^ mix(topic ^ mix((u64::from(chain) << 32) | u64::from(number as u32))))
    }

    /// The covering at a place of a road.
    pub(super) fn covering(&self, place: &LocalPlace) -> Covering {
        if self.stretch_m <= 0.0 {
            return Covering::Map;
        }
        let number = floor_int(place.along_m / self.stretch_m);
        let draw = unit(self.hash(0x434f, place.chain, number));
        COVERINGS.iter().find(|(end, _)| draw < *end).map_or(Covering::Map, |&(_, covering)| covering)
    }

    /// Lays joints, trenches and seams over a paved road's colour.
    #[inline(never)]
    pub(super) fn repair(
        &self,
        mut colour: Colour,
        covering: Covering,
        place: &LocalPlace,
        footprint: &Footprint,
        grain: f32,
    ) -> Colour {
        if self.stretch_m <= 0.0 {
            return colour;
        }
        let [along_extent_m, across_extent_m] = place.extents_m(footprint);
        if covering == Covering::Concrete {
            let from_joint = place.along_m - SLAB_M * floor_int(place.along_m / SLAB_M + 0.5) as f32;
            let joint = covered(from_joint, JOINT_M, along_extent_m);
            let middle = covered(place.left_m, JOINT_M, across_extent_m);
            colour = mixed(colour, [0.09, 0.09, 0.085], joint.max(middle));
        }
        let number = floor_int(place.along_m / TRENCH_EVERY_M);
        let hash = self.hash(0x5452, place.chain, number);
        if unit(hash) >= TRENCH_SHARE {
            return colour;
        }
        let part = |i: u64| unit(mix(hash ^ i));
        let half_length = 0.5 * (1.5 + (TRENCH_EVERY_M - 2.0) * part(1) * part(1));
        let half_width = 0.3 + 0.5 * part(2);
        let middle_along = TRENCH_EVERY_M * (number as f32 + 0.5);
        let middle_left = (2.0 * part(3) - 1.0) * (place.half_width_m - half_width).max(0.0);
        let (along, left) = (place.along_m - middle_along, place.left_m - middle_left);
        let inside = covered(along, 2.0 * half_length, along_extent_m).min(covered(
            left,
            2.0 * half_width,
            across_extent_m,
        ));
        colour = mixed(colour, FILLING.map(|c| c * (1.0 + 0.3 * grain)), inside);
        // The seam runs round the trench.
        let on_side = covered(left.abs() - half_width, SEAM_M, across_extent_m).min(covered(
            along,
            2.0 * half_length,
            along_extent_m,
        ));
        let on_end = covered(along.abs() - half_length, SEAM_M, along_extent_m).min(covered(
            left,
            2.0 * half_width,
            across_extent_m,
        ));
        mixed(colour, TAR, on_side.max(on_end))
    }

    /// The roadside in place of the verge.
    pub(super) fn roadside(
        &self,
        place: &LocalPlace,
        point: &GroundPoint,
        footprint: &Footprint,
        grain: f32,
    ) -> MadeGround {
        let extent_m = footprint.extent_m(point.edge_slope);
        // Share of the pixel between the road's edge and so far from it.
        let within = |far_m: f32| ((far_m - point.edge_m) / extent_m + 0.5).clamp(0.0, 1.0);
        match self.side(place) {
            Side::Grass => MadeGround { colour: [0.0; 3], share: 0.0, class: PixelClass::Verge },
            Side::Gravel => MadeGround {
                colour: SHOULDER.map(|c| c * (1.0 + 0.5 * grain)),
                share: within(SHOULDER_M),
                class: PixelClass::Verge,
            },
            Side::Pavement => {
                let flags = PAVEMENT.map(|c| c * (1.0 + 0.25 * grain + 0.25 * point.tone));
                let [along_extent_m, _] = place.extents_m(footprint);
                let joint = |at_m: f32, extent_m: f32| {
                    covered(at_m - FLAG_M * floor_int(at_m / FLAG_M + 0.5) as f32, 0.012, extent_m)
                };
                let joints = joint(place.along_m, along_extent_m).max(joint(point.edge_m - KERB_M, extent_m));
                let flags = mixed(flags, [0.10, 0.10, 0.095], 0.8 * joints);
                let stone = within(KERB_M);
                MadeGround {
                    colour: mixed(flags, KERB.map(|c| c * (1.0 + 0.15 * grain)), stone),
                    share: within(PAVEMENT_M),
                    class: PixelClass::Raised,
                }
            }
        }
    }

    fn side(&self, place: &LocalPlace) -> Side {
        let number = floor_int(place.along_m / SIDE_STRETCH_M);
        let topic = if place.left_m > 0.0 { 0x4c45 } else { 0x5249 };
        let hash = self.hash(topic, place.chain, number);
        if unit(hash) < self.pavements {
            Side::Pavement
        } else if self.stretch_m > 0.0 && unit(mix(hash)) < GRAVEL_SIDES {
            Side::Gravel
        } else {
            Side::Grass
        }
    }
}

/// Share of a pixel of that extent that a strip of that width covers whose middle is `from_middle_m` away.
pub(super) fn covered(from_middle_m: f32, width_m: f32, extent_m: f32) -> f32 {
    let half = 0.5 * width_m;
    ((half - from_middle_m.abs()) / extent_m + 0.5).clamp(0.0, 1.0).min(width_m / extent_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(chain: u32, along_m: f32, left_m: f32) -> LocalPlace {
        LocalPlace { chain, along_m, left_m, half_width_m: 3.0, direction: [1.0, 0.0] }
    }

    #[test]
    fn coverings_change_along_a_road_and_all_of_them_occur() {
        let varied = Varied::new(7, 45.0, 0.4).unwrap();
        let at = |i: u16| varied.covering(&place(u32::from(i) % 5, 45.0 * f32::from(i) + 20.0, 0.0));
        for (_, covering) in COVERINGS {
            assert!((0..200).any(|i| at(i) == covering), "{covering:?}");
        }
        assert_eq!(varied.covering(&place(3, 1.0, 2.0)), varied.covering(&place(3, 44.0, -2.0)));
        let as_mapped = Varied::new(7, 0.0, 0.4).unwrap();
        assert_eq!(as_mapped.covering(&place(3, 100.0, 0.0)), Covering::Map);
        assert!(Varied::new(7, 0.0, 0.0).is_none());
    }

    #[test]
    fn a_pavement_begins_with_a_kerb_and_ends_after_two_metres() {
        let varied = Varied::new(1, 0.0, 1.0).unwrap();
        let footprint = Footprint { across_m: 0.01, along_m: 0.02, sight: [1.0, 0.0] };
        let at = |edge_m: f32| {
            let point = GroundPoint { edge_m, edge_slope: [0.0, 1.0], ..GroundPoint::OPEN };
            varied.roadside(&place(1, 10.2, 3.0 + edge_m), &point, &footprint, 0.0)
        };
        let (kerb, flag, grass) = (at(0.07), at(1.0), at(2.5));
        assert!(kerb.share > 0.99 && flag.share > 0.99 && grass.share < 0.01);
        assert!(kerb.colour[0] > 1.3 * flag.colour[0], "{kerb:?} against {flag:?}");
    }
}

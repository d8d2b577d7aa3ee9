//! What is laid on the ground in rows: slabs, setts; and what wheels leave in it.

use super::Colour;
use super::lane::LocalPlace;
use super::varied::covered;
use crate::light::mixed;
use crate::noise::floor_int;

/// How a ground is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pattern {
    /// Not at all.
    Plain,
    /// Square slabs.
    Slabs {
        /// Their side, metres.
        side_m: f32,
    },
    /// Small stones in rows that are shifted by half.
    Setts {
        /// Length along the road and width, metres.
        size_m: [f32; 2],
    },
    /// Two wheel tracks.
    Ruts,
    /// Two wheel tracks with grass between them.
    GrassBetween,
}

/// Width of the joints of slabs and setts, metres, and their brightness against the stones'.
const JOINT_M: f32 = 0.012;
const JOINT_SHADE: f32 = 0.4;
/// How far stones differ in brightness, share.
const STONE_SPREAD: f32 = 0.35;
const SLAB_SPREAD: f32 = 0.12;
/// Distance of a wheel's track from the middle between both, its width, metres, and its brightness.
const TRACK_M: f32 = 0.75;
const TRACK_WIDTH_M: f32 = 0.4;
const TRACK_SHADE: f32 = 0.78;
/// Width of the grass between the tracks, metres.
const GRASS_M: f32 = 0.8;

impl Pattern {
    /// The colour of one stone, or of a joint. `tone` gives each stone a number in [0, 1) of its own.
    pub(super) fn laid(
        self,
        colour: Colour,
        place: &LocalPlace,
        [along_extent_m, across_extent_m]: [f32; 2],
        tone: impl Fn(i32, i32) -> f32,
    ) -> Colour {
        let ([length_m, width_m], spread, shift) = match self {
            Self::Plain | Self::GrassBetween => return colour,
            Self::Ruts => {
                let track = covered(place.left_m.abs() - TRACK_M, TRACK_WIDTH_M, across_extent_m).min(1.0);
                return colour.map(|c| c * (1.0 + (TRACK_SHADE - 1.0) * track));
            }
            Self::Slabs { side_m } => ([side_m; 2], SLAB_SPREAD, 0.0),
            Self::Setts { size_m } => (size_m, STONE_SPREAD, 0.5),
        };
        let row = floor_int(place.left_m / width_m);
        let along = place.along_m / length_m + shift * (row & 1) as f32;
        let column = floor_int(along);
        // Where a pixel shows several stones, it shows their mean.
        let single = (1.5 - along_extent_m / length_m).clamp(0.0, 1.0);
        let own = 1.0 + spread * single * (2.0 * tone(column, row) - 1.0);
        let from_joint = |at: f32, size_m: f32| (at - floor_int(at + 0.5) as f32) * size_m;
        let joint = covered(from_joint(along, length_m), JOINT_M, along_extent_m).max(covered(
            from_joint(place.left_m / width_m, width_m),
            JOINT_M,
            across_extent_m,
        ));
        let stone = colour.map(|c| c * own);
        mixed(stone, colour.map(|c| c * JOINT_SHADE), joint.clamp(0.0, 1.0))
    }

    /// Share of the ground that is grass between the tracks.
    pub(super) fn grass(self, left_m: f32, across_extent_m: f32) -> f32 {
        match self {
            Self::GrassBetween => covered(left_m, GRASS_M, across_extent_m).clamp(0.0, 1.0),
            _ => 0.0,
        }
    }
}

//! Colours of kerbed streets beside the road: parking bays, kerb stones, pavements.

use super::varied::covered;
use super::{Colour, Footprint, MadeGround, Painter};
use crate::ground::GroundPoint;
use crate::light::mixed;
use crate::noise::floor_int;
use crate::shown::PixelClass;
use crate::street::StreetPoint;

/// Width of a kerb stone's top and of the gutter before it, metres.
const STONE_M: f32 = 0.13;
const GUTTER_M: f32 = 0.25;
/// Brightness of the gutter and of a bay's covering against the road's.
const GUTTER_SHADE: f32 = 0.93;
const BAY_SHADE: f32 = 0.97;
/// Side of the pavement's slabs where it is not of the road's kind, and the width of their joints, metres.
const SLAB_M: f32 = 0.5;
const JOINT_M: f32 = 0.012;
/// Colours of kerb stones, and of slabs where they are not of the road's tone.
const STONE: Colour = [0.245, 0.245, 0.24];
const SLABS: Colour = [0.262, 0.258, 0.250];
const JOINT: Colour = [0.10, 0.10, 0.095];

impl Painter {
    /// The street at a place; none where no street has kerbs, and far from any road.
    #[inline]
    pub(crate) fn street_at(&self, x: f32, y: f32, point: &GroundPoint) -> Option<StreetPoint> {
        let (street, stroke) = (self.street.as_ref()?, point.stroke?);
        Some(street.at([x, y], point, &self.lanes[stroke as usize].place(x, y)))
    }

    /// The ground at a place, with islands as the road's edge and the edge of an unmade road where it wanders to.
    #[inline]
    pub(crate) fn edged(&self, x: f32, y: f32, point: GroundPoint) -> GroundPoint {
        match (&self.street, point.stroke) {
            (Some(street), Some(stroke)) => street.ground(&point, &self.lanes[stroke as usize].place(x, y)),
            _ => self.ragged(x, y, point),
        }
    }

    /// Height of the street above the ground's waves at a place, metres.
    #[inline]
    pub(crate) fn street_height_m(&self, x: f32, y: f32, point: &GroundPoint) -> f32 {
        match (&self.street, point.stroke) {
            (Some(street), Some(stroke)) => {
                street.height_m([x, y], point, &self.lanes[stroke as usize].place(x, y))
            }
            _ => 0.0,
        }
    }

    /// Whether streets have heights of their own.
    pub(crate) fn has_street(&self) -> bool {
        self.street.is_some()
    }

    /// Colour of a kerb's face in full light.
    pub(crate) fn kerb_face(&self, x: f32, y: f32, fineness: f32) -> Colour {
        let grain = self.asphalt.sample(y, x, fineness)[0];
        let stone = self.materials.map_or(1.0, |materials| materials.kerb);
        STONE.map(|c| c * stone * (1.0 + 0.3 * grain))
    }

    /// What is beside the road where that is a kerbed street.
    #[inline(never)]
    pub(super) fn kerbed(
        &self,
        x: f32,
        y: f32,
        point: &GroundPoint,
        footprint: &Footprint,
        fineness: f32,
    ) -> Option<MadeGround> {
        let street = self.street.as_ref()?;
        let at = self.street_at(x, y, point)?;
        let extent_m = footprint.extent_m(point.edge_slope);
        // Share of the pixel that lies farther than that behind the kerb's face.
        let beyond = |far_m: f32| ((at.behind_kerb_m - far_m) / extent_m + 0.5).clamp(0.0, 1.0);
        // Without its stroke no lines are painted; a road of its own ground is asked for with it, beyond all lines.
        let unpainted = if self.materials.is_some() {
            GroundPoint { other_m: 0.0, ..*point }
        } else {
            GroundPoint { stroke: None, ..*point }
        };
        let (asphalt, _) = self.road(x, y, &unpainted, footprint, fineness);
        let grain = self.asphalt.sample(y, x, fineness)[0];
        let joint = |at_m: f32, extent_m: f32| {
            covered(at_m - SLAB_M * floor_int(at_m / SLAB_M + 0.5) as f32, JOINT_M, extent_m)
        };
        let slabs = SLABS.map(|c| c * (1.0 + 0.25 * grain + 0.25 * point.tone));
        let joints = joint(x, footprint.along_m).max(joint(y, footprint.along_m));
        let slabs = mixed(slabs, JOINT, 0.8 * joints.min(1.0));
        let pavement = match self.pavement([x, y], point, footprint, asphalt) {
            Some(own) => own,
            None => mixed(slabs, asphalt.map(|c| c * street.shade), street.alike),
        };
        let stone = self.materials.map_or(1.0, |materials| materials.kerb);
        let mut colour = asphalt.map(|c| c * BAY_SHADE);
        colour = mixed(colour, asphalt.map(|c| c * GUTTER_SHADE), beyond(-GUTTER_M));
        colour = mixed(colour, STONE.map(|c| c * stone * (1.0 + 0.3 * grain)), beyond(0.0));
        colour = mixed(colour, pavement, beyond(STONE_M));
        let is_there = if at.kerb_m > 0.0 || at.behind_kerb_m < 0.0 { 1.0 } else { 0.0 };
        let class = if at.behind_kerb_m < 0.0 { PixelClass::Road } else { PixelClass::Raised };
        Some(MadeGround { colour, share: is_there * (1.0 - beyond(at.pavement_m)), class })
    }
}

//! What lies on the ground: snow and leaves.

use super::{Colour, Footprint, Painter};
use crate::ground::GroundPoint;
use crate::light::mixed;

/// Albedo of snow in towns, from trodden to fresh.
const SNOW: Colour = [0.72, 0.75, 0.80];
/// Autumn leaves.
const LEAVES: Colour = [0.30, 0.155, 0.05];
/// Snow is cleared to this far from the road's edge, and heaped beyond, metres.
const CLEARED_M: f32 = 0.4;
/// How suddenly ground is covered, per unit of noise.
const STEEPNESS: f32 = 4.0;
/// Leaves gather within this distance of the edge, metres.
const GATHER_M: f32 = 1.2;

impl Painter {
    /// Snow and leaves over a colour.
    #[inline(never)]
    pub(super) fn littered(
        &self,
        mut colour: Colour,
        [x, y]: [f32; 2],
        point: &GroundPoint,
        footprint: &Footprint,
    ) -> Colour {
        let Some(materials) = &self.materials else { return colour };
        let fineness = footprint.fineness_m();
        if materials.leaves > 0.0 {
            let flecks = self.soil.sample(1.7 * x, 1.7 * y, 1.7 * fineness)[1];
            let heaps = self.grass.sample(0.2 * y, 0.2 * x, 0.2 * fineness)[0];
            let gathered =
                (1.0 - (point.edge_m / GATHER_M).abs()).max(0.0) + if point.edge_m > 0.0 { 0.4 } else { 0.0 };
            let share = STEEPNESS * (materials.leaves * (0.2 + gathered) - 0.45 + 0.5 * flecks + 0.4 * heaps);
            let tone = 1.0 + 0.6 * flecks;
            colour = mixed(colour, LEAVES.map(|c| c * tone), share.clamp(0.0, 0.9));
        }
        if materials.snow > 0.0 {
            let drifts = self.soil.sample(0.3 * x, 0.3 * y, 0.3 * fineness)[0];
            let beyond = (point.edge_m / CLEARED_M).clamp(-2.0, 1.0);
            let share = STEEPNESS * (materials.snow - 0.6 + 0.3 * beyond + 0.6 * drifts);
            let dirt = 1.0 + 0.25 * self.soil.sample(y, x, fineness)[0];
            colour = mixed(colour, SNOW.map(|c| c * dirt), share.clamp(0.0, 0.97));
        }
        colour
    }
}

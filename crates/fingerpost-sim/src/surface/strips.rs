//! Strips of new asphalt, sealed cracks and construction seams along a road.

use super::lane::LocalPlace;
use super::varied::covered;
use super::{Colour, Footprint};
use crate::light::mixed;
use crate::noise::{floor_int, mix, unit};

/// Length of road that has its own strips, metres.
const STRETCH_M: f32 = 45.0;
/// Sealed cracks that a stretch may have.
const CRACKS: u64 = 2;
/// Width of the bitumen on a crack and of a seam, metres.
const CRACK_M: f32 = 0.09;
const SEAM_M: f32 = 0.04;
/// How far a crack wanders to either side, metres, and the length of its waves.
const CRACK_WANDERS_M: f32 = 0.12;
const CRACK_WAVE_M: f32 = 2.3;
const BITUMEN: Colour = [0.028, 0.028, 0.031];
/// New and old asphalt of repairs.
const FRESH: Colour = [0.085, 0.088, 0.096];
const PALE: Colour = [0.275, 0.272, 0.262];

/// The seed's strips.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strips {
    seed: u64,
    share: f32,
}

impl Strips {
    /// None where no road has any.
    pub(super) fn new(seed: u64, share: f32) -> Option<Self> {
        (share > 0.0).then_some(Self { seed, share })
    }

    /// Lays what a stretch has over the road's colour.
    #[inline(never)]
    pub(super) fn laid(
        &self,
        mut colour: Colour,
        place: &LocalPlace,
        footprint: &Footprint,
        grain: f32,
    ) -> Colour {
        let number = floor_int(place.along_m / STRETCH_M);
        let hash =
            mix(self.seed ^ mix(0x5354_5249 ^ (u64::from(place.chain) << 32) ^ u64::from(number as u32)));
        let draw = |topic: u64| unit(mix(hash ^ mix(topic)));
        let between = |topic: u64, low: f32, high: f32| low + (high - low) * draw(topic);
        let [along_extent_m, across_extent_m] = place.extents_m(footprint);
        let in_stretch_m = place.along_m - STRETCH_M * number as f32;
        if draw(0) < self.share {
            let (half_length_m, width_m) = (between(1, 8.0, 20.0), between(2, 0.35, 1.5));
            let from_middle_m = in_stretch_m - between(3, half_length_m, STRETCH_M - half_length_m);
            let aside_m = place.left_m - place.half_width_m * between(4, -0.8, 0.8);
            let inside = covered(from_middle_m, 2.0 * half_length_m, along_extent_m)
                * covered(aside_m, width_m, across_extent_m).min(1.0);
            let filling = if draw(5) < 0.75 { FRESH } else { PALE };
            colour = mixed(colour, filling.map(|c| c * (1.0 + 0.3 * grain)), inside.clamp(0.0, 1.0));
            let seam = covered(aside_m.abs() - 0.5 * width_m, SEAM_M, across_extent_m)
                * covered(from_middle_m, 2.0 * half_length_m, along_extent_m).min(1.0);
            colour = mixed(colour, BITUMEN, seam.clamp(0.0, 1.0));
        }
        for crack in 0..CRACKS {
            let topic = 16 * (crack + 1);
            if draw(topic) >= 0.7 * self.share {
                continue;
            }
            let phase = libm::sinf(place.along_m / CRACK_WAVE_M + 6.3 * draw(topic + 1))
                + 0.6 * libm::sinf(place.along_m * 1.7 / CRACK_WAVE_M + 6.3 * draw(topic + 2));
            let middle_m = place.half_width_m * between(topic + 3, -0.9, 0.9) + CRACK_WANDERS_M * phase;
            let on_crack = covered(place.left_m - middle_m, CRACK_M, across_extent_m);
            colour = mixed(colour, BITUMEN, on_crack.clamp(0.0, 1.0));
        }
        // The paver's lanes meet in a seam that runs all along.
        let seam_m = 0.5 * place.half_width_m + 0.25;
        let on_seam = covered(place.left_m.abs() - seam_m, 0.5 * SEAM_M, across_extent_m);
        mixed(colour, BITUMEN, (self.share * on_seam).clamp(0.0, 1.0))
    }
}

//! Manholes in the road, and crossings and arrows painted on it.
//!
//! A stretch of road has at most one of each, at a place that follows from the seed, the road and the stretch.

use super::lane::LocalPlace;
use super::varied::covered;
use super::{Colour, Footprint};
use crate::light::mixed;
use crate::noise::{floor_int, mix, unit};

/// Length of road that has its own, metres.
const STRETCH_M: f32 = 40.0;
/// Shares of the stretches with a manhole, a crossing and arrows, of those that have any.
const SHARES: [f32; 3] = [0.8, 0.35, 0.35];
/// Radius of a manhole's cover and width of its frame, metres (EN 124: 600 mm clear opening), and colours of both.
const COVER_M: f32 = 0.33;
const FRAME_M: f32 = 0.07;
const IRON: Colour = [0.055, 0.05, 0.048];
const FRAME: Colour = [0.15, 0.145, 0.14];
/// Length of a crossing along the road, and period and width of its bars, metres (German RMS-1: 3 to 4 m, bars and gaps of 0.5 m).
const CROSSING_M: f32 = 3.5;
const BARS_M: [f32; 2] = [1.0, 0.5];
/// Length and width of an arrow's shaft, length and half width of its head, metres (RMS-1, 5 m in all).
const SHAFT_M: [f32; 2] = [3.2, 0.15];
const HEAD_M: [f32; 2] = [1.8, 0.4];
const PAINT: Colour = [0.72, 0.72, 0.69];

/// The seed's manholes, crossings and arrows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fixtures {
    seed: u64,
    share: f32,
}

impl Fixtures {
    /// None where no road has any.
    pub(super) fn new(seed: u64, share: f32) -> Option<Self> {
        (share > 0.0).then_some(Self { seed, share })
    }

    /// The road's colour with what is in it and on it, and the share of the pixel that paint covers.
    #[inline(never)]
    pub(super) fn laid(&self, colour: Colour, place: &LocalPlace, footprint: &Footprint) -> (Colour, f32) {
        let number = floor_int(place.along_m / STRETCH_M);
        let hash =
            mix(self.seed ^ mix(0x4649_5854 ^ (u64::from(place.chain) << 32) ^ u64::from(number as u32)));
        let draw = |topic: u64| unit(mix(hash ^ mix(topic)));
        let [along_extent_m, across_extent_m] = place.extents_m(footprint);
        let along_m = place.along_m - STRETCH_M * number as f32;
        let has = |kind: usize| draw(kind as u64) < self.share * SHARES[kind];
        // Each keeps to a part of the stretch, so that none lies on another.
        let from_m = |topic: u64, [low, high]: [f32; 2]| along_m - (low + (high - low) * draw(topic));
        let mut colour = colour;
        if has(0) {
            let aside_m = place.left_m - place.half_width_m * (1.4 * draw(3) - 0.7);
            let from_middle_m = from_m(4, [1.0, 12.0]);
            let radius_m = (aside_m * aside_m + from_middle_m * from_middle_m).sqrt();
            let extent_m = (along_extent_m * across_extent_m).sqrt();
            let within = |far_m: f32| ((far_m - radius_m) / extent_m + 0.5).clamp(0.0, 1.0);
            let small = (2.0 * COVER_M / along_extent_m).min(1.0);
            colour = mixed(colour, FRAME, small * within(COVER_M + FRAME_M));
            colour = mixed(colour, IRON, small * within(COVER_M));
        }
        let mut paint = 0.0_f32;
        if has(1) {
            let from_middle_m = from_m(5, [16.0, 20.0]);
            let [period_m, width_m] = BARS_M;
            let aside_m = place.left_m - period_m * floor_int(place.left_m / period_m + 0.5) as f32;
            let bar = covered(aside_m, width_m, across_extent_m);
            paint = covered(from_middle_m, CROSSING_M, along_extent_m).min(1.0) * bar;
        }
        if has(2) {
            // In the middle of each lane, towards where its traffic drives.
            let lane_m = place.left_m.abs() - 0.5 * place.half_width_m;
            let ahead_m = from_m(6, [29.0, 33.0]) * if place.left_m > 0.0 { -1.0 } else { 1.0 };
            let [shaft_m, shaft_width_m] = SHAFT_M;
            let shaft = covered(ahead_m + 0.5 * shaft_m, shaft_m, along_extent_m).min(1.0)
                * covered(lane_m, shaft_width_m, across_extent_m);
            let [head_m, half_m] = HEAD_M;
            let narrowed = (1.0 - ahead_m / head_m).clamp(0.0, 1.0);
            let head = covered(ahead_m - 0.5 * head_m, head_m, along_extent_m).min(1.0)
                * covered(lane_m, 2.0 * half_m * narrowed, across_extent_m);
            paint = paint.max(shaft).max(head);
        }
        let paint = paint.clamp(0.0, 1.0);
        (mixed(colour, PAINT, paint), paint)
    }
}

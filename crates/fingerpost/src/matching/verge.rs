//! The contrast of an arm with what lies just outside its edges.
//!
//! A wide paved area is road under every mask (paper 1, section VII). An arm that is a road differs from one: beside it
//! begins a verge. So the probability of road in the bands beside an arm is held against that under the arm itself along
//! the same stretch. Where in the bands the road ends is not known, by as much as the map's width is not, so that the
//! band that is least road counts. Limits: a forecourt that is paved like the road hides a verge, and a shadow along a
//! paved area looks like one.

use fingerpost_vision::span::{Cover, RowSums, SpanMask};

use crate::feature_masks::VergeStrip;

/// Shortest seen part of a band and of the arm beside it that says something, metres.
const MIN_SEEN_M: f64 = 1.0;
/// Probability that a verge that is not seen is road: nothing is known.
pub(super) const UNSEEN_P: f64 = 0.5;

/// What was seen beside an arm, at one of its sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verge {
    /// Mean probability of road under the arm beside it.
    pub arm_p: f64,
    /// Mean probability of road in the band that is least road.
    pub verge_p: f64,
    /// Distance of that band's middle from the arm's, metres.
    pub beyond_m: f64,
}

impl Verge {
    /// What a strip shows with the feature's node at a pixel; none where too little of it is seen.
    pub(super) fn of(
        strip: &VergeStrip<SpanMask>,
        sums: &RowSums,
        (column, row): (i32, i32),
        metres_per_pixel: f64,
    ) -> Option<Self> {
        let min_seen_px = (MIN_SEEN_M * strip.band_width_m / metres_per_pixel.powi(2)).round() as u64;
        let p = |mask: &SpanMask| {
            let cover = sums.cover(mask, column, row);
            Some(cover).filter(|cover| cover.seen >= min_seen_px).as_ref().and_then(Cover::probability)
        };
        let arm_p = p(&strip.arm)?;
        let (mut seen, mut least) = (0, None);
        for (band, &beyond_m) in strip.bands.iter().zip(&strip.beyond_m) {
            let Some(verge_p) = p(band) else { continue };
            seen += 1;
            if least.is_none_or(|(least_p, _)| verge_p < least_p) {
                least = Some((verge_p, beyond_m));
            }
        }
        // The innermost bands alone may all lie on the road.
        let (verge_p, beyond_m) = least.filter(|_| 2 * seen > strip.bands.len())?;
        Some(Self { arm_p, verge_p, beyond_m })
    }

    /// How much more the arm is road than its verge, -1 to 1.
    pub fn contrast(&self) -> f64 {
        self.arm_p - self.verge_p
    }
}

//! The colours of road on this drive, learned from what the network is sure of.
//!
//! The network knows roads in general; what the road of today looks like shows in the places of which it is sure. So the colours of these
//! places are counted, on the road and beside it, as much as it is sure of each, and every pixel gets the logarithm of the
//! ratio of what its colour has on either side (naive Bayes; as in the self-supervised detectors of H. Dahlkamp et al., 2006). The
//! colours err together with the network that taught them: how much either counts beside the other was fitted on simulated drives and
//! comes with the weights (`training/colours.py` has the same computation).
//!
//! Limits: what has the road's colours beside it is drawn to the road, as far as the network is unsure of it.

use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::road_network::LOGIT_STEPS;

/// Steps of either chromaticity and of brightness that are distinguished.
const BINS: usize = 24;
/// Sum of the levels of a place's twelve numbers (four pixels of three colours), at most.
const BRIGHTEST: usize = 12 * 255;
/// Share of the counts that is kept from frame to frame: the last ten frames' worth.
const KEPT: f32 = 0.9;
/// Share of either side's places that a colour has for doubt: one that neither side had says nothing.
const DOUBT: f32 = 0.002;

/// What was counted on the drive so far.
#[derive(Debug, Clone)]
pub(super) struct DriveColours {
    /// By the sum of a place's levels.
    of_total: Vec<OfTotal>,
    /// How sure a logit is, 0 to 1; its sign says of what.
    sureness: [f32; 256],
    colours: Plane<u16>,
    road: Vec<f32>,
    beside: Vec<f32>,
    smooth: [Vec<f32>; 2],
    spare: Vec<f32>,
    log_ratio: Vec<f32>,
    /// The same weighed, in whole steps.
    steps: Vec<i8>,
}

/// What the sum of a place's levels says of its colour.
#[derive(Debug, Clone, Copy)]
struct OfTotal {
    /// What a level is multiplied by to become its share of the sum, in steps: the bits before the lowest [`SHARE_BITS`] are whole steps.
    steps_of_level: u32,
    /// Step of brightness.
    brightness: u32,
}

/// Bits behind the point with which every level comes to the whole steps that its division by the sum gives.
const SHARE_BITS: u32 = 24;
/// Steps that a share of 1 would have: from a sixth to a half, where colours of the day lie (grey has a third of each), there are [`BINS`].
const SHARE_STEPS: u32 = 72;
/// What is added to the sum of the levels, so that the darkest places are grey.
const DARK: u32 = 12;

impl OfTotal {
    fn new(total: u32, brightness: u32) -> Self {
        Self { steps_of_level: (SHARE_STEPS << SHARE_BITS).div_ceil(total + DARK), brightness }
    }

    /// Step of a level's share.
    #[inline]
    fn share(self, level: u32) -> u32 {
        ((level * self.steps_of_level) >> SHARE_BITS).clamp(12, 11 + BINS as u32) - 12
    }
}

impl DriveColours {
    pub(super) fn new() -> Self {
        let brightness = |sum: usize| {
            // The same steps everywhere between a level of 1 % and full white.
            let log = libm::log(sum as f64 / (4.0 * 255.0) + 0.05);
            ((log / 2.2 + 1.0) / 1.6 * BINS as f64).clamp(0.0, (BINS - 1) as f64) as u32
        };
        let mut sureness = [0.0; 256];
        for (logit, sure) in (i8::MIN..=i8::MAX).zip(&mut sureness) {
            *sure = libm::fabs(libm::tanh(0.5 * f64::from(logit) / f64::from(LOGIT_STEPS))) as f32;
        }
        let nothing = vec![0.0; BINS * BINS * BINS];
        Self {
            of_total: (0..=BRIGHTEST).map(|total| OfTotal::new(total as u32, brightness(total))).collect(),
            sureness,
            colours: Plane::default(),
            road: nothing.clone(),
            beside: nothing.clone(),
            smooth: [nothing.clone(), nothing.clone()],
            spare: nothing.clone(),
            log_ratio: nothing,
            steps: vec![0; BINS * BINS * BINS],
        }
    }

    pub(super) fn forget(&mut self) {
        self.road.fill(0.0);
        self.beside.fill(0.0);
    }

    /// Learns from a picture of twice the size of `road`, the network's logits; rows before `first_row` show no ground.
    pub(super) fn learn(&mut self, picture: &RgbImage, road: &Plane<i8>, first_row: usize) {
        self.name_colours(picture, road.size());
        for counts in [&mut self.road, &mut self.beside] {
            counts.iter_mut().for_each(|count| *count *= KEPT);
        }
        for y in first_row..road.height() {
            for (&colour, &logit) in self.colours.row(y).iter().zip(road.row(y)) {
                let side = if logit > 0 { &mut self.road } else { &mut self.beside };
                side[usize::from(colour)] += self.sureness[(i16::from(logit) + 128) as usize];
            }
        }
        let totals = [&self.road, &self.beside].map(|counts| counts.iter().sum::<f32>());
        // Without both there is nothing to compare.
        if totals.iter().any(|&total| total < 1.0) {
            self.log_ratio.fill(0.0);
            return;
        }
        for (counts, smooth) in [&self.road, &self.beside].into_iter().zip(&mut self.smooth) {
            smooth.copy_from_slice(counts);
            for stride in [1, BINS, BINS * BINS] {
                spread(smooth, stride, &mut self.spare);
                std::mem::swap(smooth, &mut self.spare);
            }
        }
        let [on_road, beside] = &self.smooth;
        for ((ratio, &road), &other) in self.log_ratio.iter_mut().zip(on_road).zip(beside) {
            let is_known = road > 0.0 || other > 0.0;
            let odds = (road / totals[0] + DOUBT) / (other / totals[1] + DOUBT);
            *ratio = if is_known { libm::logf(odds) } else { 0.0 };
        }
    }

    /// Makes ready what [`Self::steps`] gives: log-odds that colours add, times `steps`.
    pub(super) fn weigh(&mut self, steps: f32) {
        for (weighed, ratio) in self.steps.iter_mut().zip(&self.log_ratio) {
            *weighed = (steps * ratio).round().clamp(-127.0, 127.0) as i8;
        }
    }

    /// What a pixel's colour adds, as weighed last.
    #[inline]
    pub(super) fn steps(&self, pixel: [u8; 3]) -> i8 {
        // A place has four pixels.
        self.steps[self.colour(pixel.map(|level| 4 * u32::from(level)))]
    }

    /// The colour of a place with these sums of levels.
    #[inline]
    fn colour(&self, [red, green, blue]: [u32; 3]) -> usize {
        let total = (red + green + blue) as usize;
        let of_total = self.of_total[total.min(BRIGHTEST)];
        let (red, blue) = (of_total.share(red), of_total.share(blue));
        ((red * BINS as u32 + blue) * BINS as u32 + of_total.brightness) as usize
    }

    /// Names the colour of each place of `size`: chromaticities of red and blue, and brightness, of its four pixels.
    fn name_colours(&mut self, picture: &RgbImage, (width, height): (usize, usize)) {
        if self.colours.size() != (width, height) {
            self.colours.reset(width, height, 0);
        }
        let mut colours = std::mem::take(&mut self.colours);
        for y in 0..height {
            let (above, below) = (picture.row(2 * y), picture.row(2 * y + 1));
            let fours = above.chunks_exact(6).zip(below.chunks_exact(6));
            for (colour, (above, below)) in colours.row_mut(y).iter_mut().zip(fours) {
                let sum =
                    |c: usize| [above[c], above[c + 3], below[c], below[c + 3]].map(u32::from).iter().sum();
                *colour = self.colour([0, 1, 2].map(sum)) as u16;
            }
        }
        self.colours = colours;
    }
}

/// Spreads counts over neighbours along an axis, with weights 1, 2, 1; what would leave the ends stays there.
fn spread(counts: &[f32], stride: usize, out: &mut [f32]) {
    let block = stride * BINS;
    for (counts, out) in counts.chunks_exact(block).zip(out.chunks_exact_mut(block)) {
        for (at, out) in out.iter_mut().enumerate() {
            let before = counts[at.checked_sub(stride).unwrap_or(at)];
            let after = counts.get(at + stride).copied().unwrap_or(counts[at]);
            *out = 0.25 * before + 0.5 * counts[at] + 0.25 * after;
        }
    }
}

#[cfg(test)]
mod tests;

//! Colours of the way ahead, learned as the drive goes.
//!
//! The sample just ahead of the vehicle is not all that the road looks like: headlights make it yellower than the road
//! behind their light, the sky mirrors in a wet road far ahead, and a shadow or another covering lies where the sample is
//! not. But a vehicle drives along its road: over some seconds, most of what lies straight ahead of it is road. A colour
//! that the way ahead has had, and the verges have not, is road's.
//!
//! Limits: where the vehicle turns, what lies ahead is verge for a second or two, and counts little beside what verges have
//! of that colour; greys, which are not counted as verges', count all the more, so that grey pavements that are crossed
//! become road. A vehicle driven behind gives its colours.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, Rect, ValidityMask};

use super::colour_counts::ColourCounts;

/// Share of the view's rows, from the top, that is too far ahead to be that of the vehicle's own road for sure.
const TOO_FAR_SHARE: f64 = 0.2;
/// Every so many-th pixel and row is counted.
const STEP: usize = 3;
/// What is left of the counts after a frame: ten seconds at ten frames a second.
const KEPT: f32 = 0.99;
/// Frames' worth of pixels that have to be counted before anything is said.
const LEAST_FRAMES: f32 = 20.0;
/// Density of a colour on the way, in those of an even spread over all bins, at which it is half believed.
const HALF_BELIEVED: f32 = 0.3;
/// Weight of the way against the verges: it has some verge in it.
const WAY_ODDS: f32 = 0.5;
/// Density that verges are given of every colour: none is never a verge's.
const VERGE_FLOOR: f32 = 0.02;

/// Counts of the colours ahead of the vehicle.
#[derive(Debug)]
pub(super) struct WayColours {
    ahead: ColourCounts,
    likely: Vec<u8>,
}

impl WayColours {
    /// Nothing is known yet.
    pub(super) fn new(bins: HueSaturationBins) -> Self {
        Self { ahead: ColourCounts::new(bins), likely: vec![0; bins.count()] }
    }

    pub(super) fn forget(&mut self) {
        self.ahead.forget();
        self.likely.fill(0);
    }

    /// Least probability of road for each bin, of 255.
    pub(super) fn least_probability(&self) -> &[u8] {
        &self.likely
    }

    /// Takes in what lies ahead of the `sample` and in it, against the colours that were seen beside the road.
    pub(super) fn learn(
        &mut self,
        bin: &Plane<u16>,
        validity: &ValidityMask,
        sample: Rect,
        verges: &ColourCounts,
    ) {
        self.ahead.fade(KEPT);
        let before = self.ahead.total();
        let first_row = (bin.height() as f64 * TOO_FAR_SHARE) as usize;
        for row in (first_row..bin.height()).step_by(STEP) {
            let bins = bin.row(row);
            for run in validity.runs(row) {
                let ahead = run.start.max(sample.x)..run.end.min(sample.x + sample.width);
                ahead.step_by(STEP).for_each(|column| self.ahead.add(bins[column]));
            }
        }
        let total = self.ahead.total();
        if total < LEAST_FRAMES * (total - before).max(1.0) {
            self.likely.fill(0);
            return;
        }
        let densities = self.ahead.densities().zip(verges.densities());
        for (likely, (ahead, verge)) in self.likely.iter_mut().zip(densities) {
            let believed = ahead / (ahead + HALF_BELIEVED);
            let ahead = WAY_ODDS * ahead;
            *likely = (255.0 * believed * ahead / (ahead + verge + VERGE_FLOOR)) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINS: HueSaturationBins = HueSaturationBins { hue: 32, saturation: 32 };
    const LIT: u16 = 5 * 32 + 3;
    const UNLIT: u16 = 20 * 32 + 4;
    const GRASS: u16 = 12 * 32 + 15;
    const SAMPLE: Rect = Rect { x: 140, y: 260, width: 40, height: 50 };

    /// A road between meadows that is lit near the vehicle, after so many frames.
    fn learned(frames: usize, verge: u16) -> WayColours {
        let mut bin = Plane::new(320, 320, GRASS);
        for row in 0..320 {
            bin.row_mut(row)[100..220].fill(if row < 200 { UNLIT } else { LIT });
        }
        let mut verges = ColourCounts::new(BINS);
        (0..1000).for_each(|_| verges.add(verge));
        let validity = ValidityMask::from_plane(Plane::new(320, 320, 1));
        let mut way = WayColours::new(BINS);
        (0..frames).for_each(|_| way.learn(&bin, &validity, SAMPLE, &verges));
        way
    }

    #[test]
    fn the_road_ahead_is_road_though_the_sample_is_of_another_colour() {
        let way = learned(40, GRASS);
        let [lit, unlit, grass] = [LIT, UNLIT, GRASS].map(|bin| way.least_probability()[usize::from(bin)]);
        assert!(lit > 230 && unlit > 230 && grass == 0, "{lit} {unlit} {grass}");
    }

    #[test]
    fn a_colour_that_the_verges_have_more_of_is_not_road_for_lying_ahead() {
        let unlit = learned(40, UNLIT).least_probability()[usize::from(UNLIT)];
        assert!(unlit < 80, "{unlit}");
    }

    #[test]
    fn what_lies_ahead_is_road_though_no_verge_was_seen_yet() {
        let bin = Plane::new(320, 320, LIT);
        let validity = ValidityMask::from_plane(Plane::new(320, 320, 1));
        let mut way = WayColours::new(BINS);
        (0..40).for_each(|_| way.learn(&bin, &validity, SAMPLE, &ColourCounts::new(BINS)));
        let [lit, grass] = [LIT, GRASS].map(|bin| way.least_probability()[usize::from(bin)]);
        assert!(lit > 230 && grass == 0, "{lit} {grass}");
    }

    #[test]
    fn nothing_is_said_before_enough_was_seen_nor_when_it_is_forgotten() {
        let silent = |way: &WayColours| way.least_probability().iter().all(|&p| p == 0);
        assert!(silent(&learned(5, GRASS)));
        let mut way = learned(40, GRASS);
        way.forget();
        assert!(silent(&way));
    }
}

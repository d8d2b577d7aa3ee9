//! Colours of what lies beside the road, learned as the drive goes.
//!
//! Back-projection calls every colour that the sample does not have no road. Where a road's covering changes, at a patch,
//! a bridge, a junction with a road of another kind, it would end there. But what is beside roads is seen all along the
//! drive: a colour that neither the road nor its verges have had is unknown, and as likely road as not.
//!
//! Limits: a verge that changes is unknown as well, until none of what is passed is like the verges of before and they are
//! learned anew; a car or a wall of a colour of its own is.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, ValidityMask};

/// Probability of road below which a near pixel is taken for verge, of 255.
const VERGE_BELOW: u8 = 64;
/// Share of the view's rows, from the bottom, that is near enough for what is no road there to be passed soon.
const NEAR_SHARE: usize = 2;
/// Every so many-th pixel and row is counted.
const STEP: usize = 3;
/// What is left of the counts after a frame: ten seconds at ten frames a second.
const KEPT: f32 = 0.99;
/// Pixels that have to be counted before anything is said of verges: some seconds of a road between two of them.
const LEAST_COUNTED: f32 = 60_000.0;
/// Share of a verge's colour, in those of an even spread over all bins, at which a colour is as likely unknown as verge's.
const UNKNOWN_SHARE: f32 = 0.1;
/// Probability of road of a colour that is quite unknown, of 255.
const UNKNOWN_P: f32 = 127.0;

/// Counts of the colours beside the road.
#[derive(Debug)]
pub(super) struct VergeColours {
    bins: HueSaturationBins,
    counts: Vec<f32>,
    unknown: Vec<u8>,
}

impl VergeColours {
    /// Nothing is known yet.
    pub(super) fn new(bins: HueSaturationBins) -> Self {
        Self { bins, counts: vec![0.0; bins.count()], unknown: vec![0; bins.count()] }
    }

    pub(super) fn forget(&mut self) {
        self.counts.fill(0.0);
        self.unknown.fill(0);
    }

    /// Least probability of road for each bin, of 255: that of the colours that verges have not had.
    pub(super) fn least_probability(&self) -> &[u8] {
        &self.unknown
    }

    /// Takes in where no road was found near the vehicle.
    pub(super) fn learn(&mut self, bin: &Plane<u16>, validity: &ValidityMask, probability: &Plane<u8>) {
        self.counts.iter_mut().for_each(|count| *count *= KEPT);
        let height = probability.height().min(bin.height());
        for row in (height - height / NEAR_SHARE..height).step_by(STEP) {
            let (bins, p) = (bin.row(row), probability.row(row));
            for run in validity.runs(row) {
                for column in (run.start..run.end).step_by(STEP) {
                    let count = self.counts.get_mut(usize::from(bins[column]));
                    if let Some(count) = count.filter(|_| p[column] < VERGE_BELOW) {
                        *count += 1.0;
                    }
                }
            }
        }
        let total: f32 = self.counts.iter().sum();
        if total < LEAST_COUNTED {
            // What is known of verges has grown old, or is not yet enough.
            self.unknown.fill(0);
            return;
        }
        let even = total / self.counts.len() as f32;
        for index in 0..self.unknown.len() {
            let share = self.about(index) / even;
            self.unknown[index] = (UNKNOWN_P * UNKNOWN_SHARE / (UNKNOWN_SHARE + share)) as u8;
        }
    }

    /// Mean count of a bin and those beside it; hue goes round.
    fn about(&self, index: usize) -> f32 {
        let (hues, saturations) = (usize::from(self.bins.hue), usize::from(self.bins.saturation));
        let (hue, saturation) = (index / saturations, index % saturations);
        let mut sum = 0.0;
        for hue in [hue + hues - 1, hue, hue + 1] {
            for saturation in
                [saturation.saturating_sub(1), saturation, (saturation + 1).min(saturations - 1)]
            {
                sum += self.counts[hue % hues * saturations + saturation];
            }
        }
        sum / 9.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINS: HueSaturationBins = HueSaturationBins { hue: 32, saturation: 32 };
    const ROAD: u16 = 5 * 32 + 3;
    const GRASS: u16 = 12 * 32 + 15;
    const GRAVEL: usize = 3 * 32 + 20;

    /// A road between meadows, of which `probability` is as given.
    fn learned(frames: usize, verge_p: u8) -> VergeColours {
        let (width, height) = (320, 320);
        let (mut bin, mut p) = (Plane::new(width, height, GRASS), Plane::new(width, height, verge_p));
        for row in 0..height {
            bin.row_mut(row)[100..200].fill(ROAD);
            p.row_mut(row)[100..200].fill(250);
        }
        let validity = ValidityMask::from_plane(Plane::new(width, height, 1));
        let mut verges = VergeColours::new(BINS);
        (0..frames).for_each(|_| verges.learn(&bin, &validity, &p));
        verges
    }

    #[test]
    fn a_colour_that_verges_have_is_none_of_the_road_and_one_never_seen_is_unknown() {
        let verges = learned(40, 10);
        let least = verges.least_probability();
        assert!(least[usize::from(GRASS)] < 5, "{}", least[usize::from(GRASS)]);
        assert!(least[usize::from(GRASS) + 1] < 5, "nor is one beside it");
        assert_eq!(least[GRAVEL], 127);
    }

    #[test]
    fn nothing_is_said_before_a_verge_was_seen() {
        let silent = |verges: &VergeColours| verges.least_probability().iter().all(|&p| p == 0);
        assert!(silent(&learned(0, 10)) && silent(&learned(5, 10)), "too little is seen");
        assert!(silent(&learned(40, 100)), "what may be road is no verge");
        let mut verges = learned(40, 10);
        assert!(!silent(&verges));
        let (bin, unknown) = (Plane::new(320, 320, GRASS + 300), Plane::new(320, 320, 127));
        let validity = ValidityMask::from_plane(Plane::new(320, 320, 1));
        (0..200).for_each(|_| verges.learn(&bin, &validity, &unknown));
        assert!(silent(&verges), "verges that are passed no more are forgotten");
        verges.forget();
        assert!(silent(&verges));
    }
}

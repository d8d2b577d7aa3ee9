//! Colours of what lies beside the road, learned as the drive goes.
//!
//! Back-projection calls every colour that the sample does not have no road. Where a road's covering changes, at a patch,
//! a bridge, a junction with a road of another kind, it would end there. But what is beside roads is seen all along the
//! drive: a colour that neither the road nor its verges have had is unknown, and about as likely road as not. So are greys
//! that the road has not: beside a gravel road a grey pavement is verge, and asphalt in the next side street has its colour.
//!
//! Limits: a verge that changes is unknown as well, until none of what is passed is like the verges of before and they are
//! learned anew; a car or a wall of a colour of its own is.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, ValidityMask};

use super::colour_counts::ColourCounts;

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
/// As many have to be left for verges to stay known: greys, which are not told from coverings then, count no more.
const LEAST_KEPT: f32 = 20_000.0;
/// Share of a verge's colour, in those of an even spread over all bins, at which a colour is as likely unknown as verge's.
const UNKNOWN_SHARE: f32 = 0.1;
/// Probability of road of a colour that is quite unknown, of 255: a little more likely than not, as most of the view is road.
const UNKNOWN_P: f32 = 140.0;
/// Colours less saturated are greys, of 1.
const GREY_SATURATION: f32 = 0.1;

/// Counts of the colours beside the road.
#[derive(Debug)]
pub(super) struct VergeColours {
    bins: HueSaturationBins,
    counts: ColourCounts,
    known: bool,
    unknown: Vec<u8>,
}

impl VergeColours {
    /// Nothing is known yet.
    pub(super) fn new(bins: HueSaturationBins) -> Self {
        Self { bins, counts: ColourCounts::new(bins), known: false, unknown: vec![0; bins.count()] }
    }

    pub(super) fn forget(&mut self) {
        self.counts.forget();
        self.known = false;
        self.unknown.fill(0);
    }

    /// The colours that were seen beside the road.
    pub(super) fn counts(&self) -> &ColourCounts {
        &self.counts
    }

    /// Least probability of road for each bin, of 255: that of the colours that verges have not had.
    pub(super) fn least_probability(&self) -> &[u8] {
        &self.unknown
    }

    /// Takes in where no road was found near the vehicle.
    pub(super) fn learn(&mut self, bin: &Plane<u16>, validity: &ValidityMask, probability: &Plane<u8>) {
        self.counts.fade(KEPT);
        let height = probability.height().min(bin.height());
        for row in (height - height / NEAR_SHARE..height).step_by(STEP) {
            let (bins, p) = (bin.row(row), probability.row(row));
            for run in validity.runs(row) {
                for column in (run.start..run.end).step_by(STEP) {
                    if p[column] < VERGE_BELOW {
                        self.counts.add(bins[column]);
                    }
                }
            }
        }
        self.known = self.counts.total() >= if self.known { LEAST_KEPT } else { LEAST_COUNTED };
        if !self.known {
            // What is known of verges has grown old, or is not yet enough.
            self.unknown.fill(0);
            return;
        }
        let saturations = self.bins.saturation;
        for (index, (unknown, share)) in self.unknown.iter_mut().zip(self.counts.densities()).enumerate() {
            let known = if is_grey(index, saturations) { 0.0 } else { share };
            *unknown = (UNKNOWN_P * UNKNOWN_SHARE / (UNKNOWN_SHARE + known)) as u8;
        }
    }
}

/// Whether a bin is that of greys, which most coverings have, and pavements.
fn is_grey(index: usize, saturations: u16) -> bool {
    let saturations = usize::from(saturations);
    ((index % saturations) as f32) < GREY_SATURATION * saturations as f32
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
        assert_eq!(least[GRAVEL], 140);
    }

    #[test]
    fn greys_are_not_told_from_other_coverings() {
        let (mut bin, probability) = (Plane::new(320, 320, GRASS), Plane::new(320, 320, 10));
        let grey = 20 * 32 + 1;
        (0..320).for_each(|row| bin.row_mut(row)[..160].fill(grey));
        let validity = ValidityMask::from_plane(Plane::new(320, 320, 1));
        let mut verges = VergeColours::new(BINS);
        (0..40).for_each(|_| verges.learn(&bin, &validity, &probability));
        let least = verges.least_probability();
        assert_eq!(least[usize::from(grey)], 140);
        assert!(least[usize::from(GRASS)] < 5, "{}", least[usize::from(GRASS)]);
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

//! Which colours are road, by where the road was found.
//!
//! Back-projection asks what the place ahead looks like; here the question is Bayes' rule over the whole view: of all that
//! has this colour, how much was found to be road? Where road and verge differ in colour, the answer draws the road's edge
//! to the pixel; where they do not, it is the road's share of the view, which says nothing. Colours are hue, saturation and
//! brightness; they are learned every frame and forgotten slowly.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, ValidityMask};

use crate::ground_view::GroundPicture;

/// Levels of brightness: as many as half the bits of a grey tell apart.
const BRIGHTNESS_LEVELS: usize = 1 << LEVEL_BITS;
const LEVEL_BITS: u32 = 4;
/// Hues that are told apart.
const HUES: usize = 8;
/// Every so many-th pixel each way is learned from.
const STEP: usize = 2;
/// What is kept of the counts from frame to frame: half a second of a camera at 10 frames a second.
const KEPT: f32 = 0.8;
/// Pixels' worth of doubt in every bin.
const DOUBT_PIXELS: f32 = 4.0;

/// Likelihood ratios are cut to this either way: colours alone never decide against a sure classifier.
const MOST_ODDS: f32 = 20.0;
/// Probability below which a pixel counts as none of the road found, and from which as road, of 255.
const SURE: [u8; 2] = [60, 190];
/// Counters of a colour that are used in turn: neighbours are mostly alike, and a counter can be added to again only when
/// the last addition has been stored.
const TURNS: usize = 2;
/// Bins that a pixel can hold: with an entry for each no look-up needs a test.
const ALL_BINS: usize = 1 << 16;

/// Something for each level of brightness.
type Levels<T> = [T; BRIGHTNESS_LEVELS];

/// Counts of colours, on the road and beside it.
#[derive(Debug)]
pub(super) struct RoadColours {
    bins: HueSaturationBins,
    /// For each of [`ALL_BINS`] its hue and saturation here.
    tint_of_bin: Vec<u16>,
    road: Counts,
    beside: Counts,
    /// What each tint says at each brightness: the odds of road, seen with even ones before, as a probability of 255.
    of_tint: Vec<Levels<u8>>,
    /// The same for each of [`ALL_BINS`].
    of_bin: Vec<Levels<u8>>,
}

/// Pixels of each colour.
#[derive(Debug)]
struct Counts {
    /// Of the newest frame.
    new: Vec<Levels<[u32; TURNS]>>,
    /// Of all frames, the older ones counting less.
    pixels: Vec<Levels<f32>>,
    smooth: Vec<Levels<f32>>,
    /// Smoothed along some of the axes.
    partly: Vec<Levels<f32>>,
}

impl RoadColours {
    /// Nothing learned yet, for pictures with such bins.
    pub(super) fn new(bins: HueSaturationBins) -> Self {
        let saturations = usize::from(bins.saturation);
        let tint = |bin: usize| {
            let (hue, saturation) = (bin / saturations, bin % saturations);
            (hue * HUES / usize::from(bins.hue) * saturations + saturation) as u16
        };
        let mut tint_of_bin: Vec<u16> = (0..bins.count()).map(tint).collect();
        tint_of_bin.resize(ALL_BINS, 0);
        let tints = HUES * saturations;
        let nothing = [128; BRIGHTNESS_LEVELS];
        // Memory that comes as zeros is not touched where no bin is.
        let mut of_bin = vec![[0; BRIGHTNESS_LEVELS]; ALL_BINS];
        of_bin.iter_mut().take(bins.count()).for_each(|says| *says = nothing);
        Self {
            bins,
            tint_of_bin,
            road: Counts::new(tints),
            beside: Counts::new(tints),
            of_tint: vec![nothing; tints],
            of_bin,
        }
    }

    pub(super) fn forget(&mut self) {
        self.road.forget();
        self.beside.forget();
    }

    /// Learns the colours of what was `found` to be road (255 = 1) and of what was not.
    pub(super) fn learn(&mut self, picture: &GroundPicture, validity: &ValidityMask, found: &Plane<u8>) {
        for y in (0..found.height()).step_by(STEP) {
            let (bins, greys, found) = (picture.bin.row(y), picture.grey.row(y), found.row(y));
            for run in validity.runs(y) {
                let pixels = run.start..run.end;
                self.count(&bins[pixels.clone()], &greys[pixels.clone()], &found[pixels]);
            }
        }
        let saturations = usize::from(self.bins.saturation);
        self.road.take_in(saturations);
        self.beside.take_in(saturations);
        let (on_road, beside) = (self.road.total(), self.beside.total());
        // Without both kinds there is nothing to tell apart.
        let scale = if on_road > 0.0 && beside > 0.0 { on_road / beside } else { 0.0 };
        let smooth = self.road.smooth.as_flattened().iter().zip(self.beside.smooth.as_flattened());
        for (says, (&road, &other)) in self.of_tint.as_flattened_mut().iter_mut().zip(smooth) {
            let odds = if scale > 0.0 {
                // Doubt in proportion: a bin never seen says nothing.
                ((road + DOUBT_PIXELS) / (other * scale + DOUBT_PIXELS)).clamp(1.0 / MOST_ODDS, MOST_ODDS)
            } else {
                1.0
            };
            *says = (256.0 * odds / (1.0 + odds)) as u8;
        }
        for (says, &tint) in self.of_bin.iter_mut().zip(&self.tint_of_bin).take(self.bins.count()) {
            *says = self.of_tint[usize::from(tint)];
        }
    }

    /// Counts every [`STEP`]-th of a row's pixels, the first among them.
    fn count(&mut self, bins: &[u16], greys: &[u8], found: &[u8]) {
        let ((bins, last_bin), (greys, last_grey)) = (bins.as_chunks::<STEP>(), greys.as_chunks::<STEP>());
        let (found, last_found) = found.as_chunks::<STEP>();
        for (index, ((bins, greys), found)) in bins.iter().zip(greys).zip(found).enumerate() {
            self.count_one(bins[0], greys[0], found[0], index % TURNS);
        }
        if let ([bin, ..], [grey, ..], [found, ..]) = (last_bin, last_grey, last_found) {
            self.count_one(*bin, *grey, *found, 0);
        }
    }

    #[inline]
    fn count_one(&mut self, bin: u16, grey: u8, found: u8, turn: usize) {
        let kind = match found {
            p if p >= SURE[1] => &mut self.road,
            p if p < SURE[0] => &mut self.beside,
            _ => return,
        };
        // Of a length that is known when this is compiled.
        let tint = self.tint_of_bin[..ALL_BINS][usize::from(bin)];
        kind.new[usize::from(tint)][usize::from(grey >> LEVEL_BITS)][turn] += 1;
    }

    /// Writes what the colours of pixels with these bins and greys say: 128 is nothing, more is road.
    pub(super) fn read(&self, bins: &[u16], greys: &[u8], says: &mut [u8]) {
        let of_bin = &self.of_bin[..ALL_BINS];
        for ((says, &bin), &grey) in says.iter_mut().zip(bins).zip(greys) {
            *says = of_bin[usize::from(bin)][usize::from(grey >> LEVEL_BITS)];
        }
    }
}

impl Counts {
    fn new(tints: usize) -> Self {
        Self {
            new: vec![[[0; TURNS]; BRIGHTNESS_LEVELS]; tints],
            pixels: vec![[0.0; BRIGHTNESS_LEVELS]; tints],
            smooth: vec![[0.0; BRIGHTNESS_LEVELS]; tints],
            partly: vec![[0.0; BRIGHTNESS_LEVELS]; tints],
        }
    }

    fn forget(&mut self) {
        self.pixels.as_flattened_mut().fill(0.0);
    }

    fn total(&self) -> f32 {
        self.pixels.as_flattened().iter().sum()
    }

    /// Takes in what was counted, over which older counts fade.
    fn take_in(&mut self, saturations: usize) {
        let new = self.new.as_flattened_mut();
        for (pixels, new) in self.pixels.as_flattened_mut().iter_mut().zip(new) {
            *pixels = *pixels * KEPT + new.iter().sum::<u32>() as f32;
            *new = [0; TURNS];
        }
        self.smooth(saturations);
    }

    /// Spreads the counts over neighbouring colours, with weights 1, 2, 1 along each axis; hue is a circle.
    fn smooth(&mut self, saturations: usize) {
        let last = BRIGHTNESS_LEVELS - 1;
        for (levels, out) in self.pixels.iter().zip(&mut self.smooth) {
            let (mut darker, mut brighter) = (*levels, *levels);
            darker[1..].copy_from_slice(&levels[..last]);
            brighter[..last].copy_from_slice(&levels[1..]);
            *out = spread(&darker, levels, &brighter);
        }
        for (of_hue, out) in
            self.smooth.chunks_exact(saturations).zip(self.partly.chunks_exact_mut(saturations))
        {
            for (saturation, out) in out.iter_mut().enumerate() {
                let (paler, richer) = (saturation.saturating_sub(1), (saturation + 1).min(saturations - 1));
                *out = spread(&of_hue[paler], &of_hue[saturation], &of_hue[richer]);
            }
        }
        let tints = self.partly.len();
        for (tint, out) in self.smooth.iter_mut().enumerate() {
            let (before, after) = ((tint + tints - saturations) % tints, (tint + saturations) % tints);
            *out = spread(&self.partly[before], &self.partly[tint], &self.partly[after]);
        }
    }
}

fn spread(before: &Levels<f32>, here: &Levels<f32>, after: &Levels<f32>) -> Levels<f32> {
    std::array::from_fn(|level| 0.25 * before[level] + 0.5 * here[level] + 0.25 * after[level])
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINS: HueSaturationBins = HueSaturationBins { hue: 32, saturation: 32 };
    const ROAD: (u16, u8) = (5, 90);
    const VERGE: (u16, u8) = (10 * 32 + 20, 120);

    /// Road in the left half, verge in the right one.
    fn picture(width: usize, height: usize) -> (GroundPicture, Plane<u8>) {
        let (mut picture, mut found) =
            (GroundPicture::new(width, height, BINS), Plane::new(width, height, 0));
        for y in 0..height {
            for x in 0..width {
                let is_road = 2 * x < width;
                let (bin, grey) = if is_road { ROAD } else { VERGE };
                (picture.bin.row_mut(y)[x], picture.grey.row_mut(y)[x]) = (bin, grey);
                found.row_mut(y)[x] = if is_road { 255 } else { 0 };
            }
        }
        (picture, found)
    }

    fn says(colours: &RoadColours, (bin, grey): (u16, u8)) -> u8 {
        let mut says = [0];
        colours.read(&[bin], &[grey], &mut says);
        says[0]
    }

    #[test]
    fn what_was_found_to_be_road_says_road_and_what_was_not_says_none() {
        let mut colours = RoadColours::new(BINS);
        assert_eq!([says(&colours, ROAD), says(&colours, VERGE)], [128, 128], "nothing is learned yet");
        let (picture, found) = picture(61, 40);
        colours.learn(&picture, &ValidityMask::all_seen(61, 40), &found);
        assert!(says(&colours, ROAD) > 230 && says(&colours, VERGE) < 25);
        assert_eq!(says(&colours, (31 * 32 + 31, 250)), 128, "a colour never seen says nothing");
        colours.forget();
        colours.learn(&picture, &ValidityMask::all_seen(61, 40), &Plane::new(61, 40, 128));
        assert_eq!([says(&colours, ROAD), says(&colours, VERGE)], [128, 128], "forgotten");
    }

    #[test]
    fn every_second_pixel_each_way_counts_and_smoothing_keeps_their_number() {
        for (width, height) in [(61, 40), (60, 41), (1, 1), (2, 3), (7, 5)] {
            let mut colours = RoadColours::new(BINS);
            let (picture, found) = picture(width, height);
            colours.learn(&picture, &ValidityMask::all_seen(width, height), &found);
            let counted = colours.road.total() + colours.beside.total();
            assert!((counted - (width.div_ceil(2) * height.div_ceil(2)) as f32).abs() < 0.5);
            for counts in [&colours.road, &colours.beside] {
                let smooth: f32 = counts.smooth.as_flattened().iter().sum();
                assert!((smooth - counts.total()).abs() < 1e-2, "{smooth}");
            }
        }
    }
}

//! Which colours are road, by where the road was found.
//!
//! Back-projection asks what the place ahead looks like; here the question is Bayes' rule over the whole view: of all that
//! has this colour, how much was found to be road? Where road and verge differ in colour, the answer draws the road's edge
//! to the pixel; where they do not, it is the road's share of the view, which says nothing. Colours are hue, saturation and
//! brightness; they are learned every frame and forgotten slowly.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, ValidityMask};

use crate::ground_view::GroundPicture;

/// Levels of brightness, a power of two.
const BRIGHTNESS_LEVELS: usize = 16;
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
/// Probability from which a pixel counts as road found, and below which as none, of 255.
const SURE: [u8; 2] = [60, 190];

/// Counts of colours, on the road and beside it.
#[derive(Debug)]
pub(super) struct RoadColours {
    bins: HueSaturationBins,
    /// First index of the brightness levels of every hue-saturation bin of the pictures.
    of_bin: Vec<u16>,
    road: Counts,
    beside: Counts,
    /// What each colour says: the odds of road, seen with even ones before, as a probability of 255.
    says: Vec<u8>,
}

/// Pixels of each colour.
#[derive(Debug, Default)]
struct Counts {
    pixels: Vec<f32>,
    smooth: Vec<f32>,
}

impl RoadColours {
    /// Nothing learned yet, for pictures with such bins.
    pub(super) fn new(bins: HueSaturationBins) -> Self {
        let saturations = usize::from(bins.saturation);
        let of_bin = (0..bins.count()).map(|bin| {
            let (hue, saturation) = (bin / saturations, bin % saturations);
            let hue = hue * HUES / usize::from(bins.hue);
            ((hue * saturations + saturation) * BRIGHTNESS_LEVELS) as u16
        });
        let count = HUES * saturations * BRIGHTNESS_LEVELS;
        let counts = || Counts { pixels: vec![0.0; count], smooth: vec![0.0; count] };
        Self { bins, of_bin: of_bin.collect(), road: counts(), beside: counts(), says: vec![128; count] }
    }

    pub(super) fn forget(&mut self) {
        self.road.pixels.fill(0.0);
        self.beside.pixels.fill(0.0);
    }

    /// Learns the colours of what was `found` to be road (255 = 1) and of what was not.
    pub(super) fn learn(&mut self, picture: &GroundPicture, validity: &ValidityMask, found: &Plane<u8>) {
        self.road.fade();
        self.beside.fade();
        for y in (0..found.height()).step_by(STEP) {
            let (bins, greys, found) = (picture.bin.row(y), picture.grey.row(y), found.row(y));
            for run in validity.runs(y) {
                for x in (run.start..run.end).step_by(STEP) {
                    let Some(&first) = self.of_bin.get(usize::from(bins[x])) else { continue };
                    let counts = match found[x] {
                        p if p >= SURE[1] => &mut self.road,
                        p if p < SURE[0] => &mut self.beside,
                        _ => continue,
                    };
                    counts.pixels[usize::from(first) + usize::from(greys[x] >> 4)] += 1.0;
                }
            }
        }
        let shape = [HUES, usize::from(self.bins.saturation), BRIGHTNESS_LEVELS];
        self.road.smooth(shape);
        self.beside.smooth(shape);
        let (on_road, beside) = (self.road.total(), self.beside.total());
        // Without both kinds there is nothing to tell apart.
        let scale = if on_road > 0.0 && beside > 0.0 { on_road / beside } else { 0.0 };
        for ((says, &road), &other) in self.says.iter_mut().zip(&self.road.smooth).zip(&self.beside.smooth) {
            let odds = if scale > 0.0 {
                // Doubt in proportion: a bin never seen says nothing.
                ((road + DOUBT_PIXELS) / (other * scale + DOUBT_PIXELS)).clamp(1.0 / MOST_ODDS, MOST_ODDS)
            } else {
                1.0
            };
            *says = (256.0 * odds / (1.0 + odds)) as u8;
        }
    }

    /// Writes what the colour of every pixel of a row says: 128 is nothing, more is road.
    pub(super) fn read(&self, picture: &GroundPicture, row: usize, says: &mut [u8]) {
        let pixels = picture.bin.row(row).iter().zip(picture.grey.row(row));
        for (says, (&bin, &grey)) in says.iter_mut().zip(pixels) {
            let first = self.of_bin.get(usize::from(bin)).copied().unwrap_or(0);
            *says = self.says[usize::from(first) + usize::from(grey >> 4)];
        }
    }
}

impl Counts {
    fn fade(&mut self) {
        self.pixels.iter_mut().for_each(|pixels| *pixels *= KEPT);
    }

    fn total(&self) -> f32 {
        self.pixels.iter().sum()
    }

    /// Spreads the counts over neighbouring colours, with weights 1, 2, 1 along each axis; hue is a circle.
    fn smooth(&mut self, [hues, saturations, levels]: [usize; 3]) {
        self.smooth.copy_from_slice(&self.pixels);
        let mut along = |stride: usize, length: usize, is_circle: bool| {
            let block = stride * length;
            for block in self.smooth.chunks_exact_mut(block) {
                for offset in 0..stride {
                    let at = |i: usize| offset + i * stride;
                    let (first, last) = (block[at(0)], block[at(length - 1)]);
                    let mut before = if is_circle { last } else { first };
                    for i in 0..length {
                        let here = block[at(i)];
                        let after = match i + 1 < length {
                            true => block[at(i + 1)],
                            false if is_circle => first,
                            false => here,
                        };
                        block[at(i)] = 0.25 * before + 0.5 * here + 0.25 * after;
                        before = here;
                    }
                }
            }
        };
        along(1, levels, false);
        along(levels, saturations, false);
        along(levels * saturations, hues, true);
    }
}

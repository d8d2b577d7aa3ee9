//! Tones: histogram bins by brightness and tint.
//!
//! Greys differ in brightness alone, which tells asphalt in the sun from asphalt in shadow and from concrete; colours differ
//! in hue, which tells dirt from grass.

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, Rect};

use crate::ground_view::GroundPicture;

/// Brightness bins, over 0 to 255.
const BRIGHTNESSES: u16 = 32;
/// Tint bins: [`GREYS`] of colours so pale that their hue is chance, then [`SECTORS`] for each level of saturation.
const TINTS: u16 = 32;
const GREYS: usize = 8;
const SECTORS: usize = 4;
/// Saturation from which a hue counts: below it, one grey level of noise in a dark channel turns the hue.
const COLOURED: usize = 64;
/// Brightness and tint, in the shape of the histograms' bins.
pub(super) const TONES: HueSaturationBins = HueSaturationBins { hue: BRIGHTNESSES, saturation: TINTS };

/// Makes tones of a picture's greys and hue-saturation bins.
#[derive(Debug)]
pub(super) struct Tones {
    bins: Option<HueSaturationBins>,
    /// Tint of each hue-saturation bin.
    tints: Vec<u8>,
}

impl Tones {
    pub(super) const fn new() -> Self {
        Self { bins: None, tints: Vec::new() }
    }

    fn prepare(&mut self, bins: HueSaturationBins) {
        if self.bins == Some(bins) {
            return;
        }
        self.bins = Some(bins);
        let (hues, saturations) = (usize::from(bins.hue), usize::from(bins.saturation));
        self.tints.clear();
        self.tints.extend((0..bins.count()).map(|bin| {
            // The middle of the bin.
            let saturation = (2 * (bin % saturations) + 1) * 128 / saturations;
            let sector = (2 * (bin / saturations) + 1) * SECTORS / (2 * hues);
            let tint = match saturation.checked_sub(COLOURED) {
                None => saturation * GREYS / COLOURED,
                Some(above) => {
                    let levels = (usize::from(TINTS) - GREYS) / SECTORS;
                    GREYS + (above * levels / (256 - COLOURED)) * SECTORS + sector
                }
            };
            tint.min(usize::from(TINTS) - 1) as u8
        }));
    }

    /// Fills `tones` with the tone of every pixel of `region`; the others stay as they are.
    pub(super) fn make(&mut self, picture: &GroundPicture, region: Rect, tones: &mut Plane<u16>) {
        self.prepare(picture.bins);
        if tones.size() != picture.bin.size() {
            tones.reset(picture.bin.width(), picture.bin.height(), 0);
        }
        let columns = region.x.min(tones.width())..(region.x + region.width).min(tones.width());
        for row in region.y..(region.y + region.height).min(tones.height()) {
            let (bins, greys) =
                (&picture.bin.row(row)[columns.clone()], &picture.grey.row(row)[columns.clone()]);
            let tones = &mut tones.row_mut(row)[columns.clone()];
            for ((tone, &bin), &grey) in tones.iter_mut().zip(bins).zip(greys) {
                let tint = self.tints.get(usize::from(bin)).copied().unwrap_or(0);
                *tone = u16::from(grey / 8) * TINTS + u16::from(tint);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_differ_by_brightness_and_colours_by_hue() {
        let bins = HueSaturationBins { hue: 32, saturation: 32 };
        let mut picture = GroundPicture::new(4, 1, bins);
        // Dark grey, light grey, green, brown: half degrees of hue and saturations.
        let pixels = [(40, 0, 0), (200, 0, 0), (90, 60, 160), (90, 12, 160)];
        for (column, (grey, hue, saturation)) in pixels.into_iter().enumerate() {
            picture.grey.row_mut(0)[column] = grey;
            picture.bin.row_mut(0)[column] = bins.bin_of(hue, saturation) as u16;
        }
        let mut tones = Plane::default();
        Tones::new().make(&picture, Rect { x: 0, y: 0, width: 4, height: 1 }, &mut tones);
        let row = tones.row(0);
        assert_eq!((row[0] % TINTS, row[1] % TINTS), (0, 0), "grey");
        assert_eq!((row[0] / TINTS, row[1] / TINTS), (5, 25));
        assert_eq!(row[2] / TINTS, row[3] / TINTS);
        assert_ne!(row[2], row[3]);
        assert!(row.iter().all(|&tone| usize::from(tone) < TONES.count()));
    }
}

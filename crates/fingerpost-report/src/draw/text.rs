//! Text in Noto Sans Mono, rasterised beforehand by the `noto-sans-mono-bitmap` crate (SIL Open Font License).

use fingerpost_vision::picture::Rect;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::{Canvas, Paint};
use crate::palette::Rgb;

/// Stands for words that found no room; the font has no single letter for it.
const ELLIPSIS: &str = "...";

/// Height and weight of letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TextSize {
    /// 16 pixels a line.
    Small,
    /// 16 pixels a line, bold.
    SmallBold,
    /// 20 pixels a line, bold.
    Title,
}

impl TextSize {
    const fn raster(self) -> (FontWeight, RasterHeight) {
        match self {
            Self::Small => (FontWeight::Regular, RasterHeight::Size16),
            Self::SmallBold => (FontWeight::Bold, RasterHeight::Size16),
            Self::Title => (FontWeight::Bold, RasterHeight::Size20),
        }
    }

    /// Height of a line, pixels.
    pub(crate) const fn height_px(self) -> usize {
        self.raster().1.val()
    }

    /// Width of every letter, pixels.
    pub(crate) const fn letter_px(self) -> usize {
        let (weight, height) = self.raster();
        get_raster_width(weight, height)
    }
}

/// Width of a line of text, pixels.
pub(crate) fn text_width_px(size: TextSize, text: &str) -> usize {
    text.chars().count() * size.letter_px()
}

impl Canvas {
    /// A line of text with its top left corner at `corner`; letters that the font lacks become question marks.
    pub(crate) fn text(&mut self, corner: [f64; 2], size: TextSize, colour: Rgb, text: &str) {
        if !corner.iter().all(|c| c.is_finite()) {
            return;
        }
        let (weight, height) = size.raster();
        let (left, top) = (corner[0].round() as i64, corner[1].round() as i64);
        for (i, letter) in text.chars().enumerate() {
            let Some(raster) = get_raster(letter, weight, height).or_else(|| get_raster('?', weight, height))
            else {
                continue;
            };
            let letter_left = left + (i * size.letter_px()) as i64;
            for (row, intensities) in raster.raster().iter().enumerate() {
                for (column, &intensity) in intensities.iter().enumerate() {
                    let (x, y) = (letter_left + column as i64, top + row as i64);
                    if intensity > 0 && self.holds(x, y) {
                        self.blend(x as usize, y as usize, colour, f64::from(intensity) / 255.0);
                    }
                }
            }
        }
    }

    /// A line of text on a dark plate, shifted to lie inside the clip; returns the plate.
    pub(crate) fn label(&mut self, corner: [f64; 2], size: TextSize, colour: Rgb, text: &str) -> Rect {
        let plate = self.plate(corner, size, text);
        self.fill(plate, Paint::glaze(crate::palette::SHADE, 0.62));
        self.text([plate.x as f64 + 3.0, plate.y as f64], size, colour, text);
        plate
    }

    /// Where [`Self::label`] puts its plate.
    pub(crate) fn plate(&self, corner: [f64; 2], size: TextSize, text: &str) -> Rect {
        let (width, height) = (text_width_px(size, text) + 6, size.height_px() + 1);
        let clamp = |at: f64, start: usize, length: usize, own: usize| {
            (at.round().max(start as f64) as usize).min((start + length).saturating_sub(own).max(start))
        };
        let x = clamp(corner[0], self.clip.x, self.clip.width, width);
        let y = clamp(corner[1], self.clip.y, self.clip.height, height);
        Rect { x, y, width, height }
    }

    const fn holds(&self, x: i64, y: i64) -> bool {
        let clip = self.clip;
        x >= clip.x as i64
            && x < (clip.x + clip.width) as i64
            && y >= clip.y as i64
            && y < (clip.y + clip.height) as i64
    }
}

/// Breaks `text` between words into at most `max_lines` lines of `letters` letters; [`ELLIPSIS`] stands for what is left.
pub(crate) fn wrapped(text: &str, letters: usize, max_lines: usize) -> Vec<String> {
    let letters = letters.max(1);
    let mut lines = vec![String::new()];
    let mut length = 0;
    for word in text.split_whitespace() {
        let mut word: Vec<char> = word.chars().collect();
        loop {
            let gap = usize::from(length > 0);
            if length + gap + word.len() <= letters {
                if let Some(line) = lines.last_mut() {
                    line.extend(std::iter::repeat_n(' ', gap).chain(word.iter().copied()));
                }
                length += gap + word.len();
                break;
            }
            if length > 0 {
                lines.push(String::new());
                length = 0;
                continue;
            }
            let rest = word.split_off(letters);
            lines.pop();
            lines.extend([word.into_iter().collect(), String::new()]);
            word = rest;
        }
    }
    if lines.len() > max_lines.max(1) {
        lines.truncate(max_lines.max(1));
        if let Some(last) = lines.last_mut() {
            *last =
                last.chars().take(letters.saturating_sub(ELLIPSIS.len())).chain(ELLIPSIS.chars()).collect();
        }
    }
    lines
}

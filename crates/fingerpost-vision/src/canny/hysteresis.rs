//! Hysteresis: weak edge pixels count where they hang together with strong ones, corners included.

use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

pub(super) const NO_EDGE: u8 = 0;
/// Above the lower threshold. A bit of its own, so that several pixels are asked at once.
pub(super) const WEAK: u8 = 1;
/// Above the upper threshold, or reached from there.
pub(super) const STRONG: u8 = 2;

/// Classes behind the last row, so that eight can be read from anywhere.
const MARGIN_BYTES: usize = size_of::<u64>();

/// Classes of all pixels, and those still to be looked at.
#[derive(Debug, Clone, Default)]
pub(super) struct Hysteresis {
    width: usize,
    height: usize,
    /// Row by row with a margin of one pixel around the picture, always [`NO_EDGE`], so that every pixel has neighbours.
    classes: Vec<u8>,
    /// Indices of pixels that became strong and whose neighbours are not yet looked at.
    pending: Vec<usize>,
}

impl Hysteresis {
    /// Makes room for a picture of at least one pixel; its rows are to be filled then.
    pub(super) fn resize(&mut self, width: usize, height: usize) {
        if (self.width, self.height) != (width, height) {
            self.classes.clear();
            self.classes.resize((width + 2) * (height + 2) + MARGIN_BYTES, NO_EDGE);
            // A pixel becomes strong once, so this is as much as can ever be pending.
            self.pending.clear();
            self.pending.reserve(width * height);
            (self.width, self.height) = (width, height);
        }
    }

    pub(super) fn row_mut(&mut self, y: usize) -> &mut [u8] {
        let start = (y + 1) * (self.width + 2) + 1;
        &mut self.classes[start..start + self.width]
    }

    /// Follows all edges from their strong pixels and writes them to `edges`.
    pub(super) fn finish(&mut self, path: CodePath, edges: &mut Plane<u8>) {
        for word_start in (0..self.classes.len() - MARGIN_BYTES).step_by(size_of::<u64>()) {
            let mut strong = self.word(word_start) & u64::from_ne_bytes([STRONG; size_of::<u64>()]);
            while strong != 0 {
                self.spread_from(word_start + strong.trailing_zeros() as usize / 8);
                while let Some(index) = self.pending.pop() {
                    self.spread_from(index);
                }
                strong &= strong - 1;
            }
        }
        let pitch = self.width + 2;
        for y in 0..self.height {
            let start = (y + 1) * pitch + 1;
            strong_pixels(path, &self.classes[start..start + self.width], edges.row_mut(y));
        }
    }

    /// The classes of eight pixels from `start` on, the first one lowest.
    #[inline]
    fn word(&self, start: usize) -> u64 {
        self.classes[start..].first_chunk().map_or(0, |&classes| u64::from_le_bytes(classes))
    }

    /// Makes the weak neighbours of the pixel at `index` strong.
    #[inline]
    fn spread_from(&mut self, index: usize) {
        const WEAK_OF_THREE: u64 = u64::from_le_bytes([WEAK, WEAK, WEAK, 0, 0, 0, 0, 0]);
        let pitch = self.width + 2;
        let row_starts = [index - pitch - 1, index - 1, index + pitch - 1];
        let [above, here, below] = row_starts.map(|start| self.word(start));
        if (above | here | below) & WEAK_OF_THREE == 0 {
            return;
        }
        for start in row_starts {
            for index in start..start + 3 {
                if self.classes[index] == WEAK {
                    self.classes[index] = STRONG;
                    self.pending.push(index);
                }
            }
        }
    }
}

simd_kernel! {
    fn strong_pixels(classes: &[u8], edges: &mut [u8]) {
        for (edge, &class) in edges.iter_mut().zip(classes) {
            *edge = if class == STRONG { 255 } else { 0 };
        }
    }
}

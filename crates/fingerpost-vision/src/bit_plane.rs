//! Pictures of one bit a pixel, 64 pixels a word.

use crate::picture::PlaneView;
use crate::simd::{CodePath, simd_kernel};

/// Pixels of a word; the leftmost is the lowest bit.
pub(crate) const WORD_PX: usize = u64::BITS as usize;

/// A picture of one bit a pixel. Bits beyond its width are 0.
#[derive(Debug, Clone, Default)]
pub(crate) struct BitPlane {
    width: usize,
    words_a_row: usize,
    words: Vec<u64>,
}

impl BitPlane {
    /// Takes the size of `source`, and a 1 wherever it is not 0.
    pub(crate) fn fill_from(&mut self, path: CodePath, source: PlaneView<'_, u8>) {
        self.width = source.width();
        self.words_a_row = source.width().div_ceil(WORD_PX);
        self.words.resize(self.words_a_row * source.height(), 0);
        if self.words_a_row > 0 {
            for (y, words) in self.words.chunks_exact_mut(self.words_a_row).enumerate() {
                pack(path, source.row(y), words);
            }
        }
    }

    /// Words of each row.
    pub(crate) fn words_a_row(&self) -> usize {
        self.words_a_row
    }

    /// The words of each row, from the top.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[u64]> {
        self.words.chunks_exact(self.words_a_row.max(1))
    }
}

/// Bit i is 1 where byte i is not 0.
#[inline(always)]
fn bits_of(pixels: [u8; 8]) -> u64 {
    const LOW_7: u64 = u64::from_ne_bytes([0x7f; 8]);
    let bytes = u64::from_le_bytes(pixels);
    // The top bit of each byte: set already, or by a carry from the lower seven.
    let top_bits = (((bytes & LOW_7) + LOW_7) | bytes) & !LOW_7;
    // Shifts the top bit of byte i to bit 56 + i; no two terms of the product meet.
    (top_bits >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

simd_kernel! {
    fn pack(row: &[u8], words: &mut [u64]) {
        let (blocks, rest) = row.as_chunks::<WORD_PX>();
        let word_of = |pixels: &[u8; WORD_PX]| {
            let (eights, _) = pixels.as_chunks::<8>();
            eights.iter().rev().fold(0, |word, &eight| word << 8 | bits_of(eight))
        };
        for (word, pixels) in words.iter_mut().zip(blocks) {
            *word = word_of(pixels);
        }
        if let Some(last) = words.last_mut().filter(|_| !rest.is_empty()) {
            let mut pixels = [0; WORD_PX];
            pixels[..rest.len()].copy_from_slice(rest);
            *last = word_of(&pixels);
        }
    }
}

simd_kernel! {
    /// Sets each pixel to 255 where its bit is 1 and to 0 elsewhere.
    pub(crate) fn unpack(words: &[u64], row: &mut [u8]) {
        for (pixels, &word) in row.chunks_mut(WORD_PX).zip(words) {
            for (index, pixel) in pixels.iter_mut().enumerate() {
                *pixel = if word >> index & 1 == 1 { 255 } else { 0 };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::{binary_pictures, config, grey_pictures};

    proptest! {
        #![proptest_config(config(60))]

        #[test]
        fn a_bit_is_set_where_the_pixel_is_not_zero_on_every_path(
            picture in prop_oneof![binary_pictures(), grey_pictures()]
        ) {
            let source = picture.view();
            for path in CodePath::available() {
                let mut bits = BitPlane::default();
                bits.fill_from(path, source);
                prop_assert!(source.width() == 0 || bits.rows().count() == source.height());
                for (y, words) in bits.rows().enumerate() {
                    for x in 0..words.len() * WORD_PX {
                        let expected = source.row(y).get(x).is_some_and(|&pixel| pixel != 0);
                        prop_assert_eq!(words[x / WORD_PX] >> (x % WORD_PX) & 1 == 1, expected);
                    }
                }
            }
        }
    }
}

//! The pixels that no segment has taken yet, in a form that is quickly asked across a line.

/// Bits of a word.
const WORD: usize = u64::BITS as usize;

/// Rows of bits with an empty word before and after each, so that a window may reach beyond either end.
#[derive(Debug, Clone, Default)]
pub(super) struct BitRows {
    words_a_row: usize,
    /// Largest place that a window may start at, counted from the start of a row's first word.
    last_start: usize,
    words: Vec<u64>,
}

impl BitRows {
    /// Makes `count` empty rows of `length` bits.
    pub(super) fn reset(&mut self, length: usize, count: usize) {
        self.words_a_row = length.div_ceil(WORD) + 2;
        self.last_start = length + WORD;
        self.words.clear();
        self.words.resize(self.words_a_row * count, 0);
    }

    /// Sets the bit at `place` of `row`; both are inside.
    pub(super) fn set(&mut self, row: usize, place: usize) {
        self.words[row * self.words_a_row + place / WORD + 1] |= 1 << (place % WORD);
    }

    /// Clears the bit at `place` of `row`; both are inside.
    pub(super) fn clear(&mut self, row: usize, place: usize) {
        self.words[row * self.words_a_row + place / WORD + 1] &= !(1 << (place % WORD));
    }

    /// The bits of `row` at the `width` places, at most 64, from `start` on, the first one lowest.
    #[inline]
    pub(super) fn window(&self, row: usize, start: isize, width: usize) -> u64 {
        let start = start.saturating_add_unsigned(WORD).clamp(0, self.last_start as isize) as usize;
        let first = row * self.words_a_row + start / WORD;
        match self.words[first..] {
            [low, high, ..] => {
                let both = u128::from(high) << WORD | u128::from(low);
                (both >> (start % WORD)) as u64 & (u64::MAX >> (WORD - width))
            }
            // Nothing but the empty last word.
            _ => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_show_their_bits_and_nothing_beyond_the_ends() {
        let mut rows = BitRows::default();
        rows.reset(130, 2);
        for place in [0, 3, 63, 64, 129] {
            rows.set(1, place);
        }
        assert_eq!(rows.window(1, 0, 5), 0b01001);
        assert_eq!(rows.window(1, -2, 3), 0b100);
        assert_eq!(rows.window(1, 62, 4), 0b0110);
        assert_eq!(rows.window(1, 128, 59), 0b10);
        assert_eq!(rows.window(1, -59, 59), 0);
        assert_eq!((rows.window(1, -900, 9), rows.window(1, 900, 9)), (0, 0));
        assert_eq!(rows.window(0, 0, 64), 0);
        rows.clear(1, 3);
        assert_eq!(rows.window(1, 0, 5), 0b00001);
    }
}

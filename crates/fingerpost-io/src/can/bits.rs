//! The bits of a signal in a frame's bytes, in both byte orders of DBC files.
//!
//! A DBC numbers bits byte by byte, the lowest bit of a byte first: bit 8b + i is bit i of byte b. A little-endian signal
//! (Intel) starts at its lowest bit and goes up in these numbers. A big-endian one (Motorola) starts at its highest bit,
//! goes down within a byte and on to bit 7 of the next.

/// Order of a signal's bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    /// Intel.
    LittleEndian,
    /// Motorola.
    BigEndian,
}

/// Where a signal's bits are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BitField {
    /// First bit as the DBC counts: the lowest of a little-endian, the highest of a big-endian signal.
    pub(super) start: usize,
    /// Number of bits, 1 to 64.
    pub(super) size: usize,
    /// Order of the bytes.
    pub(super) order: ByteOrder,
}

impl BitField {
    /// The bits as a number without sign; none where the frame is too short for them.
    pub(super) fn unsigned(&self, data: &[u8]) -> Option<u64> {
        let bit = |byte: usize, place: usize| Some(u64::from(data.get(byte)? >> place & 1));
        match self.order {
            ByteOrder::LittleEndian => (0..self.size).try_fold(0, |value, i| {
                let place = self.start + i;
                Some(value | bit(place / 8, place % 8)? << i)
            }),
            ByteOrder::BigEndian => {
                // Counted from the highest bit of the first byte, a big-endian signal's bits follow one another.
                let first = self.start / 8 * 8 + (7 - self.start % 8);
                (first..first + self.size)
                    .try_fold(0, |value, place| Some(value << 1 | bit(place / 8, 7 - place % 8)?))
            }
        }
    }

    /// The bits as a number in two's complement; none where the frame is too short for them.
    pub(super) fn signed(&self, data: &[u8]) -> Option<i64> {
        let unused = 64 - self.size as u32;
        // Shifted up and back, the highest bit fills all above it.
        self.unsigned(data).map(|value| (value << unused).cast_signed() >> unused)
    }
}

//! Coefficients as bits (T.81, F.1.2).

use super::BLOCK_VALUES;
use super::transform::Block;

/// A table of codes: how many there are of each length from 1 to 16 bits, and their symbols, shortest code first.
pub(super) type CodeLengths = (&'static [u8; 16], &'static [u8]);

/// Differences of luma's first coefficients (T.81, table K.3).
pub(super) const LUMA_DC: CodeLengths =
    (&[0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0], &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
/// The same of chroma (table K.4).
pub(super) const CHROMA_DC: CodeLengths =
    (&[0, 3, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0], &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
/// Luma's other coefficients (table K.5).
#[rustfmt::skip]
pub(super) const LUMA_AC: CodeLengths = (
    &[0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 125],
    &[
        0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06, 0x13, 0x51, 0x61, 0x07,
        0x22, 0x71, 0x14, 0x32, 0x81, 0x91, 0xa1, 0x08, 0x23, 0x42, 0xb1, 0xc1, 0x15, 0x52, 0xd1, 0xf0,
        0x24, 0x33, 0x62, 0x72, 0x82, 0x09, 0x0a, 0x16, 0x17, 0x18, 0x19, 0x1a, 0x25, 0x26, 0x27, 0x28,
        0x29, 0x2a, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49,
        0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58, 0x59, 0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69,
        0x6a, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x79, 0x7a, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89,
        0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7,
        0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4, 0xb5, 0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5,
        0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe1, 0xe2,
        0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf1, 0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8,
        0xf9, 0xfa,
    ],
);
/// The same of chroma (table K.6).
#[rustfmt::skip]
pub(super) const CHROMA_AC: CodeLengths = (
    &[0, 2, 1, 2, 4, 4, 3, 4, 7, 5, 4, 4, 0, 1, 2, 119],
    &[
        0x00, 0x01, 0x02, 0x03, 0x11, 0x04, 0x05, 0x21, 0x31, 0x06, 0x12, 0x41, 0x51, 0x07, 0x61, 0x71,
        0x13, 0x22, 0x32, 0x81, 0x08, 0x14, 0x42, 0x91, 0xa1, 0xb1, 0xc1, 0x09, 0x23, 0x33, 0x52, 0xf0,
        0x15, 0x62, 0x72, 0xd1, 0x0a, 0x16, 0x24, 0x34, 0xe1, 0x25, 0xf1, 0x17, 0x18, 0x19, 0x1a, 0x26,
        0x27, 0x28, 0x29, 0x2a, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48,
        0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58, 0x59, 0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68,
        0x69, 0x6a, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x79, 0x7a, 0x82, 0x83, 0x84, 0x85, 0x86, 0x87,
        0x88, 0x89, 0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3, 0xa4, 0xa5,
        0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4, 0xb5, 0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3,
        0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda,
        0xe2, 0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8,
        0xf9, 0xfa,
    ],
);

/// No coefficient but zeros up to the block's end.
const END_OF_BLOCK: u8 = 0x00;
/// Sixteen zeros.
const SIXTEEN_ZEROS: u8 = 0xf0;

/// Codes by symbol.
#[derive(Debug, Clone)]
pub(super) struct CodeTable {
    pub(super) lengths: &'static [u8; 16],
    pub(super) symbols: &'static [u8],
    /// A symbol's code, and its length in the lowest byte.
    codes: [u32; 256],
}

impl CodeTable {
    /// Codes count up within a length, and go on with a bit more for the next (T.81, annex C).
    pub(super) fn new((lengths, symbols): CodeLengths) -> Self {
        let mut codes = [0; 256];
        let mut code = 0;
        let mut left = symbols.iter();
        for (length, &count) in (1..).zip(lengths) {
            for &symbol in left.by_ref().take(usize::from(count)) {
                codes[usize::from(symbol)] = code << 8 | length;
                code += 1;
            }
            code <<= 1;
        }
        Self { lengths, symbols, codes }
    }
}

/// Appends bits to a file, the first in the highest place of a byte.
pub(super) struct BitWriter<'a> {
    file: &'a mut Vec<u8>,
    /// Bits that wait, the last in the lowest place; what is above them does not count.
    waiting: u64,
    /// How many they are, fewer than 32 between calls.
    count: u32,
}

impl<'a> BitWriter<'a> {
    pub(super) fn new(file: &'a mut Vec<u8>) -> Self {
        Self { file, waiting: 0, count: 0 }
    }

    /// One that goes on from here, for a loop that keeps what waits in registers; this one is to go on from its
    /// [`state`](Self::state).
    #[inline(always)]
    pub(super) fn taken_over(&mut self) -> BitWriter<'_> {
        BitWriter { file: &mut *self.file, waiting: self.waiting, count: self.count }
    }

    /// The bits that wait and their number.
    #[inline(always)]
    pub(super) fn state(&self) -> (u64, u32) {
        (self.waiting, self.count)
    }

    /// Goes on where another has come to.
    #[inline(always)]
    pub(super) fn go_on(&mut self, (waiting, count): (u64, u32)) {
        (self.waiting, self.count) = (waiting, count);
    }

    /// Appends a block: the difference of its first coefficient to that of the block `before`, and the others that are not 0.
    #[inline(always)]
    pub(super) fn block(
        &mut self,
        Block { values, mask }: &Block,
        before: &mut i16,
        (dc, ac): (&CodeTable, &CodeTable),
    ) {
        let difference = i32::from(values[0]) - i32::from(*before);
        *before = values[0];
        self.value(0, difference, dc);
        let mut left = mask & !1;
        let mut last = 0;
        while left != 0 {
            let at = left.trailing_zeros();
            left &= left - 1;
            let mut zeros = at - last - 1;
            last = at;
            while zeros >= 16 {
                self.symbol(SIXTEEN_ZEROS, ac);
                zeros -= 16;
            }
            self.value(zeros, i32::from(values[at as usize & (BLOCK_VALUES - 1)]), ac);
        }
        if last as usize != BLOCK_VALUES - 1 {
            self.symbol(END_OF_BLOCK, ac);
        }
    }

    /// Fills the last byte with ones.
    pub(super) fn finish(mut self) {
        let fill = (8 - self.count % 8) % 8;
        self.put((1 << fill) - 1, fill);
        while self.count > 0 {
            self.count -= 8;
            push(self.file, (self.waiting >> self.count) as u8);
        }
    }

    /// A value behind a number of zeros: how many bits it has, and then these; those of a negative value are one less.
    #[inline(always)]
    fn value(&mut self, zeros: u32, value: i32, table: &CodeTable) {
        let size = u32::BITS - value.unsigned_abs().leading_zeros();
        let bits = (value + (value >> 31)) as u32 & ((1 << size) - 1);
        // Coefficients have 11 bits at the most, and fewer than 16 zeros before them.
        let code = table.codes[(zeros << 4 | size) as usize & 0xff];
        self.put((code >> 8) << size | bits, (code & 0xff) + size);
    }

    #[inline(always)]
    fn symbol(&mut self, symbol: u8, table: &CodeTable) {
        let code = table.codes[usize::from(symbol)];
        self.put(code >> 8, code & 0xff);
    }

    /// Appends up to 32 bits.
    #[inline(always)]
    fn put(&mut self, bits: u32, count: u32) {
        self.waiting = self.waiting << count | u64::from(bits);
        self.count += count;
        if self.count >= u32::BITS {
            self.count -= u32::BITS;
            self.word((self.waiting >> self.count) as u32);
        }
    }

    #[inline(always)]
    fn word(&mut self, word: u32) {
        // Whether a byte has all bits set: then its complement is 0, and taking one off borrows from above.
        let empty = !word;
        if empty.wrapping_sub(0x0101_0101) & !empty & 0x8080_8080 == 0 {
            self.file.extend_from_slice(&word.to_be_bytes());
        } else {
            word.to_be_bytes().into_iter().for_each(|byte| push(self.file, byte));
        }
    }
}

/// Appends a byte. One of ones would be a marker; a zero behind it says that it is none.
#[cold]
fn push(file: &mut Vec<u8>, byte: u8) {
    file.push(byte);
    if byte == 0xff {
        file.push(0);
    }
}

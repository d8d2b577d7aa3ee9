//! Changes to real files that keep most of their structure.

/// Numbers that parsers and what comes behind them tend to get wrong.
const NUMBERS: [&str; 18] = [
    "0",
    "-1",
    "1",
    "-0.0",
    "1e-300",
    "1e300",
    "-1e300",
    "NaN",
    "inf",
    "-inf",
    "2147483648",
    "4294967295",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775808",
    "18446744073709551616",
    "1e7",
    "0.0000000000000000000001",
];
/// Bytes that mean something in one format or another: longest numbers in base 128, ends and beginnings of texts.
const TOKENS: [&[u8]; 16] = [
    b"\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01",
    b"\xfe\xff\xff\xff\xff\xff\xff\xff\xff\x01",
    b"\xff\xff\xff\xff\x0f",
    b"\xff\xff\xff\xff",
    b"\x80\x00\x00\x00",
    b"\0\0\0\0",
    b"[",
    b"{",
    b"&a *a ",
    b"<a>",
    b"]]>",
    b"\"",
    b"\n",
    b"&#0;",
    "\u{202e}".as_bytes(),
    "\u{feff}".as_bytes(),
];
/// Most changes to one input, and most copies of a piece that is repeated.
const MOST_CHANGES: usize = 4;
const MOST_COPIES: usize = 300;
/// Longest input that is made, bytes.
const LONGEST: usize = 1 << 16;

/// Changes files, the same ones for the same seed.
#[derive(Debug, Clone)]
pub struct Mutator {
    state: u64,
}

impl Mutator {
    /// Changes that follow from `seed`.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next number: SplitMix64 (Steele, Lea and Flood 2014).
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number from 0 to `end`, without it; 0 where that is 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    /// One of `items`.
    fn pick<'a, T: ?Sized>(&mut self, items: &[&'a T]) -> &'a T {
        items[self.below(items.len())]
    }

    /// A changed copy of one of `seeds`, of which there is at least one.
    pub fn input(&mut self, seeds: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = seeds[self.below(seeds.len())].clone();
        for _ in 0..=self.below(MOST_CHANGES) {
            self.change(&mut bytes, seeds);
        }
        bytes.truncate(LONGEST);
        bytes
    }

    fn change(&mut self, bytes: &mut Vec<u8>, seeds: &[Vec<u8>]) {
        let at = self.below(bytes.len() + 1);
        let octave = self.below(8);
        let length = self.below(1 << octave).min(bytes.len() - at);
        let piece = bytes[at..at + length].to_vec();
        match self.below(9) {
            0 => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << self.below(8);
                }
            }
            1 => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = self.next() as u8;
                }
            }
            2 => drop(bytes.drain(at..at + length)),
            3 => bytes.truncate(at),
            4 => drop(bytes.splice(at..at + length, self.pick(&TOKENS).to_vec())),
            5 => {
                let copies = self.below(MOST_COPIES).min(LONGEST / length.max(1));
                drop(bytes.splice(at..at, piece.repeat(copies)));
            }
            6 => {
                let other = &seeds[self.below(seeds.len())];
                let from = self.below(other.len() + 1);
                let to = (from + self.below(200)).min(other.len());
                drop(bytes.splice(at..at + length, other[from..to].to_vec()));
            }
            _ => self.change_number(bytes, at),
        }
    }

    /// Puts an odd number in the place of the first one written in digits behind `at`.
    fn change_number(&mut self, bytes: &mut Vec<u8>, at: usize) {
        let is_digit = |byte: &u8| byte.is_ascii_digit();
        let Some(from) = bytes[at..].iter().position(is_digit).map(|from| at + from) else { return };
        let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'e' | b'-' | b'+');
        let to = bytes[from..].iter().position(|byte| !is_part(byte)).map_or(bytes.len(), |to| from + to);
        let number = self.pick(&NUMBERS).as_bytes().to_vec();
        drop(bytes.splice(from..to, number));
    }
}

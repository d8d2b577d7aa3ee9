//! Convolution with a disc: the mean of the seen pixels under it.
//!
//! The disc is cut into columns. The sums of a picture's columns of every height that the disc has are made first, from
//! the middle row outwards, so that each height continues the one before; then one of them is taken for each column of the
//! disc. This takes two additions a row of the disc for each pixel, whatever its radius.

use std::ops::Range;

use crate::picture::{Plane, ValidityMask};
use crate::simd::{CodePath, simd_kernel};

/// Pixels that are summed at once: two AVX-512 registers of 16-bit sums. Over so many the compiler writes loops on vectors;
/// shorter ones it unrolls into single numbers.
const LANES: usize = 64;
/// Most pixels whose sum of 8-bit values fits into 16 bits.
const MAX_NARROW_PX: usize = 257;
/// Added to a sum before it is divided: half-way between a mean that is just rounded up, at .5, and the next smaller one
/// there can be, a whole sum less one. Both are thus a quarter of 1 / area away from the rounding, which is above 2^-14 up
/// to the largest disc's area of 3209, while the division errs by 2^-15 at the most: the rounded mean is exact.
const TO_ROUND_UP: f32 = 0.25;
/// The 32-bit number from 2^23 on are whole numbers: adding it to a smaller one rounds that, and leaves it in the lowest
/// bits.
const TO_WHOLE: f32 = 8_388_608.0;

/// A disc of pixels as its columns.
#[derive(Debug, Clone)]
struct Disc {
    radius: usize,
    /// Every half height that its columns have, ascending.
    half_heights: Vec<usize>,
    /// For each column, from left to right, which of the half heights it has.
    columns: Vec<usize>,
    /// Parts of `columns` whose pixels are few enough for 16-bit sums.
    parts: Vec<Range<usize>>,
    area: usize,
}

impl Disc {
    fn new(radius: usize) -> Self {
        let half_height = |column: usize| (radius * radius - radius.abs_diff(column).pow(2)).isqrt();
        let of_columns: Vec<usize> = (0..=2 * radius).map(half_height).collect();
        let mut half_heights = of_columns.clone();
        half_heights.sort_unstable();
        half_heights.dedup();
        let columns =
            of_columns.iter().map(|half| half_heights.partition_point(|other| other < half)).collect();
        let mut parts: Vec<Range<usize>> = Vec::new();
        let mut pixels = 0;
        for (column, half) in of_columns.iter().enumerate() {
            pixels += 2 * half + 1;
            match parts.last_mut() {
                Some(part) if pixels <= MAX_NARROW_PX => part.end = column + 1,
                _ => {
                    parts.push(column..column + 1);
                    pixels = 2 * half + 1;
                }
            }
        }
        let area = of_columns.iter().map(|half| 2 * half + 1).sum();
        Self { radius, half_heights, columns, parts, area }
    }
}

/// A run of pixels in one row whose means are taken in the same way.
#[derive(Debug, Clone)]
struct Segment {
    pixels: Range<usize>,
    /// Where the pixels' own reciprocals begin, or none where the disc is seen whole.
    reciprocals: Option<usize>,
}

/// What the validity mask alone decides: where the disc is seen whole, and how much of it is seen elsewhere.
#[derive(Debug, Clone, Default)]
struct SeenUnderDisc {
    segments: Vec<Segment>,
    /// For each row where its segments begin, and behind the last where they end.
    row_starts: Vec<usize>,
    /// One by the number of seen pixels under the disc, for the pixels where not all of it is seen.
    reciprocals: Vec<f32>,
}

/// Means under a disc; keeps its buffers from picture to picture.
#[derive(Debug, Clone)]
pub(super) struct DiscMean {
    disc: Disc,
    seen: SeenUnderDisc,
    /// The picture, with a margin of the disc's radius and, at the right, of one step's pixels besides. It is 0 there, and
    /// where nothing is seen.
    values: Plane<u8>,
    scratch: Scratch,
}

/// The sums of one row.
#[derive(Debug, Clone, Default)]
struct Scratch {
    /// Sums of the columns of each half height.
    columns: Vec<u16>,
    /// Sums under the disc.
    under_disc: Vec<i32>,
}

impl DiscMean {
    pub(super) fn new(radius: usize) -> Self {
        Self {
            disc: Disc::new(radius),
            seen: SeenUnderDisc::default(),
            values: Plane::default(),
            scratch: Scratch::default(),
        }
    }

    /// Gets ready for pictures that are seen where `validity` says.
    pub(super) fn prepare(&mut self, validity: &ValidityMask) {
        let (width, height) = validity.size();
        let margins = 2 * self.disc.radius;
        self.values.reset(width + margins + LANES, height + margins, 0);
        self.scratch.columns.resize(self.disc.half_heights.len() * self.values.width(), 0);
        self.scratch.under_disc.resize(width + LANES, 0);
        // Seen pixels count 1: their sums are the numbers of seen pixels. The values themselves are filled in later.
        for y in 0..height {
            for run in validity.runs(y) {
                self.row_mut(y)[run.start..run.end].fill(1);
            }
        }
        let Self { disc, seen, values, scratch } = self;
        seen.segments.clear();
        seen.reciprocals.clear();
        seen.row_starts.clear();
        for y in 0..height {
            seen.row_starts.push(seen.segments.len());
            for run in validity.runs(y) {
                sum_under_disc(disc, values, y, run.start..run.end, scratch);
                let counts = &scratch.under_disc[..run.end - run.start];
                let mut start = run.start;
                for part in counts.chunk_by(|&a, &b| is_whole(disc, a) == is_whole(disc, b)) {
                    let pixels = start..start + part.len();
                    let whole = is_whole(disc, part[0]);
                    let reciprocals = (!whole).then_some(seen.reciprocals.len());
                    if !whole {
                        seen.reciprocals.extend(part.iter().map(|&count| 1.0 / count as f32));
                    }
                    start = pixels.end;
                    seen.segments.push(Segment { pixels, reciprocals });
                }
            }
        }
        seen.row_starts.push(seen.segments.len());
    }

    /// The pixels of row `y`, to be filled where they are seen.
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [u8] {
        let radius = self.disc.radius;
        let end = self.values.width() - radius - LANES;
        &mut self.values.row_mut(y + radius)[radius..end]
    }

    /// Fills `means` with the rounded means of the seen pixels under the disc, and with 0 where a pixel is unseen.
    pub(super) fn take(&mut self, path: CodePath, means: &mut Plane<u8>) {
        take_means(path, &self.disc, &self.seen, &self.values, &mut self.scratch, means);
    }
}

fn is_whole(disc: &Disc, count: i32) -> bool {
    count as usize == disc.area
}

simd_kernel! {
    fn take_means(
        disc: &Disc, seen: &SeenUnderDisc, values: &Plane<u8>, scratch: &mut Scratch, means: &mut Plane<u8>,
    ) {
        let whole = 1.0 / disc.area as f32;
        for y in 0..means.height() {
            let means = means.row_mut(y);
            means.fill(0);
            let segments = &seen.segments[seen.row_starts[y]..seen.row_starts[y + 1]];
            let [first, ..] = segments else { continue };
            let hull = first.pixels.start..segments[segments.len() - 1].pixels.end;
            sum_under_disc(disc, values, y, hull.clone(), scratch);
            for Segment { pixels, reciprocals } in segments {
                let sums = &scratch.under_disc[pixels.start - hull.start..pixels.end - hull.start];
                let means = &mut means[pixels.clone()];
                match reciprocals {
                    None => means.iter_mut().zip(sums).for_each(|(mean, &sum)| *mean = rounded(sum, whole)),
                    Some(start) => {
                        let reciprocals = &seen.reciprocals[*start..*start + sums.len()];
                        for ((mean, &sum), &reciprocal) in means.iter_mut().zip(sums).zip(reciprocals) {
                            *mean = rounded(sum, reciprocal);
                        }
                    }
                }
            }
        }
    }
}

/// The quotient of `sum` and the divisor of `reciprocal`, rounded half up.
#[inline(always)]
fn rounded(sum: i32, reciprocal: f32) -> u8 {
    ((sum as f32 + TO_ROUND_UP) * reciprocal + TO_WHOLE).to_bits() as u8
}

/// Sums the values under the disc about the `pixels` of row `y`, into the beginning of `scratch.under_disc`.
#[inline(always)]
fn sum_under_disc(disc: &Disc, values: &Plane<u8>, y: usize, pixels: Range<usize>, scratch: &mut Scratch) {
    let stride = values.width();
    let middle = values.as_slice();
    // Pixel x of the picture stands in column x + radius of `values`, so that the disc about it begins in column x.
    let first = (y + disc.radius) * stride + pixels.start;
    let count = pixels.len();
    for block in (0..count + 2 * disc.radius).step_by(LANES) {
        let at = first + block;
        let mut sums = [0_u16; LANES];
        add(&mut sums, &middle[at..at + LANES]);
        let mut reach = 0;
        for (level, &half) in disc.half_heights.iter().enumerate() {
            while reach < half {
                reach += 1;
                add(&mut sums, &middle[at - reach * stride..][..LANES]);
                add(&mut sums, &middle[at + reach * stride..][..LANES]);
            }
            scratch.columns[level * stride + block..][..LANES].copy_from_slice(&sums);
        }
    }
    for block in (0..count).step_by(LANES) {
        let mut sums = [0_i32; LANES];
        for part in &disc.parts {
            let mut narrow = [0_u16; LANES];
            for column in part.clone() {
                let start = disc.columns[column] * stride + block + column;
                let sums = &scratch.columns[start..start + LANES];
                narrow.iter_mut().zip(sums).for_each(|(sum, &column)| *sum += column);
            }
            sums.iter_mut().zip(narrow).for_each(|(sum, part)| *sum += i32::from(part));
        }
        scratch.under_disc[block..block + LANES].copy_from_slice(&sums);
    }
}

#[inline(always)]
fn add(sums: &mut [u16; LANES], values: &[u8]) {
    sums.iter_mut().zip(values).for_each(|(sum, &value)| *sum += u16::from(value));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_rounded_half_up_for_every_number_of_pixels() {
        let largest = Disc::new(32).area as i32;
        assert_eq!(largest, 3209);
        for count in 1..=largest {
            let reciprocal = 1.0 / count as f32;
            assert_eq!(rounded(255 * count, reciprocal), 255);
            for mean in 0..255 {
                // The smallest sum whose mean is at least mean + 1/2, and the one before.
                let sum = ((2 * mean + 1) * count + 1) / 2;
                assert_eq!(i32::from(rounded(sum, reciprocal)), mean + 1, "{sum} of {count}");
                assert_eq!(i32::from(rounded(sum - 1, reciprocal)), mean, "{} of {count}", sum - 1);
            }
        }
    }

    #[test]
    fn a_disc_holds_the_pixels_within_its_radius() {
        for radius in 0..=32_usize {
            let disc = Disc::new(radius);
            let side = || 0..=2 * radius;
            let is_within =
                |x: usize, y: usize| x.abs_diff(radius).pow(2) + y.abs_diff(radius).pow(2) <= radius * radius;
            let area = side().flat_map(|y| side().map(move |x| (x, y))).filter(|&(x, y)| is_within(x, y));
            assert_eq!(disc.area, area.count());
            let columns: Vec<usize> = disc.parts.iter().flat_map(Clone::clone).collect();
            assert!(columns.iter().copied().eq(side()));
        }
    }
}

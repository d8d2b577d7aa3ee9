//! Convolution with a disc: the mean of the seen pixels under it.
//!
//! The disc is cut into columns. The sums of a picture's columns of every height that the disc has are made first, from
//! the middle row outwards, so that each height continues the one before; then one of them is taken for each column of the
//! disc. This takes two additions a row of the disc for each pixel, whatever its radius.

use std::ops::Range;

use super::disc::{Disc, rounded, rounded_by};
use crate::picture::{Plane, ValidityMask};
use crate::simd::{CodePath, simd_kernel};

/// Pixels that are summed at once: two AVX-512 registers of 16-bit sums. Over so many the compiler writes loops on vectors;
/// shorter ones it unrolls into single numbers.
const LANES: usize = 64;

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
    /// Sums under the disc: of one whose sums fit 16 bits, and of any.
    narrow: Vec<u16>,
    wide: Vec<i32>,
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
        self.scratch.narrow.resize(width + LANES, 0);
        self.scratch.wide.resize(width + LANES, 0);
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
                let count = run.end - run.start;
                sum_columns(disc, values, y, run.start..run.end, scratch);
                sum_wide(disc, values.width(), count, scratch);
                let counts = &scratch.wide[..count];
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
        let half = (disc.area / 2) as u16;
        for y in 0..means.height() {
            let means = means.row_mut(y);
            let segments = &seen.segments[seen.row_starts[y]..seen.row_starts[y + 1]];
            let [first, ..] = segments else {
                means.fill(0);
                continue;
            };
            let hull = first.pixels.start..segments[segments.len() - 1].pixels.end;
            let (start, count) = (hull.start, hull.len());
            sum_columns(disc, values, y, hull, scratch);
            match disc.reciprocal {
                Some(whole) => {
                    sum_narrow(disc, values.width(), count, scratch);
                    let mean = |sum| rounded_by(sum + half, whole);
                    take_segments(segments, &seen.reciprocals, &scratch.narrow, start, means, mean);
                }
                None => {
                    sum_wide(disc, values.width(), count, scratch);
                    let mean = |sum| rounded(sum, whole);
                    take_segments(segments, &seen.reciprocals, &scratch.wide, start, means, mean);
                }
            }
        }
    }
}

/// Fills the segments of a row with means of `sums`, which begin at column `start`, and the rest with 0; `mean_of_whole` is
/// for whole discs.
#[inline(always)]
fn take_segments<Sum: Copy + Into<i32>>(
    segments: &[Segment],
    reciprocals: &[f32],
    sums: &[Sum],
    start: usize,
    means: &mut [u8],
    mean_of_whole: impl Fn(Sum) -> u8,
) {
    let mut done = 0;
    for segment in segments {
        let pixels = segment.pixels.clone();
        means[done..pixels.start].fill(0);
        done = pixels.end;
        let sums = &sums[pixels.start - start..pixels.end - start];
        let means = &mut means[pixels];
        match segment.reciprocals {
            None => means.iter_mut().zip(sums).for_each(|(mean, &sum)| *mean = mean_of_whole(sum)),
            Some(first) => {
                let reciprocals = &reciprocals[first..first + sums.len()];
                for ((mean, &sum), &reciprocal) in means.iter_mut().zip(sums).zip(reciprocals) {
                    *mean = rounded(sum.into(), reciprocal);
                }
            }
        }
    }
    means[done..].fill(0);
}

/// Sums the values of the columns of every half height about the `pixels` of row `y`, from the left of their discs on, into
/// `scratch.columns`.
#[inline(always)]
fn sum_columns(disc: &Disc, values: &Plane<u8>, y: usize, pixels: Range<usize>, scratch: &mut Scratch) {
    let stride = values.width();
    let middle = values.as_slice();
    // Pixel x of the picture stands in column x + radius of `values`, so that the disc about it begins in column x.
    let first = (y + disc.radius) * stride + pixels.start;
    for block in (0..pixels.len() + 2 * disc.radius).step_by(LANES) {
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
}

/// Sums [`LANES`] discs from pixel `block` on over some of their columns.
#[inline(always)]
fn sum_part(disc: &Disc, part: &Range<usize>, stride: usize, block: usize, columns: &[u16]) -> [u16; LANES] {
    let mut sums = [0_u16; LANES];
    for column in part.clone() {
        let start = disc.columns[column] * stride + block + column;
        sums.iter_mut().zip(&columns[start..start + LANES]).for_each(|(sum, &column)| *sum += column);
    }
    sums
}

/// Sums `count` discs whose sums fit 16 bits.
#[inline(always)]
fn sum_narrow(disc: &Disc, stride: usize, count: usize, scratch: &mut Scratch) {
    let whole = 0..disc.columns.len();
    for block in (0..count).step_by(LANES) {
        let sums = sum_part(disc, &whole, stride, block, &scratch.columns);
        scratch.narrow[block..block + LANES].copy_from_slice(&sums);
    }
}

/// Sums `count` discs of any size.
#[inline(always)]
fn sum_wide(disc: &Disc, stride: usize, count: usize, scratch: &mut Scratch) {
    for block in (0..count).step_by(LANES) {
        let mut sums = [0_i32; LANES];
        for part in &disc.parts {
            let narrow = sum_part(disc, part, stride, block, &scratch.columns);
            sums.iter_mut().zip(narrow).for_each(|(sum, part)| *sum += i32::from(part));
        }
        scratch.wide[block..block + LANES].copy_from_slice(&sums);
    }
}

#[inline(always)]
fn add(sums: &mut [u16; LANES], values: &[u8]) {
    sums.iter_mut().zip(values).for_each(|(sum, &value)| *sum += u16::from(value));
}

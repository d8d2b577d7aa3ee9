//! Pictures of 8 bits at half their size.
//!
//! Two neighbouring bytes are taken as one word of 16 bits, whose low and high halves are the even and the odd column: so a
//! row falls apart into its columns without any shuffling. All sums fit 16 bits.

use crate::error::{PictureError, check_size};
use crate::filter::mirror;
use crate::picture::{Plane, PlaneView};
use crate::simd::{CodePath, simd_kernel};

/// Weights of the binomial, 1 4 6 4 1, by distance from its middle.
const BINOMIAL: [u16; 3] = [6, 4, 1];
/// Rows to either side of the binomial's middle.
const REACH: isize = 2;
/// Rows under the binomial.
const ROWS: usize = 5;
/// Pixels that [`reduce`] finishes at a time: few enough for their sums to stay in the nearest memory.
const TILE: usize = 256;

/// Fills `target` with `source` at half its size: each pixel is the rounded mean of 2 x 2 pixels. Of an odd width or height
/// the last column or row is left out. A pixel `(c, r)` of the target lies at `(2 c + 1/2, 2 r + 1/2)` of the source.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the target's sides are not half of the source's, rounded down.
///
/// ```
/// use fingerpost_vision::{picture::Plane, pyramid::halve};
/// let source = Plane::from_vec(4, 2, vec![0_u8, 1, 10, 20, 2, 3, 30, 41])?;
/// let mut half = Plane::new(2, 1, 0);
/// halve(source.view(), &mut half)?;
/// assert_eq!(half.as_slice(), &[2, 25]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
pub fn halve(source: PlaneView<'_, u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
    check_size("halved picture", (source.width() / 2, source.height() / 2), target.size())?;
    halve_with(CodePath::fastest(), source, target);
    Ok(())
}

simd_kernel! {
    fn halve_with(source: PlaneView<'_, u8>, target: &mut Plane<u8>) {
        for y in 0..target.height() {
            let out = target.row_mut(y);
            let upper = &source.row(2 * y).as_chunks::<2>().0[..out.len()];
            let lower = &source.row(2 * y + 1).as_chunks::<2>().0[..out.len()];
            for ((out, &upper), &lower) in out.iter_mut().zip(upper).zip(lower) {
                let (upper, lower) = (u16::from_le_bytes(upper), u16::from_le_bytes(lower));
                *out = (((upper & 0xff) + (upper >> 8) + (lower & 0xff) + (lower >> 8) + 2) >> 2) as u8;
            }
        }
    }
}

/// Fills `target` with `source` at half its size, rounded up: a 5 x 5 binomial about every second pixel of every second
/// row. A pixel `(c, r)` of the target lies at `(2 c, 2 r)` of the source.
///
/// Beyond its edges the picture is continued by a mirror through the centre of the edge pixel. The result is that of
/// OpenCV's `pyrDown`, which follows P. Burt and E. Adelson, "The Laplacian pyramid as a compact image code", 1983.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the target's sides are not half of the source's, rounded up.
pub fn reduce(source: PlaneView<'_, u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
    check_size("reduced picture", (source.width().div_ceil(2), source.height().div_ceil(2)), target.size())?;
    reduce_with(CodePath::fastest(), source, target);
    Ok(())
}

simd_kernel! {
    fn reduce_with(source: PlaneView<'_, u8>, target: &mut Plane<u8>) {
        // Weighted sums along the columns, the even ones and the odd ones, from one pair of columns left of a tile to one
        // right of it.
        let (mut even, mut odd) = ([0_u16; TILE + 2], [0_u16; TILE + 2]);
        let height = source.height();
        for y in 0..target.height() {
            let mut rows = [source.row(2 * y); ROWS];
            for (row, offset) in rows.iter_mut().zip(-REACH..) {
                *row = source.row(mirror((2 * y) as isize + offset, height));
            }
            for (tile, out) in target.row_mut(y).chunks_mut(TILE).enumerate() {
                sum_columns(rows, tile * TILE, &mut even[..out.len() + 2], &mut odd[..out.len() + 2]);
                sum_rows(&even, &odd, out);
            }
        }
    }
}

// No `array::map` below: it is not inlined into code for other instruction sets, and a call for each pixel takes twice as
// long as the rest.

/// Sums the rows' columns for the outputs from `start` on.
#[inline(always)]
fn sum_columns(rows: [&[u8]; ROWS], start: usize, even: &mut [u16], odd: &mut [u16]) {
    let pairs = rows[0].len() / 2;
    // Pair `index` of the sums is pair `start + index - 1` of the rows.
    let (first, end) = (usize::from(start == 0), even.len().min(pairs + 1 - start));
    let (from, count) = (start + first - 1, end - first);
    let cut = |row: usize| &rows[row].as_chunks::<2>().0[from..][..count];
    let (a, b, c, d, e) = (cut(0), cut(1), cut(2), cut(3), cut(4));
    let (inner_even, inner_odd) = (&mut even[first..][..count], &mut odd[first..][..count]);
    for i in 0..count {
        let [a, b, c] = [u16::from_le_bytes(a[i]), u16::from_le_bytes(b[i]), u16::from_le_bytes(c[i])];
        let [d, e] = [u16::from_le_bytes(d[i]), u16::from_le_bytes(e[i])];
        inner_even[i] = binomial([a & 0xff, b & 0xff, c & 0xff, d & 0xff, e & 0xff]);
        inner_odd[i] = binomial([a >> 8, b >> 8, c >> 8, d >> 8, e >> 8]);
    }
    for index in (0..first).chain(end..even.len()) {
        let column = 2 * (start + index) as isize - 2;
        even[index] = binomial_at(rows, mirror(column, rows[0].len()));
        odd[index] = binomial_at(rows, mirror(column + 1, rows[0].len()));
    }
}

#[inline(always)]
fn sum_rows(even: &[u16; TILE + 2], odd: &[u16; TILE + 2], out: &mut [u8]) {
    let length = out.len();
    let (left, middle, right) = (&even[..length], &even[1..][..length], &even[2..][..length]);
    let (inner_left, inner_right) = (&odd[..length], &odd[1..][..length]);
    for i in 0..length {
        let sum = binomial([left[i], inner_left[i], middle[i], inner_right[i], right[i]]);
        // The sums over 5 x 5 reach 255 * 256, and the rounding's half still fits.
        out[i] = ((sum + 128) >> 8) as u8;
    }
}

#[inline(always)]
fn binomial_at(rows: [&[u8]; ROWS], column: usize) -> u16 {
    let at = |row: usize| u16::from(rows[row][column]);
    binomial([at(0), at(1), at(2), at(3), at(4)])
}

#[inline(always)]
fn binomial([a, b, c, d, e]: [u16; ROWS]) -> u16 {
    BINOMIAL[2] * (a + e) + BINOMIAL[1] * (b + d) + BINOMIAL[0] * c
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Rect;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    /// A picture inside a larger one, and the rectangle that it fills.
    fn inside() -> impl Strategy<Value = (Plane<u8>, Rect)> {
        (1..90_usize, 1..40_usize, 0..4_usize, 0..3_usize, 0..2_usize).prop_flat_map(
            |(width, height, x, y, rest)| {
                let (full_width, full_height) = (x + width + rest, y + height);
                proptest::collection::vec(any::<u8>(), full_width * full_height).prop_map(move |values| {
                    (Plane::from_vec(full_width, full_height, values).unwrap(), Rect { x, y, width, height })
                })
            },
        )
    }

    fn config() -> ProptestConfig {
        ProptestConfig { rng_seed: RngSeed::Fixed(3), ..ProptestConfig::default() }
    }

    fn halve_plainly(source: PlaneView<'_, u8>, x: usize, y: usize) -> u8 {
        let at = |x: usize, y: usize| u32::from(source.row(y)[x]);
        let (x, y) = (2 * x, 2 * y);
        ((at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1) + 2) / 4) as u8
    }

    fn reduce_plainly(source: PlaneView<'_, u8>, x: usize, y: usize) -> u8 {
        const WEIGHTS: [u32; 5] = [1, 4, 6, 4, 1];
        let mut sum = 128;
        for (j, wy) in WEIGHTS.iter().enumerate() {
            for (i, wx) in WEIGHTS.iter().enumerate() {
                let column = mirror(2 * x as isize + i as isize - 2, source.width());
                let row = mirror(2 * y as isize + j as isize - 2, source.height());
                sum += wx * wy * u32::from(source.row(row)[column]);
            }
        }
        (sum / 256) as u8
    }

    fn plainly(
        size: (usize, usize),
        source: PlaneView<'_, u8>,
        pixel: fn(PlaneView<'_, u8>, usize, usize) -> u8,
    ) -> Plane<u8> {
        let pixels = (0..size.0 * size.1).map(|i| pixel(source, i % size.0, i / size.0)).collect();
        Plane::from_vec(size.0, size.1, pixels).unwrap()
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn every_path_equals_the_plain_sums((plane, rect) in inside()) {
            let source = plane.view().crop(rect).unwrap();
            let half = (rect.width / 2, rect.height / 2);
            let reduced = (rect.width.div_ceil(2), rect.height.div_ceil(2));
            for path in CodePath::available() {
                let mut target = Plane::new(half.0, half.1, 0);
                halve_with(path, source, &mut target);
                prop_assert_eq!(target, plainly(half, source, halve_plainly));
                let mut target = Plane::new(reduced.0, reduced.1, 0);
                reduce_with(path, source, &mut target);
                prop_assert_eq!(target, plainly(reduced, source, reduce_plainly));
            }
        }
    }

    #[test]
    fn rows_longer_than_a_tile_are_reduced_whole() {
        for width in [2 * TILE - 1, 2 * TILE, 2 * TILE + 1, 2 * TILE + 2, 4 * TILE + 3] {
            let values = (0..width * 3).map(|index| (index * 7919 % 251) as u8).collect();
            let source = Plane::from_vec(width, 3, values).unwrap();
            let mut target = Plane::new(width.div_ceil(2), 2, 0);
            reduce(source.view(), &mut target).unwrap();
            assert_eq!(target, plainly(target.size(), source.view(), reduce_plainly), "width {width}");
        }
    }

    #[test]
    fn targets_of_another_size_are_errors_and_nothing_halves_to_nothing() {
        let source = Plane::new(5, 4, 7_u8);
        assert!(halve(source.view(), &mut Plane::new(3, 2, 0)).is_err());
        assert!(reduce(source.view(), &mut Plane::new(2, 2, 0)).is_err());
        let nothing = Plane::new(0, 1, 0_u8);
        assert_eq!(halve(nothing.view(), &mut Plane::new(0, 0, 0)), Ok(()));
        assert_eq!(reduce(nothing.view(), &mut Plane::new(0, 1, 0)), Ok(()));
    }
}

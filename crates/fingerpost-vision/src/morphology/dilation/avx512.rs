//! Dilation with AVX-512: two rows of the result at a time, so that the rows that both need are loaded once, and no
//! intermediate row at all. Along a row, maxima of 2, 4, 8, ... pixels are those of half as many and the same shifted; a
//! window is covered by two of them.

use std::arch::x86_64::*;

use super::super::element::{MAX_SIZE_PX, Rectangle, StructuringElement};
use super::{FROM_NOTHING, FURTHER};
use crate::avx512::{BYTES, left_by, load, right_by, store};
use crate::picture::{Plane, PlaneView};

/// Stands for a reach that a kernel is not compiled for.
const ANY_REACH: usize = usize::MAX;
/// How often a window of at most [`MAX_SIZE_PX`] can be halved.
const MAX_DOUBLINGS: usize = MAX_SIZE_PX.ilog2() as usize;

/// Dilates a picture into another one of its size. 1.4x (square of 3 pixels, ellipse of
/// 15) to 2.2x (square of 31) over the plain loops with AVX2 at 512x512 on Zen 4.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
pub(super) fn dilate(element: &StructuringElement, source: PlaneView<'_, u8>, target: &mut Plane<u8>) {
    let (width, height) = source.size();
    if width == 0 {
        return;
    }
    for (pair, out) in target.as_mut_slice().chunks_mut(2 * width).enumerate() {
        let y = 2 * pair;
        let (first, second) = out.split_at_mut(width);
        for (number, &Rectangle { reach_x, reach_y }) in element.rectangles.iter().enumerate() {
            let mut rows = [&[][..]; MAX_SIZE_PX];
            let below = height.min(y + reach_y + 1);
            let shared = (y + 1).saturating_sub(reach_y)..below;
            let count = shared.len();
            for (row, from) in rows.iter_mut().zip(shared) {
                *row = source.row(from);
            }
            let shared = &rows[..count];
            let top = source.row(y.saturating_sub(reach_y));
            if second.is_empty() {
                raise_rows(shared, [top], reach_x, number, [first]);
            } else {
                let bottom = source.row(below.min(height - 1));
                raise_rows(shared, [top, bottom], reach_x, number, [first, second]);
            }
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
fn raise_rows<const ROWS: usize>(
    shared: &[&[u8]],
    own: [&[u8]; ROWS],
    reach: usize,
    number: usize,
    out: [&mut [u8]; ROWS],
) {
    match (number, reach) {
        (0, 0) => raise::<ROWS, 0, FROM_NOTHING>(shared, own, 0, out),
        (0, 1) => raise::<ROWS, 1, FROM_NOTHING>(shared, own, 1, out),
        (0, 2) => raise::<ROWS, 2, FROM_NOTHING>(shared, own, 2, out),
        (0, _) => raise::<ROWS, ANY_REACH, FROM_NOTHING>(shared, own, reach, out),
        (_, 0) => raise::<ROWS, 0, FURTHER>(shared, own, 0, out),
        (_, _) => raise::<ROWS, ANY_REACH, FURTHER>(shared, own, reach, out),
    }
}

/// Finds the largest pixel of windows that reach over the `shared` rows and one of each row's `own`, and `reach` pixels to
/// either side; or of those and `out`.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
fn raise<const ROWS: usize, const REACH: usize, const KEEP: bool>(
    shared: &[&[u8]],
    own: [&[u8]; ROWS],
    reach: usize,
    out: [&mut [u8]; ROWS],
) {
    let reach = if REACH == ANY_REACH { reach } else { REACH };
    let doublings = (2 * reach + 1).ilog2() as usize;
    let by: [__m512i; MAX_DOUBLINGS] = std::array::from_fn(|doubling| right_by(1 << doubling));
    // Maxima end at their pixel. The windows' last ones are `reach` to the right of their middles, the others so that they
    // begin where the windows do.
    let distances = [reach, (1 << doublings) - 1 - reach];
    let [late, early] = distances.map(|distance| left_by(distance));
    let nothing = _mm512_setzero_si512();
    let mut last = [[nothing; MAX_DOUBLINGS]; ROWS];
    let mut last_maxima = [nothing; ROWS];
    let width = out[0].len();
    // Results come one block late: they need the next block's pixels.
    for x in (0..width + BYTES).step_by(BYTES) {
        let columns = shared.iter().fold(nothing, |maxima, row| _mm512_max_epu8(maxima, load(row, x)));
        for row in 0..ROWS {
            let mut maxima = _mm512_max_epu8(columns, load(own[row], x));
            for doubling in 0..doublings {
                let shifted = _mm512_permutex2var_epi8(last[row][doubling], by[doubling], maxima);
                last[row][doubling] = maxima;
                maxima = _mm512_max_epu8(maxima, shifted);
            }
            if let Some(x) = x.checked_sub(BYTES) {
                let shifted = |from| _mm512_permutex2var_epi8(last_maxima[row], from, maxima);
                let early = if distances[1] == 0 { last_maxima[row] } else { shifted(early) };
                let mut windows =
                    if distances[0] == distances[1] { early } else { _mm512_max_epu8(early, shifted(late)) };
                if KEEP {
                    windows = _mm512_max_epu8(windows, load(out[row], x));
                }
                store(out[row], x, windows);
            }
            last_maxima[row] = maxima;
        }
    }
}

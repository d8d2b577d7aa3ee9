//! Box blur with AVX-512, two rows at a time. Pixels of even columns and those of odd ones are summed in registers of their
//! own: a byte becomes a 16-bit number by a mask or a shift, two neighbouring windows share all but two of their columns,
//! and columns are shifted inside registers.

use std::arch::x86_64::*;

use super::division_by;
use crate::avx512::{BYTES, COUNTING, load, store};
use crate::blocks::PaddedRows;
use crate::border::Border;
use crate::picture::{Plane, PlaneView};

/// Sums in a register.
const LANES: usize = BYTES / 2;

/// Every second byte of a register.
const ODD_BYTES: u64 = 0xaaaa_aaaa_aaaa_aaaa;

/// Sums of a block's even and odd columns.
type Halves = [__m512i; 2];

/// How a product's upper half becomes a quotient, or one in the upper byte. Both are made of a size that the compiler does
/// not know: where it knows them, it shifts the products themselves, in 32 bits (1.2x slower).
struct Shifts {
    right: __m128i,
    left: __m128i,
}

impl Shifts {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw")]
    fn for_size(size_px: usize) -> Self {
        let (_, shift) = division_by((size_px * size_px) as u16);
        Self { right: _mm_cvtsi32_si128(shift as i32), left: _mm_cvtsi32_si128(8 - shift as i32) }
    }
}

/// Widest window of the twin: of wider ones it cannot keep the sums in registers, and the plain loops are faster (1.1x at 13 and
/// at 15 pixels on Zen 5).
const WIDEST_PX: usize = 11;

/// Whether [`blur`] can take pictures of this width: there must be two blocks, for the second to be continued from both.
pub(super) fn can_blur(width: usize, size_px: usize) -> bool {
    width > BYTES && (3..=WIDEST_PX).contains(&size_px)
}

/// Blurs a picture where [`can_blur`]. `band` is for sums of columns. 1.9x (3 pixels) to 2.5x (9) over the plain loops
/// with AVX2 at 512x512 on Zen 5.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
pub(super) fn blur(
    size_px: usize,
    source: PlaneView<'_, u8>,
    target: &mut Plane<u8>,
    band: &mut PaddedRows<u16>,
) {
    band.reset(source.width().next_multiple_of(BYTES), 0, 1);
    let sums = band.inner_mut(0);
    let shifts = Shifts::for_size(size_px);
    match size_px / 2 {
        1 => blur_within::<1>(source, target, &shifts, sums),
        2 => blur_within::<2>(source, target, &shifts, sums),
        3 => blur_within::<3>(source, target, &shifts, sums),
        4 => blur_within::<4>(source, target, &shifts, sums),
        5 => blur_within::<5>(source, target, &shifts, sums),
        _ => {}
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
fn blur_within<const REACH: usize>(
    source: PlaneView<'_, u8>,
    target: &mut Plane<u8>,
    shifts: &Shifts,
    sums: &mut [u16],
) {
    let (width, height) = source.size();
    let row = |y: usize, offset: isize| source.row(Border::Mirror.inside(y as isize + offset, height));
    // The sums of a row above the first one, so that the first is reached by a step like any other.
    let reach = REACH as isize;
    for offset in -reach - 1..reach {
        for x in (0..width).step_by(BYTES) {
            let pixels = halves(load(row(0, offset), x));
            store_halves(sums, x, add(load_halves(sums, x), pixels));
        }
    }
    for (pair, out) in target.as_mut_slice().chunks_mut(2 * width).enumerate() {
        let y = 2 * pair;
        let (entering, leaving) = (row(y, reach), row(y, -reach - 1));
        let (first, second) = out.split_at_mut(width);
        if second.is_empty() {
            blur_together::<REACH, 1>([entering], [leaving], shifts, sums, [first]);
        } else {
            let (entering_next, leaving_next) = (row(y + 1, reach), row(y + 1, -reach - 1));
            let (entering, leaving) = ([entering, entering_next], [leaving, leaving_next]);
            blur_together::<REACH, 2>(entering, leaving, shifts, sums, [first, second]);
        }
    }
}

/// Even and odd ones of 64 bytes as 16-bit numbers.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn halves(bytes: __m512i) -> Halves {
    [_mm512_and_si512(bytes, _mm512_set1_epi16(0xff)), _mm512_srli_epi16::<8>(bytes)]
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn load_halves(sums: &[u16], x: usize) -> Halves {
    [load(sums, x), load(sums, x + LANES)]
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn store_halves(sums: &mut [u16], x: usize, [even, odd]: Halves) {
    store(sums, x, even);
    store(sums, x + LANES, odd);
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn add(a: Halves, b: Halves) -> Halves {
    [_mm512_add_epi16(a[0], b[0]), _mm512_add_epi16(a[1], b[1])]
}

/// 0, 1, 2, ...
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn counting() -> __m512i {
    _mm512_cvtepu8_epi16(_mm512_castsi512_si256(load(&COUNTING, 0)))
}

/// `start`, `start` + 1, ...: the lanes that a block's come from in two others, for [`_mm512_permutex2var_epi16`].
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn up_from(start: usize) -> __m512i {
    _mm512_add_epi16(_mm512_set1_epi16(start as i16), counting())
}

/// `start`, `start` - 1, ...
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn down_from(start: usize) -> __m512i {
    _mm512_sub_epi16(_mm512_set1_epi16(start as i16), counting())
}

/// The sums of the columns that lie `distance` to the right of a block's even columns.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn columns(distance: isize, before: Halves, block: Halves, after: Halves) -> __m512i {
    let half = distance.rem_euclid(2) as usize;
    let lanes = distance.div_euclid(2);
    match lanes {
        ..=-1 => {
            let from = up_from(LANES - lanes.unsigned_abs());
            _mm512_permutex2var_epi16(before[half], from, block[half])
        }
        0 => block[half],
        1.. => _mm512_permutex2var_epi16(block[half], up_from(lanes.unsigned_abs()), after[half]),
    }
}

/// Rounded means of the windows about a block's pixels.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn window_means<const REACH: usize>(
    before: Halves,
    block: Halves,
    after: Halves,
    shifts: &Shifts,
) -> __m512i {
    let reach = REACH as isize;
    // The windows of an even pixel and of the odd one beside it have all columns in common but the first and the last.
    let area = (2 * REACH + 1).pow(2) as u16;
    let (factor, _) = division_by(area);
    let mut common = _mm512_set1_epi16((area / 2) as i16);
    for number in 0..2 * REACH {
        let distance = number as isize + 1 - reach;
        common = _mm512_add_epi16(common, columns(distance, before, block, after));
    }
    let [even, odd] = [-reach, reach + 1].map(|distance| {
        let windows = _mm512_add_epi16(common, columns(distance, before, block, after));
        _mm512_mulhi_epu16(windows, _mm512_set1_epi16(factor as i16))
    });
    let even = _mm512_srl_epi16(even, shifts.right);
    let odd = _mm512_sll_epi16(odd, shifts.left);
    _mm512_mask_blend_epi8(ODD_BYTES, even, odd)
}

/// Takes the sums of the columns from `x` on down by `ROWS` rows; gives those of each row.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn step_down<const ROWS: usize>(
    entering: [&[u8]; ROWS],
    leaving: [&[u8]; ROWS],
    sums: &mut [u16],
    x: usize,
) -> [Halves; ROWS] {
    let mut columns = load_halves(sums, x);
    let mut of_rows = [columns; ROWS];
    for row in 0..ROWS {
        let (enter, leave) = (halves(load(entering[row], x)), halves(load(leaving[row], x)));
        let more = add(columns, enter);
        columns = [_mm512_sub_epi16(more[0], leave[0]), _mm512_sub_epi16(more[1], leave[1])];
        of_rows[row] = columns;
    }
    store_halves(sums, x, columns);
    of_rows
}

/// Blurs `ROWS` neighbouring rows: `sums` are those of the columns for the row above them, and then for the last of them.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
fn blur_together<const REACH: usize, const ROWS: usize>(
    entering: [&[u8]; ROWS],
    leaving: [&[u8]; ROWS],
    shifts: &Shifts,
    sums: &mut [u16],
    out: [&mut [u8]; ROWS],
) {
    let width = out[0].len();
    let last_x = (width - 1) / BYTES * BYTES;
    let rest = width - last_x;
    let mut column_sums = |x: usize| step_down(entering, leaving, sums, x);
    let mut write = |x: usize, before: &[Halves; ROWS], block: &[Halves; ROWS], after: &[Halves; ROWS]| {
        for row in 0..ROWS {
            store(out[row], x, window_means::<REACH>(before[row], block[row], after[row], shifts));
        }
    };

    let mut block = column_sums(0);
    // Beyond its ends a row of sums is mirrored; what is further away than the reach may be anything.
    let mut before = block.map(|[even, odd]| {
        [
            _mm512_permutexvar_epi16(down_from(LANES), even),
            _mm512_permutexvar_epi16(down_from(LANES - 1), odd),
        ]
    });
    for x in (BYTES..last_x).step_by(BYTES) {
        let after = column_sums(x);
        write(x - BYTES, &before, &block, &after);
        (before, block) = (block, after);
    }
    // The last block has `rest` pixels of the row: the lanes from 32 on of it and the one before it.
    let back = [0, 1].map(|odd| down_from(LANES + rest - 1 - odd));
    let continued = [0, 1].map(|odd: usize| {
        let inside = _mm512_cmplt_epu16_mask(counting(), _mm512_set1_epi16((rest - odd).div_ceil(2) as i16));
        _mm512_mask_blend_epi16(inside, back[odd], up_from(LANES))
    });
    let beyond = [0, 1].map(|odd| down_from(2 * LANES + rest - 1 - odd));
    let partial = column_sums(last_x);
    let both = |from: Halves| {
        let mut both = partial;
        for row in 0..ROWS {
            for odd in 0..2 {
                both[row][odd] = _mm512_permutex2var_epi16(block[row][odd], from[odd], partial[row][odd]);
            }
        }
        both
    };
    let (last, after) = (both(continued), both(beyond));
    write(last_x - BYTES, &before, &block, &last);
    write(last_x, &block, &last, &after);
}

//! Strength and direction of the gradient, and the suppression of all pixels that are not strongest across their edge.
//!
//! Neither branches on pixels: all eight neighbours are read and the two that count are selected.

use super::hysteresis::{NO_EDGE, STRONG, WEAK};
use crate::simd::simd_kernel;

/// The gradient's direction, as the neighbours it points at: one of the four below. As wide as the strengths, so that both
/// fill vectors alike.
pub(super) type Direction = u16;

const LEFT_RIGHT: Direction = 0;
const ABOVE_BELOW: Direction = 1;
/// Upper left and lower right.
const FALLING: Direction = 2;
/// Upper right and lower left.
const RISING: Direction = 3;

/// tan 22.5 degrees in 2^-16 (OpenCV has the same value in 2^-15).
const TAN_22_5: u32 = 27146;

/// Strengths of a row and of those around it, with one beyond either end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Neighbourhood<'a, M> {
    pub(super) above: &'a [M],
    pub(super) here: &'a [M],
    pub(super) below: &'a [M],
}

/// `width` values of a row from its first, second and third on: those left of, at and right of as many pixels. Cut to one
/// length, so that loops over them need no bounds checks.
#[inline(always)]
fn three_shifts<T>(row: &[T], width: usize) -> (&[T], &[T], &[T]) {
    (&row[..width], &row[1..][..width], &row[2..][..width])
}

/// Slopes along both axes at `x` of [`crate::sobel::Columns`].
#[inline(always)]
fn slopes(smooth: [i16; 2], difference: [i16; 3]) -> (i16, i16) {
    (smooth[1] - smooth[0], difference[0] + 2 * difference[1] + difference[2])
}

#[inline(always)]
fn direction_of(dx: i16, dy: i16) -> Direction {
    let (along_x, along_y) = (dx.unsigned_abs(), dy.unsigned_abs());
    // tan 67.5 degrees is tan 22.5 degrees + 2. Only the whole part matters: the products have no fraction of exactly 0
    // but for dx = 0, where a gradient without dy has no strength either.
    let flat = ((u32::from(along_x) * TAN_22_5) >> 16) as u16;
    let diagonal = if (dx ^ dy) < 0 { RISING } else { FALLING };
    let steep = if along_y > 2 * along_x + flat { ABOVE_BELOW } else { diagonal };
    if along_y <= flat { LEFT_RIGHT } else { steep }
}

/// Strengths and directions of a row; `strength_of` has the norm.
#[inline(always)]
fn gradient<M>(
    smooth: &[i16],
    difference: &[i16],
    strength: &mut [M],
    direction: &mut [Direction],
    strength_of: impl Fn(i16, i16) -> M,
) {
    let width = strength.len();
    let (left, right) = (&smooth[..width], &smooth[2..][..width]);
    let (first, middle, last) = three_shifts(difference, width);
    let direction = &mut direction[..width];
    for x in 0..width {
        let (dx, dy) = slopes([left[x], right[x]], [first[x], middle[x], last[x]]);
        strength[x] = strength_of(dx, dy);
        direction[x] = direction_of(dx, dy);
    }
}

simd_kernel! {
    /// |dx| + |dy|.
    pub(super) fn gradient_l1(
        smooth: &[i16], difference: &[i16], strength: &mut [u16], direction: &mut [Direction]
    ) {
        gradient(smooth, difference, strength, direction, |dx, dy| dx.unsigned_abs() + dy.unsigned_abs());
    }
}

simd_kernel! {
    /// dx² + dy².
    pub(super) fn gradient_l2(
        smooth: &[i16], difference: &[i16], strength: &mut [u32], direction: &mut [Direction]
    ) {
        let squared = |slope: i16| (i32::from(slope) * i32::from(slope)) as u32;
        gradient(smooth, difference, strength, direction, |dx, dy| squared(dx) + squared(dy));
    }
}

/// Sorts a row's pixels into edges that are strong, weak or none. Of two equal strengths side by side the left one, of two
/// on top of each other the upper one is kept, and neither of two across a corner, as in OpenCV.
#[inline(always)]
fn suppress<M: Copy + PartialOrd>(
    around: Neighbourhood<'_, M>,
    direction: &[Direction],
    [low, high]: [M; 2],
    classes: &mut [u8],
) {
    let width = classes.len();
    let (above_left, above, above_right) = three_shifts(around.above, width);
    let (left, here, right) = three_shifts(around.here, width);
    let (below_left, below, below_right) = three_shifts(around.below, width);
    let direction = &direction[..width];
    for x in 0..width {
        let (strength, direction) = (here[x], direction[x]);
        let not_below = [
            (LEFT_RIGHT, (strength > left[x]) & (strength >= right[x])),
            (ABOVE_BELOW, (strength > above[x]) & (strength >= below[x])),
            (FALLING, (strength > above_left[x]) & (strength > below_right[x])),
            (RISING, (strength > above_right[x]) & (strength > below_left[x])),
        ];
        let strongest = not_below
            .iter()
            .fold(false, |any, &(across, strongest)| any | ((direction == across) & strongest));
        let kept = (strength > low) & strongest;
        let class = if strength > high { STRONG } else { WEAK };
        classes[x] = if kept { class } else { NO_EDGE };
    }
}

simd_kernel! {
    pub(super) fn suppress_l1(
        around: Neighbourhood<'_, u16>, direction: &[Direction], thresholds: [u16; 2], classes: &mut [u8]
    ) {
        suppress(around, direction, thresholds, classes);
    }
}

simd_kernel! {
    pub(super) fn suppress_l2(
        around: Neighbourhood<'_, u32>, direction: &[Direction], thresholds: [u32; 2], classes: &mut [u8]
    ) {
        suppress(around, direction, thresholds, classes);
    }
}

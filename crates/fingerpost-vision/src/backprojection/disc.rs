//! A disc of pixels and its area's reciprocal, by which sums over it become means.

use std::ops::Range;

/// Most pixels whose sum of 8-bit values fits into 16 bits.
const MAX_NARROW_PX: usize = 257;
/// Bits behind the point of the reciprocal that 16-bit sums are multiplied by.
const RECIPROCAL_BITS: u32 = 16;
/// Added to a sum before it is divided: half-way between a mean that is just rounded up, at .5, and the next smaller one
/// there can be, a whole sum less one. Both are thus a quarter of 1 / area away from the rounding, which is above 2^-14 up
/// to the largest disc's area of 3209, while the division errs by 2^-15 at the most: the rounded mean is exact.
const TO_ROUND_UP: f32 = 0.25;
/// The 32-bit number from 2^23 on are whole numbers: adding it to a smaller one rounds that, and leaves it in the lowest
/// bits.
const TO_WHOLE: f32 = 8_388_608.0;

/// A disc of pixels as its columns.
#[derive(Debug, Clone)]
pub(super) struct Disc {
    pub(super) radius: usize,
    /// Every half height that its columns have, ascending.
    pub(super) half_heights: Vec<usize>,
    /// For each column, from left to right, which of the half heights it has.
    pub(super) columns: Vec<usize>,
    /// Parts of `columns` whose pixels are few enough for 16-bit sums.
    pub(super) parts: Vec<Range<usize>>,
    pub(super) area: usize,
    /// One by the area, where 16-bit numbers suffice for means of all of it.
    pub(super) reciprocal: Option<u16>,
}

impl Disc {
    pub(super) fn new(radius: usize) -> Self {
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
        Self { radius, half_heights, columns, parts, area, reciprocal: reciprocal(area) }
    }
}

/// One by `area` as a fraction of 16 bits, rounded up, where [`rounded_by`] gives every exact rounded mean with it; a disc's
/// area is an odd number.
///
/// The sum and half the area are n, and the mean is the whole part of n / area. Rounding up makes n times the reciprocal
/// too large by at most n e / 2^16 / area, with e below the area. As long as n e is below 2^16 that is less than what n /
/// area lacks to the next whole number, 1 / area at the least.
fn reciprocal(area: usize) -> Option<u16> {
    let largest = usize::from(u8::MAX) * area + area / 2;
    let reciprocal = (1_usize << RECIPROCAL_BITS).div_ceil(area);
    let excess = reciprocal * area - (1 << RECIPROCAL_BITS);
    u16::try_from(reciprocal).ok().filter(|_| largest.max(largest * excess) < 1 << RECIPROCAL_BITS)
}

/// The quotient of `sum` and the divisor of `reciprocal`, rounded half up.
#[inline(always)]
pub(super) fn rounded(sum: i32, reciprocal: f32) -> u8 {
    ((sum as f32 + TO_ROUND_UP) * reciprocal + TO_WHOLE).to_bits() as u8
}

/// The whole part of `sum` times a [`reciprocal`].
#[inline(always)]
pub(super) fn rounded_by(sum: u16, reciprocal: u16) -> u8 {
    ((u32::from(sum) * u32::from(reciprocal)) >> RECIPROCAL_BITS) as u8
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
    fn means_by_a_reciprocal_are_exact_where_there_is_one() {
        let with_one = |radius: usize| reciprocal(Disc::new(radius).area).is_some();
        assert!((1..=3).all(with_one) && !with_one(32));
        for area in (1..400).step_by(2) {
            let Some(reciprocal) = reciprocal(area) else { continue };
            for sum in 0..=255 * area {
                let found = rounded_by((sum + area / 2) as u16, reciprocal);
                assert_eq!(usize::from(found), (2 * sum + area) / (2 * area), "{sum} of {area}");
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

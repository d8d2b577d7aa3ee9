//! Thinning of shapes to lines one pixel wide.
//!
//! T. Y. Zhang and C. Y. Suen, "A fast parallel algorithm for thinning digital patterns", CACM 27(3), 1984. Pixels at a
//! shape's edge are taken away, in turn from its lower right and its upper left, where what is left still hangs together,
//! until no more can go. As published, slanted lines two pixels wide stay so in places, and a square of 2 x 2 pixels
//! vanishes. Pixels outside the picture count as empty.
//!
//! The conditions are sums of the eight neighbours; as logic of bits they are found for 64 pixels a word at once.

use crate::bit_plane::{BitPlane, unpack};
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
use crate::simd::{CodePath, simd_kernel};

/// Thins shapes, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::morphology::Thinning;
/// use fingerpost_vision::picture::Plane;
/// let mut bar = Plane::new(9, 5, 0_u8);
/// (1..4).for_each(|y| bar.row_mut(y)[1..8].fill(255));
/// let mut thin = Plane::new(9, 5, 0);
/// Thinning::new().apply(bar.view(), &mut thin)?;
/// assert_eq!(thin.row(1), &[0; 9]);
/// assert_eq!(thin.row(2), &[0, 0, 255, 255, 255, 255, 0, 0, 0]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Thinning {
    bits: BitPlane,
    /// The shapes, row by row, with an empty row above and below and an empty word before and behind each row.
    shapes: Vec<u64>,
    /// The shapes after the turn that is being computed.
    next: Vec<u64>,
    /// Of each row of the shapes, the turns since something was taken away from it, the one at hand with them: a row whose
    /// neighbourhood is as it was when both kinds of turn last took nothing away from it is left out.
    idle_turns: Vec<u8>,
}

/// A row is computed while a row of its neighbourhood has been idle for fewer turns: the kind of turn at hand was the last but one.
const IDLE_TURNS: u8 = 2;

/// A turn takes away pixels where either of two groups of neighbours has an empty one: above, right, below, left.
type EmptyGroups = [[bool; 4]; 2];

/// From the lower right: above, right and below, and right, below and left.
const FIRST_TURN: EmptyGroups = [[true, true, true, false], [false, true, true, true]];
/// From the upper left: above, right and left, and above, below and left.
const SECOND_TURN: EmptyGroups = [[true, true, false, true], [true, false, true, true]];

impl Thinning {
    /// A thinning that has not seen a picture yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets `target` to 255 where a line is left of the shapes in `source`, which are all pixels that are not 0, and to 0
    /// elsewhere.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: PlaneView<'_, u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
        self.apply_on(CodePath::fastest(), source, target)
    }

    fn apply_on(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        target: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        check_size("thinned picture", source.size(), target.size())?;
        self.bits.fill_from(path, source);
        let pitch = self.bits.words_a_row() + 2;
        for plane in [&mut self.shapes, &mut self.next] {
            plane.clear();
            plane.resize(pitch * (source.height() + 2), 0);
        }
        // What is empty stays so.
        self.idle_turns.clear();
        self.idle_turns.resize(source.height() + 2, IDLE_TURNS);
        let idle_turns = self.idle_turns.iter_mut().skip(1);
        let rows = self.shapes.chunks_exact_mut(pitch).skip(1).zip(self.bits.rows());
        for ((row, words), idle_turns) in rows.zip(idle_turns) {
            row[1..pitch - 1].copy_from_slice(words);
            if words.iter().any(|&word| word != 0) {
                *idle_turns = 0;
            }
        }
        let mut still = 0;
        let mut turns = [FIRST_TURN, SECOND_TURN].into_iter().cycle();
        while still < 2 {
            let groups = turns.next().unwrap_or(FIRST_TURN);
            if self.take_turn(path, pitch, groups) {
                still = 0;
            } else {
                still += 1;
            }
        }
        for (y, row) in self.shapes.chunks_exact(pitch).skip(1).take(source.height()).enumerate() {
            unpack(path, &row[1..pitch - 1], target.row_mut(y));
        }
        Ok(())
    }

    /// Whether anything was taken away.
    fn take_turn(&mut self, path: CodePath, pitch: usize, groups: EmptyGroups) -> bool {
        let mut taken = 0;
        // Of the row above, before this turn.
        let mut above_idle = IDLE_TURNS;
        for (y, next) in self.next.chunks_exact_mut(pitch).enumerate().skip(1) {
            let rows = |y: usize| self.shapes.get(y * pitch..(y + 1) * pitch);
            let (Some(above), Some(here), Some(below)) = (rows(y - 1), rows(y), rows(y + 1)) else {
                continue;
            };
            let Some([here_idle, below_idle]) =
                self.idle_turns.get_mut(y..).and_then(|idle| idle.first_chunk_mut())
            else {
                continue;
            };
            let around_idle = above_idle.min(*here_idle).min(*below_idle);
            above_idle = *here_idle;
            *here_idle = here_idle.saturating_add(1);
            // A row that was left alone in the last turn is the same in both planes.
            if around_idle >= IDLE_TURNS {
                continue;
            }
            let taken_here = thin_row(path, [above, here, below], groups, &mut next[1..pitch - 1]);
            if taken_here != 0 {
                *here_idle = 0;
            }
            taken |= taken_here;
        }
        std::mem::swap(&mut self.shapes, &mut self.next);
        taken != 0
    }
}

/// Where at least one, and where at least two of `bits` are set.
#[inline(always)]
fn one_and_two(bits: [u64; 8]) -> [u64; 2] {
    bits.iter().fold([0, 0], |[one, two], bit| [one | bit, two | one & bit])
}

simd_kernel! {
    /// Thins one row into `next`; the bits that it takes away are in the result.
    fn thin_row(rows: [&[u64]; 3], groups: EmptyGroups, next: &mut [u64]) -> u64 {
        let words = next.len();
        let (above, here, below) = (&rows[0][..words + 2], &rows[1][..words + 2], &rows[2][..words + 2]);
        // All ones for the neighbours that a group does not ask.
        let unasked = groups.map(|group| group.map(|asked| if asked { 0 } else { u64::MAX }));
        let mut all_taken = 0;
        for word in 0..words {
            let right = |row: &[u64]| row[word + 1] >> 1 | row[word + 2] << 63;
            let left = |row: &[u64]| row[word + 1] << 1 | row[word] >> 63;
            // Clockwise from the one above.
            let around = [
                above[word + 1], right(above), right(here), right(below),
                below[word + 1], left(below), left(here), left(above),
            ];
            let mut rises = [0; 8];
            for (index, rise) in rises.iter_mut().enumerate() {
                *rise = !around[index] & around[(index + 1) % 8];
            }
            let [one_rise, two_rises] = one_and_two(rises);
            let [_, two_neighbours] = one_and_two(around);
            let [_, two_empty] = one_and_two(around.map(|bits| !bits));
            let [above, right, below, left] = [around[0], around[2], around[4], around[6]];
            let mut any_empty = u64::MAX;
            for group in unasked {
                let full = (above | group[0]) & (right | group[1]) & (below | group[2]) & (left | group[3]);
                any_empty &= !full;
            }
            let taken = here[word + 1] & one_rise & !two_rises & two_neighbours & two_empty & any_empty;
            next[word] = here[word + 1] & !taken;
            all_taken |= taken;
        }
        all_taken
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::{binary_pictures, config};

    fn plain(source: PlaneView<'_, u8>) -> Plane<u8> {
        let (width, height) = source.size();
        let mut shapes = Plane::new(width, height, 0);
        for y in 0..height {
            for (shape, &pixel) in shapes.row_mut(y).iter_mut().zip(source.row(y)) {
                *shape = if pixel == 0 { 0 } else { 255 };
            }
        }
        loop {
            let before = shapes.clone();
            for turn in 0..2 {
                let old = shapes.clone();
                let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                for (x, y) in all.filter(|&(x, y)| old.get(x, y) == Some(255)) {
                    let set = |dx: isize, dy: isize| {
                        let place = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
                        place.and_then(|(x, y)| old.get(x, y)) == Some(255)
                    };
                    let p = [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1)]
                        .map(|(dx, dy)| set(dx, dy));
                    let neighbours = p.iter().filter(|&&set| set).count();
                    let rises = (0..8).filter(|&k| !p[k] && p[(k + 1) % 8]).count();
                    let [p2, p4, p6, p8] = [p[0], p[2], p[4], p[6]];
                    let groups =
                        if turn == 0 { [[p2, p4, p6], [p4, p6, p8]] } else { [[p2, p4, p8], [p2, p6, p8]] };
                    let empty = groups.iter().all(|group| group.contains(&false));
                    if (2..=6).contains(&neighbours) && rises == 1 && empty {
                        shapes.row_mut(y)[x] = 0;
                    }
                }
            }
            if shapes == before {
                return shapes;
            }
        }
    }

    proptest! {
        #![proptest_config(config(60))]

        #[test]
        fn lines_are_those_of_the_published_conditions_on_every_path(picture in binary_pictures()) {
            let expected = plain(picture.view());
            let mut thinning = Thinning::new();
            for path in CodePath::available() {
                let mut target = Plane::new(expected.width(), expected.height(), 3);
                thinning.apply_on(path, picture.view(), &mut target).unwrap();
                prop_assert_eq!(&target, &expected, "{:?}", path);
            }
        }
    }

    #[test]
    fn a_target_of_another_size_is_an_error() {
        assert!(Thinning::new().apply(Plane::new(4, 3, 0).view(), &mut Plane::new(3, 4, 0)).is_err());
    }
}

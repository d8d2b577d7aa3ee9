//! Which pixels of a picture are seen.

use super::Plane;

/// A run of seen pixels in one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// First column.
    pub start: usize,
    /// Column after the last.
    pub end: usize,
}

/// The pixels of a picture that show something (the papers' "IPM mask"), as a plane and as runs row by row, so that kernels
/// can pass over the rest.
///
/// ```
/// use fingerpost_vision::picture::{Plane, Run, ValidityMask};
/// let mask = ValidityMask::from_plane(Plane::from_vec(4, 2, vec![0, 7, 7, 0, 1, 0, 0, 1])?);
/// assert_eq!(mask.runs(0), &[Run { start: 1, end: 3 }]);
/// assert_eq!(mask.runs(1), &[Run { start: 0, end: 1 }, Run { start: 3, end: 4 }]);
/// assert_eq!(mask.seen(), 4);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Default, Eq)]
pub struct ValidityMask {
    plane: Plane<u8>,
    /// Runs of all rows, row by row.
    runs: Vec<Run>,
    /// For each row where its runs begin, and behind the last where they end.
    row_starts: Vec<usize>,
    seen: usize,
    /// The runs of a row of squares, while [`ValidityMask::set_to_union`] works on it.
    of_squares: Vec<Run>,
}

impl Clone for ValidityMask {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the memory.
    fn clone_from(&mut self, source: &Self) {
        self.plane.clone_from(&source.plane);
        self.runs.clone_from(&source.runs);
        self.row_starts.clone_from(&source.row_starts);
        self.seen = source.seen;
    }
}

/// The runs say all that the plane does, and are few: comparing them takes microseconds.
impl PartialEq for ValidityMask {
    fn eq(&self, other: &Self) -> bool {
        self.size() == other.size() && self.row_starts == other.row_starts && self.runs == other.runs
    }
}

impl ValidityMask {
    /// The pixels of `plane` that are not 0; in the mask's own plane they are 1.
    #[must_use]
    pub fn from_plane(mut plane: Plane<u8>) -> Self {
        plane.as_mut_slice().iter_mut().for_each(|value| *value = u8::from(*value != 0));
        let mut runs: Vec<Run> = Vec::new();
        let mut row_starts = vec![0];
        for y in 0..plane.height() {
            let mut start = 0;
            for part in plane.row(y).chunk_by(|left, right| left == right) {
                let end = start + part.len();
                if part[0] != 0 {
                    runs.push(Run { start, end });
                }
                start = end;
            }
            row_starts.push(runs.len());
        }
        let seen = runs.iter().map(|run| run.end - run.start).sum();
        Self { plane, runs, row_starts, seen, of_squares: Vec::new() }
    }

    /// A picture of `width` x `height` pixels that is seen whole.
    #[must_use]
    pub fn all_seen(width: usize, height: usize) -> Self {
        Self::from_plane(Plane::new(width, height, 1))
    }

    /// Makes the mask show what `mask` does, and besides every square of `side` x `side` pixels whose value in `squares` is not
    /// 0, reusing the memory. The squares lie side by side from the top left corner on; what of them lies outside the mask's
    /// picture is left out, and a `side` of 0 shows no square.
    ///
    /// ```
    /// use fingerpost_vision::picture::{Plane, Run, ValidityMask};
    /// let mask = ValidityMask::from_plane(Plane::from_vec(5, 1, vec![1, 1, 0, 0, 0])?);
    /// let mut shown = ValidityMask::default();
    /// shown.set_to_union(&mask, &Plane::from_vec(3, 1, vec![0, 0, 1])?, 2);
    /// assert_eq!(shown.runs(0), &[Run { start: 0, end: 2 }, Run { start: 4, end: 5 }]);
    /// # Ok::<(), fingerpost_vision::error::PictureError>(())
    /// ```
    pub fn set_to_union(&mut self, mask: &Self, squares: &Plane<u8>, side: usize) {
        let (width, height) = mask.size();
        if self.size() != (width, height) {
            self.plane.reset(width, height, 0);
        }
        let Self { plane, runs, row_starts, seen, of_squares } = self;
        runs.clear();
        row_starts.clear();
        row_starts.push(0);
        of_squares.clear();
        // Room for every second one, so that no later mask needs more memory.
        of_squares.reserve(squares.width().div_ceil(2));
        for y in 0..height {
            if y.checked_rem(side) == Some(0) {
                let row = y / side;
                let squares = if row < squares.height() { squares.row(row) } else { &[] };
                of_squares.clear();
                of_squares.extend(RunsOfSquares { row: squares, side, next: 0, width });
            }
            let first = runs.len();
            join(mask.runs(y), of_squares, runs);
            let row = plane.row_mut(y);
            let mut done = 0;
            for run in &runs[first..] {
                row[done..run.start].fill(0);
                row[run.start..run.end].fill(1);
                done = run.end;
            }
            row[done..].fill(0);
            row_starts.push(runs.len());
        }
        *seen = runs.iter().map(|run| run.end - run.start).sum();
    }

    /// 1 where a pixel is seen, 0 where it is not.
    #[must_use]
    pub fn plane(&self) -> &Plane<u8> {
        &self.plane
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.plane.size()
    }

    /// The runs of seen pixels of row `y`, left to right; they do not touch each other.
    ///
    /// # Panics
    /// When `y` is not below the height, as indexing a slice does.
    #[must_use]
    pub fn runs(&self, y: usize) -> &[Run] {
        &self.runs[self.row_starts[y]..self.row_starts[y + 1]]
    }

    /// Number of seen pixels.
    #[must_use]
    pub fn seen(&self) -> usize {
        self.seen
    }
}

/// Appends to `runs` what either of two rows of runs shows.
fn join(left: &[Run], right: &[Run], runs: &mut Vec<Run>) {
    let first = runs.len();
    let (mut left, mut right) = (left.iter().peekable(), right.iter().peekable());
    while let Some(&run) = match (left.peek(), right.peek()) {
        (Some(of_one), Some(of_other)) if of_other.start < of_one.start => right.next(),
        (None, _) => right.next(),
        _ => left.next(),
    } {
        match runs[first..].last_mut() {
            Some(last) if last.end >= run.start => last.end = last.end.max(run.end),
            _ => runs.push(run),
        }
    }
}

/// The runs of pixels of the squares of one row that are not 0.
struct RunsOfSquares<'a> {
    row: &'a [u8],
    side: usize,
    /// Square to look at next.
    next: usize,
    /// Width of the picture, pixels.
    width: usize,
}

impl Iterator for RunsOfSquares<'_> {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        let rest = self.row.get(self.next..)?;
        let first = self.next + rest.iter().position(|&value| value != 0)?;
        let length = self.row[first..].iter().position(|&value| value == 0).unwrap_or(self.row.len() - first);
        self.next = first + length;
        let run = Run { start: first * self.side, end: (self.next * self.side).min(self.width) };
        (run.start < run.end).then_some(run)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::config;

    proptest! {
        #![proptest_config(config(200))]

        #[test]
        fn a_union_with_squares_is_the_union_pixel_by_pixel(
            (width, height, side) in (0..40_usize, 0..9_usize, 0..5_usize),
            (across, down) in (0..20_usize, 0..9_usize),
            bits in prop::collection::vec(any::<bool>(), 40 * 9 + 20 * 9),
        ) {
            let (of_mask, of_squares) = bits.split_at(40 * 9);
            let plane = |width, height, bits: &[bool]| {
                let values = bits[..width * height].iter().map(|&bit| u8::from(bit)).collect();
                Plane::from_vec(width, height, values).unwrap()
            };
            let mask = ValidityMask::from_plane(plane(width, height, of_mask));
            let squares = plane(across, down, of_squares);
            let mut expected = mask.plane().clone();
            for y in 0..height {
                for (x, pixel) in expected.row_mut(y).iter_mut().enumerate() {
                    let square = x.checked_div(side).zip(y.checked_div(side));
                    *pixel |= square.and_then(|(x, y)| squares.get(x, y)).unwrap_or(0);
                }
            }
            let expected = ValidityMask::from_plane(expected);
            // Whatever it was before.
            let mut union = ValidityMask::all_seen(7, 3);
            union.set_to_union(&mask, &squares, side);
            prop_assert_eq!(&union, &expected);
            prop_assert_eq!(union.plane(), expected.plane());
            prop_assert_eq!(union.seen(), expected.seen());
        }
    }
}

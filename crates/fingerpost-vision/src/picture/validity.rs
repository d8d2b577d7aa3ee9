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
#[derive(Debug, Clone, Default, Eq)]
pub struct ValidityMask {
    plane: Plane<u8>,
    /// Runs of all rows, row by row.
    runs: Vec<Run>,
    /// For each row where its runs begin, and behind the last where they end.
    row_starts: Vec<usize>,
    seen: usize,
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
        Self { plane, runs, row_starts, seen }
    }

    /// A picture of `width` x `height` pixels that is seen whole.
    #[must_use]
    pub fn all_seen(width: usize, height: usize) -> Self {
        Self::from_plane(Plane::new(width, height, 1))
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

//! Row-wise prefix sums of a probability plane, and what a mask covers of it.

use super::SpanMask;
use crate::error::{PictureError, check_size};
use crate::picture::PlaneView;

/// Probability 1 in an 8-bit probability plane.
const ONE: f64 = 255.0;

/// What a mask covers of a probability plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cover {
    /// Sum of the probabilities of the mask's seen pixels, 255 standing for 1.
    pub sum: u64,
    /// Pixels of the mask that lie in the picture and are seen.
    pub seen: u64,
    /// Pixels of the mask that lie in the picture.
    pub in_view: u64,
    /// Pixels of the whole mask.
    pub area: u64,
}

impl Cover {
    /// Mean probability of the mask's seen pixels, 0 to 1, or `None` when none is seen: P(F_sub) of paper 1, equation 1,
    /// with the mask ANDed with the validity ("IPM") mask.
    #[must_use]
    pub fn probability(&self) -> Option<f64> {
        (self.seen > 0).then(|| self.sum as f64 / (ONE * self.seen as f64))
    }

    /// Share of the mask that is seen, 0 to 1; 0 for an empty mask.
    #[must_use]
    pub fn seen_share(&self) -> f64 {
        if self.area == 0 { 0.0 } else { self.seen as f64 / self.area as f64 }
    }
}

/// Row-wise prefix sums of probability and of seen pixels.
///
/// ```
/// use fingerpost_vision::{picture::{Plane, Rect}, span::{RowSums, SpanMask}};
/// let probability = Plane::from_vec(3, 1, vec![255_u8, 0, 255])?;
/// let validity = Plane::from_vec(3, 1, vec![1_u8, 1, 0])?;
/// let mut sums = RowSums::default();
/// sums.rebuild(probability.view(), validity.view())?;
/// let mask = SpanMask::from_rect(Rect { x: 0, y: 0, width: 4, height: 1 });
/// let cover = sums.cover(&mask, 0, 0);
/// assert_eq!((cover.seen, cover.in_view, cover.area), (2, 3, 4));
/// assert_eq!(cover.probability(), Some(0.5));
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct RowSums {
    width: usize,
    height: usize,
    /// For each row `width + 1` pairs: sum of the probabilities, and number of the seen pixels, left of that column. The
    /// two lie side by side because every look-up needs both.
    pairs: Vec<u32>,
}

impl RowSums {
    /// Builds the sums of a probability plane (255 is 1) over the pixels whose validity is not 0, reusing the memory.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size; [`PictureError::TooLarge`] when a row's sum could
    /// exceed 32 bits.
    pub fn rebuild(
        &mut self,
        probability: PlaneView<'_, u8>,
        validity: PlaneView<'_, u8>,
    ) -> Result<(), PictureError> {
        check_size("validity mask", probability.size(), validity.size())?;
        let (width, height) = probability.size();
        let widest = u32::MAX as usize / usize::from(u8::MAX);
        if width > widest {
            return Err(PictureError::TooLarge {
                what: "probability plane",
                width,
                height,
                limit: widest.saturating_mul(height),
            });
        }
        self.width = width;
        self.height = height;
        self.pairs.resize(height * self.stride(), 0);
        for y in 0..height {
            let start = y * self.stride();
            let pairs = &mut self.pairs[start..start + 2 * (width + 1)];
            let (mut sum, mut seen) = (0_u32, 0_u32);
            pairs[..2].fill(0);
            let values = probability.row(y).iter().zip(validity.row(y));
            let (pairs, _) = pairs[2..].as_chunks_mut::<2>();
            for (pair, (&value, &valid)) in pairs.iter_mut().zip(values) {
                let valid = u32::from(valid != 0);
                sum += u32::from(value) * valid;
                seen += valid;
                *pair = [sum, seen];
            }
        }
        Ok(())
    }

    /// Width and height of the plane, pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// What `mask`, moved `d_col` pixels right and `d_row` pixels down, covers of the plane.
    #[must_use]
    pub fn cover(&self, mask: &SpanMask, d_col: i32, d_row: i32) -> Cover {
        let mut cover = Cover { area: mask.area(), ..Cover::default() };
        let (d_col, d_row) = (i64::from(d_col), i64::from(d_row));
        let (width, height) = (self.width as i64, self.height as i64);
        let spans = mask.spans();
        let first = spans.partition_point(|span| i64::from(span.row) + d_row < 0);
        for span in &spans[first..] {
            let row = i64::from(span.row) + d_row;
            if row >= height {
                break;
            }
            let start = (i64::from(span.start) + d_col).max(0);
            let end = (i64::from(span.end) + d_col).min(width);
            if start >= end {
                continue;
            }
            // Row and columns are inside the plane now.
            let pairs = self.row_pairs(row as usize);
            let (left, right) = (2 * start as usize, 2 * end as usize);
            cover.sum += u64::from(pairs[right] - pairs[left]);
            cover.seen += u64::from(pairs[right + 1] - pairs[left + 1]);
            cover.in_view += (end - start) as u64;
        }
        cover
    }

    /// The pairs (sum, seen) of row `y`, one more than there are columns.
    pub(crate) fn row_pairs(&self, y: usize) -> &[u32] {
        let start = y * self.stride();
        &self.pairs[start..start + self.stride()]
    }

    fn stride(&self) -> usize {
        2 * (self.width + 1)
    }
}

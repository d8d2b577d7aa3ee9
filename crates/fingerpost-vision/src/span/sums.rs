//! What a mask covers of a probability plane.

use super::prefix::{LANES, MAX_PIECE_PX, PrefixRows};
use super::{Span, SpanMask};
use crate::error::{PictureError, check_size};
use crate::picture::{PlaneView, Run, ValidityMask};
use crate::simd::{CodePath, simd_kernel};

/// Probability 1 in an 8-bit probability plane.
const ONE: f64 = 255.0;
/// Largest mask whose sum of 8-bit values surely fits 32 bits.
const MAX_WIDE_PX: u64 = u32::MAX as u64 / u8::MAX as u64;

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
/// Those of the seen pixels are made anew only when the validity mask is another than the last time.
///
/// ```
/// use fingerpost_vision::{picture::{Plane, Rect, ValidityMask}, span::{Cover, RowSums, SpanMask}};
/// let probability = Plane::from_vec(3, 1, vec![255_u8, 0, 255])?;
/// let validity = ValidityMask::from_plane(Plane::from_vec(3, 1, vec![1_u8, 1, 0])?);
/// let mut sums = RowSums::default();
/// sums.rebuild(probability.view(), &validity)?;
/// let mask = SpanMask::from_rect(Rect { x: 0, y: 0, width: 4, height: 1 });
/// let cover = sums.cover(&mask, 0, 0);
/// assert_eq!((cover.seen, cover.in_view, cover.area), (2, 3, 4));
/// assert_eq!(cover.probability(), Some(0.5));
/// // The same mask at three neighbouring places.
/// let mut covers = [Cover::default(); 3];
/// sums.covers(&mask, -1, 0, &mut covers);
/// assert_eq!(covers[1], cover);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct RowSums {
    width: usize,
    height: usize,
    validity: ValidityMask,
    probability: PrefixRows,
    seen: PrefixRows,
    /// One row of pixels that are all in the picture.
    in_view: PrefixRows,
    /// The longest run of seen pixels of each row.
    longest_runs: Vec<Run>,
}

impl RowSums {
    /// Builds the sums of a probability plane (255 is 1) over the seen pixels, reusing the memory.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn rebuild(
        &mut self,
        probability: PlaneView<'_, u8>,
        validity: &ValidityMask,
    ) -> Result<(), PictureError> {
        self.rebuild_on(CodePath::fastest(), probability, validity)
    }

    pub(crate) fn rebuild_on(
        &mut self,
        path: CodePath,
        probability: PlaneView<'_, u8>,
        validity: &ValidityMask,
    ) -> Result<(), PictureError> {
        check_size("validity mask", probability.size(), validity.size())?;
        if self.validity != *validity {
            self.prepare(path, validity);
        }
        self.probability.rebuild(path, probability, validity);
        Ok(())
    }

    fn prepare(&mut self, path: CodePath, validity: &ValidityMask) {
        let (width, height) = validity.size();
        (self.width, self.height) = (width, height);
        self.validity.clone_from(validity);
        for rows in
            [&mut self.probability, &mut self.seen].into_iter().filter(|rows| !rows.is_for(width, height))
        {
            rows.reset(width, height);
        }
        self.seen.rebuild(path, validity.plane().view(), validity);
        self.longest_runs.clear();
        let longest = |y| validity.runs(y).iter().max_by_key(|run| run.end - run.start).copied();
        self.longest_runs.extend((0..height).map(|y| longest(y).unwrap_or(Run { start: 0, end: 0 })));
        if !self.in_view.is_for(width, 1) {
            let row = ValidityMask::all_seen(width, 1);
            self.in_view.reset(width, 1);
            self.in_view.rebuild(path, row.plane().view(), &row);
        }
    }

    /// The pixels that count as seen.
    #[must_use]
    pub fn validity(&self) -> &ValidityMask {
        &self.validity
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
        let column = |column: i32| (i64::from(column) + i64::from(d_col)).clamp(0, self.width as i64);
        for span in self.spans_in_view(mask, d_row) {
            // Row and columns are inside the plane.
            let (start, end) = (column(span.start) as usize, column(span.end) as usize);
            let row = (i64::from(span.row) + i64::from(d_row)) as usize;
            cover.in_view += (end - start) as u64;
            cover.seen += self.seen.sum(row, start, end);
            cover.sum += self.probability.sum(row, start, end);
        }
        cover
    }

    /// What `mask` covers at a run of neighbouring places: `covers[i]` becomes
    /// [`cover(mask, d_col + i, d_row)`](RowSums::cover).
    ///
    /// Neighbouring places read neighbouring sums, 64 at once: from four places on this is faster than one by one, for 64 of them
    /// thirty times, so that it pays even where only some of the places are wanted.
    pub fn covers(&self, mask: &SpanMask, d_col: i32, d_row: i32, covers: &mut [Cover]) {
        self.covers_on(CodePath::fastest(), mask, d_col, d_row, covers);
    }

    pub(crate) fn covers_on(
        &self,
        path: CodePath,
        mask: &SpanMask,
        d_col: i32,
        d_row: i32,
        covers: &mut [Cover],
    ) {
        if mask.area() > MAX_WIDE_PX {
            for (cover, place) in covers.iter_mut().zip(0..) {
                *cover = self.cover(mask, d_col.saturating_add(place), d_row);
            }
            return;
        }
        let spans = self.spans_in_view(mask, d_row);
        let mut sums = [[0; LANES]; 3];
        let mut d_col = i64::from(d_col);
        for covers in covers.chunks_mut(LANES) {
            add_up_spans(path, self, spans, d_col, i64::from(d_row), &mut sums);
            for (index, cover) in covers.iter_mut().enumerate() {
                let [sum, seen, in_view] = [0, 1, 2].map(|of| u64::from(sums[of][index]));
                *cover = Cover { sum, seen, in_view, area: mask.area() };
            }
            d_col += LANES as i64;
        }
    }

    /// The spans of `mask` that lie in rows of the plane when the mask is moved `d_row` pixels down.
    fn spans_in_view<'a>(&self, mask: &'a SpanMask, d_row: i32) -> &'a [Span] {
        let spans = mask.spans();
        let row = |span: &Span| i64::from(span.row) + i64::from(d_row);
        let first = spans.partition_point(|span| row(span) < 0);
        let end = spans.partition_point(|span| row(span) < self.height as i64);
        &spans[first..end]
    }
}

simd_kernel! {
    /// Sets `sums` to the probability, the seen pixels and the pixels in view under `spans`, moved `d_col`, `d_col` + 1, ...
    /// pixels right and `d_row` pixels down. All rows must lie inside the plane.
    fn add_up_spans(rows: &RowSums, spans: &[Span], d_col: i64, d_row: i64, sums: &mut [[u32; LANES]; 3]) {
        let column = |column: i32| {
            (i64::from(column) + d_col).clamp(-(LANES as i64), rows.width as i64) + LANES as i64
        };
        *sums = [[0; LANES]; 3];
        // Sums over as many pixels as 16 bits hold for sure.
        let (mut narrow, mut pixels) = ([[0_u16; LANES]; 3], 0);
        // Pixels that are seen, or in view, at every place.
        let (mut all_seen, mut all_in_view) = (0, 0);
        let whole_row = Run { start: 0, end: rows.width };
        for span in spans {
            // Columns count from the left end of the prefix sums; both they and the row are inside them.
            let (mut start, end) = (column(span.start) as usize, column(span.end) as usize);
            let row = (i64::from(span.row) + d_row) as usize;
            let (probability, seen) = (rows.probability.row(row), rows.seen.row(row));
            let (is_all_seen, is_all_in_view) =
                (is_always_inside(start, end, rows.longest_runs[row]), is_always_inside(start, end, whole_row));
            if is_all_seen { all_seen += (end - start) as u32 };
            if is_all_in_view { all_in_view += (end - start) as u32 };
            while start < end {
                let piece_end = end.min(start + MAX_PIECE_PX);
                pixels += piece_end - start;
                if pixels > MAX_PIECE_PX {
                    widen(&mut narrow, sums);
                    pixels = piece_end - start;
                }
                add_piece(&mut narrow[0], probability, start, piece_end);
                if !is_all_seen {
                    add_piece(&mut narrow[1], seen, start, piece_end);
                }
                if !is_all_in_view {
                    add_piece(&mut narrow[2], rows.in_view.row(0), start, piece_end);
                }
                start = piece_end;
            }
        }
        widen(&mut narrow, sums);
        sums[1].iter_mut().for_each(|sum| *sum += all_seen);
        sums[2].iter_mut().for_each(|sum| *sum += all_in_view);
    }
}

/// Whether a span stays inside `run` at all of [`LANES`] neighbouring places.
#[inline(always)]
fn is_always_inside(start: usize, end: usize, run: Run) -> bool {
    start >= run.start + LANES && end < run.end + 2
}

/// Adds the sums of a piece of a row at [`LANES`] neighbouring places.
#[inline(always)]
fn add_piece(sums: &mut [u16; LANES], prefix: &[u16], start: usize, end: usize) {
    let (starts, ends) = (&prefix[start..start + LANES], &prefix[end..end + LANES]);
    for ((sum, &start), &end) in sums.iter_mut().zip(starts).zip(ends) {
        *sum = sum.wrapping_add(end.wrapping_sub(start));
    }
}

/// Moves `narrow` sums into wide ones.
#[inline(always)]
fn widen(narrow: &mut [[u16; LANES]; 3], sums: &mut [[u32; LANES]; 3]) {
    for (narrow, sums) in narrow.iter_mut().zip(sums) {
        for (sum, narrow) in sums.iter_mut().zip(narrow.iter()) {
            *sum += u32::from(*narrow);
        }
        *narrow = [0; LANES];
    }
}

#[cfg(test)]
mod tests;

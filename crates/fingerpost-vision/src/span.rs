//! The primitive of the method: how much probability lies under a shape.
//!
//! A shape is a [`SpanMask`]: for each row the runs of columns that it covers. A probability plane is turned once a frame
//! into [`RowSums`], row-wise prefix sums over the seen pixels. [`RowSums::cover`] then costs four look-ups a run,
//! wherever the mask is shifted to.
//!
//! A mask's coordinates are relative to an origin pixel and may lie outside any picture. A pixel belongs to a shape when
//! its centre does: the pixel-centre rule, with left and upper edges inside and right and lower edges outside, so that
//! shapes that share an edge share no pixel.

mod draw;
mod prefix;
mod sums;

pub use sums::{Cover, RowSums};

use crate::picture::Rect;

/// Farthest a drawn shape may reach from the mask's origin, pixels: 1.6 km at 0.05 m a pixel, far more than any ground
/// view, yet few enough rows that a mistaken coordinate cannot exhaust the memory.
pub const MAX_REACH_PX: f64 = 32_768.0;

/// A run of pixels in one row of a mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Span {
    /// Row.
    pub row: i32,
    /// First column.
    pub start: i32,
    /// Column after the last.
    pub end: i32,
}

/// A shape that cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpanError {
    /// A coordinate is not finite or too far away.
    #[error(
        "the point ({u_px}, {v_px}) px cannot be drawn; clip shapes to {MAX_REACH_PX} px around the mask's origin"
    )]
    OutOfReach {
        /// Column of the point, pixels.
        u_px: f64,
        /// Row of the point, pixels.
        v_px: f64,
    },
    /// A stroke's width is not a positive number, or too large.
    #[error("a stroke cannot be {width_px} px wide; give a width above 0 and at most {MAX_REACH_PX} px")]
    Width {
        /// Width given, pixels.
        width_px: f64,
    },
}

/// A set of pixels, kept as runs sorted by row and column that neither overlap nor touch.
///
/// ```
/// use fingerpost_vision::span::SpanMask;
/// // A stroke 3 px wide from (0, 0) up to (0, -4): columns -1, 0 and 1 of rows -4 to -1 (the lower end is outside).
/// let mask = SpanMask::stroke(&[[0.0, 0.0], [0.0, -4.0]], 3.0)?;
/// assert_eq!(mask.area(), 12);
/// assert_eq!(mask.centroid(), Some([0.0, -2.5]));
/// # Ok::<(), fingerpost_vision::span::SpanError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SpanMask {
    spans: Vec<Span>,
    area: u64,
}

impl SpanMask {
    /// The pixels of the given runs, in any order; runs that overlap or touch are merged, empty ones dropped.
    #[must_use]
    pub fn from_spans(spans: Vec<Span>) -> Self {
        let mut mask = Self { spans, area: 0 };
        mask.tidy();
        mask
    }

    /// The pixels of a rectangle; what lies beyond the range of `i32` is left out.
    #[must_use]
    pub fn from_rect(rect: Rect) -> Self {
        let start = saturate(rect.x);
        let end = saturate(rect.x.saturating_add(rect.width));
        let rows = saturate(rect.y)..saturate(rect.y.saturating_add(rect.height));
        Self::from_spans(rows.map(|row| Span { row, start, end }).collect())
    }

    /// The pixels whose centres lie inside a closed polygon with corners (u, v) in pixels.
    ///
    /// The corners may go round either way; where the outline crosses itself, the non-zero winding rule holds. Fewer
    /// than three corners enclose nothing.
    ///
    /// # Errors
    /// [`SpanError::OutOfReach`] when a corner is not finite or farther than [`MAX_REACH_PX`] from the origin.
    pub fn from_polygon(corners_px: &[[f64; 2]]) -> Result<Self, SpanError> {
        check_points(corners_px)?;
        let mut spans = Vec::new();
        draw::polygon(corners_px, &mut spans);
        Ok(Self::from_spans(spans))
    }

    /// The pixels within half of `width_px` of a polyline with points (u, v) in pixels, with butt ends: the union of a
    /// rectangle for each segment and a disc at each inner point.
    ///
    /// Fewer than two different points make an empty mask.
    ///
    /// # Errors
    /// [`SpanError::OutOfReach`] as for [`SpanMask::from_polygon`]; [`SpanError::Width`] when the width is not above 0
    /// or not finite.
    pub fn stroke(polyline_px: &[[f64; 2]], width_px: f64) -> Result<Self, SpanError> {
        let mut mask = Self::default();
        mask.redraw_stroke(polyline_px, width_px)?;
        Ok(mask)
    }

    /// Draws [`SpanMask::stroke`] in place of what the mask was, reusing its memory.
    ///
    /// # Errors
    /// [`SpanError`] as for [`SpanMask::stroke`]; the mask is then as before.
    pub fn redraw_stroke(&mut self, polyline_px: &[[f64; 2]], width_px: f64) -> Result<(), SpanError> {
        check_points(polyline_px)?;
        // Written so that NaN is refused.
        if !(width_px > 0.0 && width_px <= MAX_REACH_PX) {
            return Err(SpanError::Width { width_px });
        }
        self.spans.clear();
        draw::stroke(polyline_px, width_px, &mut self.spans);
        self.tidy();
        Ok(())
    }

    /// Sorts the runs, merges those that overlap or touch, drops empty ones and counts the pixels.
    fn tidy(&mut self) {
        self.spans.retain(|span| span.start < span.end);
        self.spans.sort_unstable();
        self.spans.dedup_by(|span, last| {
            let joined = last.row == span.row && span.start <= last.end;
            if joined {
                last.end = last.end.max(span.end);
            }
            joined
        });
        self.area = self.spans.iter().map(|span| u64::from(span.end.abs_diff(span.start))).sum();
    }

    /// The runs, sorted by row and column.
    #[must_use]
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Number of pixels.
    #[must_use]
    pub fn area(&self) -> u64 {
        self.area
    }

    /// Whether the mask has no pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Mean place (u, v) of the pixels' centres, or `None` when there are none.
    #[must_use]
    pub fn centroid(&self) -> Option<[f64; 2]> {
        if self.is_empty() {
            return None;
        }
        let mut sum = [0.0; 2];
        for span in &self.spans {
            let count = f64::from(span.end) - f64::from(span.start);
            sum[0] += count * 0.5 * (f64::from(span.start) + f64::from(span.end) - 1.0);
            sum[1] += count * f64::from(span.row);
        }
        Some(sum.map(|value| value / self.area as f64))
    }

    /// The pixels that are in either mask.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self::from_spans(self.spans.iter().chain(&other.spans).copied().collect())
    }

    /// The pixels that lie inside `rect`.
    #[must_use]
    pub fn intersect_rect(&self, rect: Rect) -> Self {
        let columns = (saturate(rect.x), saturate(rect.x.saturating_add(rect.width)));
        let rows = saturate(rect.y)..saturate(rect.y.saturating_add(rect.height));
        let inside = self.spans.iter().filter(|span| rows.contains(&span.row)).map(|span| Span {
            row: span.row,
            start: span.start.max(columns.0),
            end: span.end.min(columns.1),
        });
        Self::from_spans(inside.collect())
    }

    /// The mask moved by whole pixels; what would leave the range of `i32` is left out.
    #[must_use]
    pub fn translated(&self, d_col: i32, d_row: i32) -> Self {
        let moved = self.spans.iter().filter_map(|span| {
            Some(Span {
                row: span.row.checked_add(d_row)?,
                start: span.start.saturating_add(d_col),
                end: span.end.saturating_add(d_col),
            })
        });
        Self::from_spans(moved.collect())
    }
}

fn saturate(value: usize) -> i32 {
    i32::try_from(value).unwrap_or(i32::MAX)
}

fn check_points(points_px: &[[f64; 2]]) -> Result<(), SpanError> {
    // Written so that NaN is refused.
    let reachable = |point: &[f64; 2]| point.iter().all(|value| value.abs() <= MAX_REACH_PX);
    match points_px.iter().find(|point| !reachable(point)) {
        Some(&[u_px, v_px]) => Err(SpanError::OutOfReach { u_px, v_px }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(row: i32, start: i32, end: i32) -> Span {
        Span { row, start, end }
    }

    #[test]
    fn runs_are_sorted_merged_and_counted() {
        let mask = SpanMask::from_spans(vec![
            span(1, 5, 8),
            span(0, 2, 2),
            span(1, -3, 1),
            span(1, 8, 9),
            span(-2, 0, 1),
            span(1, 6, 7),
        ]);
        assert_eq!(mask.spans(), &[span(-2, 0, 1), span(1, -3, 1), span(1, 5, 9)]);
        assert_eq!(mask.area(), 9);
    }

    #[test]
    fn union_counts_shared_pixels_once() {
        let left = SpanMask::from_rect(Rect { x: 0, y: 0, width: 4, height: 3 });
        let right = SpanMask::from_rect(Rect { x: 2, y: 1, width: 4, height: 3 });
        let both = left.union(&right);
        assert_eq!(both.area(), 12 + 12 - 4);
        assert_eq!(both.union(&left), both);
    }

    #[test]
    fn moving_there_and_back_changes_nothing_and_cutting_keeps_what_is_inside() {
        let mask = SpanMask::stroke(&[[-4.0, 2.0], [5.0, 9.0]], 3.0).unwrap();
        assert_eq!(mask.translated(-7, 11).translated(7, -11), mask);
        let cut = mask.intersect_rect(Rect { x: 0, y: 0, width: 100, height: 6 });
        assert!(cut.spans().iter().all(|span| span.start >= 0 && (0..6).contains(&span.row)));
        assert_eq!(cut.union(&mask), mask);
        assert_eq!(SpanMask::default().centroid(), None);
    }

    #[test]
    fn extremes_do_not_overflow() {
        let mask = SpanMask::from_spans(vec![span(i32::MAX, i32::MIN, i32::MAX)]);
        assert_eq!(mask.area(), u64::from(u32::MAX));
        assert!(mask.translated(0, 1).is_empty());
        assert_eq!(mask.translated(i32::MAX, 0).spans(), &[span(i32::MAX, -1, i32::MAX)]);
    }

    #[test]
    fn a_stroke_drawn_again_is_as_drawn_anew() {
        let mut mask = SpanMask::stroke(&[[0.0, 0.0], [40.0, 3.0], [10.0, 30.0]], 7.0).unwrap();
        let anew = SpanMask::stroke(&[[-4.0, 2.0], [5.0, 9.0]], 3.0).unwrap();
        assert!(mask.redraw_stroke(&[[0.0, 0.0], [f64::NAN, 0.0]], 3.0).is_err());
        assert_ne!(mask, anew);
        mask.redraw_stroke(&[[-4.0, 2.0], [5.0, 9.0]], 3.0).unwrap();
        assert_eq!(mask, anew);
    }

    #[test]
    fn shapes_that_cannot_be_drawn_are_errors() {
        for bad in [f64::NAN, f64::INFINITY, 1e9] {
            let points = [[0.0, 0.0], [bad, 1.0], [3.0, 3.0]];
            assert!(matches!(SpanMask::from_polygon(&points), Err(SpanError::OutOfReach { .. })));
            assert!(matches!(SpanMask::stroke(&points, 1.0), Err(SpanError::OutOfReach { .. })));
        }
        for width_px in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                SpanMask::stroke(&[[0.0; 2], [1.0; 2]], width_px),
                Err(SpanError::Width { .. })
            ));
        }
    }
}

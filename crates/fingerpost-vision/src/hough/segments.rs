//! Segments: the runs of pixels along the strongest lines.
//!
//! Lines are walked from the strongest on. Pixels of a segment that is long enough count for no line afterwards, and a
//! line is left out when too few are left on it. This finds what the progressive probabilistic transform (J. Matas,
//! C. Galambos and J. Kittler, CVIU 78(1), 2000) finds by random samples, but all pixels vote and no chance is in it.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use super::remaining::BitRows;
use super::{HoughError, HoughLine, HoughLines, HoughParams};
use crate::picture::PlaneView;
use crate::simd::CodePath;

/// A straight segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// First end, `[u, v]` in the image frame on the line, pixels: the left one, or the upper one of a steep segment.
    pub start_px: [f64; 2],
    /// Other end.
    pub end_px: [f64; 2],
    /// Columns, or rows of a steep segment, that have a pixel on it.
    pub support_px: usize,
    /// The line that it lies on.
    pub line: HoughLine,
}

impl Segment {
    /// Length, pixels.
    #[must_use]
    pub fn length_px(&self) -> f64 {
        libm::hypot(self.end_px[0] - self.start_px[0], self.end_px[1] - self.start_px[1])
    }
}

/// Finds straight segments, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::hough::{HoughParams, HoughSegments};
/// use fingerpost_vision::picture::Plane;
/// let mut edges = Plane::new(60, 30, 0_u8);
/// edges.row_mut(7)[5..50].fill(255);
/// edges.row_mut(7)[20] = 0;
/// let params = HoughParams { rho_step_px: 1.0, theta_step_rad: 1_f64.to_radians(), votes: 20 };
/// let mut finder = HoughSegments::new(params, 25.0, 3.0)?;
/// let segments = finder.find(edges.view());
/// assert_eq!(segments.len(), 1);
/// assert_eq!((segments[0].start_px[0], segments[0].end_px[0], segments[0].support_px), (5.0, 49.0, 44));
/// # Ok::<(), fingerpost_vision::hough::HoughError>(())
/// ```
#[derive(Debug, Clone)]
pub struct HoughSegments {
    lines: HoughLines,
    votes: usize,
    min_length_px: f64,
    max_gap_px: f64,
    /// Pixels across a line within which all that voted for it lie.
    reach_px: isize,
    /// Pixels left, by rows.
    in_rows: BitRows,
    /// The same, by columns.
    in_columns: BitRows,
    runs: Vec<Run>,
    segments: Vec<Segment>,
}

/// Places along a line from `first` to `last`, of which `support` have a pixel.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: usize,
    last: usize,
    support: usize,
}

/// A line as a function along the axis that it is nearer to.
#[derive(Debug, Clone, Copy)]
struct Course {
    line: HoughLine,
    axis: Axis,
    /// Place across that axis at its zero, pixels.
    offset_px: f64,
    slope: f64,
    /// Both in steps of 2^-[`FRACTION_BITS`], the place half a pixel further, so that cutting off rounds.
    fixed: [i64; 2],
}

/// Fraction of places along a walk: an error of 2^-33 a step stays invisible over any picture's length, and rounding takes
/// one instruction where a floating-point one takes a call on processors' common base.
const FRACTION_BITS: u32 = 32;

#[derive(Debug, Clone, Copy)]
enum Axis {
    U,
    V,
}

impl HoughSegments {
    /// A finder of segments of at least `min_length_px` that are nowhere interrupted for more than `max_gap_px`, both
    /// along the segment, on lines found as by [`HoughLines`].
    ///
    /// # Errors
    /// [`HoughError`] when a step is too fine, too large or no number, or a length negative or no number.
    pub fn new(params: HoughParams, min_length_px: f64, max_gap_px: f64) -> Result<Self, HoughError> {
        for (what, length_px) in [("least length", min_length_px), ("largest gap", max_gap_px)] {
            if !(length_px.is_finite() && length_px >= 0.0) {
                return Err(HoughError::Length { what, length_px });
            }
        }
        Ok(Self {
            lines: HoughLines::new(params)?,
            votes: params.votes as usize,
            min_length_px,
            max_gap_px,
            // Half a step from the line is up to 1 / sqrt 2 of a step along an axis.
            reach_px: (params.rho_step_px * FRAC_1_SQRT_2).ceil() as isize,
            in_rows: BitRows::default(),
            in_columns: BitRows::default(),
            runs: Vec::new(),
            segments: Vec::new(),
        })
    }

    /// Finds the segments among the pixels of `edges` that are not 0, those of the strongest lines first.
    pub fn find(&mut self, edges: PlaneView<'_, u8>) -> &[Segment] {
        self.find_on(CodePath::fastest(), edges)
    }

    pub(super) fn find_on(&mut self, path: CodePath, edges: PlaneView<'_, u8>) -> &[Segment] {
        self.lines.find_on(path, edges);
        let (width, height) = edges.size();
        self.in_rows.reset(width, height);
        self.in_columns.reset(height, width);
        let [columns, rows] = &self.lines.places;
        for (&column, &row) in columns.iter().zip(rows) {
            self.in_rows.set(row as usize, column as usize);
            self.in_columns.set(column as usize, row as usize);
        }
        self.segments.clear();
        for number in 0..self.lines.lines.len() {
            let course = Course::of(self.lines.lines[number]);
            self.collect_runs(course, edges.size());
            if self.runs.iter().map(|run| run.support).sum::<usize>() > self.votes {
                self.take_runs(course);
            }
        }
        &self.segments
    }

    /// Finds where a line has pixels left, gaps bridged.
    fn collect_runs(&mut self, course: Course, (width, height): (usize, usize)) {
        let (rows, length, breadth) = match course.axis {
            Axis::U => (&self.in_columns, width, height),
            Axis::V => (&self.in_rows, height, width),
        };
        // Steps along the axis, each hypot(1, slope) long, that are no longer than the largest gap.
        let gap = (self.max_gap_px / course.step_length_px()).floor() as usize;
        let window = (2 * self.reach_px + 1) as usize;
        self.runs.clear();
        for along in course.inside(length, breadth, self.reach_px) {
            if rows.window(along, course.nearest(along) - self.reach_px, window) == 0 {
                continue;
            }
            match self.runs.last_mut() {
                Some(run) if along - run.last - 1 <= gap => {
                    run.last = along;
                    run.support += 1;
                }
                _ => self.runs.push(Run { first: along, last: along, support: 1 }),
            }
        }
    }

    /// Makes segments of those runs that are long enough, and takes their pixels away.
    fn take_runs(&mut self, course: Course) {
        let window = (2 * self.reach_px + 1) as usize;
        for &Run { first, last, support } in &self.runs {
            if ((last - first) as f64) * course.step_length_px() < self.min_length_px {
                continue;
            }
            let [start_px, end_px] = [first, last].map(|along| course.at(along));
            self.segments.push(Segment { start_px, end_px, support_px: support, line: course.line });
            let (rows, turned) = match course.axis {
                Axis::U => (&mut self.in_columns, &mut self.in_rows),
                Axis::V => (&mut self.in_rows, &mut self.in_columns),
            };
            for along in first..=last {
                let start = course.nearest(along) - self.reach_px;
                let mut pixels = rows.window(along, start, window);
                while pixels != 0 {
                    let across = start.saturating_add(pixels.trailing_zeros() as isize) as usize;
                    rows.clear(along, across);
                    turned.clear(across, along);
                    pixels &= pixels - 1;
                }
            }
        }
    }
}

impl Course {
    fn of(line: HoughLine) -> Self {
        let (sin, cos) = libm::sincos(line.theta_rad);
        let (axis, own, other) =
            if sin.abs() >= cos.abs() { (Axis::U, sin, cos) } else { (Axis::V, cos, sin) };
        let (offset_px, slope) = (line.rho_px / own, -other / own);
        let fixed =
            [offset_px + 0.5, slope].map(|value| (value * libm::exp2(f64::from(FRACTION_BITS))) as i64);
        Self { line, axis, offset_px, slope, fixed }
    }

    fn step_length_px(&self) -> f64 {
        libm::hypot(self.slope, 1.0)
    }

    fn across(&self, along: usize) -> f64 {
        self.offset_px + self.slope * along as f64
    }

    /// The pixel across the axis that is nearest to the line.
    #[inline]
    fn nearest(&self, along: usize) -> isize {
        let [offset, slope] = self.fixed;
        (offset.wrapping_add(slope.wrapping_mul(along as i64)) >> FRACTION_BITS) as isize
    }

    /// The place on the line, `[u, v]`.
    fn at(&self, along: usize) -> [f64; 2] {
        match self.axis {
            Axis::U => [along as f64, self.across(along)],
            Axis::V => [self.across(along), along as f64],
        }
    }

    /// Where the line is inside a picture of `length` pixels along and `breadth` pixels across it, or `reach` beside it.
    fn inside(&self, length: usize, breadth: usize, reach: isize) -> Range<usize> {
        // The rounding to a pixel may reach half a pixel more.
        let margin = reach as f64 + 0.5;
        let [first, second] =
            [-margin, breadth as f64 - 1.0 + margin].map(|across| (across - self.offset_px) / self.slope);
        let (from, to) = (first.min(second), first.max(second));
        // A line along the axis meets neither edge; infinite or undefined places leave the whole length.
        let start = if from > 0.0 { from.floor() } else { 0.0 };
        let end = if to < length as f64 { (to.ceil() + 1.0).max(0.0) } else { length as f64 };
        start as usize..(end as usize).min(length)
    }
}

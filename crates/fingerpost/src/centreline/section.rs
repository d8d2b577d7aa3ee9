//! The road's edges in a section of the window.

use std::ops::RangeInclusive;

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::hough::HoughLine;
use fingerpost_vision::picture::{PlaneView, Rect};

use super::fit::Course as RoadCourse;
use super::{CentrelineConfig, SectionEvidence, SectionUse};

/// How far beside a line the probability is compared, metres: past the blur of an edge, before the next thing.
const BESIDE_M: [f64; 3] = [0.2, 0.35, 0.5];
/// Towards the road's middle, in columns, from its left and from its right edge.
const INWARDS: [f64; 2] = [1.0, -1.0];
/// Rows in which both sides of a line must be known, as a share of the section's.
const MIN_KNOWN_SHARE: f64 = 0.5;

/// A line along the road's edge.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RoadEdge {
    /// How far left of the vehicle's centre line it is in the middle of its section, metres.
    pub left_m: f64,
    /// How much farther left a metre ahead.
    pub slope: f64,
    /// Edge pixels on it.
    pub votes: u32,
    /// How much more road is on its inner side than on its outer one, 0 to 1.
    pub contrast: f64,
}

/// The window's part of the surface.
#[derive(Clone, Copy)]
pub(super) struct Window<'a> {
    pub(super) probability: PlaneView<'a, u8>,
    pub(super) known: PlaneView<'a, u8>,
}

/// Chooses among the lines of a section.
pub(super) struct Finder<'a> {
    pub(super) config: &'a CentrelineConfig,
    pub(super) window: Window<'a>,
    pub(super) grid: GroundGrid,
    /// The window's first row in the ground view.
    pub(super) top: usize,
}

impl Finder<'_> {
    /// Columns a row that a line in `rect` of the window may have to be an edge.
    pub(super) fn slopes(&self, rect: Rect, road: &RoadCourse) -> RangeInclusive<f64> {
        // Lines on the limit are asked again when their exact slope is known.
        const ROUNDING: f64 = 1e-6;
        let (slope, most) = (self.expected(rect, road)[1], self.max_turn() + ROUNDING);
        (slope - most).max(-1.0 - ROUNDING)..=(slope + most).min(1.0 + ROUNDING)
    }

    /// How far ahead a rectangle of the window begins and ends, metres.
    fn forward_m(&self, rect: Rect) -> [f64; 2] {
        let x = |row: f64| {
            let row = (self.top + rect.y) as f64 + row;
            self.grid.vehicle_from_ground(GroundPixel { column: 0.0, row }).x
        };
        [x(rect.height as f64 - 0.5), x(-0.5)]
    }

    /// How far left the road's middle is expected in a rectangle, metres, and how much farther a metre ahead.
    fn expected(&self, rect: Rect, road: &RoadCourse) -> [f64; 2] {
        let [near_m, far_m] = self.forward_m(rect);
        road.at(0.5 * (near_m + far_m))
    }

    fn max_turn(&self) -> f64 {
        libm::tan(self.config.max_heading_deg.to_radians())
    }

    /// The edges in `rect` of the window, of lines with the most votes first. `road` is where the road's middle is expected: at first
    /// along the vehicle, which stands on it.
    pub(super) fn section(&self, lines: &[HoughLine], rect: Rect, road: &RoadCourse) -> SectionEvidence {
        let forward_m = self.forward_m(rect);
        let [middle_m, slope] = self.expected(rect, road);
        let max_turn = self.max_turn();
        let mut edges: [Option<RoadEdge>; 2] = [None; 2];
        for line in lines {
            if edges.iter().all(Option::is_some) {
                break;
            }
            let Some(course) = Course::of(line, rect) else { continue };
            // Left of the picture is left, and up is ahead: columns a row are metres to the left a metre ahead.
            let edge_slope = course.columns_per_row;
            let left_m = self.grid.half_width_m()
                - (course.column_at(0.5 * (rect.height as f64 - 1.0)) + 0.5) * self.grid.metres_per_pixel();
            if (edge_slope - slope).abs() > max_turn {
                continue;
            }
            let side = usize::from(left_m < middle_m);
            if edges[side].is_some_and(|edge| edge.votes >= line.votes) {
                continue;
            }
            let Some(contrast) = self.contrast(&course, rect, INWARDS[side]) else { continue };
            if contrast >= self.config.min_contrast {
                edges[side] = Some(RoadEdge { left_m, slope: edge_slope, votes: line.votes, contrast });
            }
        }
        let section_use = match edges {
            [None, None] => SectionUse::NoEdges,
            [Some(_), Some(_)] => SectionUse::BothEdges,
            _ => SectionUse::OneEdge,
        };
        SectionEvidence { forward_m, edges, section_use }
    }

    /// How much more road is beside a line on its inner side than on its outer one; none where too little is known.
    fn contrast(&self, course: &Course, rect: Rect, inwards: f64) -> Option<f64> {
        let scale_m = self.grid.metres_per_pixel();
        let (mut difference, mut known) = (0.0, 0_usize);
        for row in 0..rect.height {
            let column = course.column_at(row as f64);
            let mean = |away: f64| {
                let at = |beside_m: f64| self.at(column + away * beside_m / scale_m, rect.y + row);
                BESIDE_M
                    .iter()
                    .try_fold(0.0, |sum, beside_m| Some(sum + at(*beside_m)? / BESIDE_M.len() as f64))
            };
            if let Some((inner, outer)) = mean(inwards).zip(mean(-inwards)) {
                difference += inner - outer;
                known += 1;
            }
        }
        let enough = known as f64 >= MIN_KNOWN_SHARE * rect.height as f64;
        enough.then(|| difference / known as f64)
    }

    /// Probability of road at a pixel of the window; none where it is not known.
    fn at(&self, column: f64, row: usize) -> Option<f64> {
        let column = column.round();
        if !(0.0..self.window.probability.width() as f64).contains(&column) {
            return None;
        }
        let column = column as usize;
        let known = self.window.known.row(row)[column] != 0;
        known.then(|| f64::from(self.window.probability.row(row)[column]) / 255.0)
    }
}

/// A line as a column for every row.
struct Course {
    first_column: f64,
    columns_per_row: f64,
}

impl Course {
    /// None for a line that lies across the section or misses it.
    fn of(line: &HoughLine, rect: Rect) -> Option<Self> {
        let (sin, cos) = libm::sincos(line.theta_rad);
        if cos.abs() < sin.abs() {
            return None;
        }
        let course = Self { first_column: line.rho_px / cos, columns_per_row: -sin / cos };
        let middle = course.column_at(0.5 * (rect.height as f64 - 1.0));
        (-0.5..rect.width as f64 - 0.5).contains(&middle).then_some(course)
    }

    fn column_at(&self, row: f64) -> f64 {
        self.first_column + self.columns_per_row * row
    }
}

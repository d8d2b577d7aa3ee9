//! A road's own coordinates, and its white lines.

use super::Footprint;
use super::varied::covered;
use crate::conditions::Markings;
use crate::ground::GroundPoint;
use crate::noise::floor_int;
use crate::roads::{Stroke, Surface};

/// Width of a white line, metres.
const LINE_M: f32 = 0.14;
/// Distance of an edge line's middle from the road's edge, metres.
pub(crate) const EDGE_LINE_M: f64 = 0.25;
/// Length of a dash and of dash and gap together, metres.
const DASH_M: [f32; 2] = [3.0, 9.0];
/// Narrowest two-way road with a centre line, metres.
const CENTRE_LINE_FROM_M: f64 = 5.0;
/// Narrowest road with edge lines, metres.
const EDGE_LINES_FROM_M: f64 = 5.4;
/// Lines stop this far from another road's edge, metres.
const MOUTH_M: f32 = 0.6;

/// A stroke as the pixels need it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lane {
    chain: u32,
    start: [f32; 2],
    direction: [f32; 2],
    along_m: f32,
    half_width_m: f32,
    lines: Lines,
    pub(super) surface: Surface,
}

/// A place told by the road it is on or beside.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocalPlace {
    pub(super) chain: u32,
    /// Distance from the chain's start.
    pub(super) along_m: f32,
    /// Distance from the axis, positive to the left.
    pub(super) left_m: f32,
    pub(super) half_width_m: f32,
    pub(super) direction: [f32; 2],
}

impl LocalPlace {
    /// Extents of a pixel along and across the road, metres.
    pub(super) fn extents_m(&self, footprint: &Footprint) -> [f32; 2] {
        let [x, y] = self.direction;
        [footprint.extent_m([x, y]), footprint.extent_m([-y, x])]
    }
}

/// Which white lines a road has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lines {
    /// A dashed line in the middle.
    pub(crate) centre: bool,
    /// A line along each edge.
    pub(crate) edges: bool,
}

impl Lines {
    /// The lines of a stroke under these markings.
    pub(crate) fn of(stroke: &Stroke, markings: Markings) -> Self {
        let drawn = markings == Markings::Lines && stroke.surface == Surface::Paved;
        let width_m = 2.0 * stroke.half_width_m;
        Self {
            centre: drawn && stroke.two_way && width_m >= CENTRE_LINE_FROM_M,
            edges: drawn && width_m >= EDGE_LINES_FROM_M,
        }
    }

    /// Whether lines are drawn at a place so far from another road's edge.
    pub(crate) fn interrupted(other_m: f32) -> bool {
        other_m < MOUTH_M
    }
}

impl Lane {
    /// The lane of a stroke under these markings.
    pub(super) fn new(stroke: &Stroke, markings: Markings) -> Self {
        Self {
            chain: stroke.chain,
            start: [stroke.start.x as f32, stroke.start.y as f32],
            direction: [stroke.direction.x as f32, stroke.direction.y as f32],
            along_m: stroke.along_m as f32,
            half_width_m: stroke.half_width_m as f32,
            lines: Lines::of(stroke, markings),
            surface: stroke.surface,
        }
    }

    /// The place in the road's own coordinates.
    #[inline]
    pub(super) fn place(&self, x: f32, y: f32) -> LocalPlace {
        let (dx, dy) = (x - self.start[0], y - self.start[1]);
        LocalPlace {
            chain: self.chain,
            along_m: self.along_m + dx * self.direction[0] + dy * self.direction[1],
            left_m: self.direction[0] * dy - self.direction[1] * dx,
            half_width_m: self.half_width_m,
            direction: self.direction,
        }
    }

    /// Share of the pixel that a white line covers.
    #[inline]
    pub(super) fn paint(&self, x: f32, y: f32, point: &GroundPoint, footprint: &Footprint) -> f32 {
        if !(self.lines.centre || self.lines.edges) || Lines::interrupted(point.other_m) {
            return 0.0;
        }
        let (dx, dy) = (x - self.start[0], y - self.start[1]);
        let left = self.direction[0] * dy - self.direction[1] * dx;
        let edge = left.abs() - (self.half_width_m - EDGE_LINE_M as f32);
        if left.abs().min(edge.abs()) > 0.5 * LINE_M + footprint.along_m {
            return 0.0;
        }
        let across = footprint.extent_m([-self.direction[1], self.direction[0]]);
        let mut paint = 0.0_f32;
        if self.lines.edges {
            paint = covered(edge, LINE_M, across);
        }
        if self.lines.centre {
            let line = covered(left, LINE_M, across);
            if line > 0.0 {
                let along = self.along_m + dx * self.direction[0] + dy * self.direction[1];
                let in_period = along - DASH_M[1] * floor_int(along / DASH_M[1]) as f32;
                let dash =
                    covered(in_period - 0.5 * DASH_M[0], DASH_M[0], footprint.extent_m(self.direction));
                paint = paint.max(line * dash.min(1.0));
            }
        }
        paint
    }
}

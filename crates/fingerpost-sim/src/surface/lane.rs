//! A road's own coordinates, and its painted lines.

use fingerpost_format::MarkingColour;

use super::materials::RoadGround;
use super::varied::covered;
use super::{Colour, Footprint};
use crate::ground::GroundPoint;
use crate::markings::{Layout, Line};
use crate::mouth_lines::MouthLine;
use crate::noise::floor_int;
use crate::roads::{Stroke, Surface};
use crate::{Conditions, TrafficSide};

/// Paint in full light.
const WHITE: Colour = [0.74, 0.74, 0.70];
const YELLOW: Colour = [0.70, 0.46, 0.06];

/// A stroke as the pixels need it.
#[derive(Debug, Clone)]
pub(super) struct Lane {
    pub(super) chain: u32,
    start: [f32; 2],
    direction: [f32; 2],
    along_m: f32,
    half_width_m: f32,
    lines: Vec<Line>,
    mouths: Vec<MouthLine>,
    pub(super) surface: Surface,
    /// What it is made of, where that is not the usual ground.
    pub(super) ground: Option<RoadGround>,
}

/// A place told by the road it is on or beside.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalPlace {
    pub(crate) chain: u32,
    /// Distance from the chain's start.
    pub(crate) along_m: f32,
    /// Distance from the axis, positive to the left.
    pub(crate) left_m: f32,
    pub(crate) half_width_m: f32,
    pub(crate) direction: [f32; 2],
}

impl LocalPlace {
    /// Extents of a pixel along and across the road, metres.
    pub(super) fn extents_m(&self, footprint: &Footprint) -> [f32; 2] {
        let [x, y] = self.direction;
        [footprint.extent_m([x, y]), footprint.extent_m([-y, x])]
    }
}

impl Lane {
    /// The lane of a stroke.
    pub(super) fn new(stroke: &Stroke, conditions: &Conditions, traffic: TrafficSide) -> Self {
        Self {
            chain: stroke.chain,
            start: [stroke.start.x as f32, stroke.start.y as f32],
            direction: [stroke.direction.x as f32, stroke.direction.y as f32],
            along_m: stroke.along_m as f32,
            half_width_m: stroke.half_width_m as f32,
            lines: Layout::of(stroke, conditions, traffic).lines().to_vec(),
            mouths: Vec::new(),
            surface: stroke.surface,
            ground: None,
        }
    }

    /// Adds a line at one of its mouths.
    pub(super) fn add_mouth(&mut self, line: MouthLine) {
        self.mouths.push(line);
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

    /// Share of the pixel that paint covers, and the paint's colour.
    #[inline]
    pub(super) fn paint(&self, x: f32, y: f32, point: &GroundPoint, footprint: &Footprint) -> (f32, Colour) {
        let mut found = (0.0_f32, WHITE);
        if !self.mouths.is_empty() {
            found.0 = self.mouth_paint(x, y, point, footprint);
        }
        if self.lines.is_empty() || Layout::interrupted(point.other_m) {
            return found;
        }
        let (dx, dy) = (x - self.start[0], y - self.start[1]);
        let left = self.direction[0] * dy - self.direction[1] * dx;
        for line in &self.lines {
            let from_middle = left - line.middle_m;
            if from_middle.abs() > 0.5 * line.width_m + footprint.along_m {
                continue;
            }
            let across = footprint.extent_m([-self.direction[1], self.direction[0]]);
            let mut share = covered(from_middle, line.width_m, across);
            if let Some([dash_m, period_m]) = line.dash_m.filter(|_| share > 0.0) {
                let along = self.along_m + dx * self.direction[0] + dy * self.direction[1];
                let in_period = along - period_m * floor_int(along / period_m) as f32;
                let dash = covered(in_period - 0.5 * dash_m, dash_m, footprint.extent_m(self.direction));
                share *= dash.min(1.0);
            }
            if share > found.0 {
                found = (share, if line.colour == MarkingColour::Yellow { YELLOW } else { WHITE });
            }
        }
        found
    }

    /// Share of the pixel that stop and give-way lines cover.
    #[inline(never)]
    fn mouth_paint(&self, x: f32, y: f32, point: &GroundPoint, footprint: &Footprint) -> f32 {
        let place = self.place(x, y);
        let extents_m = place.extents_m(footprint);
        let at = [place.along_m, place.left_m, point.other_m];
        let shares = self.mouths.iter().map(|line| line.covers(at, extents_m, covered));
        shares.fold(0.0, f32::max)
    }
}

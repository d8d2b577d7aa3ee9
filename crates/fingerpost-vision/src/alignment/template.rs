//! The older picture, as points with much gradient.

use super::{LANES, Lanes, QuadraticField, UNKNOWNS};
use crate::picture::{Plane, Rect};
use crate::simd::{CodePath, simd_kernel};

/// A place far outside any picture: what fills up the last lanes.
const NOWHERE: f32 = -1e6;

/// Points of a picture with their grey and gradient, in groups of lanes.
#[derive(Debug, Clone, Default)]
pub struct Template {
    pub(super) u: Vec<Lanes>,
    pub(super) v: Vec<Lanes>,
    pub(super) grey: Vec<Lanes>,
    gradient_u: Vec<Lanes>,
    gradient_v: Vec<Lanes>,
    /// Change of grey for a unit of each unknown (the steepest-descent images).
    pub(super) descent: [Vec<Lanes>; UNKNOWNS],
    points: usize,
    strength: Vec<u16>,
}

impl Template {
    /// Takes in the points of `grey` (0: unseen) within `region`: of each cell of `cell` x `cell` pixels the one with the
    /// largest gradient, the first of equals. A point has its four neighbours seen.
    pub fn choose(&mut self, grey: &Plane<u8>, region: Rect, cell: usize) {
        self.choose_with(CodePath::fastest(), grey, region, cell);
    }

    pub(super) fn choose_with(&mut self, path: CodePath, grey: &Plane<u8>, region: Rect, cell: usize) {
        for lanes in [&mut self.u, &mut self.v, &mut self.grey, &mut self.gradient_u, &mut self.gradient_v] {
            lanes.clear();
        }
        self.points = 0;
        let cell = cell.max(1);
        let left = region.x.max(1);
        let right = (region.x + region.width).min(grey.width().saturating_sub(1));
        let top = region.y.max(1);
        let bottom = (region.y + region.height).min(grey.height().saturating_sub(1));
        let columns = right.saturating_sub(left) / cell;
        let width = columns * cell;
        self.strength.resize(width * cell, 0);
        for row in 0..bottom.saturating_sub(top) / cell {
            let y = top + row * cell;
            for dy in 0..cell {
                let span = |y: usize, x: usize| &grey.row(y)[x..x + width];
                let cross = [
                    span(y + dy, left),
                    span(y + dy, left - 1),
                    span(y + dy, left + 1),
                    span(y + dy - 1, left),
                    span(y + dy + 1, left),
                ];
                strengths(path, cross, &mut self.strength[dy * width..][..width]);
            }
            for column in 0..columns {
                let mut best = (0, 0, 0);
                for dy in 0..cell {
                    let strengths = &self.strength[dy * width + column * cell..][..cell];
                    for (dx, &strength) in strengths.iter().enumerate() {
                        best = if strength > best.0 { (strength, dx, dy) } else { best };
                    }
                }
                if best.0 > 0 {
                    self.push(grey, left + column * cell + best.1, y + best.2);
                }
            }
        }
        for descent in &mut self.descent {
            descent.clear();
            descent.resize(self.u.len(), [0.0; LANES]);
        }
    }

    fn push(&mut self, grey: &Plane<u8>, x: usize, y: usize) {
        let lane = self.points % LANES;
        if lane == 0 {
            self.u.push([NOWHERE; LANES]);
            self.v.push([NOWHERE; LANES]);
            self.grey.push([0.0; LANES]);
            self.gradient_u.push([0.0; LANES]);
            self.gradient_v.push([0.0; LANES]);
        }
        let at = |x: usize, y: usize| f32::from(grey.row(y)[x]);
        let group = self.points / LANES;
        self.u[group][lane] = x as f32;
        self.v[group][lane] = y as f32;
        self.grey[group][lane] = at(x, y);
        self.gradient_u[group][lane] = 0.5 * (at(x + 1, y) - at(x - 1, y));
        self.gradient_v[group][lane] = 0.5 * (at(x, y + 1) - at(x, y - 1));
        self.points += 1;
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// Place of a point, pixels right and down; `None` beyond the last.
    #[must_use]
    pub fn place(&self, point: usize) -> Option<[f32; 2]> {
        (point < self.points)
            .then(|| [self.u[point / LANES][point % LANES], self.v[point / LANES][point % LANES]])
    }

    /// Sets the directions in which the warp may change: how far each place moves for a unit of each unknown.
    pub fn set_directions(&mut self, fields: &[QuadraticField; UNKNOWNS]) {
        self.set_directions_with(CodePath::fastest(), fields);
    }

    pub(super) fn set_directions_with(&mut self, path: CodePath, fields: &[QuadraticField; UNKNOWNS]) {
        for (field, descent) in fields.iter().zip(&mut self.descent) {
            descend(path, field, [&self.u, &self.v, &self.gradient_u, &self.gradient_v], descent);
        }
    }
}

simd_kernel! {
    /// Sum of the gradient's absolute parts and 1, or 0 where a pixel of the cross (middle, left, right, above, below) is
    /// unseen.
    fn strengths(cross: [&[u8]; 5], out: &mut [u16]) {
        let n = out.len();
        let [middle, left, right, above, below] = cross.map(|row| &row[..n]);
        for i in 0..n {
            let seen = middle[i].min(left[i]).min(right[i]).min(above[i]).min(below[i]);
            let strength =
                u16::from(left[i].abs_diff(right[i])) + u16::from(above[i].abs_diff(below[i])) + 1;
            out[i] = if seen == 0 { 0 } else { strength };
        }
    }
}

simd_kernel! {
    fn descend(field: &QuadraticField, points: [&[Lanes]; 4], out: &mut [Lanes]) {
        let n = out.len();
        let [u, v, gradient_u, gradient_v] = points.map(|lanes| &lanes[..n]);
        for i in 0..n {
            for lane in 0..LANES {
                let [right, down] = field.at(u[i][lane], v[i][lane]);
                out[i][lane] = gradient_u[i][lane] * right + gradient_v[i][lane] * down;
            }
        }
    }
}

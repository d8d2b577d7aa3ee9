//! The older picture, as points with much gradient.

use super::{LANES, Lanes, QuadraticField, UNKNOWNS};
use crate::picture::{Plane, Rect};
use crate::simd::{CodePath, simd_kernel};

/// A place far outside any picture: what fills up the last lanes.
const NOWHERE: f32 = -1e6;

/// Largest side of a cell, pixels: the order of its pixels fits eight bits.
const MAX_CELL_PX: usize = 16;
const MOST_ORDERS: usize = MAX_CELL_PX * MAX_CELL_PX;

/// The part of a picture that a vehicle is about to drive through, which is road; what lies beside it may stand higher or
/// upright, and then moves otherwise than the road.
///
/// Points within are believed. Those outside are believed as far as their gradient runs across the columns: a kerb's edge
/// along the direction of travel tells the place across it, however high it is, while the grain of a raised verge would
/// tell a wrong distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corridor {
    /// Column of its middle in row v: coefficients of 1, v and v^2.
    pub middle: [f32; 3],
    /// From its middle to its edge, columns.
    pub half_width: f32,
    /// How far a point outside is believed at the most, 0 to 1.
    pub outside: f32,
}

impl Corridor {
    /// All of a picture.
    pub const EVERYWHERE: Self = Self { middle: [0.0; 3], half_width: f32::INFINITY, outside: 1.0 };

    /// How far a point with that gradient is believed, 0 to 1.
    #[inline(always)]
    fn trust(&self, [u, v]: [f32; 2], [right, down]: [f32; 2]) -> f32 {
        let [constant, linear, square] = self.middle;
        let is_within = (u - (constant + v * (linear + v * square))).abs() <= self.half_width;
        let (across, along) = (right * right, down * down);
        let share = across / (across + along).max(f32::MIN_POSITIVE);
        // To the fourth power: an edge that runs twenty degrees off the direction of travel has half a say.
        if is_within { 1.0 } else { self.outside * (share * share) * (share * share) }
    }
}

/// Points of a picture with their grey and gradient, in groups of lanes.
#[derive(Debug, Clone, Default)]
pub struct Template {
    pub(super) u: Vec<Lanes>,
    pub(super) v: Vec<Lanes>,
    pub(super) grey: Vec<Lanes>,
    /// How far each point is believed, 0 to 1.
    pub(super) trust: Vec<Lanes>,
    gradient_u: Vec<Lanes>,
    gradient_v: Vec<Lanes>,
    /// Change of grey for a unit of each unknown (the steepest-descent images).
    pub(super) descent: [Vec<Lanes>; UNKNOWNS],
    points: usize,
    /// Scratch: of each column of a row of cells the strongest pixel, and the columns' order in their cells.
    keys: Vec<u32>,
    orders: Vec<u32>,
}

impl Template {
    /// Takes in the points of `grey` (0: unseen) within `region`: of each cell of `cell` x `cell` pixels the one with the
    /// largest gradient, the first of equals. A point has its four neighbours seen. Cells have 16 pixels a side at the most.
    /// Points are believed as `corridor` says.
    pub fn choose(&mut self, grey: &Plane<u8>, region: Rect, cell: usize, corridor: &Corridor) {
        self.choose_with(CodePath::fastest(), grey, region, cell, corridor);
    }

    pub(super) fn choose_with(
        &mut self,
        path: CodePath,
        grey: &Plane<u8>,
        region: Rect,
        cell: usize,
        corridor: &Corridor,
    ) {
        self.u.clear();
        self.v.clear();
        self.points = 0;
        let cell = cell.clamp(1, MAX_CELL_PX);
        let left = region.x.max(1);
        let right = region.x.saturating_add(region.width).min(grey.width().saturating_sub(1));
        let top = region.y.max(1);
        let bottom = region.y.saturating_add(region.height).min(grey.height().saturating_sub(1));
        let columns = right.saturating_sub(left) / cell;
        let width = columns * cell;
        self.orders.clear();
        self.orders.extend((0..width).map(|x| (MOST_ORDERS - 1 - x % cell) as u32));
        self.keys.resize(width, 0);
        let rows = if columns > 0 { bottom.saturating_sub(top) / cell } else { 0 };
        // Room for a point in every cell, so that a richer frame needs no new memory.
        let most_groups = (columns * rows).div_ceil(LANES);
        self.u.reserve(most_groups);
        self.v.reserve(most_groups);
        for row in 0..rows {
            let y = top + row * cell;
            self.keys.fill(0);
            for dy in 0..cell {
                let span = |y: usize, x: usize| &grey.row(y)[x..x + width];
                let y = y + dy;
                let (left_of, right_of) = (span(y, left - 1), span(y, left + 1));
                let (above, below) = (span(y - 1, left), span(y + 1, left));
                let later = (dy * cell) as u32;
                strongest(
                    path,
                    span(y, left),
                    left_of,
                    right_of,
                    above,
                    below,
                    &self.orders,
                    later,
                    &mut self.keys,
                );
            }
            for column in 0..columns {
                let best = self.keys[column * cell..][..cell].iter().fold(0, |best, &key| best.max(key));
                if best >= MOST_ORDERS as u32 {
                    let order = MOST_ORDERS - 1 - best as usize % MOST_ORDERS;
                    self.push(left + column * cell + order % cell, y + order / cell);
                }
            }
        }
        let groups = self.u.len();
        let Self { grey: middle, trust, gradient_u, gradient_v, descent, .. } = self;
        for lanes in [middle, trust, gradient_u, gradient_v].into_iter().chain(descent) {
            lanes.clear();
            lanes.reserve(most_groups);
            lanes.resize(groups, [0.0; LANES]);
        }
        self.look(grey);
        judge(path, corridor, [&self.u, &self.v], [&self.gradient_u, &self.gradient_v], &mut self.trust);
        if let Some(last) = self.trust.last_mut() {
            last[(self.points - 1) % LANES + 1..].fill(0.0);
        }
    }

    fn push(&mut self, x: usize, y: usize) {
        let lane = self.points % LANES;
        if lane == 0 {
            self.u.push([NOWHERE; LANES]);
            self.v.push([NOWHERE; LANES]);
        }
        if let (Some(u), Some(v)) = (self.u.last_mut(), self.v.last_mut()) {
            (u[lane], v[lane]) = (x as f32, y as f32);
        }
        self.points += 1;
    }

    /// Sets grey and gradient of every point; each has four neighbours.
    fn look(&mut self, grey: &Plane<u8>) {
        let (values, stride) = (grey.as_slice(), grey.width());
        let mut left = self.points;
        let places = self.u.iter().zip(&self.v);
        let gradients = self.gradient_u.iter_mut().zip(&mut self.gradient_v);
        for (((u, v), middle), (gradient_u, gradient_v)) in places.zip(&mut self.grey).zip(gradients) {
            for lane in 0..left.min(LANES) {
                let above = (v[lane] as usize - 1) * stride + u[lane] as usize;
                let around = &values[above..=above + 2 * stride];
                let at = |index: usize| f32::from(around[index]);
                middle[lane] = at(stride);
                gradient_u[lane] = 0.5 * (at(stride + 1) - at(stride - 1));
                gradient_v[lane] = 0.5 * (at(2 * stride) - at(0));
            }
            left = left.saturating_sub(LANES);
        }
    }

    /// Takes over every `step`-th group of points of another template, for a look that need not be as sure; what it has no
    /// directions of cannot be stepped along.
    pub fn thin(&mut self, all: &Self, step: usize) {
        let step = step.max(1);
        for (some, all) in [
            (&mut self.u, &all.u),
            (&mut self.v, &all.v),
            (&mut self.grey, &all.grey),
            (&mut self.trust, &all.trust),
        ] {
            some.clear();
            some.reserve(all.capacity().div_ceil(step));
            some.extend(all.iter().step_by(step));
        }
        // All groups but the last are full.
        let is_last_taken = all.u.len().saturating_sub(1).is_multiple_of(step);
        let missing = if is_last_taken { all.u.len() * LANES - all.points } else { 0 };
        self.points = self.u.len() * LANES - missing;
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
            descend(path, field, &self.u, &self.v, &self.gradient_u, &self.gradient_v, descent);
        }
    }
}

simd_kernel! {
    /// Raises each key to that of its pixel: the sum of the gradient's absolute parts and 1 above eight bits of `orders`
    /// less `later`; a pixel that is unseen, or beside one, has no strength.
    fn strongest(
        middle: &[u8],
        left: &[u8],
        right: &[u8],
        above: &[u8],
        below: &[u8],
        orders: &[u32],
        later: u32,
        keys: &mut [u32],
    ) {
        let n = keys.len();
        let (middle, left, right) = (&middle[..n], &left[..n], &right[..n]);
        let (above, below, orders) = (&above[..n], &below[..n], &orders[..n]);
        for i in 0..n {
            let least = middle[i].min(left[i]).min(right[i]).min(above[i]).min(below[i]);
            let strength = u32::from(left[i].abs_diff(right[i])) + u32::from(above[i].abs_diff(below[i])) + 1;
            let key = strength * MOST_ORDERS as u32 + (orders[i] - later);
            keys[i] = keys[i].max(if least == 0 { 0 } else { key });
        }
    }
}

simd_kernel! {
    /// Fills `trust` with what `corridor` says of places and gradients.
    fn judge(
        corridor: &Corridor, places: [&[Lanes]; 2], gradients: [&[Lanes]; 2], trust: &mut [Lanes],
    ) {
        let n = trust.len();
        let ([u, v], [right, down]) = (places.map(|lanes| &lanes[..n]), gradients.map(|lanes| &lanes[..n]));
        for i in 0..n {
            for lane in 0..LANES {
                trust[i][lane] =
                    corridor.trust([u[i][lane], v[i][lane]], [right[i][lane], down[i][lane]]);
            }
        }
    }
}

simd_kernel! {
    fn descend(
        field: &QuadraticField,
        u: &[Lanes],
        v: &[Lanes],
        gradient_u: &[Lanes],
        gradient_v: &[Lanes],
        out: &mut [Lanes],
    ) {
        let n = out.len();
        let (u, v) = (&u[..n], &v[..n]);
        let (gradient_u, gradient_v) = (&gradient_u[..n], &gradient_v[..n]);
        for i in 0..n {
            for lane in 0..LANES {
                let [right, down] = field.at(u[i][lane], v[i][lane]);
                out[i][lane] = gradient_u[i][lane] * right + gradient_v[i][lane] * down;
            }
        }
    }
}

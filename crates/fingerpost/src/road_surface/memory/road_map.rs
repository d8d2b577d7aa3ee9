//! A map of the road about the vehicle: log-odds of road in a rolling grid.
//!
//! Cells are read between their centres and written at the nearest.

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::fusion::fade;
use fingerpost_vision::picture::{Plane, ValidityMask};
use nalgebra::{Isometry2, Point2};

use super::rolling_grid::RollingGrid;
use super::sensor_model::{MAX_UNITS, SensorModel};
use crate::ground_view::GroundView;

/// Bits behind the point of places counted in cells or pixels.
const PLACE_BITS: u32 = 16;
const HALF: i64 = 1 << (PLACE_BITS - 1);

/// The map, the view that it lies under, and where.
#[derive(Debug)]
pub(super) struct RoadMap {
    model: SensorModel,
    grid: Option<GroundGrid>,
    /// Pixels of the view along a cell.
    side_px: usize,
    map: RollingGrid,
    /// Evidence that a row of the view gives, in 256ths.
    row_trust: Vec<i32>,
}

impl RoadMap {
    pub(super) fn new(model: SensorModel) -> Self {
        Self { model, grid: None, side_px: 1, map: RollingGrid::default(), row_trust: Vec::new() }
    }

    /// Pixels of the view along a cell.
    pub(super) const fn side_px(&self) -> usize {
        self.side_px
    }

    pub(super) fn forget(&mut self) {
        self.map.forget();
    }

    /// Makes the map one for this view; a map for another one is forgotten.
    pub(super) fn lie_under(&mut self, view: &GroundView, cell_m: f64) {
        let grid = view.grid();
        if self.grid == Some(*grid) {
            return;
        }
        self.grid = Some(*grid);
        self.side_px = ((cell_m / grid.metres_per_pixel()).round() as usize).max(1);
        self.map.lie_under(grid, self.side_px as f64 * grid.metres_per_pixel());
        let camera_x_m = view.camera_foot().x;
        let trust = |row: usize| {
            let pixel = GroundPixel { column: 0.0, row: row as f64 };
            (256.0 * self.model.trust(grid.vehicle_from_ground(pixel).x - camera_x_m)).round() as i32
        };
        self.row_trust = (0..grid.rows()).map(trust).collect();
    }

    /// Multiplies everything by `kept`, 0 to 1.
    pub(super) fn fade(&mut self, kept: f64) {
        fade(self.map.cells.as_mut_slice(), kept);
    }

    /// Moves the vehicle on; cells that come into reach are empty.
    pub(super) fn carry(&mut self, previous_from_current: &Isometry2<f64>) {
        self.map.carry(previous_from_current);
    }

    /// Place in the map, cells, of a place in the view, pixels.
    fn cell_of(&self, grid: &GroundGrid, column: f64, row: f64) -> [f64; 2] {
        self.map.cell_of(grid.vehicle_from_ground(GroundPixel { column, row }))
    }

    /// What the map says about every square of [`RoadMap::side_px`] pixels of the view: its prior probability (256 would be
    /// 1), and 1 where that is known, 0 elsewhere.
    pub(super) fn read(&self, prior: &mut Plane<u8>, known: &mut Plane<u8>) {
        let Some(grid) = self.grid else { return };
        let side = self.side_px;
        let size = (grid.columns().div_ceil(side), grid.rows().div_ceil(side));
        if prior.size() != size {
            prior.reset(size.0, size.1, 0);
            known.reset(size.0, size.1, 0);
        }
        let middle = 0.5 * (side as f64 - 1.0);
        let at = |column: usize, row: usize| {
            self.cell_of(&grid, (column * side) as f64 + middle, (row * side) as f64 + middle).map(fixed)
        };
        let ([x0, y0], [x1, y1]) = (at(0, 0), at(1, 0));
        let step = [x1 - x0, y1 - y0];
        let mask = self.map.cells.width() - 1;
        let cells = self.map.cells.as_slice();
        let log_side = self.map.cells.width().trailing_zeros();
        for row in 0..size.1 {
            let [mut x, mut y] = at(0, row).map(|place| place + HALF);
            for (prior, known) in prior.row_mut(row).iter_mut().zip(known.row_mut(row)) {
                let (column, line) = ((x >> PLACE_BITS) as usize & mask, (y >> PLACE_BITS) as usize & mask);
                let units = cells.get((line << log_side) + column).map_or(0, |units| i32::from(*units));
                *prior = self.model.prior.get(((units + MAX_UNITS) >> 1) as usize).copied().unwrap_or(0);
                *known = u8::from(units.abs() >= self.model.min_known);
                x += step[0];
                y += step[1];
            }
        }
    }

    /// Adds what is seen in a frame; `seen` is 0 where `validity` shows nothing.
    pub(super) fn add(&mut self, seen: &Plane<u8>, validity: &ValidityMask) {
        let fits = |grid: &GroundGrid| [seen.size(), validity.size()] == [(grid.columns(), grid.rows()); 2];
        let Some(grid) = self.grid.filter(fits) else {
            return;
        };
        let (width, height) = (grid.columns(), grid.rows());
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, bottom]| {
            let last = |length: usize, share: usize| share as f64 * (length as f64 - 1.0);
            self.cell_of(&grid, last(width, right), last(height, bottom))
        });
        let ranges = [0, 1].map(|axis: usize| {
            let of = corners.map(|corner| corner[axis]);
            let least = of.iter().copied().fold(f64::INFINITY, f64::min);
            let most = of.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            // One place of a torus must not be written twice.
            let first = least.ceil() as i64;
            first..(most.floor() as i64 + 1).min(first + self.map.cells.width() as i64)
        });
        let vehicle_from_map = self.map.map_from_vehicle.inverse();
        let pixel_of = |place: [i64; 2]| {
            let p_in_map = Point2::from(place.map(|cell| cell as f64)) * self.map.cell_m;
            let pixel = grid.ground_from_vehicle(vehicle_from_map * p_in_map);
            // Half a pixel more, so that cutting off rounds.
            [pixel.column + 0.5, pixel.row + 0.5]
        };
        let steps = [[1, 0], [0, 1]].map(|next| {
            let ([u0, v0], [u1, v1]) = (pixel_of([0, 0]), pixel_of(next));
            [u1 - u0, v1 - v0]
        });
        // Along the axis that runs more along the view's rows, neighbours lie together in memory.
        let along = usize::from(steps[1][0].abs() > steps[0][0].abs());
        let across = 1 - along;
        let log_side = self.map.cells.width().trailing_zeros();
        let bits = [0, log_side];
        let mask = self.map.cells.width() - 1;
        let keep = (256.0 * self.model.keep_seen).round() as i32;
        let (values, cells, step) = (seen.as_slice(), self.map.cells.as_mut_slice(), steps[along]);
        let (first_along, count) = (ranges[along].start, ranges[along].clone().count());
        for line in ranges[across].clone() {
            let mut place = [0; 2];
            (place[along], place[across]) = (first_along, line);
            let [u, v] = pixel_of(place);
            let [first, end] = inside([u, v], step, [width as f64, height as f64], count);
            let [mut u, mut v] = [u + first as f64 * step[0], v + first as f64 * step[1]].map(fixed);
            let step = step.map(fixed);
            let start = (line as usize & mask) << bits[across];
            for cell in first_along + first..first_along + end {
                // A place before the first becomes one far behind the last.
                let (row, column) = ((v >> PLACE_BITS) as usize, (u >> PLACE_BITS) as usize);
                (u, v) = (u + step[0], v + step[1]);
                // Rounding may lead a place at the edge out of the view.
                if row >= height || column >= width {
                    continue;
                }
                let index = row * width + column;
                let (Some(&p), Some(&trust)) = (values.get(index), self.row_trust.get(row)) else { continue };
                // Mostly the value alone says that the pixel is seen. The runs are few, where the mask's plane is as large
                // as the picture.
                let is_seen = || validity.runs(row).iter().any(|run| (run.start..run.end).contains(&column));
                if p == 0 && !is_seen() {
                    continue;
                }
                let told = i32::from(self.model.log_odds[usize::from(p)]) * trust;
                if let Some(cell) = cells.get_mut(start + ((cell as usize & mask) << bits[along])) {
                    *cell = ((i32::from(*cell) * keep + told) >> 8).clamp(-MAX_UNITS, MAX_UNITS) as i16;
                }
            }
        }
    }
}

/// A place with [`PLACE_BITS`] behind the point.
fn fixed(place: f64) -> i64 {
    (place * f64::from(1_u32 << PLACE_BITS)).round() as i64
}

/// Which steps from `from` on lead to places inside `[0, size)`: the first, and the one after the last, of `count`.
fn inside(from: [f64; 2], step: [f64; 2], size: [f64; 2], count: usize) -> [i64; 2] {
    let (mut first, mut end) = (0.0_f64, count as f64);
    for axis in [0, 1] {
        // A step of less than this moves a place by less than a pixel over the whole map.
        const STANDING: f64 = 1e-9;
        if step[axis].abs() < STANDING {
            if !(0.0..size[axis]).contains(&from[axis]) {
                return [0, 0];
            }
            continue;
        }
        let at = [-from[axis] / step[axis], (size[axis] - from[axis]) / step[axis]];
        first = first.max(at[0].min(at[1]).ceil());
        end = end.min(at[0].max(at[1]).floor() + 1.0);
    }
    let first = first.min(count as f64) as i64;
    [first, (end.max(0.0) as i64).max(first)]
}

//! Which squares of the view are raised: cross-sections of the map at the last look, carried to where the vehicle is since.

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::parallax::rise_chain::LANES;
use fingerpost_vision::picture::Plane;
use nalgebra::{Isometry2, Vector2};

use super::cross_section::CrossSections;
use super::height_map::HeightMap;
use super::{ASIDE_M, GroundHeight, UNIT};

/// The vehicle's way to either side of its axis, metres. It fixes the height that the rest of a row is compared with: a chain begins
/// at its other side.
const WAY_M: f64 = 1.0;
/// Rows of squares from one cross-section to the next.
const SECTION_ROWS: usize = 3;

/// The squares as the last look found them.
#[derive(Debug, Default)]
pub(super) struct RaisedSquares {
    chains: CrossSections,
    by_section: Plane<f32>,
    /// Log-odds in 256ths.
    squares: Plane<i16>,
    odometry_from_vehicle: Isometry2<f64>,
}

/// Squares of a view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Squares {
    pub(super) grid: GroundGrid,
    pub(super) side_px: usize,
}

impl Squares {
    fn side_m(self) -> f64 {
        self.side_px as f64 * self.grid.metres_per_pixel()
    }

    /// Columns and rows.
    pub(super) fn size(self) -> (usize, usize) {
        (self.grid.columns().div_ceil(self.side_px), self.grid.rows().div_ceil(self.side_px))
    }

    /// The pixel in the middle of a square.
    fn middle(self, column: usize, row: usize) -> GroundPixel {
        let middle = 0.5 * (self.side_px as f64 - 1.0);
        let of_square = |square: usize| (square * self.side_px) as f64 + middle;
        GroundPixel { column: of_square(column), row: of_square(row) }
    }
}

impl RaisedSquares {
    pub(super) fn forget(&mut self) {
        self.squares.as_mut_slice().fill(0);
    }

    /// Reads the map from where the vehicle is.
    pub(super) fn look(
        &mut self,
        map: &HeightMap,
        squares: Squares,
        odometry_from_vehicle: Isometry2<f64>,
        reach_m: f64,
    ) {
        self.odometry_from_vehicle = odometry_from_vehicle;
        let size = squares.size();
        let axis = size.0 / 2;
        let other = ((WAY_M / squares.side_m()).round() as usize).min(axis);
        let reach = ((ASIDE_M / squares.side_m()).round() as usize).min(axis);
        let sections = size.1 / SECTION_ROWS;
        let first = ((squares.grid.far_m() - reach_m) / (squares.side_m() * SECTION_ROWS as f64)).max(0.0);
        let Self { chains, by_section, .. } = self;
        by_section.reset(size.0, sections, 0.0);
        // From the vehicle's way outwards: columns of places, of every section those to the left and those to the right.
        let side_of = |chain: usize| (chain / 2, chain.is_multiple_of(2));
        let column_of = |is_left: bool, place: usize| match is_left {
            true => (axis + other - 1).saturating_sub(place),
            false => (axis - other + place).min(size.0 - 1),
        };
        for first in (2 * first as usize..2 * sections).step_by(LANES) {
            let heights = |place: usize, lane: usize| {
                let (section, is_left) = side_of((first + lane).min(2 * sections - 1));
                let middle = squares.middle(column_of(is_left, place), section * SECTION_ROWS);
                map.at(squares.grid.vehicle_from_ground(middle))
            };
            let log_odds = chains.log_odds(reach + other, heights, squares.side_m());
            for (place, lanes) in log_odds.iter().enumerate().skip(other) {
                for (lane, &log_odds) in lanes.iter().enumerate().take(2 * sections - first) {
                    let (section, is_left) = side_of(first + lane);
                    by_section.row_mut(section)[column_of(is_left, place)] = log_odds;
                }
            }
        }
        if self.squares.size() != size {
            self.squares.reset(size.0, size.1, 0);
        }
        for row in 0..size.1 {
            let middle = (row / SECTION_ROWS).min(sections.saturating_sub(1));
            let rows = middle.saturating_sub(1)..(middle + 2).min(sections);
            for (column, out) in self.squares.row_mut(row).iter_mut().enumerate() {
                let sum: f32 = rows.clone().map(|row| self.by_section.row(row)[column]).sum();
                *out = (sum / rows.len().max(1) as f32 * UNIT as f32) as i16;
            }
        }
    }

    /// The squares as they lie when the vehicle is here.
    pub(super) fn carried(
        &self,
        squares: Squares,
        odometry_from_vehicle: &Isometry2<f64>,
        height: &mut GroundHeight,
    ) {
        height.side_px = squares.side_px;
        let size = squares.size();
        if height.raised.size() != size {
            height.raised.reset(size.0, size.1, 0);
        }
        let then_from_now = self.odometry_from_vehicle.inv_mul(odometry_from_vehicle);
        let then = |column: usize, row: usize| {
            let place = squares.grid.vehicle_from_ground(squares.middle(column, row));
            let pixel = squares.grid.ground_from_vehicle(then_from_now * place);
            Vector2::new(pixel.column + 0.5, pixel.row + 0.5) / squares.side_px as f64
        };
        let (first, column_on, row_on) = (then(0, 0), then(1, 0) - then(0, 0), then(0, 1) - then(0, 0));
        for row in 0..size.1 {
            let start = first + row_on * row as f64;
            for (column, out) in height.raised.row_mut(row).iter_mut().enumerate() {
                let then = start + column_on * column as f64;
                let is_there = then.x >= 0.0 && then.y >= 0.0;
                let square = self.squares.get(then.x as usize, then.y as usize).filter(|_| is_there);
                *out = square.unwrap_or(0);
            }
        }
    }
}

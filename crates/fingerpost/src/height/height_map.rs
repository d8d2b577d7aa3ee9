//! What has been seen of the ground's height about the vehicle: log-odds that a place is raised, in cells that lie still.

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::fusion::fade;
use fingerpost_vision::picture::Plane;
use nalgebra::{Isometry2, Point2};

use crate::still_cells::StillCells;

/// Units of log-odds in a cell.
pub(super) const UNIT: f64 = 256.0;
/// Largest log-odds of a cell: looks at one place share their texture, and a hundred of them do not make it surer than this.
pub(super) const MOST_LOG_ODDS: f64 = 8.0;

/// The map.
#[derive(Debug, Default)]
pub(super) struct HeightMap {
    cells: StillCells<i16>,
    grid: Option<GroundGrid>,
}

impl HeightMap {
    /// Makes the map one for this view; a map for another one is forgotten.
    pub(super) fn lie_under(&mut self, grid: &GroundGrid, cell_m: f64) {
        if self.grid != Some(*grid) {
            self.grid = Some(*grid);
            self.cells.lie_under(grid, cell_m);
        }
    }

    pub(super) fn forget(&mut self) {
        self.cells.forget();
    }

    pub(super) fn carry(&mut self, previous_from_current: &Isometry2<f64>, kept: f64) {
        self.cells.carry(previous_from_current);
        fade(self.cells.cells.as_mut_slice(), kept);
    }

    /// Adds log-odds that a place (vehicle frame) is raised.
    pub(super) fn add(&mut self, p_in_vehicle: Point2<f64>, log_odds: f32) {
        let index = self.cells.index(self.cells.cell_of(p_in_vehicle));
        if let Some(cell) = self.cells.cells.as_mut_slice().get_mut(index) {
            let most = (MOST_LOG_ODDS * UNIT) as i32;
            let told = (log_odds * UNIT as f32) as i32;
            *cell = (i32::from(*cell) + told).clamp(-most, most) as i16;
        }
    }

    /// What the map says about every square of `side_px` pixels of the view, in units.
    pub(super) fn read(&self, side_px: usize, raised: &mut Plane<i16>) {
        let Some(grid) = self.grid else { return };
        let size = (grid.columns().div_ceil(side_px), grid.rows().div_ceil(side_px));
        if raised.size() != size {
            raised.reset(size.0, size.1, 0);
        }
        let middle = 0.5 * (side_px as f64 - 1.0);
        let at = |column: usize, row: usize| {
            let pixel = GroundPixel {
                column: (column * side_px) as f64 + middle,
                row: (row * side_px) as f64 + middle,
            };
            self.cells.cell_of(grid.vehicle_from_ground(pixel))
        };
        let ([x0, y0], [x1, y1]) = (at(0, 0), at(1, 0));
        let step = [x1 - x0, y1 - y0];
        for row in 0..size.1 {
            let [mut x, mut y] = at(0, row);
            for out in raised.row_mut(row) {
                *out = self.cells.cells.as_slice().get(self.cells.index([x, y])).copied().unwrap_or(0);
                (x, y) = (x + step[0], y + step[1]);
            }
        }
    }
}

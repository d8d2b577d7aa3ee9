//! A rolling grid: square cells about the vehicle that stay fixed in the odometry frame while it moves over them.
//!
//! They are a torus: a cell that falls out of reach on one side becomes, emptied, one that comes into reach on the other, so
//! that memory is bounded and nothing is ever moved or resampled.

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::picture::Plane;
use nalgebra::{Isometry2, Point2};

/// Most cells along a side, a bound on memory.
const MAX_SIDE: usize = 2048;

/// The cells, and how the vehicle lies in them.
#[derive(Debug)]
pub(super) struct RollingGrid {
    /// Side, a power of two; the cell of map place (x, y) is in column x and row y modulo the side.
    pub(super) cells: Plane<i16>,
    pub(super) cell_m: f64,
    pub(super) map_from_vehicle: Isometry2<f64>,
    /// Middle of what is to be in reach, vehicle frame, metres.
    middle: Point2<f64>,
    /// First column and row in reach, cells of the endless map.
    corner: [i64; 2],
}

impl Default for RollingGrid {
    fn default() -> Self {
        Self {
            cells: Plane::default(),
            cell_m: 1.0,
            map_from_vehicle: Isometry2::identity(),
            middle: Point2::origin(),
            corner: [0, 0],
        }
    }
}

impl RollingGrid {
    /// Empty cells under the whole of a view, whichever way it lies.
    pub(super) fn lie_under(&mut self, grid: &GroundGrid, cell_m: f64) {
        self.cell_m = cell_m;
        // A cell more all around for rounding.
        let across_m = grid.metres_per_pixel() * libm::hypot(grid.columns() as f64, grid.rows() as f64);
        let reach = (across_m / cell_m).ceil() as usize + 4;
        let side = reach.next_power_of_two().min(MAX_SIDE);
        self.cells.reset(side, side, 0);
        self.map_from_vehicle = Isometry2::identity();
        self.middle = Point2::new(0.5 * (grid.near_m() + grid.far_m()), 0.0);
        self.corner = self.corner_now();
    }

    pub(super) fn forget(&mut self) {
        self.cells.as_mut_slice().fill(0);
    }

    /// Moves the vehicle on; cells that come into reach are empty.
    pub(super) fn carry(&mut self, previous_from_current: &Isometry2<f64>) {
        self.map_from_vehicle *= previous_from_current;
        self.map_from_vehicle.rotation.renormalize();
        let side = self.cells.width() as i64;
        // Once around the torus nothing is another place.
        let around_m = side as f64 * self.cell_m;
        if around_m <= 0.0 {
            return;
        }
        let whole = self.map_from_vehicle.translation.vector.map(|m| (m / around_m).trunc());
        self.map_from_vehicle.translation.vector -= whole * around_m;
        self.corner = [self.corner[0] - whole.x as i64 * side, self.corner[1] - whole.y as i64 * side];
        let before = self.corner;
        self.corner = self.corner_now();
        for axis in [0, 1] {
            let entered = if self.corner[axis] >= before[axis] {
                before[axis] + side..self.corner[axis] + side
            } else {
                self.corner[axis]..before[axis]
            };
            let count = (entered.end - entered.start).min(side);
            for line in (entered.start..entered.start + count).map(|line| (line & (side - 1)) as usize) {
                if axis == 1 {
                    self.cells.row_mut(line).fill(0);
                } else {
                    (0..side as usize).for_each(|row| self.cells.row_mut(row)[line] = 0);
                }
            }
        }
    }

    /// First column and row in reach when [`Self::middle`] is the middle of the map.
    fn corner_now(&self) -> [i64; 2] {
        let middle = self.map_from_vehicle * self.middle;
        let half = (self.cells.width() / 2) as i64;
        [middle.x, middle.y].map(|m| (m / self.cell_m).round() as i64 - half)
    }

    /// Place in the map, cells, of a place in the vehicle frame, metres.
    pub(super) fn cell_of(&self, p_in_vehicle: Point2<f64>) -> [f64; 2] {
        let p_in_map = self.map_from_vehicle * p_in_vehicle;
        [p_in_map.x / self.cell_m, p_in_map.y / self.cell_m]
    }
}

//! What has been seen of the ground's height about the vehicle: how likely each height is, in cells that lie still.

use fingerpost_geometry::GroundGrid;
use nalgebra::{Point2, Vector2};

use super::laid_over::{Raster, Region};
use super::sweep::Sweep;
use crate::ground_view::Viewpoint;
use crate::motion::Motion;
use crate::still_cells::StillCells;

/// Heights that are told apart, and the step between them, metres.
pub(super) const HEIGHTS: usize = 24;
pub(super) const HEIGHT_STEP_M: f64 = 0.025;
/// Height of the lowest, metres over the plane of the strip ahead: a road that falls by 3 % beyond its crown.
pub(super) const LOWEST_M: f64 = -0.30;
/// Units of a height's log-likelihood.
const UNIT: f32 = 8.0;
/// A window of n independent witnesses whose correlation is r is as likely as (1 - r^2)^(-n / 2). This is n / 2, with eight of a
/// window's cells for a witness, over the cells of the map that a window is wide.
const WITNESSES: f32 = 4.0;
/// Cells before a place and behind it that are taken together with it, a window's half length: kerbs run along the way.
const POOLED: i32 = 2;
/// A correlation is never believed to be greater.
const MOST_CORRELATION: f32 = 0.97;
/// Eighths of what a cell says that are left when it is seen anew: looks at one place share their texture.
const KEPT_EIGHTHS: u16 = 6;

/// Log-likelihoods of a cell's heights.
pub(super) type Heights = [u8; HEIGHTS];

/// The map.
#[derive(Debug, Default)]
pub(super) struct HeightMap {
    cells: StillCells<Heights>,
    grid: Option<GroundGrid>,
}

/// How correlations of a sweep tell of one height.
#[derive(Debug, Clone, Copy, Default)]
struct Reading {
    /// The shift below and the share of the one above.
    shift: usize,
    share: f32,
    /// From the camera's foot to where the place is shown, over its true distance.
    enlarged: f64,
}

/// Height of one of the heights over the plane, metres.
pub(super) fn height_m(index: usize) -> f64 {
    LOWEST_M + HEIGHT_STEP_M * index as f64
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

    pub(super) fn carry(&mut self, motion: &Motion) {
        self.cells.carry(&motion.previous_from_current);
    }

    /// Takes in what a sweep of part of a view shows.
    pub(super) fn add(&mut self, sweep: &Sweep, raster: Raster, region: Region, viewpoint: Viewpoint) {
        let Some(readings) = readings(sweep, viewpoint) else { return };
        let vehicle_from_map = self.cells.map_from_vehicle.inverse();
        let cell_m = self.cells.cell_m;
        let left_m = |column: usize| raster.left_m((region.first_column + column) as f64);
        let ahead_m = |row: usize| raster.ahead_m((region.first_row + row) as f64);
        let corners = [(0, 0), (0, region.columns), (region.rows, 0), (region.rows, region.columns)]
            .map(|(row, column)| self.cell_of(Point2::new(ahead_m(row), left_m(column))));
        let limits = [0, 1].map(|axis| {
            let along = corners.map(|corner| corner[axis]);
            let least = along.into_iter().fold(f64::INFINITY, f64::min);
            let most = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
            (least.ceil() as i64, most.floor() as i64)
        });
        let [across_m, down_m] = raster.cell_m();
        let (first_row, first_column) = (region.first_row as f64, region.first_column as f64);
        for y in limits[1].0..=limits[1].1 {
            for x in limits[0].0..=limits[0].1 {
                let cell = [x as f64, y as f64];
                let place =
                    vehicle_from_map * Point2::new((cell[0] + 0.5) * cell_m, (cell[1] + 0.5) * cell_m);
                let from_foot = place - viewpoint.foot;
                let index = self.cells.index(cell);
                let Some(heights) = self.cells.cells.as_mut_slice().get_mut(index) else { continue };
                for (height, reading) in heights.iter_mut().zip(&readings) {
                    let shown = viewpoint.foot + from_foot * reading.enlarged;
                    let row = (raster.grid.far_m() - shown.x) / down_m - 0.5 - first_row;
                    let column = (raster.grid.half_width_m() - shown.y) / across_m - 0.5 - first_column;
                    if row < 0.0 || column < 0.0 {
                        continue;
                    }
                    let (row, column) = ((row + 0.5) as usize, (column + 0.5) as usize);
                    let Some(r) = sweep.correlation(reading.shift, reading.share, column, row) else {
                        continue;
                    };
                    let kept = u16::from(*height) * KEPT_EIGHTHS / 8;
                    *height = (kept + told(r)).min(u16::from(u8::MAX)) as u8;
                }
            }
        }
    }

    /// The cell of a place, whose middle lies where a square of a view has its own as long as the vehicle drives straight on.
    fn cell_of(&self, p_in_vehicle: Point2<f64>) -> [f64; 2] {
        self.cells.cell_of(p_in_vehicle).map(|cells| cells - 0.5)
    }

    /// What is known of the heights at a place (vehicle frame) and right before and behind it.
    pub(super) fn at(&self, p_in_vehicle: Point2<f64>) -> Heights {
        let mut sums = [0_u16; HEIGHTS];
        for along in -POOLED..=POOLED {
            let place = p_in_vehicle + Vector2::new(f64::from(along) * self.cells.cell_m, 0.0);
            let index = self.cells.index(self.cell_of(place));
            let Some(heights) = self.cells.cells.as_slice().get(index) else { continue };
            sums.iter_mut().zip(heights).for_each(|(sum, height)| *sum += u16::from(*height));
        }
        sums.map(|sum| sum.min(u16::from(u8::MAX)) as u8)
    }
}

/// Log-likelihood of a place's height in units by its correlation.
fn told(r: f32) -> u16 {
    let r = r.clamp(0.0, MOST_CORRELATION);
    (-UNIT * WITNESSES * (1.0 - r * r).ln()) as u16
}

/// Likelihood of each of a byte's log-likelihoods under the largest.
pub(super) fn likelihoods() -> [f32; 256] {
    std::array::from_fn(|below| (-(below as f32) / UNIT).exp())
}

fn readings(sweep: &Sweep, viewpoint: Viewpoint) -> Option<[Reading; HEIGHTS]> {
    let mut readings = [Reading::default(); HEIGHTS];
    for (index, reading) in readings.iter_mut().enumerate() {
        let height_m = height_m(index);
        let (shift, share) = sweep.shift_at(height_m)?;
        *reading = Reading { shift, share, enlarged: 1.0 / (1.0 - height_m / viewpoint.height_m) };
    }
    Some(readings)
}

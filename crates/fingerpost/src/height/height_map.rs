//! What has been seen of the ground's height about the vehicle: how likely each height is, in a rolling grid.

use fingerpost_geometry::GroundGrid;
use nalgebra::{Point2, Vector2};

use super::height_likelihoods::{HeightLikelihoods, UNIT};
use super::superimposed::{Raster, Region};
use crate::ground_view::Viewpoint;
use crate::motion::Motion;
use crate::rolling_grid::RollingGrid;

/// Heights that are told apart, and the step between them, metres.
pub(super) const HEIGHTS: usize = 24;
pub(super) const HEIGHT_STEP_M: f64 = 0.025;
/// Height of the lowest, metres over the plane of the strip ahead: a road that falls by 3 % beyond its crown.
pub(super) const LOWEST_M: f64 = -0.30;
/// Cells before a place and behind it that are taken together with it, a window's half length: kerbs run along the way.
const POOLED: i32 = 2;
/// Eighths of what a cell says that are left when it is seen anew: looks at one place share their texture.
const KEPT_EIGHTHS: i16 = 6;

/// Log-likelihoods of a cell's heights, against each not being the one.
pub(super) type Heights = [i8; HEIGHTS];
/// By how much each height's is below the greatest.
pub(super) type Below = [u8; HEIGHTS];

/// The map.
#[derive(Debug, Default)]
pub(super) struct HeightMap {
    cells: RollingGrid<Heights>,
    grid: Option<GroundGrid>,
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

    /// Takes in the log-likelihoods of part of a view.
    pub(super) fn add(
        &mut self,
        likelihoods: &HeightLikelihoods,
        raster: Raster,
        region: Region,
        viewpoint: Viewpoint,
    ) {
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
        // Of the camera's foot, and half a cell on, so that what is cut off leaves the nearest cell.
        let top = (raster.row_at(viewpoint.foot.x) - region.first_row as f64 + 0.5) as f32;
        let left = (raster.column_at(viewpoint.foot.y) - region.first_column as f64 + 0.5) as f32;
        let along = (vehicle_from_map.rotation * Vector2::x() * cell_m).cast::<f32>();
        let mask = self.cells.cells.width() as i64 - 1;
        for (index, of_height) in likelihoods.of_heights().enumerate() {
            let [rows_a_metre, columns_a_metre] = cells_a_metre(height_m(index), raster, viewpoint);
            for y in limits[1].0..=limits[1].1 {
                let middle = Point2::new(limits[0].0 as f64 + 0.5, y as f64 + 0.5) * cell_m;
                let start = (vehicle_from_map * middle - viewpoint.foot).cast::<f32>();
                let line = self.cells.cells.row_mut((y & mask) as usize);
                let row = (top + rows_a_metre * start.x, rows_a_metre * along.x);
                let column = (left + columns_a_metre * start.y, columns_a_metre * along.y);
                let (from, to) = meeting(within(row, region.rows), within(column, region.columns));
                let [row, column] = [row, column].map(|(start, step)| (fixed(start), fixed(step)));
                for on in from..to.min(limits[0].1 - limits[0].0 + 1) {
                    let [row, column] = [row.0 + row.1 * on, column.0 + column.1 * on];
                    let place = ((column >> FIXED_BITS) as usize, (row >> FIXED_BITS) as usize);
                    let Some(log_likelihood) = of_height.at(place.0, place.1) else { continue };
                    let Some(heights) = line.get_mut(((limits[0].0 + on) & mask) as usize) else { continue };
                    let sum = i16::from(heights[index]) * KEPT_EIGHTHS / 8 + i16::from(log_likelihood);
                    heights[index] = sum.clamp(i16::from(i8::MIN), i16::from(i8::MAX)) as i8;
                }
            }
        }
    }

    /// The cell of a place, whose middle lies where a square of a view has its own as long as the vehicle drives straight on.
    fn cell_of(&self, p_in_vehicle: Point2<f64>) -> [f64; 2] {
        self.cells.cell_of(p_in_vehicle).map(|cells| cells - 0.5)
    }

    /// What is known of the heights at a place (vehicle frame) and right before and behind it.
    pub(super) fn at(&self, p_in_vehicle: Point2<f64>) -> Below {
        let mut sums = [0_i16; HEIGHTS];
        let middle = self.cell_of(p_in_vehicle);
        let ahead = self.cells.map_from_vehicle.rotation * Vector2::x();
        for along in -POOLED..=POOLED {
            let along = f64::from(along);
            let index = self.cells.index([middle[0] + along * ahead.x, middle[1] + along * ahead.y]);
            let Some(heights) = self.cells.cells.as_slice().get(index) else { continue };
            sums.iter_mut().zip(heights).for_each(|(sum, height)| *sum += i16::from(*height));
        }
        let most = sums.iter().fold(i16::MIN, |most, &sum| most.max(sum));
        let mut below = [0; HEIGHTS];
        for (below, sum) in below.iter_mut().zip(&sums) {
            *below = (most - sum).min(i16::from(u8::MAX)) as u8;
        }
        below
    }
}

/// Likelihood of each of a byte's log-likelihoods under the largest.
pub(super) fn likelihoods() -> [f32; 256] {
    std::array::from_fn(|below| libm::expf(-(below as f32) / UNIT))
}

/// Bits of a fixed-point number's fraction.
const FIXED_BITS: i64 = 24;

fn fixed(value: f32) -> i64 {
    (value * (1 << FIXED_BITS) as f32) as i64
}

/// For which whole numbers n `start + step n` lies between 0 and `end`: from one to before another.
fn within((start, step): (f32, f32), end: usize) -> (i64, i64) {
    let end = end as f32;
    if step == 0.0 {
        return if start >= 0.0 && start < end { (0, i64::MAX) } else { (0, 0) };
    }
    let (a, b) = (-start / step, (end - start) / step);
    (a.min(b).ceil() as i64, a.max(b).ceil() as i64)
}

fn meeting(a: (i64, i64), b: (i64, i64)) -> (i64, i64) {
    (a.0.max(b.0).max(0), a.1.min(b.1))
}

/// Rows and columns from the camera's foot to where a place of this height is shown, for a metre of its true distance.
fn cells_a_metre(height_m: f64, raster: Raster, viewpoint: Viewpoint) -> [f32; 2] {
    let enlarged = 1.0 / (1.0 - height_m / viewpoint.height_m);
    let [across_m, down_m] = raster.cell_m();
    [down_m, across_m].map(|cell_m| (-enlarged / cell_m) as f32)
}

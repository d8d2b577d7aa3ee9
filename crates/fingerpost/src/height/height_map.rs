//! What has been seen of the ground's height about the vehicle: how likely each height is, in cells that lie still.

use fingerpost_geometry::GroundGrid;
use nalgebra::{Point2, Vector2};

use super::laid_over::{Raster, Region};
use super::sweep::{Correlations, Sweep};
use super::texture_noise::{EXPECTED, log_likelihood_ratio};
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
/// Pairs of a window's cells that are independent witnesses, over the cells of the map that a window covers.
const WITNESSES: f32 = 1.0;
/// Cells before a place and behind it that are taken together with it, a window's half length: kerbs run along the way.
const POOLED: i32 = 2;
/// Eighths of what a cell says that are left when it is seen anew: looks at one place share their texture.
const KEPT_EIGHTHS: i16 = 6;

/// Log-likelihoods of a cell's heights, against each not being the one.
pub(super) type Heights = [i8; HEIGHTS];
/// By how much each height's is below the greatest.
pub(super) type Below = [u8; HEIGHTS];

/// Steps of correlations that are told apart.
const CORRELATIONS: usize = 128;

/// The map.
#[derive(Debug)]
pub(super) struct HeightMap {
    cells: StillCells<Heights>,
    grid: Option<GroundGrid>,
    /// Log-likelihood by the correlation that is expected and the one that is found.
    told: [[i8; CORRELATIONS]; EXPECTED],
}

impl Default for HeightMap {
    fn default() -> Self {
        let told = std::array::from_fn(|expected| {
            let expected = expected as f32 / EXPECTED as f32;
            std::array::from_fn(|step| told(step as f32 / (CORRELATIONS - 1) as f32, expected))
        });
        Self { cells: StillCells::default(), grid: None, told }
    }
}

/// How a sweep tells of one height.
#[derive(Debug, Clone, Copy)]
struct Reading<'a> {
    correlations: Correlations<'a>,
    /// Rows and columns from the camera's foot to where a place is shown, for a metre of its true distance.
    rows_a_metre: f32,
    columns_a_metre: f32,
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
        let Some(readings) = readings(sweep, raster, viewpoint) else { return };
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
        for (index, reading) in readings.iter().enumerate() {
            for y in limits[1].0..=limits[1].1 {
                let middle = Point2::new(limits[0].0 as f64 + 0.5, y as f64 + 0.5) * cell_m;
                let start = (vehicle_from_map * middle - viewpoint.foot).cast::<f32>();
                let line = self.cells.cells.row_mut((y & mask) as usize);
                let row = (top + reading.rows_a_metre * start.x, reading.rows_a_metre * along.x);
                let column = (left + reading.columns_a_metre * start.y, reading.columns_a_metre * along.y);
                let Correlations { columns, rows, .. } = reading.correlations;
                let (from, to) = meeting(within(row, rows), within(column, columns));
                let [row, column] = [row, column].map(|(start, step)| (fixed(start), fixed(step)));
                for on in from..to.min(limits[0].1 - limits[0].0 + 1) {
                    let [row, column] = [row.0 + row.1 * on, column.0 + column.1 * on];
                    let place = ((column >> FIXED_BITS) as usize, (row >> FIXED_BITS) as usize);
                    let Some(r) = reading.correlations.at(place.0, place.1) else { continue };
                    let Some(heights) = line.get_mut(((limits[0].0 + on) & mask) as usize) else { continue };
                    let step = ((r * (CORRELATIONS - 1) as f32) as i32).max(0) as usize;
                    let expected = sweep.expected(place.0, place.1);
                    let told = self.told.get(expected).map_or(0, |told| told[step.min(CORRELATIONS - 1)]);
                    let sum = i16::from(heights[index]) * KEPT_EIGHTHS / 8 + i16::from(told);
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

/// Log-likelihood in units of a place's height by its correlation there, against that of a height at which it is not.
fn told(r: f32, expected: f32) -> i8 {
    (UNIT * WITNESSES * log_likelihood_ratio(r, expected)) as i8
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

fn readings(sweep: &Sweep, raster: Raster, viewpoint: Viewpoint) -> Option<[Reading<'_>; HEIGHTS]> {
    let [across_m, down_m] = raster.cell_m();
    let of_height = |height_m: f64| {
        let enlarged = 1.0 / (1.0 - height_m / viewpoint.height_m);
        let correlations = sweep.at_height(height_m)?;
        let [rows_a_metre, columns_a_metre] = [down_m, across_m].map(|cell_m| (-enlarged / cell_m) as f32);
        Some(Reading { correlations, rows_a_metre, columns_a_metre })
    };
    let mut readings = [of_height(height_m(0))?; HEIGHTS];
    for (index, reading) in readings.iter_mut().enumerate() {
        *reading = of_height(height_m(index))?;
    }
    Some(readings)
}

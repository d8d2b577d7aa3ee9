//! Two ground views looked at as if the ground lay at several heights.

use fingerpost_vision::parallax::{Correlation, Detrending, HalfWindow, Rows, UNSEEN, register};
use fingerpost_vision::picture::Plane;

use super::ASIDE_M;
use super::height_likelihoods::HeightLikelihoods;
use super::height_map::{HEIGHT_STEP_M, HEIGHTS, LOWEST_M, height_m};
use super::past_views::PastView;
use super::road_plane::{Displaced, PlaneFit};
use super::superimposed::{Raster, Region, Superimposed};
use super::texture_noise::TextureNoise;
use crate::ground_view::Viewpoint;

/// Half the sides of a window, metres: long, because kerbs run along the way, and narrow, so that they are sharp.
const WINDOW_M: [f64; 2] = [0.1, 0.6];
/// Half the length over which brightness is evened out along the way, metres.
const TREND_M: f64 = 0.75;
/// Farther than this ahead of the camera's foot a pixel is too long to show a kerb's parallax, metres.
pub(super) const REACH_M: f64 = 12.0;
/// Half the width of the strip ahead that is taken for road, metres: a vehicle's, and as much again.
const STRIP_M: f64 = 1.5;
/// Displacements of the strip that are looked at, metres either way.
const STRIP_SEARCH_M: f64 = 0.4;
/// Times that the strip is superimposed anew and the plane fitted.
const FIT_ROUNDS: usize = 2;
/// Spacing of the blocks of the strip that displacements are taken from, metres.
const BLOCKS_M: [f64; 2] = [0.4, 0.5];
/// Correlation below which a block shows nothing.
const LEAST_CORRELATION: f32 = 0.5;
/// Rows of the sweep that are looked at: a cell of the map is as long as one.
pub(super) const SWEPT_ROWS: Rows = Rows { first: 0, step: 4 };
/// Most shifts of one sweep.
const MOST_SHIFTS: usize = 32;

/// Planes of a view or of a part of one.
#[derive(Debug, Default)]
struct Detrended {
    values: Plane<i16>,
    scales: Plane<f32>,
}

/// The shifts of a sweep.
#[derive(Debug, Default, Clone, Copy)]
struct Shifts {
    first: isize,
    last: isize,
    step_m: f64,
    way_m: f64,
    camera_m: f64,
}

impl Shifts {
    /// The correlations of places of this height, of `planes` of one shift each; none where it was not looked at.
    fn at_height(self, height_m: f64, planes: &[Plane<f32>]) -> Option<Correlations<'_>> {
        let Self { first, last, step_m, way_m, camera_m } = self;
        let shift = way_m * height_m / (camera_m - height_m) / step_m;
        let below = (shift.floor() as isize).clamp(first, last - 1);
        if first >= last || shift - below as f64 > 1.0 {
            return None;
        }
        let index = (below - first) as usize;
        let share = (shift - below as f64) as f32;
        Some(Correlations { below: planes.get(index)?, above: planes.get(index + 1)?, share })
    }
}

/// The correlations of one sweep, and the memory for it.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// What is looked at of the newer view.
    all: Region,
    grey: Plane<i16>,
    newer: Detrended,
    noise: TextureNoise,
    part: Detrended,
    older: Detrended,
    registered: Plane<i16>,
    detrending: Detrending,
    correlation: Correlation,
    /// A plane a shift: of the strip ahead, and of all of the view.
    of_strip: Vec<Plane<f32>>,
    of_view: Vec<Plane<f32>>,
    /// Shifts of the view, in the order of their heights.
    shifts: Shifts,
    likelihoods: HeightLikelihoods,
    blocks: Vec<Displaced>,
}

/// Correlations between two of a sweep's shifts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Correlations<'a> {
    pub(super) below: &'a Plane<f32>,
    pub(super) above: &'a Plane<f32>,
    /// How far from the one to the other.
    pub(super) share: f32,
}

impl Sweep {
    /// Takes in the newer view of the pairs to come.
    pub(super) fn look_at(&mut self, raster: Raster, viewpoint: Viewpoint, newer: &PastView) {
        self.all = region(raster, viewpoint, ASIDE_M);
        copy(&newer.grey, self.all, &mut self.grey);
        let half = (TREND_M / raster.cell_m()[1]).round() as usize;
        self.detrending.detrend(&self.grey, half, &mut self.newer.values);
        self.correlation.scales(&self.newer.values, window(raster), 0.0, &mut self.newer.scales);
    }

    /// Fits the road's plane to the strip ahead.
    pub(super) fn fit_plane(
        &mut self,
        raster: Raster,
        viewpoint: Viewpoint,
        superimposed: &mut Superimposed,
        older: &PastView,
    ) {
        let strip = region(raster, viewpoint, STRIP_M);
        let part = Region { first_row: 0, first_column: strip.first_column - self.all.first_column, ..strip };
        copy(&self.newer.values, part, &mut self.part.values);
        copy(&self.newer.scales, part, &mut self.part.scales);
        let [across_m, down_m] = raster.cell_m();
        let most = (STRIP_SEARCH_M / down_m).round() as isize;
        let step = (most / 8).max(1);
        let [step_across, step_down] =
            [(BLOCKS_M[0] / across_m).max(1.0) as usize, (BLOCKS_M[1] / down_m).max(1.0) as usize];
        let rows = Rows { first: step_down / 2, step: step_down };
        let shifts = || (-most..=most).step_by(step as usize);
        for _ in 0..FIT_ROUNDS {
            self.noise = TextureNoise::default();
            self.superimpose(raster, superimposed, strip, older);
            let pair = (&self.part, &self.older);
            correlate(
                &mut self.correlation,
                pair,
                shifts().map(|up| [up, 0]),
                (window(raster), rows),
                &mut self.of_strip,
            );
            self.blocks.clear();
            for row in rows.of(strip.rows) {
                for column in (step_across / 2..strip.columns).step_by(step_across) {
                    let place = [
                        raster.ahead_m((strip.first_row + row) as f64) - viewpoint.foot.x,
                        raster.left_m((strip.first_column + column) as f64),
                    ];
                    let on_plane = self.of_strip.get((most / step) as usize);
                    if let Some(r) = on_plane.and_then(|plane| plane.get(column, row)).filter(|&r| r != 0.0)
                        && let Some(scale) = self.part.scales.get(column, row)
                    {
                        self.noise.add(scale, window(raster).cells() as f64, r);
                    }
                    if let Some([by, sigma]) = peak(&self.of_strip, column, row, window(raster)) {
                        let by_m = (by * step as f64 - most as f64) * down_m;
                        self.blocks.push(Displaced { place, by_m, sigma_m: sigma * step as f64 * down_m });
                    }
                }
            }
            superimposed.fit =
                PlaneFit::of(&self.blocks, &superimposed.fit, superimposed.way.norm(), viewpoint.height_m);
        }
    }

    /// Looks at all that is near at several heights.
    pub(super) fn sweep(
        &mut self,
        raster: Raster,
        viewpoint: Viewpoint,
        superimposed: &mut Superimposed,
        older: &PastView,
    ) -> Region {
        let all = self.all;
        self.superimpose(raster, superimposed, all, older);
        let [across_m, down_m] = raster.cell_m();
        let way_m = superimposed.way.norm();
        let displaced_m = |height_m: f64| way_m * height_m / (viewpoint.height_m - height_m);
        let step_m = displaced_m(HEIGHT_STEP_M).max(down_m);
        let first = (displaced_m(LOWEST_M) / step_m).floor() as isize;
        let highest = displaced_m(height_m(HEIGHTS - 1)) / step_m;
        let last = (highest.ceil() as isize).min(first + MOST_SHIFTS as isize - 1);
        self.shifts = Shifts { first, last, step_m, way_m, camera_m: viewpoint.height_m };
        let along = superimposed.way / way_m.max(f64::EPSILON) * step_m;
        let cells = |shift: isize| {
            let shift = shift as f64;
            [(along.x * shift / down_m).round() as isize, (along.y * shift / across_m).round() as isize]
        };
        let pair = (&self.newer, &self.older);
        let shifts = (first..=last).map(cells);
        correlate(&mut self.correlation, pair, shifts, (window(raster), SWEPT_ROWS), &mut self.of_view);
        all
    }

    /// Log-likelihoods of each height by the last sweep; none where it did not reach all of them.
    pub(super) fn likelihoods(&mut self, raster: Raster) -> Option<&HeightLikelihoods> {
        let Self { likelihoods, shifts, of_view, noise, newer, .. } = self;
        likelihoods.expect(&noise.expected(window(raster).cells() as f64), &newer.scales);
        let reached_all = likelihoods.update(|height_m| shifts.at_height(height_m, of_view));
        reached_all.then_some(&*likelihoods)
    }

    fn superimpose(
        &mut self,
        raster: Raster,
        superimposed: &mut Superimposed,
        region: Region,
        older: &PastView,
    ) {
        superimposed.over(region);
        if self.registered.size() != (region.columns, region.rows) {
            self.registered.reset(region.columns, region.rows, UNSEEN);
        }
        register(&older.grey, superimposed, &mut self.registered);
        let half = (TREND_M / raster.cell_m()[1]).round() as usize;
        self.detrending.detrend(&self.registered, half, &mut self.older.values);
        self.correlation.scales(&self.older.values, window(raster), 0.0, &mut self.older.scales);
    }
}

/// The correlations of a pair of views at several shifts, a plane each.
fn correlate(
    correlation: &mut Correlation,
    (newer, older): (&Detrended, &Detrended),
    shifts: impl Iterator<Item = [isize; 2]>,
    looked_at: (HalfWindow, Rows),
    planes: &mut Vec<Plane<f32>>,
) {
    let (newer, older) = ((&newer.values, &newer.scales), (&older.values, &older.scales));
    for (index, shift) in shifts.enumerate() {
        if index == planes.len() {
            planes.push(Plane::default());
        }
        let Some(plane) = planes.get_mut(index) else { return };
        correlation.at_shift(newer, older, shift, looked_at, plane);
    }
}

pub(super) fn window(raster: Raster) -> HalfWindow {
    let [across, down] = raster.cell_m();
    HalfWindow {
        columns: (WINDOW_M[0] / across).round() as usize,
        rows: (WINDOW_M[1] / down).round() as usize,
    }
}

/// The part of the view up to the reach and `half_m` to both sides.
fn region(raster: Raster, viewpoint: Viewpoint, half_m: f64) -> Region {
    let Raster { grid, cell_px: (across, down) } = raster;
    let (columns, rows) = (grid.columns() / across, grid.rows() / down);
    let cut = |at: f64, most: usize| (at.ceil().max(0.0) as usize).min(most);
    let first_row = cut(raster.row_at(viewpoint.foot.x + REACH_M), rows);
    let first_column = cut(raster.column_at(half_m), columns);
    let end = cut(raster.column_at(-half_m), columns);
    Region { first_row, first_column, rows: rows - first_row, columns: end.saturating_sub(first_column) }
}

fn copy<T: Copy + Default>(from: &Plane<T>, region: Region, to: &mut Plane<T>) {
    if to.size() != (region.columns, region.rows) {
        to.reset(region.columns, region.rows, T::default());
    }
    for row in 0..region.rows {
        let columns = region.first_column..region.first_column + region.columns;
        to.row_mut(row).copy_from_slice(&from.row(region.first_row + row)[columns]);
    }
}

/// Where the correlation is greatest over the shifts, in shifts from the first, and its standard deviation; none where it is
/// small or at an end.
fn peak(correlations: &[Plane<f32>], column: usize, row: usize, window: HalfWindow) -> Option<[f64; 2]> {
    let at = |shift: usize| correlations.get(shift).and_then(|plane| plane.get(column, row));
    let best = (0..correlations.len())
        .max_by(|&a, &b| at(a).partial_cmp(&at(b)).unwrap_or(std::cmp::Ordering::Equal))?;
    let r = at(best)?;
    let (before, after) = (at(best.checked_sub(1)?)?, at(best + 1)?);
    let curvature = 2.0 * r - before - after;
    if r < LEAST_CORRELATION || curvature <= 0.0 {
        return None;
    }
    let offset = 0.5 * f64::from(after - before) / f64::from(curvature);
    // Least squares: residual variance over the square of the slope, whose mean the curvature is, for the window's cells.
    let variance =
        2.0 * f64::from(1.0 - r * r) / (f64::from(curvature * r) * window.cells() as f64 / INDEPENDENT_CELLS);
    Some([best as f64 + offset.clamp(-1.0, 1.0), variance.max(0.0).sqrt()])
}

/// Cells that err together.
const INDEPENDENT_CELLS: f64 = 8.0;

//! Height: which of the ground lies on the road's plane and which is raised, told by parallax and by no colour.
//!
//! A pavement lies 6 to 16 cm above the road, and two pictures taken some metres of travel apart show that: laid over each
//! other through the road's plane, what lies at a height h is displaced along the way d by d h / (H - h), seen from a camera of height
//! H. Ground views of the last metres are kept (`past_views`); each new one is laid over by ones from two distances back, after the
//! plane's own errors (pitch, roll, the way driven, the road's fall) have been fitted to the strip ahead (`road_plane`), and looked
//! at as if the ground lay at several heights (`sweep`). What the two hypotheses, level and raised, make of it adds up in a map that
//! lies still on the road (`height_map`).
//!
//! Limits: it needs some metres of travel and texture across the way; ground that falls away by more than a few centimetres against
//! the plane of the strip ahead looks neither level nor raised. Things that move are not on any height.

mod height_map;
mod joining;
mod laid_over;
mod past_views;
mod road_plane;
mod sweep;

use fingerpost_vision::parallax::coarse;
use fingerpost_vision::picture::Plane;
use nalgebra::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::height_map::{HeightMap, UNIT};
pub(crate) use self::joining::Joining;
use self::laid_over::{LaidOver, Raster, Region};
use self::past_views::{PastView, PastViews, SPACING_M};
use self::sweep::{SWEPT_ROWS, Sweep};
use crate::ground_view::{CameraTurn, GroundView};
use crate::motion::Motion;

/// Settings of the ground's height.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HeightConfig {
    /// What the ground's height is looked at for.
    pub used: HeightUse,
    /// Side of a cell of the map, metres; rounded to whole pixels of the ground view.
    #[schemars(range(min = 0.05, max = 1.0))]
    pub cell_m: f64,
}

impl Default for HeightConfig {
    fn default() -> Self {
        Self { used: HeightUse::default(), cell_m: 0.1 }
    }
}

/// What the ground's height is looked at for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HeightUse {
    /// Nothing: it is not looked at.
    #[default]
    Off,
    /// To be shown: nothing else follows from it.
    Shown,
    /// To tell road from pavement, joined to what the road detector finds.
    Surface,
}

/// The height of the ground in view.
#[derive(Debug, Default)]
pub struct GroundHeight {
    /// Pixels of the ground view along a square.
    pub side_px: usize,
    /// Log-odds that a square is raised, in 256ths; below zero it lies on the road's plane, at zero nothing is known.
    pub raised: Plane<i16>,
}

/// How the height was found.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HeightEvidence {
    /// The pair of views that was compared in this frame.
    pub pair: Option<HeightPair>,
}

/// A pair of views that was compared.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HeightPair {
    /// The camera's way between them, metres.
    pub way_m: f64,
    /// Blocks of the strip ahead that fix the plane.
    pub blocks: f64,
    /// Root mean square of what they leave, metres along the way.
    pub residual_m: f64,
}

/// Travel of the pairs, metres, in turns: the short one for what is near, the long one for what is far.
const TRAVELS_M: [f64; 2] = [2.8, 4.8];
/// A pair that turned by more is not compared, radians: the shift along the way is one of rows no more.
const MOST_TURN_RAD: f64 = 0.5;
/// Blocks without which the plane is not known.
const LEAST_BLOCKS: f64 = 8.0;
/// Pixels across and down a cell that views are compared in: rows are what tells heights.
const CELL_PX: (usize, usize) = (2, 1);
/// Heights up to which a place is level and from which it is raised, metres over the plane.
const LEVEL_M: f64 = 0.035;
const RAISED_M: f64 = 0.055;
/// Independent witnesses in a window, times the share of a look that is news.
const WITNESSES: f32 = 3.0;
/// A single look says no more than this.
const MOST_A_LOOK: f32 = 2.0;
/// A motion less sure than this leaves the map behind, metres.
const LEFT_BEHIND_M: f64 = 1.0;
/// Travel over which the map fades to a third, metres.
const FADE_M: f64 = 30.0;

/// The stage.
#[derive(Debug, Default)]
pub struct HeightStage {
    config: HeightConfig,
    views: PastViews,
    now: PastView,
    sweep: Sweep,
    map: HeightMap,
    driven_m: f64,
    last_look_m: Option<f64>,
    looks: usize,
    height: GroundHeight,
    evidence: HeightEvidence,
    level: Vec<f32>,
    raised: Vec<f32>,
}

impl HeightStage {
    /// A stage that has seen nothing yet.
    #[must_use]
    pub fn new(config: &HeightConfig) -> Self {
        Self { config: config.clone(), ..Self::default() }
    }

    /// Takes in a frame: its ground view, how the vehicle moved to it, and how its camera is turned against the mount.
    pub fn step(
        &mut self,
        view: &GroundView,
        grey: &Plane<u8>,
        motion: Option<&Motion>,
        turn: CameraTurn,
    ) -> (&GroundHeight, &HeightEvidence) {
        self.evidence.pair = None;
        let grid = view.grid();
        self.height.side_px = ((self.config.cell_m / grid.metres_per_pixel()).round() as usize).max(1);
        self.map.lie_under(grid, self.height.side_px as f64 * grid.metres_per_pixel());
        self.carry(motion);
        if self.last_look_m.is_none_or(|last_m| self.driven_m - last_m >= SPACING_M) {
            self.last_look_m = Some(self.driven_m);
            self.look(view, grey, turn);
        }
        self.map.read(self.height.side_px, &mut self.height.raised);
        (&self.height, &self.evidence)
    }

    fn carry(&mut self, motion: Option<&Motion>) {
        let Some(motion) = motion else { return };
        if motion.covariance[(0, 0)].max(0.0).sqrt() > LEFT_BEHIND_M {
            self.views.clear();
            self.map.forget();
            return;
        }
        let step = &motion.previous_from_current;
        let moved_m = step.translation.vector.norm();
        self.driven_m += moved_m;
        self.now.odometry_from_vehicle *= step;
        self.now.odometry_from_vehicle.rotation.renormalize();
        self.map.carry(step, (-moved_m / FADE_M).exp());
    }

    fn look(&mut self, view: &GroundView, grey: &Plane<u8>, turn: CameraTurn) {
        let raster = Raster { grid: *view.grid(), cell_px: CELL_PX };
        (self.now.turn, self.now.driven_m) = (turn, self.driven_m);
        coarse(grey, view.validity().plane(), CELL_PX, &mut self.now.grey);
        self.sweep.look_at(raster, &self.now);
        self.compare(raster, view, TRAVELS_M[self.looks % TRAVELS_M.len()]);
        self.looks += 1;
        let odometry_from_vehicle = self.now.odometry_from_vehicle;
        self.views.keep(&mut self.now);
        self.now.odometry_from_vehicle = odometry_from_vehicle;
    }

    /// Compares the view at hand with one from so far back.
    fn compare(&mut self, raster: Raster, view: &GroundView, travel_m: f64) {
        let viewpoint = view.viewpoint();
        let Some(older) = self.views.at(self.driven_m, travel_m) else { return };
        let mut laid = LaidOver::new(raster, viewpoint, &self.now, older);
        if laid.turned_rad.abs() > MOST_TURN_RAD || laid.way.norm() < 0.5 * travel_m {
            return;
        }
        self.sweep.fit_plane(raster, viewpoint, &mut laid, older);
        let pair =
            HeightPair { way_m: laid.way.norm(), blocks: laid.fit.blocks, residual_m: laid.fit.residual_m };
        self.evidence.pair = Some(pair);
        if laid.fit.blocks < LEAST_BLOCKS {
            return;
        }
        let region = self.sweep.sweep(raster, viewpoint, &mut laid, older);
        let Self { sweep, level, raised, map, .. } = self;
        weigh(
            sweep,
            (level, raised),
            |place, log_odds| add(map, raster, region, view, place, log_odds),
            region,
        );
    }
}

/// Calls `tell` with the log-odds that each cell of the region is raised.
fn weigh(
    sweep: &Sweep,
    (level, raised): (&mut Vec<f32>, &mut Vec<f32>),
    mut tell: impl FnMut([usize; 2], f32),
    region: Region,
) {
    for row in SWEPT_ROWS.of(region.rows) {
        for best in [&mut *level, &mut *raised] {
            best.clear();
            best.resize(region.columns, 0.0);
        }
        for (height_m, correlations) in sweep.heights() {
            let best = if height_m.abs() <= LEVEL_M {
                &mut *level
            } else if height_m >= RAISED_M {
                &mut *raised
            } else {
                continue;
            };
            for (best, r) in best.iter_mut().zip(correlations.row(row)) {
                *best = best.max(*r);
            }
        }
        for (column, (level, raised)) in level.iter().zip(raised.iter()).enumerate() {
            // A window of n witnesses whose correlation is r is as likely as (1 - r^2)^(-n / 2).
            let left_over = |r: f32| 1.0 - r.min(0.97) * r.min(0.97);
            if *level > 0.0 || *raised > 0.0 {
                let log_odds = WITNESSES * (left_over(*level) / left_over(*raised)).ln();
                tell([column, row], log_odds.clamp(-MOST_A_LOOK, MOST_A_LOOK));
            }
        }
    }
}

/// Where a raised place is shown, it is nearer to the camera.
fn add(
    map: &mut HeightMap,
    raster: Raster,
    region: Region,
    view: &GroundView,
    [column, row]: [usize; 2],
    log_odds: f32,
) {
    let shown = Point2::new(
        raster.ahead_m((region.first_row + row) as f64),
        raster.left_m((region.first_column + column) as f64),
    );
    let (foot, height_m) = (view.camera_foot(), view.camera_height_m());
    let place = if log_odds > 0.0 { foot + (shown - foot) * (1.0 - TYPICAL_M / height_m) } else { shown };
    map.add(place, log_odds);
}

/// Height of a kerb, metres.
const TYPICAL_M: f64 = 0.11;

impl GroundHeight {
    /// Log-odds that the square under a pixel of the ground view is raised.
    #[must_use]
    pub fn log_odds(&self, column: usize, row: usize) -> f64 {
        let side = self.side_px.max(1);
        self.raised.get(column / side, row / side).map_or(0.0, |units| f64::from(units) / UNIT)
    }
}

#[cfg(test)]
mod tests;

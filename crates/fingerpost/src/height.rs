//! Height: which of the ground lies on the road's plane and which is raised, told by parallax and by no colour.
//!
//! A pavement lies 6 to 16 cm above the road, and two pictures taken some metres of travel apart show that: superimposed
//! through the road's plane, what lies at a height h is displaced along the way d by d h / (H - h), seen from a camera of height
//! H. Ground views of the last metres are kept (`past_views`); on each new one is superimposed one from some way back, after the
//! plane's own errors (pitch, roll, the way driven, the road's fall) have been fitted to the strip ahead (`road_plane`), and looked
//! at as if the ground lay at several heights (`sweep`). How likely that makes each height adds up in a rolling
//! grid (`height_map`). Across the way a chain of heights with kerbs as its steps tells what has been climbed to (`cross_section`).
//!
//! Limits: it needs some metres of travel and texture across the way. Things that move are not on any height. A kerb is looked for
//! across the view, so one that crosses the way ahead shows by the ground's height alone.

mod cross_section;
mod height_likelihoods;
mod height_map;
mod past_views;
mod raised_squares;
mod road_plane;
mod superimposed;
mod sweep;
mod texture_noise;

use fingerpost_vision::parallax::coarse;
use fingerpost_vision::picture::Plane;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::height_map::HeightMap;
use self::past_views::{PastView, PastViews, SPACING_M};
use self::raised_squares::{RaisedSquares, Squares};
use self::superimposed::{Raster, Superimposed};
use self::sweep::Sweep;
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
        Self { used: HeightUse::default(), cell_m: 0.2 }
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

/// Travel between the views of a pair, metres: a kerb of 10 cm is displaced by four cells.
const TRAVEL_M: f64 = 2.8;
/// A pair that turned by more is not compared, radians: the shift along the way is one of rows no more.
const MOST_TURN_RAD: f64 = 0.5;
/// Blocks without which the plane is not known.
const LEAST_BLOCKS: f64 = 8.0;
/// Pixels across and down a cell that views are compared in: rows are what tells heights.
const CELL_PX: (usize, usize) = (2, 1);
/// A motion less sure than this leaves the map behind, metres.
const LEFT_BEHIND_M: f64 = 1.0;
/// Units of log-odds in a square.
pub(crate) const UNIT: f64 = 256.0;
/// Largest log-odds of a square.
pub(crate) const MOST_LOG_ODDS: f32 = 8.0;
/// Farther to the side nothing is looked at, metres.
const ASIDE_M: f64 = 8.0;

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
    height: GroundHeight,
    evidence: HeightEvidence,
    squares: RaisedSquares,
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
        let grid = *view.grid();
        let side_px = ((self.config.cell_m / grid.metres_per_pixel()).round() as usize).max(1);
        let squares = Squares { grid, side_px };
        self.map.lie_under(&grid, side_px as f64 * grid.metres_per_pixel());
        self.carry(motion);
        if self.last_look_m.is_none_or(|last_m| self.driven_m - last_m >= SPACING_M) {
            self.last_look_m = Some(self.driven_m);
            self.look(view, grey, turn);
            let reach_m = view.viewpoint().foot.x + sweep::REACH_M;
            self.squares.look(&self.map, squares, self.now.odometry_from_vehicle, reach_m);
        }
        self.squares.carried(squares, &self.now.odometry_from_vehicle, &mut self.height);
        (&self.height, &self.evidence)
    }

    fn carry(&mut self, motion: Option<&Motion>) {
        let Some(motion) = motion else { return };
        if motion.covariance[(0, 0)].max(0.0).sqrt() > LEFT_BEHIND_M {
            self.views.clear();
            self.map.forget();
            self.squares.forget();
            return;
        }
        let step = &motion.previous_from_current;
        let moved_m = step.translation.vector.norm();
        self.driven_m += moved_m;
        self.now.odometry_from_vehicle *= step;
        self.now.odometry_from_vehicle.rotation.renormalize();
        self.map.carry(motion);
    }

    fn look(&mut self, view: &GroundView, grey: &Plane<u8>, turn: CameraTurn) {
        let raster = Raster { grid: *view.grid(), cell_px: CELL_PX };
        (self.now.turn, self.now.driven_m) = (turn, self.driven_m);
        coarse::<{ CELL_PX.0 }>(grey, view.validity().plane(), CELL_PX.1, &mut self.now.grey);
        self.sweep.look_at(raster, view.viewpoint(), &self.now);
        self.compare(raster, view);
        let odometry_from_vehicle = self.now.odometry_from_vehicle;
        self.views.keep(&mut self.now);
        self.now.odometry_from_vehicle = odometry_from_vehicle;
    }

    /// Compares the view at hand with one from some way back.
    fn compare(&mut self, raster: Raster, view: &GroundView) {
        let viewpoint = view.viewpoint();
        let Some(older) = self.views.at(self.driven_m, TRAVEL_M) else { return };
        let mut superimposed = Superimposed::new(raster, viewpoint, &self.now, older);
        if superimposed.turned_rad.abs() > MOST_TURN_RAD || superimposed.way.norm() < 0.5 * TRAVEL_M {
            return;
        }
        self.sweep.fit_plane(raster, viewpoint, &mut superimposed, older);
        let pair = HeightPair {
            way_m: superimposed.way.norm(),
            blocks: superimposed.fit.blocks,
            residual_m: superimposed.fit.residual_m,
        };
        self.evidence.pair = Some(pair);
        if superimposed.fit.blocks < LEAST_BLOCKS {
            return;
        }
        let region = self.sweep.sweep(raster, viewpoint, &mut superimposed, older);
        if let Some(likelihoods) = self.sweep.likelihoods(raster) {
            self.map.add(likelihoods, raster, region, viewpoint);
        }
    }
}

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

//! How one ground view is superimposed on a later one, through the road's plane.

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::parallax::Registration;
use nalgebra::{Matrix3, Vector2, Vector3};

use super::past_views::PastView;
use super::road_plane::PlaneFit;
use crate::ground_view::Viewpoint;

/// The raster of coarse ground views: cells instead of pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Raster {
    pub(super) grid: GroundGrid,
    /// Pixels of the ground view across and down a cell.
    pub(super) cell_px: (usize, usize),
}

impl Raster {
    pub(super) fn cell_m(&self) -> [f64; 2] {
        let (across, down) = self.cell_px;
        [across as f64 * self.grid.metres_per_pixel(), down as f64 * self.grid.metres_per_pixel()]
    }

    /// Ahead of the vehicle's origin, metres.
    pub(super) fn ahead_m(&self, row: f64) -> f64 {
        self.grid.far_m() - (row + 0.5) * self.cell_m()[1]
    }

    /// Left of it.
    pub(super) fn left_m(&self, column: f64) -> f64 {
        self.grid.half_width_m() - (column + 0.5) * self.cell_m()[0]
    }

    pub(super) fn row_at(&self, ahead_m: f64) -> f64 {
        (self.grid.far_m() - ahead_m) / self.cell_m()[1] - 0.5
    }

    pub(super) fn column_at(&self, left_m: f64) -> f64 {
        (self.grid.half_width_m() - left_m) / self.cell_m()[0] - 0.5
    }

    /// Column, row and 1 of a place (vehicle frame, metres), homogeneous.
    fn cells_from_vehicle(&self) -> Matrix3<f64> {
        let [across, down] = self.cell_m();
        let (left, top) = (self.grid.half_width_m() / across - 0.5, self.grid.far_m() / down - 0.5);
        Matrix3::new(0.0, -1.0 / across, left, -1.0 / down, 0.0, top, 0.0, 0.0, 1.0)
    }
}

/// A part of a raster.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Region {
    pub(super) first_row: usize,
    pub(super) first_column: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
}

/// An older view superimposed on part of a newer one.
#[derive(Debug)]
pub(super) struct Superimposed {
    raster: Raster,
    region: Region,
    foot_x_m: f64,
    older_cells_from_shown: Matrix3<f64>,
    pub(super) fit: PlaneFit,
    /// The camera's way from the older view to the newer one, in the newer vehicle frame, metres.
    pub(super) way: Vector2<f64>,
    /// By how much the vehicle turned meanwhile, radians.
    pub(super) turned_rad: f64,
}

impl Superimposed {
    pub(super) fn new(raster: Raster, viewpoint: Viewpoint, newer: &PastView, older: &PastView) -> Self {
        let older_from_newer = older.odometry_from_vehicle.inv_mul(&newer.odometry_from_vehicle);
        let older_shown_from_newer_shown = older.turn.shown_from_road(viewpoint)
            * older_from_newer.to_homogeneous()
            * newer.turn.road_from_shown(viewpoint);
        let foot = viewpoint.foot;
        let way = older_from_newer.rotation.inverse() * (older_from_newer * foot - foot);
        Self {
            raster,
            region: Region::default(),
            foot_x_m: foot.x,
            older_cells_from_shown: raster.cells_from_vehicle() * older_shown_from_newer_shown,
            fit: PlaneFit::default(),
            way,
            turned_rad: older_from_newer.rotation.angle(),
        }
    }

    /// Over this part of the newer view.
    pub(super) fn over(&mut self, region: Region) {
        self.region = region;
    }
}

impl Registration for Superimposed {
    fn along_row(&self, row: usize) -> [[f32; 2]; 3] {
        let ahead_m = self.raster.ahead_m((self.region.first_row + row) as f64);
        let left_m = self.raster.left_m(self.region.first_column as f64);
        let across_m = self.raster.cell_m()[0];
        let [level, tilted] = self.fit.along_row(ahead_m - self.foot_x_m);
        let start = Vector3::new(ahead_m + level + tilted * left_m, left_m, 1.0);
        let step = Vector3::new(-tilted * across_m, -across_m, 0.0);
        let (start, step) = (self.older_cells_from_shown * start, self.older_cells_from_shown * step);
        [0, 1, 2].map(|axis| [start[axis] as f32, step[axis] as f32])
    }
}

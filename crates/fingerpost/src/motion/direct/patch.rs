//! The strip of road that is aligned: of the newer frame a pyramid, of the older one its points.

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::alignment::{Flattening, Target, Template, mark_unseen};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, Rect, ValidityMask};
use fingerpost_vision::pyramid::halve;

use super::DirectMotionConfig;
use super::plane_warp::Raster;
use crate::ground_view::GroundView;

/// Scale of the finest level, metres per pixel, at least: finer ones show the camera's noise.
const FINEST_M: f64 = 0.04;
/// Scale of the coarsest level, metres per pixel, at most: a vehicle that speeds up or turns in moves by less than this
/// against the frame before.
const COARSEST_M: f64 = 0.45;
/// Distance between template points, metres: closer ones say much the same.
const POINT_SPACING_M: f64 = 0.2;
/// Width of road beside and behind the template that may be moved into it, metres.
const MARGIN_M: f64 = 1.0;
/// Side of the window whose mean brightness is taken off each place, metres: what the light and the lens do to the picture
/// stays with the camera while the road goes by, and would speak for a vehicle that stands.
const FLATTEN_M: f64 = 2.5;
/// Side of the blocks that it is made of, metres.
const FLATTEN_BLOCK_M: f64 = 0.2;
/// Least side of the patch at the finest level, pixels.
const MIN_SIDE_PX: usize = 16;

/// One scale of the patch.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) raster: Raster,
    /// Where template points are chosen.
    region: Rect,
    /// Side of the cells with one point each, pixels.
    cell_px: usize,
    /// 1 where all pixels of the ground view are seen.
    seen: Plane<u8>,
    halved: Plane<u8>,
    /// The newer frame, 0 where unseen.
    grey: Plane<u8>,
    pub(super) target: Target,
    /// The older frame.
    pub(super) template: Template,
}

/// The patch at all scales, the finest first.
#[derive(Debug)]
pub(super) struct Patch {
    pub(super) grid: GroundGrid,
    mask: ValidityMask,
    /// Part of the ground view that is looked at: the region and a margin.
    area: Rect,
    /// Part of the ground view in which template points are chosen.
    pub(super) region: Rect,
    pub(super) levels: Vec<Level>,
    /// The newer frame as the camera sees it.
    seen_grey: Plane<u8>,
    flattening: Flattening,
    /// Some of the points of the finest level, for a search among them.
    pub(super) some_points: Template,
    /// Index of the finest level that is aligned.
    pub(super) finest: usize,
}

impl Patch {
    /// The patch of a ground view; `None` when the view shows too little.
    pub(super) fn new(view: &GroundView, config: &DirectMotionConfig) -> Option<Self> {
        let grid = *view.grid();
        let viewpoint = view.viewpoint();
        let scale = grid.metres_per_pixel();
        let pixels = |length_m: f64| (length_m / scale).round() as usize;
        let finest = libm::log2(FINEST_M / scale).ceil().max(0.0) as usize;
        let coarsest = (libm::log2(COARSEST_M / scale).floor().max(0.0) as usize).max(finest);

        let bottom = pixels(grid.far_m() - view.nearest_seen_m()).min(grid.rows());
        let (middle, half) = (grid.columns() / 2, pixels(0.5 * config.width_m));
        let (left, right) = (middle.saturating_sub(half), (middle + half).min(grid.columns()));
        let top = bottom.saturating_sub(pixels(config.length_m));
        let region = Rect { x: left, y: top, width: right - left, height: bottom - top };
        if region.width.min(region.height) >> finest < MIN_SIDE_PX {
            return None;
        }
        // Levels correspond pixel by pixel when the area starts at a multiple of the coarsest pixel.
        let (margin, step) = (pixels(MARGIN_M), 1 << coarsest);
        let down = |at: usize| at.saturating_sub(margin) / step * step;
        let (x, y) = (down(left), down(top));
        let area = Rect { x, y, width: (right + margin).min(grid.columns()) - x, height: bottom - y };
        let flattening = Flattening::new(pixels(FLATTEN_BLOCK_M), pixels(FLATTEN_M));
        let mut patch = Self {
            seen_grey: Plane::default(),
            flattening,
            grid,
            mask: view.validity().clone(),
            area,
            region,
            levels: Vec::new(),
            some_points: Template::default(),
            finest,
        };
        for level in 0..=coarsest {
            let seen = match patch.levels.last() {
                None => cut(view.validity().plane(), area),
                Some(below) => halved_mask(&below.seen),
            };
            let (width, height) = seen.size();
            let raster = Raster::new(&grid, viewpoint, [x, y], level);
            let spacing = POINT_SPACING_M / raster.metres_per_pixel;
            let (left, top) = ((left - x) >> level, (top - y) >> level);
            patch.levels.push(Level {
                raster,
                region: Rect {
                    x: left,
                    y: top,
                    width: ((right - x) >> level) - left,
                    height: ((bottom - y) >> level) - top,
                },
                cell_px: (spacing.round() as usize).max(1),
                seen,
                halved: Plane::new(width, height, 0),
                grey: Plane::new(width, height, 0),
                target: Target::default(),
                template: Template::default(),
            });
        }
        Some(patch)
    }

    /// Whether this is a patch of `view`.
    pub(super) fn fits(&self, view: &GroundView) -> bool {
        let same_runs = |y: usize| self.mask.runs(y) == view.validity().runs(y);
        self.grid == *view.grid() && (0..self.grid.rows()).all(same_runs)
    }

    /// Takes in the newer frame.
    pub(super) fn look_at(&mut self, grey: &Plane<u8>) -> Result<(), PictureError> {
        for index in 0..self.levels.len() {
            let (below, rest) = self.levels.split_at_mut(index);
            let level = &mut rest[0];
            match below.last() {
                None => {
                    self.seen_grey.reset(self.area.width, self.area.height, 0);
                    mark_unseen(grey.view().crop(self.area)?, &level.seen, &mut self.seen_grey)?;
                    self.flattening.apply(&self.seen_grey, &mut level.grey);
                }
                Some(below) => {
                    halve(below.grey.view(), &mut level.halved)?;
                    mark_unseen(level.halved.view(), &level.seen, &mut level.grey)?;
                }
            }
            if index >= self.finest {
                level.target.fill(&level.grey);
            }
        }
        Ok(())
    }

    /// Makes the frame taken in last the older one, on a path that bends so.
    pub(super) fn keep(&mut self, curvature_per_m: f64) {
        for level in &mut self.levels[self.finest..] {
            let corridor = level.raster.corridor(curvature_per_m);
            level.template.choose(&level.grey, level.region, level.cell_px, &corridor);
        }
    }
}

fn cut(mask: &Plane<u8>, area: Rect) -> Plane<u8> {
    let mut part = Plane::new(area.width, area.height, 0);
    for y in 0..area.height {
        part.row_mut(y).copy_from_slice(&mask.row(area.y + y)[area.x..area.x + area.width]);
    }
    part
}

/// A pixel of the halved mask is seen when all four are.
fn halved_mask(seen: &Plane<u8>) -> Plane<u8> {
    let (width, height) = (seen.width() / 2, seen.height() / 2);
    let mut half = Plane::new(width, height, 0);
    for y in 0..height {
        let (upper, lower) = (seen.row(2 * y), seen.row(2 * y + 1));
        for (x, out) in half.row_mut(y).iter_mut().enumerate() {
            let all = [upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]];
            *out = u8::from(all.iter().all(|&seen| seen != 0));
        }
    }
    half
}

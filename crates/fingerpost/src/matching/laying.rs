//! What the masks are superimposed on, as a stage of its own.

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::span::RowSums;

use super::{LaidSurface, MatchConfig, Matcher};
use crate::road_surface::RoadSurface;

/// A way to make of a frame's road surface what feature masks are superimposed on: equations 1 and 2 of paper 1 then read it.
///
/// [`Matcher`] lays them over the probabilities, or over road and no road by a threshold. Another may weigh the pixels first.
pub trait FeatureMatcher: Send {
    /// The surface of one frame, ready for any number of masks.
    ///
    /// # Errors
    /// [`PictureError`] when what is known of the surface has another size than the surface.
    fn lay<'a>(&'a mut self, surface: &'a RoadSurface) -> Result<LaidSurface<'a>, PictureError>;
}

impl FeatureMatcher for Matcher {
    fn lay<'a>(&'a mut self, surface: &'a RoadSurface) -> Result<LaidSurface<'a>, PictureError> {
        self.laid(surface, surface.known())
    }
}

impl<'a> LaidSurface<'a> {
    /// Sums of any values from 0 to 255 as what masks are superimposed on on the raster `grid`. Sums and raster must have the same
    /// size.
    pub const fn over(config: &'a MatchConfig, grid: &'a GroundGrid, sums: &'a RowSums) -> Self {
        Self { config, grid, sums }
    }
}

//! The camera picture behind a picture in which road is wanted.
//!
//! Some detectors look at the camera picture whatever view is wanted: there walls stand above the road and distance is a
//! row. What they find is then laid into the picture that was asked for.

use fingerpost_geometry::{Camera, GroundGrid, GroundPixel, Pixel};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, RgbImage, ValidityMask};
use fingerpost_vision::warp::WarpTable;
use nalgebra::Point2;

use super::{Perspective, RoadInput};

/// How far ahead the horizon is measured, metres: farther the road's row changes by less than a hundredth of a pixel.
const FAR_AWAY_M: f64 = 1e5;

/// A perspective to be remembered: what a table from the camera picture depends on.
#[derive(Debug, Clone, PartialEq)]
pub enum KnownPerspective {
    /// The camera's.
    Camera {
        /// Row of the horizon, pixels from the centre of the top row.
        horizon_row: f64,
    },
    /// From above.
    Ground {
        /// The camera whose frames are shown.
        camera: Box<Camera>,
        /// The ground view's raster.
        grid: GroundGrid,
    },
}

impl KnownPerspective {
    /// What is to be remembered of `perspective`.
    pub fn of(perspective: Perspective<'_>) -> Self {
        match perspective {
            Perspective::Camera { horizon_row } => Self::Camera { horizon_row },
            Perspective::Ground { view, .. } => {
                Self::Ground { camera: Box::new(view.camera().clone()), grid: *view.grid() }
            }
        }
    }

    /// Whether `perspective` is the same.
    pub fn is(&self, perspective: Perspective<'_>) -> bool {
        match (self, perspective) {
            (Self::Camera { horizon_row: known }, Perspective::Camera { horizon_row }) => {
                known.to_bits() == horizon_row.to_bits()
            }
            (Self::Ground { camera, grid }, Perspective::Ground { view, .. }) => {
                camera.as_ref() == view.camera() && grid == view.grid()
            }
            _ => false,
        }
    }
}

impl<'a> RoadInput<'a> {
    /// The camera's picture.
    pub fn camera_picture(&self) -> &'a RgbImage {
        match self.perspective {
            Perspective::Camera { .. } => &self.picture.colour,
            Perspective::Ground { frame, .. } => frame,
        }
    }

    /// Where straight roads ahead meet the horizon, pixels of the camera picture; in the middle of its upper edge where that is unknown.
    pub(super) fn vanishing_point(&self) -> Pixel {
        let middle = 0.5 * (self.camera_picture().width() as f64 - 1.0);
        match self.perspective {
            Perspective::Camera { horizon_row } => Pixel::new(middle, horizon_row),
            Perspective::Ground { view, .. } => {
                let foot = view.camera_foot();
                let far_ahead = view.camera().pixel_of_ground(Point2::new(foot.x + FAR_AWAY_M, foot.y));
                far_ahead.unwrap_or(Pixel::new(middle, 0.0))
            }
        }
    }

    /// Where a place of the camera picture lies in the picture that is asked for.
    pub(super) fn asked_from_camera(&self, p: Pixel) -> Option<[f64; 2]> {
        match self.perspective {
            Perspective::Camera { .. } => Some([p.u, p.v]),
            Perspective::Ground { view, .. } => {
                let GroundPixel { column, row } =
                    view.grid().ground_from_vehicle(view.camera().ground_of_pixel(p)?);
                Some([column, row])
            }
        }
    }

    /// Where a place of the picture that is asked for lies in the camera picture, where the camera sees it.
    pub fn camera_from_asked(&self, [column, row]: [f64; 2]) -> Option<Pixel> {
        match self.perspective {
            Perspective::Camera { .. } => Some(Pixel::new(column, row)),
            Perspective::Ground { view, .. } => {
                let p_in_vehicle = view.grid().vehicle_from_ground(GroundPixel { column, row });
                view.camera().pixel_of_ground(p_in_vehicle).filter(|&p| view.camera().contains(p))
            }
        }
    }

    /// The table that lays a reduced camera picture of `columns` x `rows` pixels into the picture that is asked for;
    /// `reduced_from_camera` says where a place of the camera picture lies in the reduced one. Half a reduced pixel lies
    /// beyond the centres of the outermost ones and shows those.
    ///
    /// # Errors
    /// [`PictureError`] when either picture has no pixels.
    pub fn table_from_reduced(
        &self,
        (columns, rows): (usize, usize),
        reduced_from_camera: impl Fn(Pixel) -> [f64; 2],
    ) -> Result<WarpTable, PictureError> {
        let (width, height) = self.validity.size();
        let last = |count: usize| count.saturating_sub(1) as f64;
        WarpTable::new(width, height, columns, rows.max(1), |column, row| {
            let p = self.camera_from_asked([column as f64, row as f64])?;
            let [u, v] = reduced_from_camera(p);
            Some([u.clamp(0.0, last(columns)), v.clamp(0.0, last(rows))])
        })
    }
}

/// Sets the probability of what is not seen to 0.
pub fn clear_unseen(validity: &ValidityMask, probability: &mut Plane<u8>) {
    for y in 0..probability.height() {
        let row = probability.row_mut(y);
        let mut done = 0;
        for run in validity.runs(y) {
            row[done..run.start].fill(0);
            done = run.end;
        }
        row[done..].fill(0);
    }
}

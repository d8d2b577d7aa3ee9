//! Ground view: the picture as seen from above (inverse perspective mapping).
//!
//! Paper 1, section IV-A; paper 2, sections 2.1, 3.1 and 6. One table, built once, maps each ground pixel to the
//! frame with the lens folded in. Limits: the road is taken as flat; whatever stands on it is smeared away from the
//! camera.

mod turn;

use fingerpost_geometry::{Camera, GeometryError, GroundGrid, GroundPixel, View};
use fingerpost_vision::colour::{BinDivision, ColourError, HueSaturationBins};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, RgbImage, ValidityMask};
use fingerpost_vision::warp::WarpTable;
use nalgebra::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use turn::{CameraTurn, Viewpoint};

/// Which part of the road the ground view shows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GroundViewConfig {
    /// Lower edge, metres ahead of the rear axle; below far_m.
    #[schemars(range(min = -10.0, max = 200.0))]
    pub near_m: f64,
    /// Upper edge, metres ahead; 15 to 20 works best (paper 2, section 6).
    #[schemars(range(min = -9.0, max = 300.0))]
    pub far_m: f64,
    /// Left and right edge, metres from the centre line.
    #[schemars(range(min = 0.5, max = 100.0))]
    pub half_width_m: f64,
    /// Scale, metres per pixel.
    #[schemars(range(min = 0.005, max = 1.0))]
    pub metres_per_pixel: f64,
}

impl Default for GroundViewConfig {
    fn default() -> Self {
        Self { near_m: 4.0, far_m: 20.0, half_width_m: 10.0, metres_per_pixel: 0.05 }
    }
}

/// A ground view that cannot be made.
#[derive(Debug, Error)]
pub enum GroundViewError {
    /// The configured part of the road cannot be a picture.
    #[error("the ground view cannot be made: {0}")]
    Grid(#[from] GeometryError),
    /// The camera sees too little of the configured part of the road.
    #[error(
        "the camera sees {seen_percent:.1} % of the ground view ({near_m} to {far_m} m ahead); check the mount's height \
         and pitch, or move near_m and far_m"
    )]
    NothingSeen {
        /// Share of the ground view inside the picture, percent.
        seen_percent: f64,
        /// Lower edge, metres.
        near_m: f64,
        /// Upper edge, metres.
        far_m: f64,
    },
    /// The numbers of histogram bins cannot be used.
    #[error("the ground view's colours cannot be told apart: {0}")]
    Bins(#[from] ColourError),
    /// A frame does not have the camera's size.
    #[error("the frame cannot be warped: {0}")]
    Frame(#[from] PictureError),
}

/// The table from frame to ground view, built once for a camera.
#[derive(Debug)]
pub struct GroundView {
    grid: GroundGrid,
    table: WarpTable,
    division: BinDivision,
    nearest_seen_m: f64,
    viewpoint: Viewpoint,
    camera: Camera,
}

/// The ground view of one frame.
#[derive(Debug, Clone)]
pub struct GroundPicture {
    /// Colour, black where unseen.
    pub colour: RgbImage,
    /// Grey (CCIR 601), black where unseen.
    pub grey: Plane<u8>,
    /// Index of each pixel's bin in `bins`, 0 where unseen.
    pub bin: Plane<u16>,
    /// The division of hue and saturation into bins.
    pub bins: HueSaturationBins,
}

impl GroundPicture {
    /// A black picture of `columns` x `rows` pixels.
    pub fn new(columns: usize, rows: usize, bins: HueSaturationBins) -> Self {
        Self {
            colour: RgbImage::new(columns, rows),
            grey: Plane::new(columns, rows, 0),
            bin: Plane::new(columns, rows, 0),
            bins,
        }
    }
}

/// Share of the ground view that must be inside the picture, percent; with less no arm could be seen whole.
const MIN_SEEN_PERCENT: f64 = 5.0;
/// Height that is assumed of a camera known by points, metres: behind a car's windscreen.
const CAR_CAMERA_HEIGHT_M: f64 = 1.4;
/// Half the width of the strip ahead whose nearest wholly seen row counts as the bottom of the view, metres.
const CORRIDOR_HALF_WIDTH_M: f64 = 0.9;

/// Where the sharpness is taken, metres beyond the bottom of the view, over which length, and the fewest rows that this is
/// believed to span.
const SHARPNESS_AHEAD_M: f64 = 4.0;
const SHARPNESS_STEP_M: f64 = 0.5;
const LEAST_ROWS: f64 = 0.5;

impl GroundView {
    /// Builds the table for `camera`; `bins` is the division of hue and saturation that pictures are to have.
    ///
    /// # Errors
    /// [`GroundViewError::Grid`] for limits that make no picture, [`GroundViewError::Bins`] for numbers of bins that
    /// cannot be used, [`GroundViewError::NothingSeen`] when the camera looks elsewhere.
    pub fn new(
        config: &GroundViewConfig,
        bins: HueSaturationBins,
        camera: &Camera,
    ) -> Result<Self, GroundViewError> {
        let division = BinDivision::new(bins)?;
        let grid =
            GroundGrid::new(config.near_m, config.far_m, config.half_width_m, config.metres_per_pixel)?;
        let table =
            WarpTable::new(grid.columns(), grid.rows(), camera.width(), camera.height(), |column, row| {
                let pixel = GroundPixel { column: column as f64, row: row as f64 };
                camera.pixel_of_ground(grid.vehicle_from_ground(pixel)).map(|p| [p.u, p.v])
            })?;
        let validity = table.validity();
        let seen_percent = 100.0 * validity.seen() as f64 / validity.plane().as_slice().len() as f64;
        let nothing_seen =
            GroundViewError::NothingSeen { seen_percent, near_m: config.near_m, far_m: config.far_m };
        if seen_percent < MIN_SEEN_PERCENT {
            return Err(nothing_seen);
        }
        let Some(nearest_seen_m) = nearest_seen_m(&grid, validity.plane()) else { return Err(nothing_seen) };
        let viewpoint = match camera.view() {
            View::Calibrated { mount, .. } => {
                Viewpoint { foot: Point2::new(mount.x_m, mount.y_m), height_m: mount.height_m }
            }
            View::RoadPlane(_) => Viewpoint { foot: Point2::origin(), height_m: CAR_CAMERA_HEIGHT_M },
        };
        Ok(Self { grid, table, division, nearest_seen_m, viewpoint, camera: camera.clone() })
    }

    /// The raster of the ground view.
    pub const fn grid(&self) -> &GroundGrid {
        &self.grid
    }

    /// The validity mask (the papers' "IPM mask"): where the picture shows the road plane.
    pub fn validity(&self) -> &ValidityMask {
        self.table.validity()
    }

    /// The bottom of what is seen straight ahead, metres from the vehicle's origin.
    pub const fn nearest_seen_m(&self) -> f64 {
        self.nearest_seen_m
    }

    /// Where the camera looks from; for a camera known by points its height is that of a car's.
    pub const fn viewpoint(&self) -> Viewpoint {
        self.viewpoint
    }

    /// The camera that the view is made from.
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The place on the road below the camera, vehicle frame, metres.
    pub const fn camera_foot(&self) -> Point2<f64> {
        self.viewpoint.foot
    }

    /// Height of the camera above the road, metres.
    pub const fn camera_height_m(&self) -> f64 {
        self.viewpoint.height_m
    }

    /// Angle that a row of the picture spans where it shows the road straight ahead, radians: how sharp the view is.
    pub fn row_rad(&self) -> f64 {
        let Viewpoint { foot, height_m } = self.viewpoint;
        let ahead_m = self.grid.far_m().min(self.nearest_seen_m + SHARPNESS_AHEAD_M) - foot.x;
        let row = |ahead_m: f64| Some(self.camera.pixel_of_ground(Point2::new(foot.x + ahead_m, foot.y))?.v);
        let below_rad = |ahead_m: f64| libm::atan(height_m / ahead_m);
        let step_m = SHARPNESS_STEP_M;
        let rows = row(ahead_m).zip(row(ahead_m + step_m)).map_or(0.0, |(near, far)| (near - far).abs());
        (below_rad(ahead_m) - below_rad(ahead_m + step_m)) / rows.max(LEAST_ROWS)
    }

    /// A picture for [`GroundView::render`] to fill.
    pub fn black_picture(&self) -> GroundPicture {
        GroundPicture::new(self.grid.columns(), self.grid.rows(), self.division.bins())
    }

    /// Warps `frame` into `picture`, whose memory is reused.
    ///
    /// # Errors
    /// [`GroundViewError::Frame`] when the frame's size is not the camera's.
    pub fn render(&self, frame: &RgbImage, picture: &mut GroundPicture) -> Result<(), GroundViewError> {
        if picture.colour.size() != self.table.target_size() || picture.bins != self.division.bins() {
            *picture = self.black_picture();
        }
        let GroundPicture { colour, grey, bin, .. } = picture;
        Ok(self.table.warp_ground(frame, &self.division, colour, grey, bin)?)
    }
}

fn nearest_seen_m(grid: &GroundGrid, validity: &Plane<u8>) -> Option<f64> {
    let middle = 0.5 * grid.columns() as f64;
    let half = CORRIDOR_HALF_WIDTH_M.min(grid.half_width_m()) / grid.metres_per_pixel();
    let columns = (middle - half).floor() as usize..(middle + half).ceil() as usize;
    (0..grid.rows())
        .rev()
        .find(|&row| validity.row(row)[columns.clone()].iter().all(|&v| v != 0))
        .map(|row| grid.vehicle_from_ground(GroundPixel { column: 0.0, row: row as f64 + 0.5 }).x)
}

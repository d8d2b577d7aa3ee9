//! Camera pictures as detectors take them, and their ground views.

use std::time::Instant;

use anyhow::{Context, Result};
use fingerpost::Config;
use fingerpost::ground_view::{GroundPicture, GroundView, GroundViewConfig};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost_vision::colour::{BinDivision, grey_and_bins};
use fingerpost_vision::picture::{Plane, RgbImage, ValidityMask};

use crate::stage_clock::milliseconds;

/// The assumed camera: how wide it sees, and how high above the road.
const ASSUMED_WIDTH_RAD: f64 = 1.05;
const ASSUMED_HEIGHT_M: f64 = 1.4;

/// The picture at hand, as detectors take it.
pub(super) struct Pictures {
    division: BinDivision,
    from_row: f64,
    pub(super) picture: GroundPicture,
    pub(super) validity: ValidityMask,
    /// First row that counts.
    pub(super) first_row: usize,
}

impl Pictures {
    pub(super) fn new(config: &Config, from_row: f64) -> Result<Self> {
        let division = BinDivision::new(config.road_surface.backprojection.bins())?;
        let picture = GroundPicture::new(0, 0, division.bins());
        Ok(Self { division, from_row, picture, validity: ValidityMask::default(), first_row: 0 })
    }

    /// Takes a picture; milliseconds that its greys and bins took.
    pub(super) fn take(&mut self, colour: RgbImage) -> Result<f64> {
        let (width, height) = colour.size();
        if self.picture.colour.size() != (width, height) {
            self.picture = GroundPicture::new(width, height, self.division.bins());
            self.first_row = ((height as f64 * self.from_row).round() as usize).min(height);
            let mut below = Plane::new(width, height, 0);
            (self.first_row..height).for_each(|row| below.row_mut(row).fill(1));
            self.validity = ValidityMask::from_plane(below);
        }
        let GroundPicture { grey, bin, .. } = &mut self.picture;
        let start = Instant::now();
        grey_and_bins(&colour, &self.division, grey, bin)?;
        let spent_ms = milliseconds(start.elapsed());
        self.picture.colour = colour;
        Ok(spent_ms)
    }
}

/// Ground views of pictures through a camera that is given or assumed.
pub(super) struct GroundViews {
    config: GroundViewConfig,
    division: BinDivision,
    camera: Option<Camera>,
    from_row: f64,
    /// The view of pictures of one size.
    view: Option<((usize, usize), GroundView)>,
}

impl GroundViews {
    /// Through `camera`, or else one that is assumed: 60 degrees wide, 1.4 m above a level road, with the horizon at
    /// `from_row` of the height.
    pub(super) fn new(config: &Config, camera: Option<Camera>, from_row: f64) -> Result<Self> {
        let division = BinDivision::new(config.road_surface.backprojection.bins())?;
        Ok(Self { config: config.ground_view.clone(), division, camera, from_row, view: None })
    }

    /// The ground view of a picture, and the view that it was taken with.
    pub(super) fn take(&mut self, picture: &RgbImage) -> Result<(GroundPicture, &GroundView)> {
        let size = picture.size();
        if self.view.as_ref().is_none_or(|(of, _)| *of != size) {
            let camera = match &self.camera {
                Some(camera) => camera.clone(),
                None => assumed_camera(size, self.from_row)?,
            };
            self.view = Some((size, GroundView::new(&self.config, self.division.bins(), &camera)?));
        }
        let (_, view) = self.view.as_ref().context("a view was just made")?;
        let mut ground = view.black_picture();
        view.render(picture, &mut ground)?;
        Ok((ground, view))
    }
}

fn assumed_camera((width, height): (usize, usize), from_row: f64) -> Result<Camera> {
    let f = 0.5 * width as f64 / libm::tan(0.5 * ASSUMED_WIDTH_RAD);
    let (cx, cy) = (0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0));
    let pitch_rad = libm::atan((cy - from_row * height as f64) / f);
    let mount = Mount { pitch_rad, ..Mount::level(ASSUMED_HEIGHT_M) };
    Ok(Camera::calibrated(width, height, Intrinsics { fx: f, fy: f, cx, cy }, Distortion::None, mount)?)
}

//! A detector that sees the camera picture itself, whose probabilities are then laid into the ground view.
//!
//! Paper 1, section IV-B and figure 4: road detection works before and after the inverse perspective mapping, and there it
//! was better after. `road_surface.picture` chooses; `docs/papers.md` says what comes of either on simulated drives. The detector
//! samples the same bit of road: the largest upright rectangle of the camera picture that lies on it.

use fingerpost::ground_view::GroundPicture;
use fingerpost::road_surface::{
    KnownPerspective, Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput, SurfaceFile,
    clear_unseen,
};
use fingerpost_geometry::{GroundPixel, Pixel};
use fingerpost_vision::colour::{BinDivision, HueSaturationBins, grey_and_bins};
use fingerpost_vision::picture::{Plane, Rect, RgbImage, ValidityMask};
use fingerpost_vision::warp::WarpTable;
use nalgebra::Point2;

/// How far ahead the horizon is looked for, metres: farther, the road's row changes by less than a hundredth of a pixel.
const FAR_AWAY_M: f64 = 1e5;

/// A detector around another, which it shows the camera picture.
pub(super) struct InCamera {
    detector: Box<dyn RoadDetector>,
    division: BinDivision,
    picture: GroundPicture,
    probability: Plane<u8>,
    layout: Option<Layout>,
}

/// Where the camera picture shows road, and where it lies in the ground view.
struct Layout {
    perspective: KnownPerspective,
    asked_sample: Rect,
    sample: Rect,
    horizon_row: f64,
    validity: ValidityMask,
    table: WarpTable,
}

impl InCamera {
    /// Around `detector`, whose pictures have these bins.
    ///
    /// # Errors
    /// [`RoadError::Colour`] when the bins cannot be used.
    pub(super) fn new(detector: Box<dyn RoadDetector>, bins: HueSaturationBins) -> Result<Self, RoadError> {
        Ok(Self {
            detector,
            division: BinDivision::new(bins)?,
            picture: GroundPicture::new(0, 0, bins),
            probability: Plane::default(),
            layout: None,
        })
    }

    /// Makes greys and bins of the camera picture.
    fn take(&mut self, frame: &RgbImage) -> Result<(), RoadError> {
        if self.picture.colour.size() != frame.size() {
            self.picture = GroundPicture::new(frame.width(), frame.height(), self.division.bins());
        }
        let GroundPicture { colour, grey, bin, .. } = &mut self.picture;
        colour.as_mut_slice().copy_from_slice(frame.as_slice());
        Ok(grey_and_bins(frame, &self.division, grey, bin)?)
    }
}

impl RoadDetector for InCamera {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let Perspective::Ground { frame, .. } = input.perspective else {
            // The camera picture is what is asked for.
            return self.detector.estimate(input, probability);
        };
        self.take(frame)?;
        let layout = match self.layout.take().filter(|layout| layout.serves(&input)) {
            Some(layout) => layout,
            None => Layout::new(&input)?,
        };
        let layout = self.layout.insert(layout);
        let seen = RoadInput {
            picture: &self.picture,
            validity: &layout.validity,
            sample: layout.sample,
            perspective: Perspective::Camera { horizon_row: layout.horizon_row },
            motion: input.motion,
        };
        let evidence = self.detector.estimate(seen, &mut self.probability)?;
        if probability.size() != input.validity.size() {
            let (width, height) = input.validity.size();
            probability.reset(width, height, 0);
        }
        layout.table.warp_grey(&self.probability, probability)?;
        clear_unseen(input.validity, probability);
        // The sample is shown in the picture that was asked for.
        Ok(RoadEvidence { sample: input.sample, ..evidence })
    }

    fn know(&mut self, surfaces: &SurfaceFile) -> Result<(), RoadError> {
        self.detector.know(surfaces)
    }

    fn known_surfaces(&self) -> Option<SurfaceFile> {
        self.detector.known_surfaces()
    }

    fn reset(&mut self) {
        self.detector.reset();
    }
}

impl Layout {
    fn new(input: &RoadInput<'_>) -> Result<Self, RoadError> {
        let (width, height) = input.camera_picture().size();
        let mut shows_road = Plane::new(width, height, 0);
        let mut horizon_row = f64::INFINITY;
        if let Perspective::Ground { view, .. } = input.perspective {
            for row in 0..height {
                for (column, pixel) in shows_road.row_mut(row).iter_mut().enumerate() {
                    let p = Pixel::new(column as f64, row as f64);
                    *pixel = u8::from(view.camera().ground_of_pixel(p).is_some());
                }
            }
            let ahead = Point2::new(FAR_AWAY_M, 0.0);
            horizon_row = view.camera().pixel_of_ground(ahead).map_or(f64::INFINITY, |p| p.v);
        }
        Ok(Self {
            perspective: KnownPerspective::of(input.perspective),
            asked_sample: input.sample,
            sample: camera_sample(input),
            horizon_row,
            validity: ValidityMask::from_plane(shows_road),
            table: input.table_from_reduced((width, height), |p| [p.u, p.v])?,
        })
    }

    fn serves(&self, input: &RoadInput<'_>) -> bool {
        self.perspective.is(input.perspective)
            && self.asked_sample == input.sample
            && self.table.source_size() == input.camera_picture().size()
            && self.table.target_size() == input.validity.size()
    }
}

/// The upright rectangle of the camera picture inside the sample of the ground view: as narrow as its far edge is there.
/// Empty where the camera does not see the sample's corners.
fn camera_sample(input: &RoadInput<'_>) -> Rect {
    let Rect { x, y, width, height } = input.sample;
    let corner = |column: usize, row: usize| {
        let GroundPixel { column, row } = GroundPixel { column: column as f64 - 0.5, row: row as f64 - 0.5 };
        input.camera_from_asked([column, row])
    };
    let corners = [corner(x, y), corner(x + width, y), corner(x, y + height), corner(x + width, y + height)];
    let [Some(far_left), Some(far_right), Some(near_left), Some(near_right)] = corners else {
        return Rect { x: 0, y: 0, width: 0, height: 0 };
    };
    let (picture_width, picture_height) = input.camera_picture().size();
    let whole = |place: f64, limit: usize| (place + 0.5).round().clamp(0.0, limit as f64) as usize;
    let left = whole(far_left.u.max(near_left.u), picture_width);
    let right = whole(far_right.u.min(near_right.u), picture_width);
    let top = whole(far_left.v.max(far_right.v), picture_height);
    let bottom = whole(near_left.v.min(near_right.v), picture_height);
    Rect { x: left, y: top, width: right.saturating_sub(left), height: bottom.saturating_sub(top) }
}

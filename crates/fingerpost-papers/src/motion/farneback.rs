//! Motion from Farneback's dense flow on the ground view.
//!
//! Paper 1, section VI; G. Farneback, "Two-frame motion estimation based on polynomial expansion", 2003. The flow is
//! measured in a region ahead of the vehicle that is seen whole, away from the ragged edges of the ground view. The
//! papers take its mean; in a turn the road also rotates about the vehicle, so by default the rigid motion that
//! explains the field best is taken, of which the mean flow is the part without a turn.
//!
//! Limits: featureless road gives no flow; suspension pitch shows as motion. A compressed video's smooth asphalt stays where it
//! was in the picture: flow that says so while the camera is seen to travel is taken for no motion at all.

use fingerpost::attitude::AttitudeObservation;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::motion::{
    FarnebackMotionConfig, FlowModel, FlowSample, FlowStart, Motion, MotionError, MotionEstimator,
    MotionEvidence, MotionOutput, SeenTravel, distinctness, mean_flow,
};
use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::farneback::{Farneback, FarnebackError, FarnebackParams};
use fingerpost_vision::picture::{Plane, Rect};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2, Vector3};

use super::coarse;
use super::rigid_fit::{Pair, Residuals, RigidFit, fit};

/// Every how many pixels a flow vector enters the fit.
const SAMPLE_STRIDE_PX: usize = 4;
/// Accuracy of a flow vector below which differences say nothing, pixels.
const FLOW_FLOOR_PX: f64 = 0.05;
/// A start is good enough when its difference is at most this many times the difference that the last fit left.
const GOOD_START: f64 = 1.5;
/// Flow beyond this after the start was applied is measured again from the better start, pixels.
const RESTART_PX: f64 = 1.5;
/// Shift along the road that a good motion must be told from by the picture, metres.
const TELL_SHIFT_M: f64 = 0.3;
/// Share of the distance by which a flat road's scale is off when the vehicle pitches, one standard deviation.
const SCALE_SIGMA: f64 = 0.015;
/// Smallest standard deviations of a frame's motion: metres and radians; a real road is never flatter.
const FLOOR_M: f64 = 0.01;
const FLOOR_RAD: f64 = 0.001;

/// The papers' motion estimator.
#[derive(Debug)]
pub struct FarnebackMotion {
    config: FarnebackMotionConfig,
    flow: Farneback,
    moved: Plane<u8>,
    previous: Option<Plane<u8>>,
    pairs: Vec<Pair>,
    residuals: Residuals,
    /// Pixels seen to either side of the middle, a row each.
    halves: Vec<usize>,
    evidence: MotionEvidence,
    last: Isometry2<f64>,
    travel: SeenTravel,
    /// Grey difference that the last fit left, grey levels.
    last_difference: f64,
}

impl FarnebackMotion {
    /// An estimator that has seen no frame yet.
    ///
    /// # Errors
    /// [`FarnebackError`] when the flow's parameters are out of range.
    pub fn new(config: &FarnebackMotionConfig) -> Result<Self, FarnebackError> {
        let flow = Farneback::new(FarnebackParams {
            pyramid_scale: config.pyramid_scale,
            levels: config.levels,
            window_px: config.window_px,
            iterations: config.iterations,
            poly_n_px: config.poly_n_px,
            poly_sigma_px: config.poly_sigma_px,
        })?;
        Ok(Self {
            config: config.clone(),
            flow,
            moved: Plane::default(),
            previous: None,
            pairs: Vec::new(),
            residuals: Residuals::default(),
            halves: Vec::new(),
            evidence: MotionEvidence::default(),
            last: Isometry2::identity(),
            travel: SeenTravel::default(),
            last_difference: 0.0,
        })
    }

    /// The flow from the older picture, moved by `start`, to the newer one in `region`, as pairs of places.
    ///
    /// Moving the older picture first leaves the flow so small that its window, over which it takes displacements to be
    /// alike, does not flatten a turn.
    fn measure(
        &mut self,
        view: &GroundView,
        pictures: (&Plane<u8>, &Plane<u8>),
        region: Rect,
        start: &Isometry2<f64>,
    ) -> Result<(), MotionError> {
        let grid = view.grid();
        let previous_from_current = start.inverse();
        let previous_of = |pixel: GroundPixel| previous_from_current * grid.vehicle_from_ground(pixel);
        move_patch(grid, pictures.0, region, &previous_from_current, &mut self.moved);
        let current = pictures.1.view().crop(region)?;
        let flow = self.flow.flow(self.moved.view(), current, None).map_err(MotionError::of_estimator)?;
        // Within half a window of the region's edge the flow is extrapolated.
        let margin = self.config.window_px.min(region.width / 4).min(region.height / 4);
        self.pairs.clear();
        for y in (margin..region.height - margin).step_by(SAMPLE_STRIDE_PX) {
            for x in (margin..region.width - margin).step_by(SAMPLE_STRIDE_PX) {
                let Some([dx, dy]) = flow.get(x, y) else { continue };
                let at = GroundPixel { column: (region.x + x) as f64, row: (region.y + y) as f64 };
                let previous = previous_of(at);
                let from = grid.ground_from_vehicle(previous);
                let seen = from.column >= 0.0
                    && from.row >= 0.0
                    && view.validity().plane().get(from.column as usize, from.row as usize) == Some(1);
                if !seen {
                    continue;
                }
                let to = GroundPixel { column: at.column + f64::from(dx), row: at.row + f64::from(dy) };
                self.pairs.push(Pair { previous, current: grid.vehicle_from_ground(to), weight: 1.0 });
            }
        }
        Ok(())
    }

    fn start(
        &self,
        view: &GroundView,
        pictures: (&Plane<u8>, &Plane<u8>),
        region: Rect,
    ) -> (FlowStart, Isometry2<f64>) {
        let difference = |motion: &Isometry2<f64>| {
            coarse::difference(view.grid(), pictures, view.validity().plane(), region, motion)
                .unwrap_or(f64::INFINITY)
        };
        let (standing, same) = (difference(&Isometry2::identity()), difference(&self.last));
        if standing.min(same) > GOOD_START * self.last_difference {
            (FlowStart::CoarseSearch, coarse::search(view.grid(), pictures, view.validity().plane(), region))
        } else if standing <= same {
            (FlowStart::Standing, Isometry2::identity())
        } else {
            (FlowStart::SameAsBefore, self.last)
        }
    }

    fn fit(&mut self, view: &GroundView) -> Option<RigidFit> {
        let pairs = &mut self.pairs;
        // The window ties neighbouring vectors together: only one in a window is independent.
        let area = (pairs.len() * SAMPLE_STRIDE_PX * SAMPLE_STRIDE_PX) as f64;
        let independent = (area / (self.config.window_px * self.config.window_px) as f64).max(1.0);
        let viewpoint = view.viewpoint();
        let floor_m = FLOW_FLOOR_PX * view.grid().metres_per_pixel();
        let fitted = fit(pairs, &mut self.residuals, viewpoint, floor_m, independent)?;
        match self.config.model {
            FlowModel::Rigid => Some(fitted),
            FlowModel::Mean => {
                let mean = pairs.iter().map(|pair| pair.current - pair.previous).sum::<Vector2<f64>>();
                let current_from_previous = Isometry2::new(mean / pairs.len() as f64, 0.0);
                Some(RigidFit { current_from_previous, ..fitted })
            }
        }
    }

    fn between(
        &mut self,
        view: &GroundView,
        previous: &Plane<u8>,
        current: &Plane<u8>,
    ) -> Result<Option<Motion>, MotionError> {
        let grid = *view.grid();
        let region = region(view, &self.config, &mut self.halves).ok_or(MotionError::NoRegion)?;
        let pictures = (previous, current);
        let (start, mut motion) = self.start(view, pictures, region);
        self.measure(view, pictures, region, &motion)?;
        let Some(mut fitted) = self.fit(view) else { return Ok(None) };
        let corner = |column: usize, row: usize| {
            let pixel = GroundPixel { column: column as f64, row: row as f64 };
            let p_in_vehicle = grid.vehicle_from_ground(pixel);
            (fitted.current_from_previous * p_in_vehicle - motion * p_in_vehicle).norm()
        };
        let (right, bottom) = (region.x + region.width, region.y + region.height);
        let corners = [(region.x, region.y), (right, region.y), (region.x, bottom), (right, bottom)];
        let change = corners.into_iter().map(|(column, row)| corner(column, row)).fold(0.0, f64::max);
        if change > RESTART_PX * grid.metres_per_pixel() {
            motion = fitted.current_from_previous;
            self.measure(view, pictures, region, &motion)?;
            let Some(again) = self.fit(view) else { return Ok(None) };
            fitted = again;
        }
        motion = fitted.current_from_previous;
        let difference = |motion: &Isometry2<f64>| {
            coarse::difference(&grid, pictures, view.validity().plane(), region, motion)
        };
        let left_over = difference(&motion).unwrap_or(f64::INFINITY);
        let shifted = [-TELL_SHIFT_M, TELL_SHIFT_M]
            .map(|shift| difference(&(Isometry2::translation(shift, 0.0) * motion)).unwrap_or(0.0));
        let quality = fitted.accepted * distinctness(left_over, shifted[0].min(shifted[1]));
        self.last = motion;
        self.last_difference = if left_over.is_finite() { left_over.max(1.0) } else { 0.0 };
        let places = self.pairs.iter().map(|pair| {
            let (from, to) =
                (grid.ground_from_vehicle(pair.previous), grid.ground_from_vehicle(pair.current));
            FlowSample { from_px: [from.column, from.row], to_px: [to.column, to.row], weight: pair.weight }
        });
        let evidence = &mut self.evidence;
        evidence.samples.clear();
        evidence.samples.extend(places);
        evidence.mean_flow_px = mean_flow(&evidence.samples);
        evidence.region = region;
        evidence.residual_px = fitted.residual_m / grid.metres_per_pixel();
        evidence.start = start;
        if self.travel.contradicts(&motion) {
            // Flow that reads no travel where the whole picture shows some says nothing, and not that the vehicle stands.
            return Ok(Some(Motion::unknown()));
        }
        let previous_from_current = motion.inverse();
        let covariance = fitted.covariance + floor(&previous_from_current);
        Ok(Some(Motion { previous_from_current, covariance, quality }))
    }
}

impl MotionEstimator for FarnebackMotion {
    fn estimate(
        &mut self,
        view: &GroundView,
        picture: &GroundPicture,
        attitude: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
        self.travel = self.travel.after(attitude);
        let same_size = |previous: &Plane<u8>| previous.size() == picture.grey.size();
        let Some(mut previous) = self.previous.take().filter(same_size) else {
            self.previous = Some(picture.grey.clone());
            return Ok(None);
        };
        let result = self.between(view, &previous, &picture.grey);
        previous.as_mut_slice().copy_from_slice(picture.grey.as_slice());
        self.previous = Some(previous);
        Ok(result?.map(|motion| (motion.into(), &self.evidence)))
    }

    fn reset(&mut self) {
        self.previous = None;
        self.last = Isometry2::identity();
        self.travel = SeenTravel::default();
        self.last_difference = 0.0;
    }
}

/// What the older picture would show in `region` had the vehicle already moved; black where it shows nothing.
fn move_patch(
    grid: &GroundGrid,
    previous: &Plane<u8>,
    region: Rect,
    previous_from_current: &Isometry2<f64>,
    moved: &mut Plane<u8>,
) {
    if moved.size() != (region.width, region.height) {
        moved.reset(region.width, region.height, 0);
    }
    let place = |column: usize, row: usize| {
        let pixel = GroundPixel { column: column as f64, row: row as f64 };
        grid.ground_from_vehicle(previous_from_current * grid.vehicle_from_ground(pixel))
    };
    let (origin, right) = (place(region.x, region.y), place(region.x + 1, region.y));
    let (along_column, along_row) = (right.column - origin.column, right.row - origin.row);
    let limits = (previous.width() as f64 - 1.0, previous.height() as f64 - 1.0);
    for y in 0..region.height {
        let start = place(region.x, region.y + y);
        for (x, out) in moved.row_mut(y).iter_mut().enumerate() {
            let column = start.column + x as f64 * along_column;
            let row = start.row + x as f64 * along_row;
            if !(0.0..limits.0).contains(&column) || !(0.0..limits.1).contains(&row) {
                *out = 0;
                continue;
            }
            let (c, r) = (column as usize, row as usize);
            let (right_share, below_share) = (column - c as f64, row - r as f64);
            let (upper, lower) = (previous.row(r), previous.row(r + 1));
            let mix = |pixels: &[u8]| {
                f64::from(pixels[c]) * (1.0 - right_share) + f64::from(pixels[c + 1]) * right_share
            };
            *out = (mix(upper) * (1.0 - below_share) + mix(lower) * below_share).round() as u8;
        }
    }
}

/// The largest region ahead, at most as large as configured, that is seen whole; the nearer of equals.
fn region(view: &GroundView, config: &FarnebackMotionConfig, halves: &mut Vec<usize>) -> Option<Rect> {
    let (grid, validity) = (view.grid(), view.validity().plane());
    let middle = grid.columns() / 2;
    let half_limit = (0.5 * config.region_width_m / grid.metres_per_pixel()) as usize;
    let length = ((config.region_length_m / grid.metres_per_pixel()) as usize).min(grid.rows());
    let seen_half = |row: usize| {
        let pixels = validity.row(row);
        (0..half_limit.min(middle))
            .take_while(|&k| pixels[middle + k] != 0 && pixels[middle - 1 - k] != 0)
            .count()
    };
    halves.clear();
    halves.extend((0..grid.rows()).map(seen_half));
    (length..=grid.rows())
        .rev()
        .map(|bottom| (bottom, halves[bottom - length..bottom].iter().copied().min().unwrap_or(0)))
        .fold(None, |best: Option<(usize, usize)>, now| match best {
            Some(best) if best.1 >= now.1 => Some(best),
            _ => Some(now),
        })
        // Under 32 pixels the pyramid has nothing to stand on.
        .filter(|&(_, half)| half >= 16 && length >= 32)
        .map(|(bottom, half)| Rect { x: middle - half, y: bottom - length, width: 2 * half, height: length })
}

/// What no fit can promise: scale errors of a pitching vehicle and the accuracy of the flow itself.
fn floor(previous_from_current: &Isometry2<f64>) -> Matrix3<f64> {
    let distance = (previous_from_current * Point2::origin()).coords.norm();
    let along = libm::hypot(FLOOR_M, SCALE_SIGMA * distance);
    let turn = libm::hypot(FLOOR_RAD, SCALE_SIGMA * previous_from_current.rotation.angle());
    Matrix3::from_diagonal(&Vector3::new(along * along, FLOOR_M * FLOOR_M, turn * turn))
}

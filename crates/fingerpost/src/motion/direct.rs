//! Motion by aligning the ground patch itself.
//!
//! The road is a plane and the vehicle moves on it in three degrees of freedom, so nothing need be known of where single
//! pixels go: the strip of road ahead is superimposed on that of the frame before, and forward, left and yaw are changed until
//! the grey values agree, from coarse to fine ([`fingerpost_vision::alignment`] has the sources). The camera's pitch and
//! roll against the road are fitted beside them ([`super::camera_turn`]), and a change of the light; kerbs, cars and walls
//! are told from the road by weights, and by lying beside the path. The motion of the frame
//! before, with its covariance, is a prior: where the road shows nothing, motion goes on and its
//! uncertainty grows.
//!
//! While the vehicle stands, the frame in which it came to stand stays the older one: noise is not summed up as motion, and
//! creeping shows as soon as it can be told from noise.
//!
//! Limits: what stands on the road and fills most of the patch is taken for road; a road without texture gives the prior,
//! with a quality near zero.

mod aligned;
mod expected;
mod gauss_newton;
mod patch;
mod plane_warp;
mod start;

use fingerpost_vision::alignment::{Brightness, Residuals};
use nalgebra::{Isometry2, Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::aligned::{Aligned, costs};
use self::expected::Expected;
use self::gauss_newton::Estimate;
use self::patch::Patch;
use self::plane_warp::{Displacement, Views};
use self::start::{FINE_STEP_M, cost, search_along, start};
use super::camera_turn::{SeenTurn, TurnFilter};
use super::seen_travel::HiddenTravel;
use super::{
    FlowSample, FlowStart, MEASURED_QUALITY, Motion, MotionDoubt, MotionError, MotionEstimator,
    MotionEvidence, MotionOutput, SeenTravel, mean_flow,
};
use crate::attitude::AttitudeObservation;
use crate::ground_view::{GroundPicture, GroundView};

/// Settings of the motion by direct alignment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DirectMotionConfig {
    /// Width of the strip of road that is aligned, metres, by default a street with its kerbs. Half a lane to either
    /// side of the path counts with all its texture, what is farther off with edges along the direction of travel
    /// alone.
    #[schemars(range(min = 1.0, max = 40.0))]
    pub width_m: f64,
    /// Its length from the nearest place seen, metres.
    #[schemars(range(min = 1.0, max = 40.0))]
    pub length_m: f64,
    /// Most iterations at each level.
    #[schemars(range(min = 1, max = 50))]
    pub iterations: usize,
}

impl Default for DirectMotionConfig {
    fn default() -> Self {
        Self { width_m: 10.0, length_m: 7.5, iterations: 10 }
    }
}

/// A start is bearable when it costs at most so many times what the last alignment left.
const BEARABLE: f64 = 2.0;
/// Least cost that is taken to be left, levels of the flattened picture squared: the camera's noise at the
/// coarsest level.
const COST_FLOOR: f64 = 2.0;
/// No vehicle changes its way in a frame by more, metres: full braking for a fifth of a second. What says so must be clear.
const MOST_CHANGE_M: f64 = 0.4;
const CLEAR: f64 = 0.5;
/// A vehicle that moved less stands: several times what the camera's noise makes of a standing one, metres and radians.
const STANDING_M: f64 = 0.005;
const STANDING_RAD: f64 = 0.0005;
/// Quality below which a standing vehicle is not believed to stand.
const STANDING_QUALITY: f64 = 0.5;
/// Quality below which the motion is searched for among the finest texture: lines along the road, the vehicle's light and what
/// a wet road mirrors are all that a coarse picture shows of some roads, and none of them goes by.
const UNSURE: f64 = 0.3;
/// Levels, from the finest on, that such a search is followed by.
const FINE_LEVELS: usize = 2;
/// Every so many-th group of the finest points takes part in the search: what it finds is aligned, and weighed by all of them.
const SEARCHED_EVERY: usize = 2;
/// How far around the expected motion it is searched for, standard deviations.
const REACH_SIGMAS: f64 = 3.0;
/// A motion that was searched for must cost less than the expected one by this factor.
const CLEARLY_LESS: f64 = 0.95;
/// Share of the distance by which a road's scale is off when it is not quite flat or the vehicle's load tilts the camera, one
/// standard deviation.
const SCALE_SIGMA: f64 = 0.015;
/// A shorter step does not tell how the path bends, metres.
const LEAST_ARC_M: f64 = 0.05;
/// No car turns tighter, 1/m.
const TIGHTEST_PER_M: f64 = 0.2;
/// About how many displacements the evidence shows.
const SAMPLES: usize = 400;

/// The direct motion estimator.
#[derive(Debug)]
pub struct DirectMotion {
    config: DirectMotionConfig,
    patch: Option<Patch>,
    residuals: Residuals,
    evidence: MotionEvidence,
    last: Option<Last>,
    turn: TurnFilter,
    travel: SeenTravel,
    hidden: HiddenTravel,
}

/// What the next frame is to know of this one.
#[derive(Debug, Clone, Copy)]
struct Last {
    current_from_previous: Isometry2<f64>,
    /// None where it was not measured.
    covariance: Option<Matrix3<f64>>,
    /// What a start may cost.
    bearable: f64,
}

impl Last {
    /// By how much another motion is longer or shorter than is known of this one, metres: nothing where that is not known. A
    /// frame may have been lost, and the way doubled.
    fn leap_m(&self, current_from_previous: &Isometry2<f64>) -> f64 {
        let forward_m = |motion: &Isometry2<f64>| motion.inverse().translation.x;
        let (now_m, last_m) = (forward_m(current_from_previous), forward_m(&self.current_from_previous));
        let change_m = (now_m - last_m).abs().min((now_m - 2.0 * last_m).abs());
        self.covariance.map_or(0.0, |covariance| change_m - covariance[(0, 0)].max(0.0).sqrt())
    }

    /// Whether the frame said too little for the next one to begin from.
    fn is_to_be_searched(&self) -> bool {
        self.bearable <= 0.0
    }

    /// Before the second frame: nothing is known, and any start but a fitting one is searched for.
    fn first() -> Self {
        Self { current_from_previous: Isometry2::identity(), covariance: None, bearable: 0.0 }
    }
}

impl DirectMotion {
    /// An estimator that has seen no frame yet.
    #[must_use]
    pub fn new(config: &DirectMotionConfig) -> Self {
        Self {
            config: config.clone(),
            patch: None,
            residuals: Residuals::default(),
            evidence: MotionEvidence::default(),
            last: None,
            turn: TurnFilter::default(),
            travel: SeenTravel::default(),
            hidden: HiddenTravel::default(),
        }
    }

    fn between(
        &mut self,
        last: Last,
        attitude: &AttitudeObservation,
    ) -> Option<(Motion, Option<MotionDoubt>)> {
        let patch = self.patch.as_mut()?;
        let residuals = &mut self.residuals;
        let coarsest = patch.levels.last()?;
        let (views, turn_before_rad) = (Views::default(), self.turn.turn_rad());
        let displaced = |motion| Displacement::of(motion, turn_before_rad);
        let points = (coarsest, &coarsest.template);
        let mut cost_of = |motion| cost(points, residuals, &displaced(motion), &views, Brightness::default());
        let expected = Expected::after(&last, self.turn, attitude);
        let found = start(&mut cost_of, expected.current_from_previous, last.bearable);
        self.travel = self.travel.after(attitude);
        let travel = self.travel;
        let mut begun = Begun { patch, residuals, views, last, travel, iterations: self.config.iterations };
        let (aligned, start) = begun.aligned(&expected, found, displaced)?;
        let Aligned { mut estimate, quality, stands_still, .. } = aligned;
        show(begun.patch, begun.residuals, (&estimate, &begun.views), start, &mut self.evidence);
        let mut seen_turn = estimate.seen_turn;
        let leap_m = last.leap_m(&estimate.displacement.current_from_previous);
        let goes_on = quality < MEASURED_QUALITY || (quality < CLEAR && leap_m > MOST_CHANGE_M);
        if goes_on {
            estimate.displacement = displaced(expected.current_from_previous);
            estimate.covariance = expected.covariance;
            seen_turn = SeenTurn::default();
        }
        let coarsest = begun.patch.levels.last()?;
        let (left_over, shifted) = costs(coarsest, begun.residuals, (&estimate, &begun.views));
        self.turn = expected.turn.updated(&seen_turn);
        self.evidence.attitude = seen_turn.observation();
        // Where too little is seen to judge by, or what was seen is not believed, the next frame is searched for.
        let bearable = if !goes_on && left_over.is_finite() && shifted.is_finite() {
            (BEARABLE * left_over.max(COST_FLOOR)).max(shifted)
        } else {
            0.0
        };
        let motion = &estimate.displacement.current_from_previous;
        let is_contradicted = travel.contradicts(motion);
        self.hidden = self.hidden.after(attitude, motion, (!goes_on, is_contradicted));
        let is_hidden = is_contradicted || self.hidden.contradicts(motion);
        let doubt = is_hidden.then_some(if goes_on && stands_still < MEASURED_QUALITY {
            MotionDoubt::NothingToGoBy
        } else {
            MotionDoubt::ViewStandsStill
        });
        Some((self.keep(&estimate, quality, bearable), doubt))
    }

    /// The motion of an estimate; the next frame is to know it.
    fn keep(&mut self, estimate: &Estimate, quality: f64, bearable: f64) -> Motion {
        let mut previous_from_current = estimate.displacement.current_from_previous.inverse();
        let covariance = covariance(&previous_from_current, &estimate.covariance);
        let stands = previous_from_current.translation.vector.norm() < STANDING_M
            && previous_from_current.rotation.angle().abs() < STANDING_RAD
            && quality >= STANDING_QUALITY;
        if stands {
            previous_from_current = Isometry2::identity();
        } else if let Some(patch) = &mut self.patch {
            patch.keep(curvature_per_m(&previous_from_current));
        }
        self.last = Some(Last {
            current_from_previous: previous_from_current.inverse(),
            covariance: Some(estimate.covariance),
            bearable,
        });
        Motion { previous_from_current, covariance, quality }
    }
}

/// An alignment that has its start.
struct Begun<'a> {
    patch: &'a mut Patch,
    residuals: &'a mut Residuals,
    views: Views,
    last: Last,
    travel: SeenTravel,
    iterations: usize,
}

impl Begun<'_> {
    /// The alignment with what is expected, and where it started from in the end.
    fn aligned(
        &mut self,
        expected: &Expected,
        (start, motion): (FlowStart, Isometry2<f64>),
        displaced: impl Fn(Isometry2<f64>) -> Displacement,
    ) -> Option<(Aligned, FlowStart)> {
        let Self { patch, residuals, views, last, travel, iterations } = self;
        let prior = match start {
            FlowStart::CoarseSearch => expected.searched(motion).prior()?,
            _ => expected.prior()?,
        };
        let (all, at) = (patch.levels.len(), displaced(motion));
        let mut aligned = Aligned::through(all, (patch, residuals), (&prior, views), *iterations, at)?;
        let is_too_short = |motion: &Isometry2<f64>| travel.contradicts(motion);
        if is_too_short(&aligned.estimate.displacement.current_from_previous) {
            (aligned.stands_still, aligned.quality) = (aligned.quality, 0.0);
        }
        if aligned.quality >= UNSURE || last.covariance.is_none() {
            return Some((aligned, start));
        }
        let finest = patch.levels.get(patch.finest)?;
        patch.some_points.thin(&finest.template, SEARCHED_EVERY);
        let points = (finest, &patch.some_points);
        let cost_of = |motion| {
            if is_too_short(&motion) {
                return f64::INFINITY;
            }
            cost(points, residuals, &displaced(motion), views, Brightness::default())
        };
        let reach_m = REACH_SIGMAS * expected.covariance[(0, 0)].max(0.0).sqrt();
        let found = search_along(cost_of, expected.current_from_previous, reach_m);
        // From next to where the alignment has come to, it comes there again.
        let reached = aligned.estimate.displacement.current_from_previous;
        let is_there = (reached.inverse() * found).translation.vector.norm() < FINE_STEP_M;
        if is_there {
            return Some((aligned, start));
        }
        let at = displaced(found);
        let again = Aligned::through(FINE_LEVELS, (patch, residuals), (&prior, views), *iterations, at);
        let is_better = |again: &Aligned| {
            again.cost < CLEARLY_LESS * aligned.cost
                && !is_too_short(&again.estimate.displacement.current_from_previous)
        };
        Some(again.filter(is_better).map_or((aligned, start), |again| (again, FlowStart::FineSearch)))
    }
}

impl MotionEstimator for DirectMotion {
    fn estimate(
        &mut self,
        view: &GroundView,
        picture: &GroundPicture,
        attitude: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
        if !self.patch.as_ref().is_some_and(|patch| patch.fits(view)) {
            self.patch = Patch::new(view, &self.config);
            self.last = None;
        }
        let patch = self.patch.as_mut().ok_or(MotionError::NoRegion)?;
        patch.look_at(&picture.grey)?;
        let motion = self.last.and_then(|last| self.between(last, attitude));
        if let (None, Some(patch)) = (&motion, &mut self.patch) {
            self.last = Some(Last::first());
            patch.keep(0.0);
        }
        let camera = self.turn.attitude();
        Ok(motion
            .map(|(motion, doubt)| (MotionOutput { motion, camera: Some(camera), doubt }, &self.evidence)))
    }

    fn reset(&mut self) {
        self.last = None;
        self.turn = TurnFilter::default();
        self.travel = SeenTravel::default();
        self.hidden = HiddenTravel::default();
    }
}

/// How the path bends, 1/m, positive to the left; straight when the vehicle hardly moves.
fn curvature_per_m(previous_from_current: &Isometry2<f64>) -> f64 {
    let (forward_m, yaw_rad) = (previous_from_current.translation.x, previous_from_current.rotation.angle());
    if forward_m > LEAST_ARC_M { (yaw_rad / forward_m).clamp(-TIGHTEST_PER_M, TIGHTEST_PER_M) } else { 0.0 }
}

/// Covariance of the vehicle's new pose in the old frame, from that of a small motion there.
fn covariance(previous_from_current: &Isometry2<f64>, of_motion: &Matrix3<f64>) -> Matrix3<f64> {
    // A turn in the old frame swings the new place.
    let step = previous_from_current.translation.vector;
    let swing = Matrix3::new(1.0, 0.0, -step.y, 0.0, 1.0, step.x, 0.0, 0.0, 1.0);
    let scale = SCALE_SIGMA * Vector3::new(step.x, step.y, previous_from_current.rotation.angle());
    swing * of_motion * swing.transpose() + Matrix3::from_diagonal(&scale.component_mul(&scale))
}

/// Writes down how the points of the finest level were displaced.
fn show(
    patch: &Patch,
    residuals: &mut Residuals,
    (estimate, views): (&Estimate, &Views),
    start: FlowStart,
    evidence: &mut MotionEvidence,
) {
    let Some(level) = patch.levels.get(patch.finest) else { return };
    cost((level, &level.template), residuals, &estimate.displacement, views, estimate.brightness);
    let warp = level.raster.warp(&estimate.displacement, views);
    let ground = |pixel: [f32; 2]| {
        let pixel = patch.grid.ground_from_vehicle(level.raster.vehicle_from_pixel(pixel));
        [pixel.column, pixel.row]
    };
    let points = level.template.len();
    evidence.samples.clear();
    evidence.samples.reserve(SAMPLES);
    evidence.samples.extend((0..points).step_by(points.div_ceil(SAMPLES).max(1)).filter_map(|point| {
        let place = level.template.place(point)?;
        let weight = f64::from(residuals.weight(point)?);
        Some(FlowSample { from_px: ground(place), to_px: ground(warp.at(place[0], place[1])), weight })
    }));
    evidence.region = patch.region;
    evidence.mean_flow_px = mean_flow(&evidence.samples);
    evidence.residual_px = estimate.residual_m / patch.grid.metres_per_pixel();
    evidence.start = start;
}

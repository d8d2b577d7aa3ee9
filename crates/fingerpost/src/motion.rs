//! Ego-motion: how the vehicle moved since the frame before, from the ground view.
//!
//! Paper 1, section VI: the mean flow of the road ahead moves the followed feature. A [`MotionEstimator`] sees one
//! ground view a frame. [`DirectMotion`] aligns the road itself. The papers' own way, a fit to Farneback's flow, is in
//! `fingerpost-papers`.

mod camera_turn;
mod direct;
mod farneback;
mod seen_travel;

use std::fmt::{self, Display, Formatter};

use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::Rect;
use nalgebra::{Isometry2, Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use camera_turn::TurnFilter;
pub use direct::{DirectMotion, DirectMotionConfig};
pub use farneback::{FarnebackMotionConfig, FlowModel};
pub use seen_travel::SeenTravel;

use crate::attitude::AttitudeObservation;
use crate::ground_view::{CameraTurn, GroundPicture, GroundView};

/// Settings of the ego-motion.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MotionConfig {
    /// How the motion between frames is found.
    pub estimator: MotionMethod,
    /// Settings of "direct".
    pub direct: DirectMotionConfig,
    /// Settings of "farneback".
    pub farneback: FarnebackMotionConfig,
}

/// Ways to find the ego-motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionMethod {
    /// The road ahead aligned with that of the frame before ([`DirectMotion`]).
    #[default]
    Direct,
    /// Dense flow, the papers' own (`fingerpost_papers::FarnebackMotion`).
    Farneback,
}

impl MotionConfig {
    /// The estimator of these settings; it has seen no frame yet.
    ///
    /// # Errors
    /// [`MotionError::NotGiven`] where the papers' own is asked for, which is not a part of this crate.
    pub fn estimator(&self) -> Result<Box<dyn MotionEstimator>, MotionError> {
        Ok(match self.estimator {
            MotionMethod::Direct => Box::new(DirectMotion::new(&self.direct)),
            MotionMethod::Farneback => return Err(MotionError::NotGiven),
        })
    }
}

/// The vehicle's motion between two frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// The vehicle's new pose in its old frame: metres forward and left, radians to the left.
    pub previous_from_current: Isometry2<f64>,
    /// Covariance of forward (m), left (m) and yaw (rad); never zero.
    pub covariance: Matrix3<f64>,
    /// 0 (do not believe it) to 1.
    pub quality: f64,
}

/// Quality from which a motion was measured; below it, the picture is not believed and the motion goes on as before, ever less surely.
pub const MEASURED_QUALITY: f64 = 0.1;

/// Standard deviation of a motion of which nothing is known, metres: farther than a vehicle comes while a camera may be covered
/// and is still waited for.
const UNKNOWN_SIGMA_M: f64 = 100.0;

impl Motion {
    /// A motion of which nothing is known.
    pub fn unknown() -> Self {
        let sigma = Vector3::new(UNKNOWN_SIGMA_M, UNKNOWN_SIGMA_M, std::f64::consts::PI);
        let covariance = Matrix3::from_diagonal(&sigma.component_mul(&sigma));
        Self { previous_from_current: Isometry2::identity(), covariance, quality: 0.0 }
    }
}

/// What an estimator says of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionOutput {
    /// How the vehicle moved.
    pub motion: Motion,
    /// How the camera is turned by all that was seen so far; none where the estimator says nothing of it.
    pub camera: Option<CameraAttitude>,
    /// Why the motion is wrong by what else the picture shows; none where nothing speaks against it.
    pub doubt: Option<MotionDoubt>,
}

/// Why a motion is wrong: it goes less far forward than a vehicle whose camera is seen to travel, as [`SeenTravel`] has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MotionDoubt {
    /// What lies in the ground view clearly shows that motion: the bonnet, what is mirrored in it, or asphalt that a video's
    /// compression keeps where it was.
    ViewStandsStill,
    /// The ground view does not show how far the vehicle moved, and no motion was known that could go on.
    NothingToGoBy,
}

impl Display for MotionDoubt {
    /// What was seen, as a clause of a sentence.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::ViewStandsStill => write!(
                f,
                "the camera is seen to travel, but what lies in the ground view comes nearer by less than {:.0} cm a frame, as the bonnet, \
                 what is mirrored in it or smooth asphalt in a compressed video does",
                100.0 * seen_travel::SEEN_TRAVEL_M
            ),
            Self::NothingToGoBy => f.write_str(
                "the camera is seen to travel, but the ground view does not show how far the vehicle went",
            ),
        }
    }
}

impl From<Motion> for MotionOutput {
    /// A motion that says nothing of the camera.
    fn from(motion: Motion) -> Self {
        Self { motion, camera: None, doubt: None }
    }
}

/// How a motion was found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MotionEvidence {
    /// The region of the ground view that was measured, pixels.
    pub region: Rect,
    /// Displacements of the road over the region: as measured, or, of a direct alignment, as the motion has them, each with
    /// the weight that its place had.
    pub samples: Vec<FlowSample>,
    /// Mean displacement of the road in the region, pixels right and down.
    pub mean_flow_px: [f64; 2],
    /// Root mean square of what the motion leaves unexplained, as a displacement, pixels.
    pub residual_px: f64,
    /// Where the estimate started from.
    pub start: FlowStart,
    /// How the camera was turned, as this frame alone shows it; none where nothing was measured.
    pub attitude: Option<AttitudeObservation>,
}

/// How the camera is turned against its mount, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraAttitude {
    /// The turn.
    pub turn: CameraTurn,
    /// Standard deviations of its pitch and roll, radians; never zero.
    pub sigma_rad: [f64; 2],
}

impl Default for CameraAttitude {
    /// What is known before anything is seen.
    fn default() -> Self {
        TurnFilter::default().attitude()
    }
}

/// The displacement of one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowSample {
    /// Place in the older ground view, pixels right and down.
    pub from_px: [f64; 2],
    /// Place of the same bit of road in the newer one, pixels.
    pub to_px: [f64; 2],
    /// Weight in the fit, 0 (rejected) to 1.
    pub weight: f64,
}

/// Where the estimate started from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FlowStart {
    /// The vehicle stands.
    #[default]
    Standing,
    /// It moves on as in the frame before.
    SameAsBefore,
    /// Neither fitted; a coarse search over the ground view did.
    CoarseSearch,
    /// What came of either was doubtful; a search among the road's finest texture fitted better.
    FineSearch,
}

/// A motion that cannot be estimated.
#[derive(Debug, Error)]
pub enum MotionError {
    /// The papers' own estimator is asked for, and none was given.
    #[error(
        "motion.estimator = \"farneback\" is the papers' own: give the pipeline the parts of `fingerpost_papers::parts`, or choose \
         \"direct\""
    )]
    NotGiven,
    /// An estimator that was given fails.
    #[error("motion: {reason}")]
    Estimator {
        /// What it says.
        reason: String,
    },
    /// Pictures do not fit together.
    #[error("motion: {0}")]
    Picture(#[from] PictureError),
    /// Too little of the ground view is seen.
    #[error(
        "motion: too little road is seen straight ahead; enlarge the motion's region in the configuration or mount the camera lower"
    )]
    NoRegion,
}

impl MotionError {
    /// What an estimator of another crate says.
    pub fn of_estimator(error: impl std::error::Error) -> Self {
        Self::Estimator { reason: error.to_string() }
    }
}

/// A way to measure the vehicle's motion on the road.
pub trait MotionEstimator: Send {
    /// The motion from the frame given last to this one, and how it was found; none for the first, where the ground view
    /// is another than the last frame's, and where nothing can be measured. `attitude` is what the picture itself shows of
    /// how the camera is turned in this frame. The evidence stays with the estimator, so that a frame needs no new memory.
    ///
    /// # Errors
    /// [`MotionError`] when too little road is seen ahead, or the picture has not the view's size.
    fn estimate(
        &mut self,
        view: &GroundView,
        picture: &GroundPicture,
        attitude: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError>;

    /// Forgets the last frame, as at the start of a drive.
    fn reset(&mut self);
}

/// How clearly a motion is distinguished from one a little longer or shorter by the grey differences that both leave, 0 to 1:
/// road without texture looks alike however far the vehicle moved.
pub fn distinctness(left_over: f64, shifted: f64) -> f64 {
    if left_over.is_finite() && shifted > 0.0 {
        (2.0 * (1.0 - left_over / shifted)).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// The weighted mean of displacements, pixels right and down; 0 where there are none.
pub fn mean_flow(samples: &[FlowSample]) -> [f64; 2] {
    let total = samples.iter().map(|s| s.weight).sum::<f64>().max(1e-9);
    let mean = |axis: usize| {
        samples.iter().map(|s| s.weight * (s.to_px[axis] - s.from_px[axis])).sum::<f64>() / total
    };
    [mean(0), mean(1)]
}

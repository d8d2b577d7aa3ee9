//! Stages that a program gives the pipeline in place of the configuration's.

use fingerpost_geometry::GroundGrid;

use super::PipelineError;
use crate::config::Config;
use crate::lanes::LaneDetector;
use crate::matching::{FeatureMatcher, Matcher};
use crate::motion::MotionEstimator;
use crate::road_surface::RoadDetector;

/// Stages of a program's own. One that is none is made by the configuration.
///
/// Paper 1, III: the stages are defined by what goes in and what comes out, so that better ones take their places.
///
/// ```
/// use fingerpost::ground_view::{GroundPicture, GroundView};
/// use fingerpost::motion::{Motion, MotionError, MotionEstimator, MotionEvidence, MotionOutput};
/// use fingerpost::attitude::AttitudeObservation;
/// use fingerpost::pipeline::Parts;
/// use fingerpost::{Config, Pipeline, Sensors};
/// use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
/// use fingerpost_vision::picture::RgbImage;
/// use nalgebra::{Isometry2, Matrix3, Vector2};
///
/// /// A vehicle on rails: it goes on by half a metre a frame.
/// #[derive(Default)]
/// struct OnRails {
///     evidence: MotionEvidence,
/// }
///
/// impl MotionEstimator for OnRails {
///     fn estimate(
///         &mut self,
///         _view: &GroundView,
///         _picture: &GroundPicture,
///         _attitude: &AttitudeObservation,
///     ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
///         let previous_from_current = Isometry2::new(Vector2::new(0.5, 0.0), 0.0);
///         let motion = Motion { previous_from_current, covariance: Matrix3::identity() * 1e-4, quality: 1.0 };
///         Ok(Some((motion.into(), &self.evidence)))
///     }
///
///     fn reset(&mut self) {}
/// }
///
/// let intrinsics = Intrinsics { fx: 210.0, fy: 210.0, cx: 159.5, cy: 119.5 };
/// let mount = Mount { pitch_rad: 0.14, ..Mount::level(1.5) };
/// let camera = Camera::calibrated(320, 240, intrinsics, Distortion::None, mount)?;
/// let parts = Parts { motion_estimator: Some(Box::new(OnRails::default())), ..Parts::default() };
/// let mut pipeline = Pipeline::with_parts(&Config::default(), &camera, None, None, parts)?;
/// // A chessboard: a picture of nothing, or of noise, is passed over.
/// let mut picture = RgbImage::new(320, 240);
/// for y in 0..240 {
///     for (x, pixel) in picture.row_mut(y).chunks_exact_mut(3).enumerate() {
///         pixel.fill(if (x / 20 + y / 20) % 2 == 0 { 60 } else { 180 });
///     }
/// }
/// let (output, _) = pipeline.step(&picture, Sensors::default(), &mut |_| {})?;
/// assert!((output.motion.unwrap().previous_from_current.translation.x - 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct Parts {
    /// What tells road from everything else.
    pub road_detector: Option<Box<dyn RoadDetector>>,
    /// What measures how the vehicle moves on the road.
    pub motion_estimator: Option<Box<dyn MotionEstimator>>,
    /// What makes of the road surface what feature masks are superimposed on.
    pub matcher: Option<Box<dyn FeatureMatcher>>,
    /// What finds the lane; it is asked whatever `lanes.finder` says.
    pub lane_finder: Option<Box<dyn LaneDetector>>,
}

impl Parts {
    /// The road detector, else the configuration's.
    pub(super) fn take_road_detector(
        &mut self,
        config: &Config,
    ) -> Result<Box<dyn RoadDetector>, PipelineError> {
        Ok(match self.road_detector.take() {
            Some(detector) => detector,
            None => config.road_surface.detector()?,
        })
    }

    /// The motion estimator, else the configuration's.
    pub(super) fn take_motion_estimator(
        &mut self,
        config: &Config,
    ) -> Result<Box<dyn MotionEstimator>, PipelineError> {
        Ok(match self.motion_estimator.take() {
            Some(estimator) => estimator,
            None => config.motion.estimator()?,
        })
    }

    /// The matcher, else the configuration's on the raster `grid`.
    pub(super) fn take_matcher(&mut self, config: &Config, grid: &GroundGrid) -> Box<dyn FeatureMatcher> {
        self.matcher.take().unwrap_or_else(|| Box::new(Matcher::new(&config.matching, grid)))
    }

    /// The lane finder, else the configuration's; none where lanes are not to be looked for.
    pub(super) fn take_lane_finder(
        &mut self,
        config: &Config,
    ) -> Result<Option<Box<dyn LaneDetector>>, PipelineError> {
        Ok(match self.lane_finder.take() {
            Some(finder) => Some(finder),
            None => config.lanes.finder()?,
        })
    }
}

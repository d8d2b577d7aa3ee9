//! The papers' own ways, where the method goes another: plug-ins for its pipeline.
//!
//! | module | what | trait |
//! |---|---|---|
//! | `motion` | Farneback's dense flow and the motion behind it (paper 1, VI) | `MotionEstimator` |
//! | `road_surface` | known surfaces (paper 2, 7.4), and the detector before the ground view (paper 1, figure 4) | `RoadDetector` |
//! | `lanes` | lines in sections of the picture, kept from frame to frame (paper 3, III-C) | `LaneDetector` |
//! | `claims` | what the papers claim, measured again: settings that are compared, figures, verdicts and the page; with feature `claims` | |
//!
//! Their settings are a part of every configuration (`fingerpost::Config`); the stages themselves are given to the pipeline by
//! whoever builds it: [`parts`] makes those that a configuration asks for. Papers 1 to 3 are those of CONVENTIONS.md.

#[cfg(feature = "claims")]
pub mod claims;
mod lanes;
mod motion;
mod road_surface;

use fingerpost::Config;
use fingerpost::motion::MotionMethod;
use fingerpost::pipeline::Parts;
use fingerpost::road_surface::RoadError;
use fingerpost_lanes::{LaneError, LaneMethod};
use fingerpost_vision::farneback::FarnebackError;
use thiserror::Error;

pub use lanes::SectionTracker;
pub use motion::FarnebackMotion;
pub use road_surface::{Bank, road_detector};

/// A stage of the papers that cannot be used as configured.
#[derive(Debug, Error)]
pub enum PapersError {
    /// The flow's parameters are out of range.
    #[error("motion: {0}")]
    Flow(#[from] FarnebackError),
    /// The road detector's settings are out of range.
    #[error(transparent)]
    Road(#[from] RoadError),
    /// The lane finder's kernels cannot be set up.
    #[error(transparent)]
    Lane(#[from] LaneError),
}

/// The stages of the papers that a configuration asks for; none for every other one, which the pipeline makes itself.
///
/// ```
/// use fingerpost::motion::MotionMethod;
/// use fingerpost::{Config, Pipeline};
/// use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
///
/// let intrinsics = Intrinsics { fx: 210.0, fy: 210.0, cx: 159.5, cy: 119.5 };
/// let mount = Mount { pitch_rad: 0.14, ..Mount::level(1.5) };
/// let camera = Camera::calibrated(320, 240, intrinsics, Distortion::None, mount)?;
/// let mut config = Config::default();
/// config.motion.estimator = MotionMethod::Farneback;
/// assert!(Pipeline::new(&config, &camera, None, None).is_err(), "the method itself has no dense flow");
/// let parts = fingerpost_papers::parts(&config)?;
/// let pipeline = Pipeline::with_parts(&config, &camera, None, None, parts)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PapersError`] when a stage's settings are out of range.
pub fn parts(config: &Config) -> Result<Parts, PapersError> {
    let mut parts = Parts::default();
    if config.motion.estimator == MotionMethod::Farneback {
        parts.motion_estimator = Some(Box::new(FarnebackMotion::new(&config.motion.farneback)?));
    }
    if let Some(seeing) = road_surface::seeing(&config.road_surface)? {
        parts.road_detector = Some(config.road_surface.detector_with(Some(seeing))?);
    }
    if config.lanes.finder == LaneMethod::Sections {
        parts.lane_finder = Some(Box::new(SectionTracker::new(&config.lanes)?));
    }
    Ok(parts)
}

//! The way of a drive as the method itself measures it through a camera, to hold a mount against that was found another way.
//!
//! `MountCalibrator` follows corners of the picture, which the road has few of; the method aligns the whole of the road
//! ahead. Each is misled by other things. A camera through which the way is not as long as was given is not the one of the drive.

use fingerpost::attitude::AttitudeWatch;
use fingerpost::ground_view::{GroundPicture, GroundView, GroundViewConfig, GroundViewError};
use fingerpost::motion::{DirectMotion, DirectMotionConfig, Motion, MotionError, MotionEstimator};
use fingerpost_geometry::Camera;
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::mount::Estimated;

/// Share of the way that is off where the road is not quite flat or the load tilts the camera: every frame alike.
const SCALE_SIGMA: f64 = 0.015;

/// A way that cannot be measured.
#[derive(Debug, Error)]
pub enum DrivenWayError {
    /// The camera does not see the road ahead, or not in such a frame.
    #[error(transparent)]
    View(#[from] GroundViewError),
    /// The frame has another size than the camera.
    #[error(transparent)]
    Frame(#[from] PictureError),
    /// The road's motion cannot be measured.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// Measures the way of a drive.
#[derive(Debug)]
pub struct DrivenWay {
    view: GroundView,
    picture: GroundPicture,
    attitude: AttitudeWatch,
    motion: DirectMotion,
    way_m: f64,
    variance_m2: f64,
    frames: usize,
}

impl DrivenWay {
    /// A measurement through `camera` that has seen no frame yet.
    ///
    /// # Errors
    /// [`GroundViewError`] when the camera does not see the road just ahead.
    pub fn new(camera: &Camera) -> Result<Self, GroundViewError> {
        // Colours play no part, and one bin is the least there can be of each.
        let bins = HueSaturationBins { hue: 1, saturation: 1 };
        let view = GroundView::new(&GroundViewConfig::default(), bins, camera)?;
        Ok(Self {
            picture: view.black_picture(),
            view,
            attitude: AttitudeWatch::new(camera),
            motion: DirectMotion::new(&DirectMotionConfig::default()),
            way_m: 0.0,
            variance_m2: 0.0,
            frames: 0,
        })
    }

    /// Takes in a frame.
    ///
    /// # Errors
    /// [`DrivenWayError`] when it has not the camera's size, or too little road is seen.
    pub fn add(&mut self, frame: &RgbImage) -> Result<(), DrivenWayError> {
        self.view.render(frame, &mut self.picture)?;
        let attitude = self.attitude.look_at(self.view.camera(), frame)?.unwrap_or_default();
        let measured = self.motion.estimate(&self.view, &self.picture, &attitude)?;
        self.frames += 1;
        if self.frames > 1 {
            let believed = measured.filter(|(output, _)| output.doubt.is_none());
            let motion = believed.map_or_else(Motion::unknown, |(output, _)| output.motion);
            self.way_m += motion.previous_from_current.translation.x;
            self.variance_m2 += motion.covariance[(0, 0)];
        }
        Ok(())
    }

    /// The way so far, metres; frames that do not show it make it unsure.
    #[must_use]
    pub fn way(&self) -> Estimated {
        let sigma = libm::hypot(self.variance_m2.sqrt(), SCALE_SIGMA * self.way_m);
        Estimated { value: self.way_m, sigma: sigma.max(f64::MIN_POSITIVE) }
    }
}

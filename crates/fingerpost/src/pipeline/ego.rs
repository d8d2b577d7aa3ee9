//! Ego-motion: how vehicle and camera moved, by the far scene, the road, the mount and the vehicle's bus.

use fingerpost_geometry::Camera;
use fingerpost_vision::picture::RgbImage;

use super::{PipelineError, Sensors, Stage};
use crate::attitude::{AttitudeWatch, ObservedAngle};
use crate::config::Config;
use crate::ground_view::{GroundPicture, GroundView};
use crate::motion::{CameraAttitude, Motion, MotionDoubt, MotionEstimator, MotionEvidence};
use crate::mount::{MountEstimate, MountFilter};
use crate::vehicle_signals::{SignalsEvidence, SignalsInput, VehicleSignals, VehicleState};

/// After a longer time two pictures show other road, seconds: at 50 km/h 14 m of the default view's 16 lie behind.
const LONGEST_STEP_S: f64 = 1.0;

/// The stages that say how vehicle and camera move, with their state.
pub(super) struct Ego {
    attitude: AttitudeWatch,
    motion: Box<dyn MotionEstimator>,
    mount: MountFilter,
    signals: VehicleSignals,
    /// Seconds of the frames that showed nothing, behind the last one that did; none where it was the last.
    unseen_s: Option<f64>,
}

/// What they say after a frame.
pub(super) struct EgoFrame<'a> {
    /// Since the last frame that showed something; nothing is known of one that is not believed.
    pub(super) motion: Option<Motion>,
    /// Why what was measured of it is not believed.
    pub(super) motion_doubt: Option<MotionDoubt>,
    /// How the camera is turned against its mount.
    pub(super) camera: Option<CameraAttitude>,
    pub(super) vehicle: VehicleState,
    /// Where the camera looks against its calibration.
    pub(super) mount: MountEstimate,
    /// Change of the camera's pitch since the frame before, radians; none where the picture does not show it.
    pub(super) pitch_change: Option<ObservedAngle>,
    /// Seconds since the last frame that showed something.
    pub(super) dt_s: Option<f64>,
    pub(super) motion_evidence: Option<&'a MotionEvidence>,
    pub(super) signals_evidence: SignalsEvidence,
}

impl Ego {
    pub(super) fn new(
        config: &Config,
        camera: &Camera,
        view: &GroundView,
        motion: Box<dyn MotionEstimator>,
    ) -> Self {
        Self {
            attitude: AttitudeWatch::new(camera),
            motion,
            mount: MountFilter::new(&config.mount, view.viewpoint().foot.x),
            signals: VehicleSignals::new(&config.can),
            unseen_s: None,
        }
    }

    /// Takes one frame in.
    ///
    /// # Errors
    /// [`PipelineError`] when pictures do not fit together.
    pub(super) fn step(
        &mut self,
        (camera, frame): (&Camera, &RgbImage),
        (view, ground): (&GroundView, &GroundPicture),
        Sensors { signals, dt_s, .. }: Sensors,
        finished: &mut dyn FnMut(Stage),
    ) -> Result<EgoFrame<'_>, PipelineError> {
        let unseen_s = self.unseen_s.take();
        let attitude = self.attitude.look_at(camera, frame)?.unwrap_or_default();
        finished(Stage::Mount);

        let since_shown_s = dt_s.map(|dt_s| dt_s + unseen_s.unwrap_or(0.0));
        let (seen, motion_evidence) = self.motion.estimate(view, ground, &attitude)?.unzip();
        let is_gap = since_shown_s.is_some_and(|since_s| since_s > LONGEST_STEP_S);
        let motion_doubt = seen.and_then(|seen| seen.doubt).filter(|_| !is_gap);
        let motion = seen.map(|seen| match motion_doubt {
            None if !is_gap => seen.motion,
            _ => Motion::unknown(),
        });
        // A frame whose picture shows nothing still lets the suspension swing back.
        if let Some(motion) = motion.as_ref().filter(|_| motion_doubt.is_none()) {
            self.mount.observe(&attitude, motion);
        }
        // A motion over frames that showed nothing took longer than this frame.
        let of_frame = motion.as_ref().filter(|_| unseen_s.is_none());
        let (vehicle, signals_evidence) =
            self.signals.step(SignalsInput { samples: signals, motion: of_frame, dt_s });
        finished(Stage::Motion);
        let mount = self.mount.estimate();
        Ok(EgoFrame {
            motion,
            motion_doubt,
            camera: seen.map(|seen| seen.camera.unwrap_or_else(|| mount.attitude())),
            vehicle,
            mount,
            pitch_change: attitude.pitch_change,
            dt_s: since_shown_s,
            motion_evidence,
            signals_evidence,
        })
    }

    /// Takes in a frame whose picture shows nothing new: only the bus says anything.
    pub(super) fn pass_over(
        &mut self,
        Sensors { signals, dt_s, .. }: Sensors,
    ) -> (VehicleState, SignalsEvidence) {
        self.unseen_s = Some(self.unseen_s.unwrap_or(0.0) + dt_s.unwrap_or(0.0));
        self.signals.step(SignalsInput { samples: signals, motion: None, dt_s })
    }
}

//! The vehicle's motion, found ahead.

use fingerpost::attitude::AttitudeObservation;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::motion::{MotionError, MotionEstimator, MotionEvidence, MotionOutput};

use super::notes::{Reader, Writer};

/// What an estimator found in a frame; none where it found nothing.
pub(super) type MotionNote = Option<(MotionOutput, MotionEvidence)>;

/// An estimator whose findings are written down.
pub(super) struct NotedMotion {
    pub(super) estimator: Box<dyn MotionEstimator>,
    pub(super) notes: Writer<MotionNote>,
}

impl MotionEstimator for NotedMotion {
    fn estimate(
        &mut self,
        view: &GroundView,
        picture: &GroundPicture,
        attitude: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
        let found = self.estimator.estimate(view, picture, attitude);
        self.notes.write(match &found {
            Ok(found) => Ok(found.map(|(output, evidence)| (output, evidence.clone()))),
            Err(cause) => Err(cause.to_string()),
        });
        found
    }

    fn reset(&mut self) {
        self.estimator.reset();
    }
}

/// What was written down, said again frame by frame.
pub(super) struct RepeatedMotion(pub(super) Reader<MotionNote>);

impl MotionEstimator for RepeatedMotion {
    fn estimate(
        &mut self,
        _: &GroundView,
        _: &GroundPicture,
        _: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
        let note = self.0.next().map_err(|reason| MotionError::Estimator { reason })?;
        Ok(note.as_ref().map(|(output, evidence)| (*output, evidence)))
    }

    fn reset(&mut self) {
        self.0.begin_again();
    }
}

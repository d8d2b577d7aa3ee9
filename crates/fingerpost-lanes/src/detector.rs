//! The lane finder's place in the pipeline.

use fingerpost_geometry::Camera;

use super::{Lane, LaneError, LaneEvidence, LaneFinder, LaneInput};

/// A way to find the lane in which the vehicle is.
pub trait LaneDetector: Send {
    /// Takes a frame in and sets `lane`, whose memory may be used again; none where there is no lane. The evidence stays with the
    /// detector, so that a frame needs no new memory.
    ///
    /// # Errors
    /// [`LaneError`] when the frame cannot be used, as one that has not the camera's size.
    fn find(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError>;

    /// Forgets the lane, as where the vehicle has turned through a junction.
    fn reset(&mut self);
}

impl LaneDetector for LaneFinder {
    fn find(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError> {
        Self::find(self, camera, input, lane)
    }

    fn reset(&mut self) {
        Self::reset(self);
    }
}

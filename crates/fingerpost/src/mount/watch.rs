//! The camera's own motion, frame by frame, as observations of its attitude.

use fingerpost_geometry::{Camera, View};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::RgbImage;

use super::AttitudeObservation;
use super::sighting::Sightings;
use super::sparse::{BackCheck, SparseSetting};

/// A corner for every 64 x 64 pixels of the picture, found at a quarter of its size and followed at half of it: a hundred or
/// so of them tell the motion.
const QUICK: SparseSetting =
    SparseSetting { find_level: 2, cell_px: 16, follow_level: 1, iterations: 6, check: BackCheck::Off };

/// Watches where the camera moves to in its own picture, which needs no road.
#[derive(Debug)]
pub struct AttitudeWatch {
    sightings: Sightings,
}

impl Default for AttitudeWatch {
    fn default() -> Self {
        Self::new()
    }
}

impl AttitudeWatch {
    /// A watch that has seen no frame yet.
    #[must_use]
    pub fn new() -> Self {
        Self { sightings: Sightings::new(QUICK) }
    }

    /// Takes in a frame: what it says about the attitude of `camera` against its mount; none for the first frame, for one
    /// that shows too little, and for a camera known by points.
    ///
    /// # Errors
    /// [`PictureError`] when the frame has not the camera's size.
    pub fn look_at(
        &mut self,
        camera: &Camera,
        frame: &RgbImage,
    ) -> Result<Option<AttitudeObservation>, PictureError> {
        let View::Calibrated { mount, .. } = camera.view() else { return Ok(None) };
        let seen = self.sightings.look_at(camera, frame)?;
        Ok(seen.map(|(sighting, _)| sighting.observation(mount)))
    }
}

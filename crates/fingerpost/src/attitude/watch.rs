//! The camera's own motion, frame by frame, as observations of its attitude.

use fingerpost_geometry::{Camera, View};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::RgbImage;

use super::AttitudeObservation;
use super::sighting::Sightings;
use super::sparse::{BackCheck, SparseSetting};

/// About how many corners tell the motion: more cost time, fewer leave too few of each part of the scene.
const CORNERS: usize = 72;
/// Level of the pyramid at which they are looked for: a quarter of the picture's size.
const FIND_LEVEL: usize = 2;
/// Smallest cell that holds a corner, pixels of that level: a window of the second moments.
const LEAST_CELL_PX: usize = 5;

/// Watches where the camera moves to in its own picture, which needs no road.
#[derive(Debug)]
pub struct AttitudeWatch {
    sightings: Sightings,
}

impl AttitudeWatch {
    /// A watch through `camera` that has seen no frame yet.
    #[must_use]
    pub fn new(camera: &Camera) -> Self {
        let area = (camera.width() >> FIND_LEVEL) * (camera.height() >> FIND_LEVEL);
        let quick = SparseSetting {
            find_level: FIND_LEVEL,
            cell_px: (area / CORNERS).isqrt().max(LEAST_CELL_PX),
            follow_level: 0,
            iterations: 6,
            check: BackCheck::Off,
        };
        Self { sightings: Sightings::new(quick) }
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

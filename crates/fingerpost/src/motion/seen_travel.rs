//! Whether the camera is seen to travel, by the whole of its picture.
//!
//! A compressed video keeps smooth asphalt where it was, and a bonnet's mirror image stays: the road's texture then says that
//! the vehicle stands. What lies around the road says otherwise.

use nalgebra::Isometry2;

use crate::attitude::AttitudeObservation;

/// The camera travels when it was seen to do so in two frames of three.
const TRAVELS: u32 = 3;
const MOST: u32 = 4;
/// Shortest step in a frame that shows in which direction the camera travels, metres.
pub(super) const SEEN_TRAVEL_M: f64 = 0.03;

/// Two for each frame in which the camera was seen to travel, less one for each since in which it was not.
#[derive(Debug, Clone, Copy, Default)]
pub struct SeenTravel(u32);

impl SeenTravel {
    /// After another frame, with what it says about the camera's attitude: the pitch is seen by the direction of travel.
    #[must_use]
    pub fn after(self, attitude: &AttitudeObservation) -> Self {
        Self(attitude.pitch.map_or(self.0.saturating_sub(1), |_| (self.0 + 2).min(MOST)))
    }

    /// Whether the camera travels farther than a motion says.
    pub fn contradicts(self, current_from_previous: &Isometry2<f64>) -> bool {
        self.0 >= TRAVELS && current_from_previous.inverse().translation.x < SEEN_TRAVEL_M
    }
}

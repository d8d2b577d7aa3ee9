//! Whether the camera is seen to travel, by the whole of its picture.
//!
//! A compressed video keeps smooth asphalt where it was, and a bonnet's mirror image stays: the road's texture then says that
//! the vehicle stands. What lies around the road says otherwise, in most frames clearly; what such a view showed before, it shows in those
//! between them as well.

use nalgebra::Isometry2;

use crate::attitude::AttitudeObservation;

/// The camera travels when it was seen to do so in two frames of three.
const TRAVELS: u32 = 3;
const MOST: u32 = 4;
/// Shortest step in a frame that shows in which direction the camera travels, metres.
pub(super) const SEEN_TRAVEL_M: f64 = 0.03;

/// How often the camera is seen to travel, seen to leave near things behind without a direction that is sure, and neither: of a vehicle
/// that drives, and of one that stands beside others that drive.
const OF_DRIVING: [f64; 3] = [0.6, 0.3, 0.1];
const OF_STANDING: [f64; 3] = [0.02, 0.1, 0.88];
/// A motion that was measured and is long enough is so much less likely where the view stands still than where it does not.
const SEEN_TO_MOVE: f64 = 0.02;
/// From one frame to the next a view begins to stand still, or no longer does, as the surface changes and the vehicle stops and starts.
const CHANGES: f64 = 0.02;

/// Probability that the vehicle drives and what lies in its ground view does not show it: none before [`SeenTravel`] says so.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct HiddenTravel(f64);

impl HiddenTravel {
    /// After another frame with the motion that the ground view shows, which `is_measured` or goes on as before, and which
    /// `is_contradicted` by the camera's seen travel.
    pub(super) fn after(
        self,
        attitude: &AttitudeObservation,
        current_from_previous: &Isometry2<f64>,
        (is_measured, is_contradicted): (bool, bool),
    ) -> Self {
        let begins = if is_contradicted { CHANGES } else { 0.0 };
        let before = self.0 * (1.0 - CHANGES) + (1.0 - self.0) * begins;
        let ratio = match (is_short(current_from_previous), is_measured) {
            (false, true) => SEEN_TO_MOVE,
            (false, false) => 1.0,
            (true, _) => {
                let seen = match attitude {
                    AttitudeObservation { pitch: Some(_), .. } => 0,
                    AttitudeObservation { passes_things: true, .. } => 1,
                    _ => 2,
                };
                OF_DRIVING[seen] / OF_STANDING[seen]
            }
        };
        let odds = before / (1.0 - before) * ratio;
        Self(odds / (1.0 + odds))
    }

    /// Whether a motion is one that such a view makes.
    pub(super) fn contradicts(self, current_from_previous: &Isometry2<f64>) -> bool {
        self.0 > 0.5 && is_short(current_from_previous)
    }
}

/// Whether a motion is shorter than any that shows in which direction the camera travels.
fn is_short(current_from_previous: &Isometry2<f64>) -> bool {
    current_from_previous.inverse().translation.x < SEEN_TRAVEL_M
}

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
        self.0 >= TRAVELS && is_short(current_from_previous)
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::ObservedAngle;

    use super::*;

    const SEEN: AttitudeObservation = AttitudeObservation {
        pitch: Some(ObservedAngle { angle_rad: 0.0, variance_rad2: 1e-6 }),
        passes_things: true,
        ..NEITHER
    };
    const PASSES: AttitudeObservation = AttitudeObservation { passes_things: true, ..NEITHER };
    const NEITHER: AttitudeObservation = AttitudeObservation {
        pitch: None,
        roll: None,
        yaw: None,
        pitch_change: None,
        roll_change: None,
        heading_change: None,
        passes_things: false,
    };

    fn moved_m(forward_m: f64) -> Isometry2<f64> {
        Isometry2::translation(forward_m, 0.0).inverse()
    }

    /// Whether a short motion is doubted after frames, each with the motion that is measured in it.
    fn is_doubted(frames: &[(AttitudeObservation, f64)]) -> bool {
        let (mut travel, mut hidden) = (SeenTravel::default(), HiddenTravel::default());
        for (attitude, m) in frames {
            travel = travel.after(attitude);
            hidden = hidden.after(attitude, &moved_m(*m), (true, travel.contradicts(&moved_m(*m))));
        }
        travel.contradicts(&moved_m(0.003)) || hidden.contradicts(&moved_m(0.003))
    }

    #[test]
    fn what_was_doubted_stays_so_until_the_picture_says_otherwise() {
        for doubted in [2, 3, 10, 57] {
            let doubted = vec![(SEEN, 0.003); doubted];
            assert!(is_doubted(&doubted));
            // As long as near things are left behind, no frame in which the direction is not sure is believed.
            for unsure in [1, 2, 5, 20] {
                assert!(is_doubted(&[&doubted[..], &vec![(PASSES, 0.004); unsure]].concat()), "{unsure}");
            }
            assert!(
                is_doubted(&[&doubted[..], &[(NEITHER, 0.0)]].concat()),
                "one that shows little is no stand"
            );
            // A vehicle that stopped, and a road that is seen again.
            assert!(!is_doubted(&[&doubted[..], &[(NEITHER, 0.0); 4]].concat()));
            let road = [(SEEN, 1.1), (SEEN, 1.1), (PASSES, 0.0), (PASSES, 0.0)];
            assert!(!is_doubted(&[&doubted[..], &road].concat()));
        }
    }

    #[test]
    fn a_vehicle_that_stops_and_stands_is_believed() {
        let driven = [(SEEN, 1.0), (SEEN, 0.4), (PASSES, 0.1), (NEITHER, 0.05), (NEITHER, 0.01)];
        for begin in 0..driven.len() {
            for standing in [1, 5, 100] {
                assert!(
                    !is_doubted(&[&driven[begin..], &vec![(NEITHER, 0.0); standing]].concat()),
                    "{begin}"
                );
            }
        }
        // Others that pass are not its own way, however often.
        for passing in [1, 9] {
            let traffic =
                [vec![(NEITHER, 0.0); 10 - passing], vec![(PASSES, 0.0); passing]].concat().repeat(20);
            assert!((1..traffic.len()).all(|frames| !is_doubted(&traffic[..frames])));
        }
        // A smooth road on which the motion of before goes on is not one that stands still.
        let after = |hidden: HiddenTravel, _| hidden.after(&SEEN, &moved_m(0.8), (false, false));
        assert!(!(0..100).fold(HiddenTravel::default(), after).contradicts(&moved_m(0.0)));
    }
}

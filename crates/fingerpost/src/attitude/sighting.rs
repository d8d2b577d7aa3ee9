//! What a camera's motion says about its mount.
//!
//! A vehicle that does not turn moves along its own x axis, parallel to the road it stands on: the direction of travel in
//! the camera frame is that axis, which fixes pitch and yaw once the roll is known.

use fingerpost_geometry::{Camera, Mount, View};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};

use super::camera_motion::{CameraMotion, MotionFit};
use super::sparse::{RayPair, SparseSetting, SparseTracks};
use super::{AttitudeObservation, ObservedAngle};

/// A direction of travel less certain than this says nothing, radians: the vehicle stands or nearly so.
const MOST_TRAVEL_SIGMA_RAD: f64 = 0.6 * DEGREE;
/// Share of the pairs that must agree with the motion.
const LEAST_AGREEING: f64 = 0.25;
/// Pairs that must tell the direction, four for each of its two unknowns: where near texture is lost, a few false pairs fit
/// some direction, and all that is far agrees with it.
const LEAST_TELLING: usize = 8;
/// A vehicle that turns faster in a frame does not move the way its camera looks.
const TURNING_RAD: f64 = 0.5 * DEGREE;
/// Directions further from straight ahead are those of a vehicle that rolls back, or no directions at all.
const MOST_FROM_AHEAD_RAD: f64 = 40.0 * DEGREE;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A frame's view of the camera's own motion.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    /// The motion in the camera frame.
    pub motion: CameraMotion,
    /// Change of the pitch since the frame before, radians, positive nose down.
    pub pitch_change_rad: f64,
    /// Change of the roll, radians, positive left side up.
    pub roll_change_rad: f64,
    /// Change of the vehicle's heading, radians, positive left.
    pub turn_rad: f64,
    /// Whether near things were left behind, however sure the direction is.
    pub passes_things: bool,
    /// Whether the vehicle moved far enough for a direction.
    pub moves: bool,
}

/// Watches the camera's own motion.
#[derive(Debug)]
pub struct Sightings {
    tracks: SparseTracks,
    fit: MotionFit,
}

impl Sightings {
    /// A watch that has seen no frame yet.
    #[must_use]
    pub fn new(setting: SparseSetting) -> Self {
        Self { tracks: SparseTracks::new(setting), fit: MotionFit::default() }
    }

    /// Takes in a frame: the motion since the one before with the rays that showed it; none where it cannot be told, and
    /// for a camera known by points.
    ///
    /// # Errors
    /// [`PictureError`] when the frame has not the camera's size.
    pub fn look_at(
        &mut self,
        camera: &Camera,
        frame: &RgbImage,
    ) -> Result<Option<(Sighting, &[RayPair])>, PictureError> {
        let View::Calibrated { vehicle_from_camera, .. } = camera.view() else { return Ok(None) };
        let turned = vehicle_from_camera.rotation;
        let ahead = Unit::new_unchecked(turned.inverse() * Vector3::x());
        self.fit.reserve(self.tracks.most_pairs(camera));
        let Some(pairs) = self.tracks.look_at(camera, frame)? else { return Ok(None) };
        let motion = self.fit.fit(pairs, ahead);
        Ok(motion.map(|motion| (Sighting::of(motion, turned, ahead), pairs)))
    }
}

impl Sighting {
    fn of(motion: CameraMotion, vehicle_from_camera: UnitQuaternion<f64>, ahead: Unit<Vector3<f64>>) -> Self {
        // What is seen turns the other way than the camera does.
        let turned = -(vehicle_from_camera * motion.current_from_previous.scaled_axis());
        let passes_things = motion.agreeing > LEAST_AGREEING
            && motion.telling >= LEAST_TELLING
            && motion.travel.angle(&ahead) < MOST_FROM_AHEAD_RAD;
        let moves =
            passes_things && motion.travel_sigma_rad.iter().all(|&sigma| sigma < MOST_TRAVEL_SIGMA_RAD);
        let [pitch_change_rad, roll_change_rad, turn_rad] = [turned.y, turned.x, turned.z];
        Self { motion, pitch_change_rad, roll_change_rad, turn_rad, passes_things, moves }
    }

    /// Whether the vehicle moved straight ahead.
    pub fn is_straight(&self) -> bool {
        self.moves && self.turn_rad.abs() < TURNING_RAD
    }

    /// How much shorter the way may be for its direction still to show, as a share of it: what the way moves grows with it, and so do the
    /// direction's precision and the number of pairs that tell it.
    pub fn least_way_share(&self) -> f64 {
        let [up, aside] = self.motion.travel_sigma_rad;
        let by_sigma = up.max(aside) / MOST_TRAVEL_SIGMA_RAD;
        by_sigma.max(LEAST_TELLING as f64 / self.motion.telling.max(1) as f64)
    }

    /// What the frame says about the mount.
    pub(super) fn observation(&self, mount: &Mount) -> AttitudeObservation {
        let seen =
            |angle_rad: f64, sigma: f64| Some(ObservedAngle { angle_rad, variance_rad2: sigma * sigma });
        let [up, aside] = self.motion.travel_sigma_rad;
        let (pitch_rad, yaw_rad) = angles_of_travel(&self.motion.travel, mount.roll_rad);
        let turned = self.motion.rotation_sigma_rad;
        AttitudeObservation {
            pitch: self.moves.then(|| seen(pitch_rad - mount.pitch_rad, up)).flatten(),
            yaw: self.is_straight().then(|| seen(yaw_rad - mount.yaw_rad, aside)).flatten(),
            roll: None,
            pitch_change: seen(self.pitch_change_rad, turned.x),
            roll_change: seen(self.roll_change_rad, turned.z),
            heading_change: seen(self.turn_rad, turned.y),
            passes_things: self.passes_things,
        }
    }
}

/// Pitch and yaw, radians, of a mount whose camera moves along `travel` (camera frame) while its vehicle drives straight ahead.
pub fn angles_of_travel(travel: &Unit<Vector3<f64>>, roll_rad: f64) -> (f64, f64) {
    let level = Mount::level(1.0).vehicle_from_camera().rotation * travel.into_inner();
    let rolled = Rotation3::from_axis_angle(&Vector3::x_axis(), roll_rad) * level;
    (libm::atan2(rolled.z, rolled.x), libm::asin(-rolled.y))
}

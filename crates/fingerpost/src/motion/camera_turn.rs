//! How the camera is turned against its configured mount, from frame to frame, as the road's own motion shows it.
//!
//! A camera that looks lower than its calibration says shows the road too far away, and the farther the more: with a pitch p
//! from height h, road that is X ahead seems to move by the share 2 p X / h too far, which is a tenth at half a degree and
//! 10 m. The road near the vehicle and that farther off thus disagree about the distance driven, and in that disagreement
//! the pitch is seen, as the roll is in that of left and right. A single frame knows the pitch to about half a degree, and
//! hardly tells a change of it from a little more speed; but a change that never came back would add up. So pitch and roll
//! are filtered, each as a slow part, which is the mount with the vehicle's load, and a swing of the body on its springs,
//! which returns to nothing. The alignment takes the filter's prediction as a prior, and gives back what the pictures alone
//! say ([`SeenTurn`]), in information form, because most of it is known only together.
//!
//! A change of pitch or roll is seen far better against the far scene, in the camera's own motion, than in that of the road. But
//! it is the change against the sky: over a crest or through a dip the road turns the vehicle, and its pitch against the road
//! stays. So the filter has the road's own change of slope as well, which lasts longer than a swing. The direction in which the
//! camera travels ([`mount`](crate::mount)) is not used: on some drives it is off by a degree throughout, where the road's own
//! motion leaves a tenth.
//!
//! Limits: what is seen as pitch is the direction of the camera against the road just ahead, so a crest or a dip counts as
//! pitch; a verge higher than the road counts as roll.

use nalgebra::{Matrix4, Matrix5, SMatrix, SVector, Vector4, Vector5};

use super::CameraAttitude;
use crate::attitude::{AttitudeObservation, ObservedAngle, lasting_variance_rad2};
use crate::ground_view::CameraTurn;

const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// How one of the two angles may go.
struct Way {
    /// How far a calibration may be off, one standard deviation.
    configured_sigma_rad: f64,
    /// How far the slow part goes in a frame.
    slow_step_rad: f64,
    /// How far the body swings on its springs, and the road ahead bends.
    swing_sigma_rad: f64,
    /// Share of a swing that is left in the next frame.
    swing_kept: f64,
}
/// A camera that was set up by eye; half a degree of slow change in a minute at ten frames a second; a swing lasts half a
/// second. A wider swing explains more of an uneven road and takes longer to find the slow part.
const PITCH: Way = Way {
    configured_sigma_rad: 2.0 * DEGREE,
    slow_step_rad: 0.02 * DEGREE,
    swing_sigma_rad: 0.3 * DEGREE,
    swing_kept: 0.8,
};
/// Calibrated cameras are level to half a degree, because the horizon shows it. In a bend the body leans by half a degree.
const ROLL: Way = Way {
    configured_sigma_rad: 0.5 * DEGREE,
    slow_step_rad: 0.01 * DEGREE,
    swing_sigma_rad: 0.4 * DEGREE,
    swing_kept: 0.85,
};
/// How the road's slope changes in a frame, one standard deviation, and how much of it is left in the next: a crest or a dip
/// turns the camera against the far scene, not against the road, and lasts for seconds.
const BEND_SIGMA_RAD: f64 = 0.03 * DEGREE;
const BEND_KEPT: f64 = 0.95;
/// What a frame by itself is given for pitch and roll, so that an angle of which nothing is seen has a variance.
const UNSEEN_SIGMA_RAD: f64 = 10.0 * DEGREE;

impl Way {
    fn swing_step_variance(&self) -> f64 {
        (1.0 - self.swing_kept * self.swing_kept) * self.swing_sigma_rad * self.swing_sigma_rad
    }
}

/// What is known of change of pitch, change of roll, pitch before and roll before, radians: the inverse of its covariance,
/// and that times its mean.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct SeenTurn {
    pub(super) information: Matrix4<f64>,
    pub(super) vector: Vector4<f64>,
}

/// Slow pitch, the swing's pitch, slow roll, the swing's roll, radians; change of the road's slope, nose down, radians a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TurnFilter {
    mean: Vector5<f64>,
    covariance: Matrix5<f64>,
}

/// The state before and after a frame's time: slow pitch, its swing before and after, slow roll, its swing before and after,
/// and the change of the road's slope in between.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictedTurn {
    mean: SVector<f64, 7>,
    covariance: SMatrix<f64, 7, 7>,
}

/// What [`SeenTurn`] is about, from the state before and after a frame.
#[rustfmt::skip]
fn seen_from_state() -> SMatrix<f64, 4, 7> {
    SMatrix::<f64, 4, 7>::from_row_slice(&[
        0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0,
        1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0,
    ])
}

impl Default for TurnFilter {
    fn default() -> Self {
        let sigma = [
            PITCH.configured_sigma_rad,
            PITCH.swing_sigma_rad,
            ROLL.configured_sigma_rad,
            ROLL.swing_sigma_rad,
            BEND_SIGMA_RAD,
        ];
        let sigma = Vector5::from(sigma);
        Self { mean: Vector5::zeros(), covariance: Matrix5::from_diagonal(&sigma.component_mul(&sigma)) }
    }
}

impl TurnFilter {
    /// Pitch and roll after the last frame, radians.
    pub(super) fn turn_rad(&self) -> [f64; 2] {
        [self.mean[0] + self.mean[1], self.mean[2] + self.mean[3]]
    }

    /// How the camera is turned after the last frame.
    pub(super) fn attitude(&self) -> CameraAttitude {
        let [pitch_rad, roll_rad] = self.turn_rad();
        // Of each the slow part and the swing together.
        let sigma_rad = [0, 2].map(|i| self.covariance.fixed_view::<2, 2>(i, i).sum().max(0.0).sqrt());
        CameraAttitude { turn: CameraTurn { pitch_rad, roll_rad, yaw_rad: 0.0 }, sigma_rad }
    }

    /// What is expected of the next frame.
    pub(super) fn predicted(&self) -> PredictedTurn {
        let mut forward = SMatrix::<f64, 7, 5>::zeros();
        for (row, column, share) in [
            (0, 0, 1.0),
            (1, 1, 1.0),
            (2, 1, PITCH.swing_kept),
            (3, 2, 1.0),
            (4, 3, 1.0),
            (5, 3, ROLL.swing_kept),
            (6, 4, BEND_KEPT),
        ] {
            forward[(row, column)] = share;
        }
        let slow = |way: &Way| way.slow_step_rad * way.slow_step_rad;
        let steps = SVector::<f64, 7>::from([
            slow(&PITCH),
            0.0,
            PITCH.swing_step_variance(),
            slow(&ROLL),
            0.0,
            ROLL.swing_step_variance(),
            (1.0 - BEND_KEPT * BEND_KEPT) * BEND_SIGMA_RAD * BEND_SIGMA_RAD,
        ]);
        PredictedTurn {
            mean: forward * self.mean,
            covariance: forward * self.covariance * forward.transpose() + SMatrix::from_diagonal(&steps),
        }
    }
}

impl PredictedTurn {
    /// With how the camera turned against the far scene since the older frame.
    pub(super) fn with(mut self, attitude: &AttitudeObservation) -> Self {
        if let Some(seen) = attitude.pitch_change {
            let change = SVector::from([0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
            self.take(&change, seen.angle_rad, lasting_variance_rad2(&seen));
        }
        if let Some(seen) = attitude.roll_change {
            let change = SVector::from([0.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0]);
            self.take(&change, seen.angle_rad, lasting_variance_rad2(&seen));
        }
        self
    }

    fn take(&mut self, of_state: &SVector<f64, 7>, angle_rad: f64, variance_rad2: f64) {
        let across = self.covariance * of_state;
        let gain = across / (of_state.dot(&across) + variance_rad2);
        self.mean += gain * (angle_rad - of_state.dot(&self.mean));
        self.covariance -= gain * across.transpose();
    }

    /// The prediction as a prior of the alignment; none when it is so sure of itself that it has no inverse.
    pub(super) fn prior(&self) -> Option<SeenTurn> {
        let seen = seen_from_state();
        let information = (seen * self.covariance * seen.transpose()).try_inverse()?;
        Some(SeenTurn { information, vector: information * (seen * self.mean) })
    }

    /// Takes in what a frame shows; the prediction alone where that makes no sense.
    pub(super) fn updated(&self, seen_turn: &SeenTurn) -> TurnFilter {
        let seen = seen_from_state();
        let across = self.covariance * seen.transpose();
        let expected = seen * across;
        let (mean, covariance) = match (Matrix4::identity() + seen_turn.information * expected).try_inverse()
        {
            Some(shrunk) => {
                let gain = across * shrunk;
                let surprise = seen_turn.vector - seen_turn.information * (seen * self.mean);
                (
                    self.mean + gain * surprise,
                    self.covariance - gain * seen_turn.information * across.transpose(),
                )
            }
            None => (self.mean, self.covariance),
        };
        let kept = [0, 2, 3, 5, 6];
        let covariance = Matrix5::from_fn(|row, column| covariance[(kept[row], kept[column])]);
        TurnFilter {
            mean: Vector5::from(kept.map(|row| mean[row])),
            covariance: 0.5 * (covariance + covariance.transpose()),
        }
    }
}

impl SeenTurn {
    /// Each angle by itself, as this frame alone shows it: pitch and roll now, and their changes.
    pub(super) fn observation(&self) -> Option<AttitudeObservation> {
        let unseen = UNSEEN_SIGMA_RAD * UNSEEN_SIGMA_RAD;
        let weak = Vector4::new(PITCH.swing_step_variance(), ROLL.swing_step_variance(), unseen, unseen)
            .map(f64::recip);
        let covariance = (self.information + Matrix4::from_diagonal(&weak)).try_inverse()?;
        let mean = covariance * self.vector;
        let angle = |of: Vector4<f64>| {
            let variance_rad2 = of.dot(&(covariance * of));
            (variance_rad2 > 0.0).then_some(ObservedAngle { angle_rad: of.dot(&mean), variance_rad2 })
        };
        Some(AttitudeObservation {
            pitch: angle(Vector4::new(1.0, 0.0, 1.0, 0.0)),
            roll: angle(Vector4::new(0.0, 1.0, 0.0, 1.0)),
            yaw: None,
            pitch_change: angle(Vector4::new(1.0, 0.0, 0.0, 0.0)),
            roll_change: angle(Vector4::new(0.0, 1.0, 0.0, 0.0)),
            heading_change: None,
            passes_things: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed_by(angle_rad: f64) -> AttitudeObservation {
        let seen = ObservedAngle { angle_rad, variance_rad2: (0.005 * DEGREE).powi(2) };
        AttitudeObservation { pitch_change: Some(seen), ..AttitudeObservation::default() }
    }

    #[test]
    fn a_body_that_swings_turns_the_camera_as_the_picture_shows() {
        let mut filter = TurnFilter::default();
        let swing_rad = |frame: i32| 0.3 * DEGREE * libm::sin(f64::from(frame) * 0.9);
        let mut worst_rad = 0.0_f64;
        for frame in 1..60 {
            let change = changed_by(swing_rad(frame) - swing_rad(frame - 1));
            filter = filter.predicted().with(&change).updated(&SeenTurn::default());
            if frame > 10 {
                worst_rad = worst_rad.max((filter.turn_rad()[0] - swing_rad(frame)).abs());
            }
        }
        assert!(worst_rad < 0.15 * DEGREE, "{worst_rad}");
    }

    #[test]
    fn a_crest_turns_the_road_not_the_camera_against_it() {
        let mut filter = TurnFilter::default();
        for _ in 0..60 {
            filter = filter.predicted().with(&changed_by(0.05 * DEGREE)).updated(&SeenTurn::default());
        }
        // The far scene shows 3 degrees in all.
        assert!(filter.turn_rad()[0].abs() < 0.2 * DEGREE, "{}", filter.turn_rad()[0]);
        let lasting_rad = filter.mean[4];
        assert!(lasting_rad > 0.025 * DEGREE && lasting_rad < 0.05 * DEGREE, "{lasting_rad}");
    }

    #[test]
    fn a_roll_that_the_far_scene_shows_turns_the_camera_and_leaves_its_pitch() {
        let seen = ObservedAngle { angle_rad: 0.2 * DEGREE, variance_rad2: (0.005 * DEGREE).powi(2) };
        let attitude = AttitudeObservation { roll_change: Some(seen), ..AttitudeObservation::default() };
        let filter = TurnFilter::default().predicted().with(&attitude).updated(&SeenTurn::default());
        let [pitch_rad, roll_rad] = filter.turn_rad();
        assert!((0.05..0.2).contains(&(roll_rad / DEGREE)), "{roll_rad}");
        assert!(pitch_rad.abs() < 1e-12);
        let CameraAttitude { sigma_rad: [pitch_sigma_rad, roll_sigma_rad], .. } = filter.attitude();
        assert!(pitch_sigma_rad > roll_sigma_rad, "a calibrated camera is level");
        let untold = TurnFilter::default().predicted().with(&AttitudeObservation::default());
        assert!(untold.mean.norm() < 1e-12);
    }
}

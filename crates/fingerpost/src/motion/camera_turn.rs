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
//! Limits: what is seen as pitch is the direction of the camera against the road just ahead, so a crest or a dip counts as
//! pitch; a verge higher than the road counts as roll.

use nalgebra::{Matrix4, SMatrix, SVector, Vector4};

use crate::mount::{AttitudeObservation, ObservedAngle};

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

/// Slow pitch, the swing's pitch, slow roll, the swing's roll, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TurnFilter {
    mean: Vector4<f64>,
    covariance: Matrix4<f64>,
}

/// The state before and after a frame's time: slow pitch, its swing before and after, slow roll, its swing before and after.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictedTurn {
    mean: SVector<f64, 6>,
    covariance: SMatrix<f64, 6, 6>,
}

/// What [`SeenTurn`] is about, from the state before and after a frame.
#[rustfmt::skip]
fn seen_from_state() -> SMatrix<f64, 4, 6> {
    SMatrix::<f64, 4, 6>::new(
        0.0, -1.0, 1.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, -1.0, 1.0,
        1.0, 1.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 1.0, 1.0, 0.0,
    )
}

impl Default for TurnFilter {
    fn default() -> Self {
        let sigma = [
            PITCH.configured_sigma_rad,
            PITCH.swing_sigma_rad,
            ROLL.configured_sigma_rad,
            ROLL.swing_sigma_rad,
        ];
        let sigma = Vector4::from(sigma);
        Self { mean: Vector4::zeros(), covariance: Matrix4::from_diagonal(&sigma.component_mul(&sigma)) }
    }
}

impl TurnFilter {
    /// Pitch and roll after the last frame, radians.
    pub(super) fn turn_rad(&self) -> [f64; 2] {
        [self.mean[0] + self.mean[1], self.mean[2] + self.mean[3]]
    }

    /// What is expected of the next frame.
    pub(super) fn predicted(&self) -> PredictedTurn {
        let mut forward = SMatrix::<f64, 6, 4>::zeros();
        for (row, column, share) in [
            (0, 0, 1.0),
            (1, 1, 1.0),
            (2, 1, PITCH.swing_kept),
            (3, 2, 1.0),
            (4, 3, 1.0),
            (5, 3, ROLL.swing_kept),
        ] {
            forward[(row, column)] = share;
        }
        let slow = |way: &Way| way.slow_step_rad * way.slow_step_rad;
        let steps = SVector::<f64, 6>::from([
            slow(&PITCH),
            0.0,
            PITCH.swing_step_variance(),
            slow(&ROLL),
            0.0,
            ROLL.swing_step_variance(),
        ]);
        PredictedTurn {
            mean: forward * self.mean,
            covariance: forward * self.covariance * forward.transpose() + SMatrix::from_diagonal(&steps),
        }
    }
}

/// Least standard deviation of a pitch that the picture shows: waves of the road turn the direction of driving by a third of
/// it, and errors last for many frames.
const ATTITUDE_FLOOR_RAD: f64 = 0.8 * DEGREE;

impl PredictedTurn {
    /// With the pitch that the picture itself shows in the newer frame, from the point that the vehicle moves towards.
    pub(super) fn with(mut self, attitude: &AttitudeObservation) -> Self {
        let Some(seen) = attitude.pitch else { return self };
        let pitch = SVector::<f64, 6>::from([1.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        let across = self.covariance * pitch;
        let gain = across / (pitch.dot(&across) + seen.variance_rad2.max(ATTITUDE_FLOOR_RAD.powi(2)));
        self.mean += gain * (seen.angle_rad - pitch.dot(&self.mean));
        self.covariance -= gain * across.transpose();
        self
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
        let kept = [0, 2, 3, 5];
        let covariance = Matrix4::from_fn(|row, column| covariance[(kept[row], kept[column])]);
        TurnFilter {
            mean: Vector4::from(kept.map(|row| mean[row])),
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
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pitch_that_the_picture_shows_turns_the_camera_that_way_and_leaves_its_roll() {
        let seen = ObservedAngle { angle_rad: DEGREE, variance_rad2: (0.1 * DEGREE).powi(2) };
        let attitude = AttitudeObservation { pitch: Some(seen), ..AttitudeObservation::default() };
        let mut filter = TurnFilter::default();
        let mut before_rad = 0.0;
        for _ in 0..20 {
            filter = filter.predicted().with(&attitude).updated(&SeenTurn::default());
            let [pitch_rad, roll_rad] = filter.turn_rad();
            assert!(pitch_rad > before_rad && pitch_rad < DEGREE, "{pitch_rad}");
            assert!(roll_rad.abs() < 1e-12);
            before_rad = pitch_rad;
        }
        assert!(before_rad > 0.8 * DEGREE, "{before_rad}");
        let untold = TurnFilter::default().predicted().with(&AttitudeObservation::default());
        assert!(untold.mean.norm() < 1e-12);
    }
}

//! The vehicle goes on as the features that it comes to show it: bracketing in place of flow.
//!
//! Paper 2, section 7.2: flow costs as much as several masks, and a feature that is found again about where it was says as well
//! how the vehicle moved. Nothing of the road is compared with the frame before here. The way and the turn of a frame are those of
//! the frame before, ever less sure, until a followed feature tells them.
//!
//! Limits: between features nothing is measured, so that neither braking nor a bend is noticed there; a standing vehicle goes on
//! until a feature stands. Steps are those of a frame, so that missing frames shift a place by as many steps.

use nalgebra::{Isometry2, Matrix3, Vector2, Vector3};

use super::{FeatureStep, Motion, MotionError, MotionEstimator, MotionEvidence, MotionOutput};
use crate::attitude::AttitudeObservation;
use crate::ground_view::{GroundPicture, GroundView};

/// Way of a frame before any is known, and its standard deviation, metres: up to 50 km/h at ten frames a second.
const FIRST_STEP_M: f64 = 0.7;
/// Standard deviation of a frame's turn before any is known, radians: a car's full lock at walking pace.
const FIRST_TURN_RAD: f64 = 0.05;
/// How much the way of a frame differs from that of the one before, metres: braking by 3 m/s2 at ten frames a second.
const STEP_CHANGE_M: f64 = 0.03;
/// The same of its turn, radians: a lock in two seconds at 5 m/s.
const TURN_CHANGE_RAD: f64 = 0.005;
/// Standard deviation of a frame's way to the side, metres: what a rear axle slips.
const SIDE_M: f64 = 0.02;

/// Motion without a look at the road.
#[derive(Debug)]
pub struct SteadyMotion {
    forward_m: Known,
    turn_rad: Known,
    /// Whether there was a frame before.
    is_under_way: bool,
    evidence: MotionEvidence,
}

/// A number and its variance.
#[derive(Debug, Clone, Copy)]
struct Known {
    mean: f64,
    variance: f64,
}

impl Known {
    const fn new(mean: f64, sigma: f64) -> Self {
        Self { mean, variance: sigma * sigma }
    }

    fn take(&mut self, seen: f64, variance: f64) {
        let gain = self.variance / (self.variance + variance.max(f64::MIN_POSITIVE));
        self.mean += gain * (seen - self.mean);
        self.variance *= 1.0 - gain;
    }

    /// A frame later; never less sure than at first.
    fn drift(&mut self, sigma: f64, first_sigma: f64) {
        self.variance = (self.variance + sigma * sigma).min(first_sigma * first_sigma);
    }
}

impl Default for SteadyMotion {
    fn default() -> Self {
        Self {
            forward_m: Known::new(FIRST_STEP_M, FIRST_STEP_M),
            turn_rad: Known::new(0.0, FIRST_TURN_RAD),
            is_under_way: false,
            evidence: MotionEvidence::default(),
        }
    }
}

impl MotionEstimator for SteadyMotion {
    fn estimate(
        &mut self,
        _view: &GroundView,
        _picture: &GroundPicture,
        _attitude: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
        if !std::mem::replace(&mut self.is_under_way, true) {
            return Ok(None);
        }
        self.forward_m.drift(STEP_CHANGE_M, FIRST_STEP_M);
        self.turn_rad.drift(TURN_CHANGE_RAD, FIRST_TURN_RAD);
        let variances = Vector3::new(self.forward_m.variance, SIDE_M * SIDE_M, self.turn_rad.variance);
        let motion = Motion {
            previous_from_current: Isometry2::new(Vector2::new(self.forward_m.mean, 0.0), self.turn_rad.mean),
            covariance: Matrix3::from_diagonal(&variances),
            quality: 0.0,
        };
        Ok(Some((motion.into(), &self.evidence)))
    }

    fn learn(&mut self, step: &FeatureStep) {
        self.forward_m.take(step.previous_from_current.translation.x, step.variances[0]);
        self.turn_rad.take(step.previous_from_current.rotation.angle(), step.variances[1]);
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}

//! The Kalman filter of the mount's angles.

use fingerpost_geometry::wrap_angle;
use nalgebra::{Matrix2, Vector2};

use super::fault::{AngleWatch, RollJump};
use super::{MountAngle, MountConfig, MountContradiction, MountEstimate, MountFault, MountState};
use crate::attitude::{AttitudeObservation, ObservedAngle};
use crate::motion::Motion;

/// Least standard deviation of a change of the pitch: what a single pair of frames makes of a few corners.
const CHANGE_FLOOR_RAD: f64 = 0.06 * DEGREE;
/// Frames over which the suspension swings back to its rest: a second or two at ten frames a second, which covers braking
/// as well as the body's own bounce.
const SUSPENSION_FRAMES: f64 = 15.0;
/// Frames in which the drift of the configuration is counted.
const DRIFT_FRAMES: f64 = 100.0;
/// Least standard deviation of an observed angle that is believed: waves of the road turn the direction of driving by so
/// much, and stay for many frames.
const OBSERVED_FLOOR_RAD: f64 = 0.3 * DEGREE;
/// Observations that differ by more standard deviations say nothing of a slow change.
const GATE_SIGMAS: f64 = 3.0;
/// So many observations outside the gate in a row show a change that is too small for a fault and too fast for a drift.
const REJECTED_FRAMES: usize = 30;
/// Observations of pitch and yaw before the first estimate is valid: a second.
const LEAST_OBSERVATIONS: usize = 10;
/// A vehicle that turns faster in a frame leans, which the roll is not to be judged by.
const TURNING_RAD: f64 = 0.5 * DEGREE;
/// A calibration that is farther off than so many standard deviations, of what it may be off by (`mount.prior_sigma_deg`) and of
/// the estimate, cannot be true: of a thousand true ones one is.
const CONTRADICTION_SIGMAS: f64 = 3.29;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Mount angles over time: slow ones as random walks, the suspension's pitch as one that decays.
#[derive(Debug, Clone)]
pub struct MountFilter {
    config: MountConfig,
    /// Distance of the camera ahead of the rear axle, metres.
    camera_ahead_m: f64,
    pitch: PitchAndSuspension,
    yaw: SlowAngle,
    roll: SlowAngle,
    observations: usize,
    /// Pitch and yaw of the first of them.
    first_rad: [[f64; LEAST_OBSERVATIONS]; 2],
    state: MountState,
    fault: Option<MountFault>,
    watches: [AngleWatch; 3],
    roll_jump: RollJump,
}

/// Slow pitch and the suspension's.
#[derive(Debug, Clone, Copy)]
struct PitchAndSuspension {
    mean: Vector2<f64>,
    covariance: Matrix2<f64>,
    rejected: usize,
}

/// An angle that changes slowly.
#[derive(Debug, Clone, Copy)]
struct SlowAngle {
    mean_rad: f64,
    variance_rad2: f64,
    rejected: usize,
}

impl MountFilter {
    /// A filter that has seen nothing yet, of a camera `camera_ahead_m` metres ahead of the rear axle.
    #[must_use]
    pub fn new(config: &MountConfig, camera_ahead_m: f64) -> Self {
        let variance = (config.prior_sigma_deg * DEGREE).powi(2);
        Self {
            pitch: PitchAndSuspension::new(0.0, variance, (config.suspension_sigma_deg * DEGREE).powi(2)),
            yaw: SlowAngle::new(0.0, variance),
            roll: SlowAngle::new(0.0, variance),
            observations: 0,
            first_rad: [[0.0; LEAST_OBSERVATIONS]; 2],
            state: MountState::NotYetValid,
            fault: None,
            watches: [MountAngle::Pitch, MountAngle::Yaw, MountAngle::Roll]
                .map(|angle| AngleWatch::new(angle, config.moved_deg * DEGREE)),
            roll_jump: RollJump::new(config.moved_deg * DEGREE),
            config: config.clone(),
            camera_ahead_m,
        }
    }

    /// Takes in what a frame shows. Frames without motion say nothing of the mount and leave it as it was.
    pub fn observe(&mut self, observation: &AttitudeObservation, motion: &Motion) -> MountEstimate {
        self.drift(observation.pitch_change);
        let is_turning = motion.previous_from_current.rotation.angle().abs() > TURNING_RAD;
        let yaw = observation.yaw.and_then(|seen| self.off_curve(seen, motion));
        let differences = [
            observation.pitch.map(|seen| seen.angle_rad - self.pitch.mean[0]),
            yaw.map(|seen| wrap_angle(seen.angle_rad - self.yaw.mean_rad)),
            observation.roll.filter(|_| !is_turning).map(|seen| seen.angle_rad - self.roll.mean_rad),
        ];
        if let Some(seen) = observation.pitch {
            self.pitch.take(floored(seen));
        }
        if let Some(seen) = yaw {
            self.yaw.take(floored(seen));
        }
        if let Some(seen) = observation.roll {
            self.roll.take(floored(seen));
        }
        if let (Some(pitch), Some(yaw)) = (observation.pitch, yaw) {
            self.count([pitch.angle_rad, yaw.angle_rad]);
        }
        self.judge(differences, observation.roll_change, is_turning);
        self.estimate()
    }

    /// The yaw against the vehicle's own direction, from that against the camera's: ahead of the rear axle, which is where a
    /// vehicle does not slip sideways, a camera moves to the inside of a curve. None where the vehicle does not move on.
    fn off_curve(&self, seen: ObservedAngle, motion: &Motion) -> Option<ObservedAngle> {
        let Motion { previous_from_current, covariance, .. } = motion;
        let (forward_m, turn_rad) =
            (previous_from_current.translation.x, previous_from_current.rotation.angle());
        if forward_m <= 0.0 {
            return None;
        }
        // Against where the vehicle points at the end of the step, half of whose turn it moved less far round.
        let per_turn = self.camera_ahead_m / forward_m - 0.5;
        let variance_rad2 = seen.variance_rad2 + per_turn * per_turn * covariance[(2, 2)];
        Some(ObservedAngle { angle_rad: seen.angle_rad + per_turn * turn_rad, variance_rad2 })
    }

    /// Counts an observation of pitch and yaw. A false first one shuts the true ones out, because each seems surer than it
    /// is: when there are enough of them the estimate begins at their median instead.
    fn count(&mut self, angles_rad: [f64; 2]) {
        let index = self.observations;
        self.observations += 1;
        for (first, angle_rad) in self.first_rad.iter_mut().zip(angles_rad) {
            if let Some(first) = first.get_mut(index) {
                *first = angle_rad;
            }
        }
        if self.observations != LEAST_OBSERVATIONS {
            return;
        }
        let [pitch_rad, yaw_rad] = self.first_rad.map(|mut first| {
            first.sort_unstable_by(f64::total_cmp);
            first[LEAST_OBSERVATIONS / 2]
        });
        let variance = OBSERVED_FLOOR_RAD.powi(2);
        if (pitch_rad - self.pitch.mean[0]).abs() > OBSERVED_FLOOR_RAD {
            let suspension_variance = self.pitch.covariance[(1, 1)];
            self.pitch = PitchAndSuspension::new(pitch_rad, variance, suspension_variance);
        }
        if wrap_angle(yaw_rad - self.yaw.mean_rad).abs() > OBSERVED_FLOOR_RAD {
            self.yaw = SlowAngle::new(yaw_rad, variance);
        }
    }

    /// The estimate after the last frame.
    #[must_use]
    pub fn estimate(&self) -> MountEstimate {
        let PitchAndSuspension { mean, covariance, .. } = &self.pitch;
        MountEstimate {
            pitch_rad: mean[0],
            yaw_rad: self.yaw.mean_rad,
            roll_rad: self.roll.mean_rad,
            suspension_pitch_rad: mean[1],
            sigma_rad: [
                covariance[(0, 0)],
                self.yaw.variance_rad2,
                self.roll.variance_rad2,
                covariance[(1, 1)],
            ]
            .map(f64::sqrt),
            state: self.state,
            fault: self.fault,
            contradiction: self.contradiction(),
        }
    }

    /// Pitch or yaw of the calibration that a valid estimate contradicts. The roll is not judged: a crowned road looks
    /// rolled.
    fn contradiction(&self) -> Option<MountContradiction> {
        let prior = (self.config.prior_sigma_deg * DEGREE).powi(2);
        let pitch = (MountAngle::Pitch, self.pitch.mean[0], self.pitch.covariance[(0, 0)]);
        let yaw = (MountAngle::Yaw, wrap_angle(self.yaw.mean_rad), self.yaw.variance_rad2);
        let contradicted = [pitch, yaw].into_iter().filter_map(|(angle, by_rad, variance)| {
            let most_rad = CONTRADICTION_SIGMAS * (prior + variance).sqrt();
            (by_rad.abs() > most_rad).then_some(MountContradiction { angle, by_rad, most_rad })
        });
        contradicted
            .max_by(|a, b| a.by_rad.abs().total_cmp(&b.by_rad.abs()))
            .filter(|_| self.state == MountState::Valid)
    }

    /// What a frame's time does: the slow angles become less sure, the suspension moves as seen or swings back.
    fn drift(&mut self, pitch_change: Option<ObservedAngle>) {
        let drift = (self.config.drift_sigma_deg * DEGREE).powi(2) / DRIFT_FRAMES;
        self.yaw.variance_rad2 += drift;
        self.roll.variance_rad2 += drift;
        let rest = (self.config.suspension_sigma_deg * DEGREE).powi(2);
        let keep = libm::exp(-1.0 / SUSPENSION_FRAMES);
        let PitchAndSuspension { mean, covariance, .. } = &mut self.pitch;
        let (change, noise) = match pitch_change {
            Some(seen) => (seen.angle_rad, seen.variance_rad2.max(CHANGE_FLOOR_RAD.powi(2))),
            None => (0.0, (1.0 - keep * keep) * rest),
        };
        mean[1] = keep * mean[1] + change;
        covariance[(0, 0)] += drift;
        covariance[(0, 1)] *= keep;
        covariance[(1, 0)] *= keep;
        covariance[(1, 1)] = keep * keep * covariance[(1, 1)] + noise;
    }

    /// Whether the estimate is valid, and whether the camera has been moved.
    fn judge(&mut self, differences: [Option<f64>; 3], roll_change: Option<ObservedAngle>, is_turning: bool) {
        if let Some(fault) = &mut self.fault {
            fault.frames_since += 1;
        }
        let sigma = self.config.valid_sigma_deg * DEGREE;
        let is_known = self.pitch.covariance[(0, 0)].sqrt() < sigma && self.yaw.variance_rad2.sqrt() < sigma;
        if self.state != MountState::Valid {
            if is_known && self.observations >= LEAST_OBSERVATIONS {
                self.state = MountState::Valid;
                self.fault = None;
            }
            return;
        }
        let by_angle = self
            .watches
            .iter_mut()
            .zip(differences)
            .filter_map(|(watch, difference)| difference.and_then(|difference| watch.add(difference)));
        let jumped = self.roll_jump.add(roll_change.map_or(0.0, |seen| seen.angle_rad), is_turning);
        let clearest = by_angle.chain(jumped).max_by(|a, b| a.by_rad.abs().total_cmp(&b.by_rad.abs()));
        if let Some(fault) = clearest {
            self.restart(fault);
        }
    }

    /// Begins anew after the camera has been moved.
    fn restart(&mut self, fault: MountFault) {
        let Self { config, camera_ahead_m, pitch, yaw, roll, .. } = &*self;
        let mut begun = Self::new(config, *camera_ahead_m);
        begun.pitch.mean[0] = pitch.mean[0];
        begun.yaw.mean_rad = yaw.mean_rad;
        begun.roll.mean_rad = roll.mean_rad;
        match fault.angle {
            MountAngle::Pitch => begun.pitch.mean[0] += fault.by_rad,
            MountAngle::Yaw => begun.yaw.mean_rad += fault.by_rad,
            MountAngle::Roll => begun.roll.mean_rad += fault.by_rad,
        }
        begun.state = MountState::Moved;
        begun.fault = Some(fault);
        *self = begun;
    }
}

impl PitchAndSuspension {
    fn new(pitch_rad: f64, variance: f64, suspension_variance: f64) -> Self {
        Self {
            mean: Vector2::new(pitch_rad, 0.0),
            covariance: Matrix2::new(variance, 0.0, 0.0, suspension_variance),
            rejected: 0,
        }
    }

    /// Takes in a pitch that is the sum of both.
    fn take(&mut self, seen: ObservedAngle) {
        let toward = self.covariance * Vector2::new(1.0, 1.0);
        let variance = toward.sum() + seen.variance_rad2;
        let difference = seen.angle_rad - self.mean.sum();
        if is_outside(difference, variance, &mut self.rejected) {
            return;
        }
        if self.rejected > REJECTED_FRAMES {
            self.rejected = 0;
            self.covariance[(0, 0)] += difference * difference;
            return self.take(seen);
        }
        let gain = toward / variance;
        self.mean += gain * difference;
        self.covariance -= gain * toward.transpose();
    }
}

impl SlowAngle {
    fn new(mean_rad: f64, variance_rad2: f64) -> Self {
        Self { mean_rad, variance_rad2, rejected: 0 }
    }

    fn take(&mut self, seen: ObservedAngle) {
        let variance = self.variance_rad2 + seen.variance_rad2;
        let difference = wrap_angle(seen.angle_rad - self.mean_rad);
        if is_outside(difference, variance, &mut self.rejected) {
            return;
        }
        if self.rejected > REJECTED_FRAMES {
            self.rejected = 0;
            self.variance_rad2 += difference * difference;
            return self.take(seen);
        }
        let gain = self.variance_rad2 / variance;
        self.mean_rad += gain * difference;
        self.variance_rad2 *= 1.0 - gain;
    }
}

/// Whether an observation is to be left out; counts those that are, until there are too many of them.
fn is_outside(difference: f64, variance: f64, rejected: &mut usize) -> bool {
    if difference.abs() <= GATE_SIGMAS * variance.sqrt() {
        *rejected = 0;
        return false;
    }
    *rejected += 1;
    *rejected <= REJECTED_FRAMES
}

fn floored(seen: ObservedAngle) -> ObservedAngle {
    ObservedAngle { variance_rad2: seen.variance_rad2.max(OBSERVED_FLOOR_RAD.powi(2)), ..seen }
}

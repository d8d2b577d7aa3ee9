//! Speed, yaw rate and turn signal: from the vehicle's own bus where it can be believed, else from the camera.
//!
//! Paper 3 takes the yaw rate from the vehicle's data bus and silences its warnings while the driver signals (sections III-B
//! and II). A bus can be unplugged, late, or read by the wrong database, so that every sample is judged before it is
//! used: its age, what a vehicle can do at all, how fast its value can change, and what the camera sees of the motion, for a
//! while and over the metres driven and the turns taken. A signal that fails is replaced by the camera's own estimate, and
//! the evidence says so. Nothing replaces a turn signal: without it the state is [`TurnSignal::Unknown`].
//!
//! Limits: a constant bias of the yaw rate (half a degree a second is usual) is not found, nor is a small scale error:
//! of the speed below a fifth, which the camera's own height may explain, of the yaw rate below two fifths.

mod agreement;
mod config;
mod gate;

pub use agreement::Disagreement;
pub use config::{CanConfig, PositiveYaw, SignalValue, SpeedUnit, YawRateUnit};
pub use fingerpost_control::{TurnSignal, VehicleState};

use self::agreement::AgreementLimits;
use self::gate::{Gate, Limits};
use crate::motion::Motion;

/// Quality from which the camera's motion is believed; below it, an estimate often fits half of what it sees.
const MIN_MOTION_QUALITY: f64 = 0.3;
/// How far a speed may differ from the camera's without contradicting it: metres a second, and as a share of the larger.
/// Camera heights are known to a few percent, tyres to as much, and a picture of wet road may be a quarter off for a moment.
const SPEED_TOLERANCE: (f64, f64) = (1.5, 0.3);
/// The same for yaw rates, radians a second: six degrees and half.
const YAW_RATE_TOLERANCE: (f64, f64) = (0.1, 0.5);
/// A change of speed that is no jump however soon it comes, m/s: coarse signals have steps.
const SPEED_STEP_MPS: f64 = 0.5;
/// The same for yaw rates, radians a second: two degrees.
const YAW_RATE_STEP_RPS: f64 = 0.035;

/// A signal's newest value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T> {
    /// The value.
    pub value: T,
    /// How long before the frame it came, seconds.
    pub age_s: f64,
}

/// The newest values of the vehicle's signals; none of those that have not come yet.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VehicleSamples {
    /// Yaw rate, radians a second, positive to the left.
    pub yaw_rate_rps: Option<Sample<f64>>,
    /// Speed, metres a second, positive forward.
    pub speed_mps: Option<Sample<f64>>,
    /// Turn signal.
    pub turn_signal: Option<Sample<TurnSignal>>,
}

impl VehicleSamples {
    /// Speed and yaw rate that were measured at this moment, where one of them was.
    pub fn of_now(speed_mps: Option<f64>, yaw_rate_rps: Option<f64>) -> Option<Self> {
        let sample = |value: f64| Sample { value, age_s: 0.0 };
        let samples = Self {
            speed_mps: speed_mps.map(sample),
            yaw_rate_rps: yaw_rate_rps.map(sample),
            turn_signal: None,
        };
        (samples != Self::default()).then_some(samples)
    }
}

/// Where a value comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum SignalSource {
    /// It is not known.
    #[default]
    Nowhere,
    /// The vehicle's bus.
    Can,
    /// The camera's own motion.
    Camera,
}

/// Why a signal of the bus was not used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NotUsed {
    /// None has come yet.
    Missing,
    /// The newest is too old.
    Late {
        /// Its age, seconds.
        age_s: f64,
    },
    /// No number, none that a vehicle reaches, or no value of the turn signal.
    OutOfRange,
    /// It has changed faster than a vehicle can.
    Jump,
    /// It has said something else than the camera for long.
    ContradictsCamera,
    /// Over what has been driven it does not agree with the camera: [`Disagreement`].
    DisagreesWithCamera,
}

impl NotUsed {
    /// The reason in a word or two, as it stands in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Late { .. } => "late",
            Self::OutOfRange => "out_of_range",
            Self::Jump => "jump",
            Self::ContradictsCamera => "contradicts_camera",
            Self::DisagreesWithCamera => "disagrees_with_camera",
        }
    }
}

/// Where one value came from and why the bus was not believed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SignalUse {
    /// Where it came from.
    pub source: SignalSource,
    /// Why the bus's value was not used; none where it was used.
    pub not_used: Option<NotUsed>,
}

/// How the state was found.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SignalsEvidence {
    /// Of the speed.
    pub speed: SignalUse,
    /// Of the yaw rate.
    pub yaw_rate: SignalUse,
    /// Of the turn signal.
    pub turn_signal: SignalUse,
    /// Where the bus's speed and the camera's do not agree: metres driven by either.
    pub speed_disagreement: Option<Disagreement>,
    /// Where the bus's yaw rate and the camera's do not agree: radians turned by either.
    pub yaw_rate_disagreement: Option<Disagreement>,
}

/// What a frame says.
#[derive(Debug, Clone, Copy, Default)]
pub struct SignalsInput<'a> {
    /// Newest values of the bus; none without a bus.
    pub samples: Option<VehicleSamples>,
    /// The camera's own motion since the frame before.
    pub motion: Option<&'a Motion>,
    /// Seconds since the frame before.
    pub dt_s: Option<f64>,
}

/// The stage with its state.
#[derive(Debug, Clone)]
pub struct VehicleSignals {
    turn_signal_max_age_s: f64,
    speed: Gate,
    yaw_rate: Gate,
}

impl VehicleSignals {
    /// Nothing is known yet.
    pub fn new(config: &CanConfig) -> Self {
        let speed = Limits {
            max_age_s: config.max_age_s,
            max: config.max_speed_mps,
            max_change_per_s: config.max_acceleration_mps2,
            step: SPEED_STEP_MPS,
            tolerance: SPEED_TOLERANCE,
            contradiction_s: config.contradiction_s,
            agreement: AgreementLimits::SPEED,
        };
        let yaw_rate = Limits {
            max: config.max_yaw_rate_deg_per_s.to_radians(),
            max_change_per_s: config.max_yaw_acceleration_deg_per_s2.to_radians(),
            step: YAW_RATE_STEP_RPS,
            tolerance: YAW_RATE_TOLERANCE,
            agreement: AgreementLimits::YAW_RATE,
            ..speed
        };
        Self {
            turn_signal_max_age_s: config.turn_signal_max_age_s,
            speed: Gate::new(speed),
            yaw_rate: Gate::new(yaw_rate),
        }
    }

    /// What is known of the vehicle when a frame is taken, and how.
    pub fn step(&mut self, input: SignalsInput<'_>) -> (VehicleState, SignalsEvidence) {
        let dt_s = input.dt_s.filter(|dt_s| dt_s.is_finite() && *dt_s > 0.0);
        let motion = input.motion.filter(|motion| motion.quality >= MIN_MOTION_QUALITY);
        let (camera_mps, camera_rps) = motion
            .zip(dt_s)
            .map(|(motion, dt_s)| {
                let pose = &motion.previous_from_current;
                (pose.translation.x / dt_s, pose.rotation.angle() / dt_s)
            })
            .unzip();
        let dt_s = dt_s.unwrap_or_default();
        let samples = input.samples.unwrap_or_default();
        let (speed_mps, speed) = self.speed.choose(samples.speed_mps, camera_mps, dt_s);
        let (yaw_rate_rps, yaw_rate) = self.yaw_rate.choose(samples.yaw_rate_rps, camera_rps, dt_s);
        let (turn_signal, signal_use) = self.turn_signal(samples.turn_signal);
        let state = VehicleState { speed_mps, yaw_rate_rps, turn_signal };
        let evidence = SignalsEvidence {
            speed,
            yaw_rate,
            turn_signal: signal_use,
            speed_disagreement: self.speed.disagreement(),
            yaw_rate_disagreement: self.yaw_rate.disagreement(),
        };
        (state, evidence)
    }

    fn turn_signal(&self, sample: Option<Sample<TurnSignal>>) -> (TurnSignal, SignalUse) {
        let not_used = match sample {
            None => NotUsed::Missing,
            Some(Sample { age_s, .. }) if gate::is_late(age_s, self.turn_signal_max_age_s) => {
                NotUsed::Late { age_s }
            }
            Some(Sample { value: TurnSignal::Unknown, .. }) => NotUsed::OutOfRange,
            Some(Sample { value, .. }) => {
                return (value, SignalUse { source: SignalSource::Can, not_used: None });
            }
        };
        (TurnSignal::Unknown, SignalUse { source: SignalSource::Nowhere, not_used: Some(not_used) })
    }
}

#[cfg(test)]
mod bus_faults;
#[cfg(test)]
mod tests;

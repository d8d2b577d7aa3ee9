//! Which signals of the bus mean what.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Unit of a yaw rate on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum YawRateUnit {
    /// Degrees a second.
    #[default]
    DegPerS,
    /// Radians a second.
    RadPerS,
}

impl YawRateUnit {
    /// Radians a second in one unit.
    pub const fn rps(self) -> f64 {
        match self {
            Self::DegPerS => 1_f64.to_radians(),
            Self::RadPerS => 1.0,
        }
    }
}

/// The side to which a positive yaw rate turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PositiveYaw {
    /// To the left, anticlockwise from above.
    #[default]
    Left,
    /// To the right.
    Right,
}

impl PositiveYaw {
    /// 1 to the left, -1 to the right.
    pub const fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// Unit of a speed on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpeedUnit {
    /// Metres a second.
    MPerS,
    /// Kilometres an hour.
    #[default]
    KmPerH,
    /// Miles an hour.
    MilesPerH,
}

impl SpeedUnit {
    /// Metres a second in one unit.
    pub const fn mps(self) -> f64 {
        match self {
            Self::MPerS => 1.0,
            Self::KmPerH => 1.0 / 3.6,
            Self::MilesPerH => 0.44704,
        }
    }
}

/// A value of a signal: a number, or what the DBC file's value table calls it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SignalValue {
    /// As scaled by the DBC file.
    Number(f64),
    /// By its name in the value table, in capitals or not.
    Name(String),
}

/// Signals of the vehicle's bus, named `MESSAGE.SIGNAL` as in the DBC file, and what is believed of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CanConfig {
    /// Only frames of this interface are read, such as "can0"; by default those of all.
    pub interface: Option<String>,
    /// When the log's first line came, seconds after the drive's first frame; negative where the log began earlier. A
    /// live bus needs none.
    #[schemars(range(min = -100000.0, max = 100000.0))]
    pub time_offset_s: f64,
    /// Signal with the yaw rate.
    pub yaw_rate: Option<String>,
    /// Its unit.
    pub yaw_rate_unit: YawRateUnit,
    /// The side to which a positive yaw rate turns.
    pub yaw_rate_positive: PositiveYaw,
    /// Signal with the speed.
    pub speed: Option<String>,
    /// Its unit.
    pub speed_unit: SpeedUnit,
    /// Signal with the turn signal.
    pub turn_signal: Option<String>,
    /// Its value while the driver signals to the left, a number or a name of the value table.
    pub turn_signal_left: SignalValue,
    /// Its value to the right.
    pub turn_signal_right: SignalValue,
    /// Its value while the driver does not signal.
    pub turn_signal_off: SignalValue,
    /// Oldest speed and yaw rate that are used, seconds.
    #[schemars(range(min = 0.01, max = 60.0))]
    pub max_age_s: f64,
    /// Oldest turn signal that is used, seconds: many buses tell it when it changes and seldom else.
    #[schemars(range(min = 0.01, max = 600.0))]
    pub turn_signal_max_age_s: f64,
    /// Highest speed that is believed, m/s.
    #[schemars(range(min = 1.0, max = 200.0))]
    pub max_speed_mps: f64,
    /// Fastest change of speed that is believed, m/s².
    #[schemars(range(min = 1.0, max = 200.0))]
    pub max_acceleration_mps2: f64,
    /// Highest yaw rate that is believed, degrees a second.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub max_yaw_rate_deg_per_s: f64,
    /// Fastest change of the yaw rate that is believed, degrees/s².
    #[schemars(range(min = 1.0, max = 10000.0))]
    pub max_yaw_acceleration_deg_per_s2: f64,
    /// How long a signal may contradict what the camera sees of the motion until the camera is believed, seconds.
    #[schemars(range(min = 0.1, max = 600.0))]
    pub contradiction_s: f64,
}

impl Default for CanConfig {
    fn default() -> Self {
        Self {
            interface: None,
            time_offset_s: 0.0,
            yaw_rate: None,
            yaw_rate_unit: YawRateUnit::default(),
            yaw_rate_positive: PositiveYaw::default(),
            speed: None,
            speed_unit: SpeedUnit::default(),
            turn_signal: None,
            turn_signal_left: SignalValue::Name("left".to_owned()),
            turn_signal_right: SignalValue::Name("right".to_owned()),
            turn_signal_off: SignalValue::Name("none".to_owned()),
            max_age_s: 0.5,
            turn_signal_max_age_s: 10.0,
            max_speed_mps: 90.0,
            max_acceleration_mps2: 20.0,
            max_yaw_rate_deg_per_s: 120.0,
            max_yaw_acceleration_deg_per_s2: 400.0,
            contradiction_s: 2.0,
        }
    }
}

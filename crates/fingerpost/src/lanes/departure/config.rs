//! Settings of the departure warning.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::{ConfigError, check_ranges};

/// When a departure is warned of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DepartureConfig {
    /// Front axle ahead of the rear one, metres, 0.3 to 10; default 2.7.
    pub front_axle_m: f64,
    /// Speed from which departures are warned of, m/s, 0 to 100; default 10.
    pub min_speed_mps: f64,
    /// Slowest drift that is warned of, m/s across the lane, 0.01 to 2; default 0.05.
    pub min_drift_mps: f64,
    /// How long before a wheel reaches the edge the warning comes, seconds, -1 to 3; default 0.
    pub lead_s: f64,
    /// How long a turn signal is still taken as the driver's intent when it has ended, seconds, 0 to 60; default 3.
    pub signal_hold_s: f64,
    /// How long a vehicle that has crossed an edge must keep between two until it is warned again, seconds, 0 to 60;
    /// default 1.
    pub settle_s: f64,
    /// How far a wheel must be back inside for a warning to end, metres, 0 to 1; default 0.1.
    pub hysteresis_m: f64,
    /// Least time between two warnings, seconds, 0 to 60; default 3.
    pub cool_down_s: f64,
    /// How far off a lane's edge is seen, one standard deviation, metres, 0.005 to 1; default 0.05.
    pub offset_sigma_m: f64,
    /// How far off its direction is seen, one standard deviation, degrees, 0.02 to 10; default 0.3.
    pub heading_sigma_deg: f64,
}

impl Default for DepartureConfig {
    fn default() -> Self {
        Self {
            front_axle_m: 2.7,
            min_speed_mps: 10.0,
            min_drift_mps: 0.05,
            lead_s: 0.0,
            signal_hold_s: 3.0,
            settle_s: 1.0,
            hysteresis_m: 0.1,
            cool_down_s: 3.0,
            offset_sigma_m: 0.05,
            heading_sigma_deg: 0.3,
        }
    }
}

impl DepartureConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`ConfigError`] names the first key out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(&[
            ("lanes.departure.front_axle_m", self.front_axle_m, 0.3, 10.0, "0.3 to 10 metres"),
            ("lanes.departure.min_speed_mps", self.min_speed_mps, 0.0, 100.0, "0 to 100 m/s"),
            ("lanes.departure.min_drift_mps", self.min_drift_mps, 0.01, 2.0, "0.01 to 2 m/s"),
            ("lanes.departure.lead_s", self.lead_s, -1.0, 3.0, "-1 to 3 seconds"),
            ("lanes.departure.signal_hold_s", self.signal_hold_s, 0.0, 60.0, "0 to 60 seconds"),
            ("lanes.departure.settle_s", self.settle_s, 0.0, 60.0, "0 to 60 seconds"),
            ("lanes.departure.hysteresis_m", self.hysteresis_m, 0.0, 1.0, "0 to 1 metre"),
            ("lanes.departure.cool_down_s", self.cool_down_s, 0.0, 60.0, "0 to 60 seconds"),
            ("lanes.departure.offset_sigma_m", self.offset_sigma_m, 0.005, 1.0, "0.005 to 1 metre"),
            ("lanes.departure.heading_sigma_deg", self.heading_sigma_deg, 0.02, 10.0, "0.02 to 10 degrees"),
        ])
    }
}

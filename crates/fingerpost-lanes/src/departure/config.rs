//! Settings of the departure warning.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When a departure is warned of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DepartureConfig {
    /// Front axle ahead of the rear one, metres.
    #[schemars(range(min = 0.3, max = 10.0))]
    pub front_axle_m: f64,
    /// Speed from which departures are warned of, m/s.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub min_speed_mps: f64,
    /// Slowest drift that is warned of, m/s across the lane.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub min_drift_mps: f64,
    /// How long before a wheel reaches the edge the warning comes, seconds.
    #[schemars(range(min = -1.0, max = 3.0))]
    pub lead_s: f64,
    /// How long a turn signal is still taken as the driver's intent when it has ended, seconds.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub signal_hold_s: f64,
    /// How long a vehicle that has crossed an edge must keep between two until it is warned again, seconds.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub settle_s: f64,
    /// How far a wheel must be back inside for a warning to end, metres.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub hysteresis_m: f64,
    /// Least time between two warnings, seconds.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub cool_down_s: f64,
    /// How far off a lane's edge is seen, one standard deviation, metres.
    #[schemars(range(min = 0.005, max = 1.0))]
    pub offset_sigma_m: f64,
    /// How far off its direction is seen, one standard deviation, degrees.
    #[schemars(range(min = 0.02, max = 10.0))]
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

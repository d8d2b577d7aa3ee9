//! Settings of the progress along the route.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of the progress along the route.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RouteProgressConfig {
    /// Standard deviation of a start given by hand, metres.
    #[schemars(range(min = 0.1, max = 10000.0))]
    pub start_sigma_m: f64,
    /// Standard deviation of dead reckoning, share of the distance driven.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drift_share: f64,
    /// Standard deviation of a GPS position along the road, metres.
    #[schemars(range(min = 0.1, max = 10000.0))]
    pub gps_sigma_m: f64,
    /// A GPS position farther than this from the route is not believed, metres.
    #[schemars(range(min = 1.0, max = 10000.0))]
    pub gps_gate_m: f64,
}

impl Default for RouteProgressConfig {
    fn default() -> Self {
        Self { start_sigma_m: 3.0, drift_share: 0.03, gps_sigma_m: 6.0, gps_gate_m: 40.0 }
    }
}

//! Settings of search and tracking.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of search and tracking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackConfig {
    /// Probability that a feature is there from which it is tracked.
    #[schemars(range(min = 0.5, max = 1.0))]
    pub detect_present: f64,
    /// Probability below which a tracked feature is lost; at most `detect_present`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lost_present: f64,
    /// Standard deviation of its place up to which a feature is tracked, metres: the record says how well it is known.
    #[schemars(range(min = 0.1, max = 10.0))]
    pub detect_sigma_m: f64,
    /// Standard deviation of an arm's width against the map's, share of it.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub width_sigma_share: f64,
    /// Radius of the kerbs where roads meet, metres: within them a road's edge is not its own.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub kerb_radius_m: f64,
}

impl Default for TrackConfig {
    fn default() -> Self {
        Self {
            detect_present: 0.8,
            lost_present: 0.5,
            detect_sigma_m: 2.5,
            width_sigma_share: 0.35,
            kerb_radius_m: 4.0,
        }
    }
}

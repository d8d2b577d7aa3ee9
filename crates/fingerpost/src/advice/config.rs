//! Settings of the advice.

use fingerpost_control::{ControllerName, VehicleLimits};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::vehicle::VehicleConfig;

/// How the vehicle is advised to drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AdviceConfig {
    /// Who steers.
    pub controller: ControllerName,
    /// Highest speed, m/s.
    #[schemars(range(min = 0.1, max = 70.0))]
    pub speed_mps: f64,
    /// Largest acceleration to the side in bends, m/s².
    #[schemars(range(min = 0.1, max = 10.0))]
    pub lateral_acceleration_mps2: f64,
    /// Deceleration with which the vehicle stops within what it sees, m/s².
    #[schemars(range(min = 0.1, max = 10.0))]
    pub deceleration_mps2: f64,
    /// Time until it begins to brake, seconds.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub reaction_s: f64,
    /// Distance ahead that controllers look at, as driving time, seconds.
    #[schemars(range(min = 0.1, max = 10.0))]
    pub look_ahead_s: f64,
    /// The same at the least, metres.
    #[schemars(range(min = 0.5, max = 50.0))]
    pub look_ahead_min_m: f64,
    /// Text of the fuzzy controller's rules; the shipped ones, which `fingerpost schema --rules` prints, where it is left out.
    pub rules: Option<String>,
}

impl Default for AdviceConfig {
    fn default() -> Self {
        let limits = VehicleLimits::default();
        Self {
            controller: ControllerName::default(),
            speed_mps: limits.speed_max_mps,
            lateral_acceleration_mps2: limits.lateral_acceleration_mps2,
            deceleration_mps2: limits.deceleration_mps2,
            reaction_s: limits.reaction_s,
            look_ahead_s: limits.look_ahead_s,
            look_ahead_min_m: limits.look_ahead_min_m,
            rules: None,
        }
    }
}

impl AdviceConfig {
    /// The limits of a vehicle that is driven like this.
    pub fn limits(&self, vehicle: &VehicleConfig) -> VehicleLimits {
        VehicleLimits {
            wheelbase_m: vehicle.wheelbase_m,
            turning_radius_m: vehicle.turning_radius_m,
            steering_rate_radps: vehicle.steering_rate_deg_per_s.to_radians(),
            steering_lag_s: vehicle.steering_lag_s,
            lateral_acceleration_mps2: self.lateral_acceleration_mps2,
            clearance_m: vehicle.margin_m,
            deceleration_mps2: self.deceleration_mps2,
            reaction_s: self.reaction_s,
            speed_max_mps: self.speed_mps,
            look_ahead_s: self.look_ahead_s,
            look_ahead_min_m: self.look_ahead_min_m,
        }
    }
}

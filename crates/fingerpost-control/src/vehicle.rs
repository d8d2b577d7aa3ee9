//! The vehicle that is guided: its size, how tightly it turns, and its side of the road.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Side of the road that the vehicle keeps to on two-way roads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Traffic {
    /// Left-hand traffic.
    Left,
    /// Right-hand traffic.
    #[default]
    Right,
    /// The middle of a single-lane road, as in the papers.
    Centre,
}

/// Least width of a lane, metres: below 2.75 m lanes are laid out for cars only (RASt 06, section 6.1.1; residential roads of
/// 5.5 m have two of it).
const LEAST_LANE_M: f64 = 2.75;

impl Traffic {
    /// How far left of a road's middle the papers' curve is laid, as a share of the road's width.
    pub const fn left_share(self) -> f64 {
        match self {
            Self::Left => 0.25,
            Self::Right => -0.25,
            Self::Centre => 0.0,
        }
    }

    /// How far left of a road's middle the vehicle's lane is, metres, on a two-way road of this width: the middle of its half, or
    /// of the outermost of the lanes for which the half has room.
    pub fn lane_left_m(self, road_width_m: f64) -> f64 {
        let half_m = 0.5 * road_width_m.max(0.0);
        let lanes = (half_m / LEAST_LANE_M).floor().max(1.0);
        let outermost_m = half_m * (1.0 - 0.5 / lanes);
        match self {
            Self::Left => outermost_m,
            Self::Right => -outermost_m,
            Self::Centre => 0.0,
        }
    }
}

/// Size and manners of the vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct VehicleConfig {
    /// Width of the body, metres.
    #[schemars(range(min = 0.3, max = 6.0))]
    pub width_m: f64,
    /// Room that the driving line keeps on either side of the body, metres.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub margin_m: f64,
    /// Radius of the tightest path of the rear axle's middle, metres.
    #[schemars(range(min = 0.5, max = 50.0))]
    pub turning_radius_m: f64,
    /// Distance between the axles, metres.
    #[schemars(range(min = 0.2, max = 20.0))]
    pub wheelbase_m: f64,
    /// How fast the front wheels can be turned, degrees a second.
    #[schemars(range(min = 1.0, max = 360.0))]
    pub steering_rate_deg_per_s: f64,
    /// Time from a steering angle that is asked for to the wheels having it, seconds.
    #[schemars(range(min = 0.0, max = 3.0))]
    pub steering_lag_s: f64,
    /// Side of the road that the vehicle keeps to.
    pub traffic: Traffic,
}

impl Default for VehicleConfig {
    fn default() -> Self {
        Self {
            width_m: 1.8,
            margin_m: 0.1,
            turning_radius_m: 5.0,
            wheelbase_m: 2.7,
            // 0.4 rad/s: M. Althoff, M. Koschi and S. Manzinger, "CommonRoad", 2017, vehicle models.
            steering_rate_deg_per_s: 23.0,
            steering_lag_s: 0.2,
            traffic: Traffic::Right,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_road_has_a_lane_along_its_edge() {
        // One lane a side; 7 m a side have room for two of 3.5 m.
        for (width_m, lane_m) in [(4.0, 1.0), (6.0, 1.5), (8.0, 2.0), (14.0, 5.25)] {
            assert!((Traffic::Left.lane_left_m(width_m) - lane_m).abs() < 1e-9, "{width_m}");
            assert!((Traffic::Right.lane_left_m(width_m) + lane_m).abs() < 1e-9, "{width_m}");
            assert!(Traffic::Centre.lane_left_m(width_m).abs() < 1e-9);
        }
    }
}

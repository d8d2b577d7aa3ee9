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

impl Traffic {
    /// How far left of a road's middle the vehicle drives, as a share of the road's width.
    pub const fn left_share(self) -> f64 {
        match self {
            Self::Left => 0.25,
            Self::Right => -0.25,
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
    /// Side of the road that the vehicle keeps to.
    pub traffic: Traffic,
}

impl Default for VehicleConfig {
    fn default() -> Self {
        Self { width_m: 1.8, margin_m: 0.1, turning_radius_m: 5.0, traffic: Traffic::Right }
    }
}

//! The road's middle and the direction to steer in, as `frames.jsonl` has them.

use serde::{Deserialize, Serialize};

/// The road's middle near the vehicle, and the direction to steer in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CentrelineRecord {
    /// How far the middle lies to the left of the rear axle's middle, metres.
    pub offset_m: f64,
    /// Standard deviation of the offset, metres; none in records that do not tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma_m: Option<f64>,
    /// The road's direction against the vehicle's, radians.
    pub heading_rad: f64,
    /// Its curvature there, 1/m, positive to the left; none in records that do not tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curvature_per_m: Option<f64>,
    /// The road's width, metres; none in records that do not tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
    /// Advised steering direction, radians, positive to the left.
    pub steer_rad: f64,
    /// Standard deviation of the steering direction, radians; none in records that do not tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steer_sigma_rad: Option<f64>,
    /// What it goes by: `road`, the surface ahead, or `driving_line`, the line through the route's feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steer_by: Option<String>,
    /// How probable the ways are on which the road goes on, 0 to 1; none where the driving line says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ways: Option<WaysRecord>,
}

/// Which way the road goes on, by its surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WaysRecord {
    /// Probability of a corner to the left.
    pub left: f64,
    /// Probability that it goes on along its curve.
    pub on: f64,
    /// Probability of a corner to the right.
    pub right: f64,
}

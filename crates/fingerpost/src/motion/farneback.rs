//! Settings of the motion from Farneback's dense flow, the papers' own way (paper 1, section VI).
//!
//! They are a part of every configuration; the estimator is `fingerpost_papers::FarnebackMotion`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of the motion from Farneback's flow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FarnebackMotionConfig {
    /// What is taken from the flow.
    pub model: FlowModel,
    /// Width of the region, metres.
    #[schemars(range(min = 1.0, max = 20.0))]
    pub region_width_m: f64,
    /// Length of the region, metres.
    #[schemars(range(min = 1.0, max = 20.0))]
    pub region_length_m: f64,
    /// Size of a level of the pyramid against the one below.
    #[schemars(range(min = 0.1, max = 0.95))]
    pub pyramid_scale: f64,
    /// Levels above the full size.
    #[schemars(range(min = 0, max = 8))]
    pub levels: usize,
    /// Side of the averaging window, pixels; odd.
    #[schemars(range(min = 3, max = 101))]
    pub window_px: usize,
    /// Iterations at each level.
    #[schemars(range(min = 1, max = 20))]
    pub iterations: usize,
    /// Pixels to either side in the polynomial expansion.
    #[schemars(range(min = 1, max = 15))]
    pub poly_n_px: usize,
    /// Standard deviation of the expansion's weights, pixels.
    #[schemars(range(min = 0.1, max = 15.0))]
    pub poly_sigma_px: f64,
}

/// What is taken from the flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FlowModel {
    /// Translation and rotation of the road plane, robustly.
    Rigid,
    /// The mean flow: translation alone (paper 1, VI).
    Mean,
}

impl Default for FarnebackMotionConfig {
    fn default() -> Self {
        Self {
            model: FlowModel::Rigid,
            // 128 pixels of the default ground view.
            region_width_m: 6.4,
            region_length_m: 6.4,
            pyramid_scale: 0.5,
            levels: 3,
            window_px: 15,
            iterations: 3,
            poly_n_px: 5,
            poly_sigma_px: 1.2,
        }
    }
}

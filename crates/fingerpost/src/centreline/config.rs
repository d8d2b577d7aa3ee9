//! Settings of the centreline.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the road's middle is found from its surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CentrelineConfig {
    /// Whether it is looked for.
    pub enabled: bool,
    /// Length of the window, metres from the nearest place seen ahead.
    #[schemars(range(min = 2.0, max = 60.0))]
    pub length_m: f64,
    /// Length of a section, in which the road's edges are straight, metres.
    #[schemars(range(min = 1.0, max = 20.0))]
    pub section_m: f64,
    /// Lower threshold of the probability's edges, levels of the Sobel gradient; a step from no road to road reads
    /// 1020.
    #[schemars(range(min = 0.0, max = 2000.0), extend("x-unit" = "levels of the Sobel gradient"))]
    pub edge_low: f64,
    /// Upper threshold, likewise; no less than the lower one.
    #[schemars(range(min = 0.0, max = 2000.0), extend("x-unit" = "levels of the Sobel gradient"))]
    pub edge_high: f64,
    /// Share of a section's rows that a line must have edges in.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub min_line_share: f64,
    /// How much the probability must fall across a line.
    #[schemars(range(min = 0.02, max = 1.0))]
    pub min_contrast: f64,
    /// How far an edge may point away from the vehicle's direction, or from the section before, degrees.
    #[schemars(range(min = 1.0, max = 60.0))]
    pub max_heading_deg: f64,
    /// Narrowest road, metres.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub min_width_m: f64,
    /// Widest road, metres.
    #[schemars(range(min = 1.0, max = 60.0))]
    pub max_width_m: f64,
    /// How far ahead the steering direction aims, metres.
    #[schemars(range(min = 1.0, max = 60.0))]
    pub look_ahead_m: f64,
}

impl Default for CentrelineConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            length_m: 12.0,
            section_m: 2.4,
            edge_low: 60.0,
            edge_high: 160.0,
            min_line_share: 0.35,
            min_contrast: 0.2,
            max_heading_deg: 30.0,
            min_width_m: 2.0,
            max_width_m: 16.0,
            look_ahead_m: 8.0,
        }
    }
}

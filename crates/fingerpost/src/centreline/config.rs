//! Settings of the centreline.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::{ConfigError, check_ranges};

/// How the road's middle is found from its surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CentrelineConfig {
    /// Whether it is looked for; default true.
    pub enabled: bool,
    /// Length of the window, metres from the nearest place seen ahead, 2 to 60; default 12.
    pub length_m: f64,
    /// Length of a section, in which the road's edges are straight, metres, 1 to 20; default 2.4.
    pub section_m: f64,
    /// Lower threshold of the probability's edges, levels of the Sobel gradient, 0 to 2000; a step from no road to road
    /// reads 1020; default 60.
    pub edge_low: f64,
    /// Upper threshold, likewise, at least the lower one; default 160.
    pub edge_high: f64,
    /// Share of a section's rows that a line must have edges in, 0.1 to 1; default 0.35.
    pub min_line_share: f64,
    /// How much the probability must fall across a line, 0.02 to 1; default 0.2.
    pub min_contrast: f64,
    /// How far an edge may point away from the vehicle's direction, or from the section before, degrees, 1 to 60;
    /// default 30.
    pub max_heading_deg: f64,
    /// Narrowest road, metres, 0.5 to 20; default 2.
    pub min_width_m: f64,
    /// Widest road, metres, 1 to 60; default 16.
    pub max_width_m: f64,
    /// How far ahead the steering direction aims, metres, 1 to 60; default 8.
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

impl CentrelineConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`ConfigError`] names the first key out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(&[
            ("centreline.length_m", self.length_m, 2.0, 60.0, "2 to 60 metres"),
            ("centreline.section_m", self.section_m, 1.0, 20.0, "1 to 20 metres"),
            ("centreline.edge_low", self.edge_low, 0.0, 2000.0, "0 to 2000 levels"),
            (
                "centreline.edge_high",
                self.edge_high,
                self.edge_low,
                2000.0,
                "centreline.edge_low to 2000 levels",
            ),
            ("centreline.min_line_share", self.min_line_share, 0.1, 1.0, "a share, 0.1 to 1"),
            ("centreline.min_contrast", self.min_contrast, 0.02, 1.0, "0.02 to 1"),
            ("centreline.max_heading_deg", self.max_heading_deg, 1.0, 60.0, "1 to 60 degrees"),
            ("centreline.min_width_m", self.min_width_m, 0.5, 20.0, "0.5 to 20 metres"),
            ("centreline.max_width_m", self.max_width_m, 1.0, 60.0, "1 to 60 metres"),
            ("centreline.look_ahead_m", self.look_ahead_m, 1.0, 60.0, "1 to 60 metres"),
        ])
    }
}

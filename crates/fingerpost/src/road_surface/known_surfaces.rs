//! Known surfaces: what the road has looked like, which of it is under way, and its name.
//!
//! Paper 2, section 7.4. Every surface that the road has had is kept as a histogram of brightness and tint
//! (`known_surfaces/tones.rs`), learned on the drive or read from a file. A sample that is like none of them founds a new surface
//! when that lasts some frames of straight driving: in a turn the region straight ahead may lie on the verge. There are at most so
//! many; the surface that has not been met for longest gives way.
//!
//! By default they name the surface under way and no more. The papers' detector by known surfaces is
//! `fingerpost_papers::Bank`.
//!
//! Limits: brightness depends on the camera's exposure: a surface in another light is another surface.

mod known;
mod surface_memory;
mod tones;

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use known::{SurfaceFile, SurfaceRecord, SurfacesError};
pub use surface_memory::SurfaceMemory;

/// Settings of the bank of known surfaces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BankConfig {
    /// Surfaces that are kept at the most.
    #[schemars(range(min = 1, max = 64))]
    pub surfaces: usize,
    /// Likeness (Bhattacharyya coefficient) from which a sample is of a known surface.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_likeness: f64,
    /// Frames of straight driving over which a sample must be like no known surface before it founds a new one.
    #[schemars(range(min = 1, max = 1000))]
    pub patience_frames: usize,
    /// Curvature of the vehicle's way from which it counts as turning, 1/m.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub turning_per_m: f64,
    /// Frames in the rolling mean (paper 1, IV-B).
    #[schemars(range(min = 1, max = 1000))]
    pub frames: usize,
    /// Share of the picture expected to be road.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub prior: f64,
    /// What a surface counts that has not been met for long.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub stale_weight: f64,
    /// Frames since a surface was met after which it has come half way to that.
    #[schemars(range(min = 1.0, max = 1000000000.0))]
    pub stale_frames: f64,
    /// Radius of the disc of the back-projection, pixels; 0 for none.
    #[schemars(range(min = 0, max = 32))]
    pub disc_radius_px: u16,
}

impl Default for BankConfig {
    fn default() -> Self {
        Self {
            surfaces: 8,
            min_likeness: 0.6,
            patience_frames: 4,
            // A radius of 25 m.
            turning_per_m: 0.04,
            frames: 5,
            prior: 0.8,
            stale_weight: 0.7,
            stale_frames: 100.0,
            disc_radius_px: 2,
        }
    }
}

/// Which surface is under way, by the bank.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BankEvidence {
    /// The known surface that the sample is most like; none where nothing is known or seen.
    pub surface: Option<Arc<str>>,
    /// How like it is, 0 to 1.
    pub likeness: f64,
    /// Surfaces known.
    pub surfaces: usize,
    /// Whether this frame founded a new one.
    pub founded: bool,
    /// Share of the picture that some surface gives a probability of at least a half, and the share of that at which the one
    /// under way gives the largest; 0 where the bank only names the surface.
    pub road_share: f64,
    /// See `road_share`.
    pub won_share: f64,
}

//! How far about a prediction places are tried.

use super::candidates::MIN_LEFT_REACH_M;
use super::{PoseFilter, TrackConfig};

/// How far about a prediction poses are tried.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    pub(super) forward_m: f64,
    pub(super) left_m: f64,
    pub(super) heading_rad: f64,
}

impl Reach {
    /// As the settings say.
    pub const fn of(config: &TrackConfig) -> Self {
        Self {
            forward_m: config.bracket_forward_m,
            left_m: config.bracket_left_m,
            heading_rad: config.bracket_heading_deg.to_radians(),
        }
    }

    /// At least as the settings say, and as far as the prediction may be off: within the view, across no more than a road.
    pub fn covering(config: &TrackConfig, predicted: &PoseFilter, view_m: f64) -> Self {
        let Self { forward_m, left_m, heading_rad } = Self::of(config);
        let off = predicted.covariance().diagonal().map(|variance| 3.0 * variance.sqrt());
        Self {
            forward_m: forward_m.max(off.x.min(view_m)),
            left_m: left_m.max(off.y.min(MIN_LEFT_REACH_M)),
            heading_rad: heading_rad.max(off.z.min(config.search_heading_deg.to_radians())),
        }
    }
}

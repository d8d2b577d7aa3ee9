//! Settings of search and tracking.

use fingerpost_geometry::GeometryError;
use fingerpost_map::Route;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{AlignmentConfig, BeliefTracker, Directions, FeatureTracker, Tracker, TrackerSetting};

/// Settings of search and tracking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackConfig {
    /// How features are found and followed.
    pub method: TrackMethod,
    /// P(F) from which a feature counts as seen.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub detect_threshold: f64,
    /// P(F) that is enough where the arms that distinguish the feature stand out from their verges; at most
    /// `detect_threshold`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub detect_threshold_at_verge: f64,
    /// Contrast with the verge that is enough for detection in `detect_frames` frames: with less it takes longer, and
    /// half of it or less is none.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub detect_contrast: f64,
    /// P(F) from which a tracked feature counts as confirmed; at most `detect_threshold`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub confirm_threshold: f64,
    /// Frames in a row in which a feature must be seen to be tracked.
    #[schemars(range(min = 1, max = 100))]
    pub detect_frames: usize,
    /// Standard deviation of its distance up to which a feature is tracked, metres, in a ground view to 20 m. Pitch moves a place by
    /// the square of its distance, so a view that reaches farther asks for more by that square.
    #[schemars(range(min = 0.1, max = 100.0))]
    pub detect_sigma_m: f64,
    /// Frames in a row without confirmation after which a tracked feature is lost.
    #[schemars(range(min = 1, max = 1000))]
    pub lost_frames: usize,
    /// Step of the search along the road, metres.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub search_forward_step_m: f64,
    /// Step of the search across the road, metres.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub search_left_step_m: f64,
    /// How far the vehicle's heading may differ from the road's in the search, degrees.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub search_heading_deg: f64,
    /// Step of the search over headings, degrees.
    #[schemars(range(min = 0.2, max = 45.0))]
    pub search_heading_step_deg: f64,
    /// Reach of the bracketing search along the road, metres.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub bracket_forward_m: f64,
    /// Reach of the bracketing search across the road, metres.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub bracket_left_m: f64,
    /// Reach of the bracketing search over headings, degrees.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub bracket_heading_deg: f64,
    /// How the place of a matched feature is made precise.
    pub alignment: AlignmentConfig,
    /// What the method "belief" asks of a feature.
    pub belief: BeliefConfig,
}

/// How features are found and followed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrackMethod {
    /// By the match of the masks ([`Tracker`]).
    #[default]
    Rules,
    /// By the probability of every place and of none ([`BeliefTracker`]).
    Belief,
}

/// Settings of [`BeliefTracker`], which also takes `track.alignment.kerb_radius_m`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BeliefConfig {
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
}

impl TrackConfig {
    /// The tracker of these settings at the start of `route`, or without one.
    ///
    /// # Errors
    /// [`GeometryError`] when a feature's arms have no extent.
    pub fn tracker(
        &self,
        setting: TrackerSetting<'_>,
        route: Option<&Route>,
        start_m: Option<f64>,
    ) -> Result<Box<dyn FeatureTracker>, GeometryError> {
        Ok(match self.method {
            // Of a single feature there is no doubt which is next.
            TrackMethod::Rules
                if start_m.is_none() && route.is_some_and(|route| route.features.len() > 1) =>
            {
                Box::new(Directions::new(setting, route)?)
            }
            TrackMethod::Rules => Box::new(Tracker::new(setting, route, start_m)?),
            TrackMethod::Belief => Box::new(BeliefTracker::new(setting, route, start_m)?),
        })
    }
}

impl Default for BeliefConfig {
    fn default() -> Self {
        Self { detect_present: 0.8, lost_present: 0.5, detect_sigma_m: 2.5, width_sigma_share: 0.35 }
    }
}

impl Default for TrackConfig {
    fn default() -> Self {
        Self {
            method: TrackMethod::default(),
            detect_threshold: 0.75,
            detect_threshold_at_verge: 0.5,
            detect_contrast: 0.12,
            confirm_threshold: 0.65,
            detect_frames: 3,
            detect_sigma_m: 0.45,
            lost_frames: 10,
            search_forward_step_m: 0.5,
            search_left_step_m: 0.4,
            search_heading_deg: 6.0,
            search_heading_step_deg: 2.0,
            bracket_forward_m: 2.0,
            bracket_left_m: 1.0,
            bracket_heading_deg: 6.0,
            alignment: AlignmentConfig::default(),
            belief: BeliefConfig::default(),
        }
    }
}

impl TrackConfig {
    /// The least P(F) that confirms a tracked feature with this contrast.
    pub(super) fn confirming_p(&self, contrast: Option<f64>) -> f64 {
        let stands_out = contrast.is_some_and(|contrast| contrast >= self.detect_contrast);
        if stands_out {
            self.detect_threshold_at_verge.min(self.confirm_threshold)
        } else {
            self.confirm_threshold
        }
    }

    /// Whether a tracked feature with this P(F) and contrast counts as confirmed.
    pub(super) fn confirms(&self, p: f64, contrast: Option<f64>) -> bool {
        p >= self.confirming_p(contrast)
    }
}

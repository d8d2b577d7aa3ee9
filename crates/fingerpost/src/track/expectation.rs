//! Where a feature is expected before the picture is looked at.
//!
//! Places look alike, so a search weighs what it sees against where the feature ought to be: by the distance driven since
//! the last one, or by its own motion once it is followed. A place three standard deviations off is believed when it stands
//! out clearly more than one that is where it should be.

use nalgebra::Isometry2;

use super::PoseFilter;
use crate::feature_model::FeatureModel;

/// What a place loses in rank for each unit of its surprise (half its squared distance in standard deviations): a third
/// of what tells a road from its verge, at three standard deviations.
const RANK_OF_SURPRISE: f64 = 0.05;
/// A prediction is never surer than this: metres, metres, radians.
const PREDICTED_SIGMAS: [f64; 3] = [0.5, 0.4, 0.05];

/// A distance at which the next feature may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedAhead {
    /// Along the approach to its node, metres.
    pub ahead_m: f64,
    /// Standard deviation, metres.
    pub sigma_m: f64,
}

/// Where a feature is expected.
#[derive(Debug, Clone, Copy)]
pub enum Expectation<'a> {
    /// Anywhere.
    Anywhere,
    /// On its approach, at one of these distances.
    Ahead(&'a FeatureModel, &'a [ExpectedAhead]),
    /// Where it was, moved on.
    About(&'a PoseFilter),
}

impl Expectation<'_> {
    /// What a place loses in rank because the feature is not expected there.
    pub(super) fn penalty(&self, vehicle_from_feature: &Isometry2<f64>) -> f64 {
        let squared = match self {
            Self::Anywhere => 0.0,
            Self::Ahead(feature, expected) => {
                let before_m = feature.before_m(vehicle_from_feature);
                let squared = |at: &ExpectedAhead| ((before_m - at.ahead_m) / at.sigma_m).powi(2);
                expected.iter().map(squared).min_by(f64::total_cmp).unwrap_or(0.0)
            }
            Self::About(predicted) => {
                let off = vehicle_from_feature.translation.vector - predicted.pose().translation.vector;
                let turned = predicted.pose().rotation.angle_to(&vehicle_from_feature.rotation);
                let variance = predicted.covariance().diagonal();
                [off.x, off.y, turned]
                    .iter()
                    .zip(PREDICTED_SIGMAS)
                    .zip(&variance)
                    .map(|((off, least), variance)| off * off / variance.max(least * least))
                    .sum()
            }
        };
        0.5 * RANK_OF_SURPRISE * squared
    }
}

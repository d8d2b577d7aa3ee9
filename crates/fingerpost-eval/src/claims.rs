//! What a run claims of its features frame by frame, and how far that is from the truth.

use std::collections::BTreeMap;

use fingerpost_format::{CampaignGroup, FeatureRecord};

use crate::quantiles::{error_quantiles, median, sigma_quantiles};
use crate::{FALSE_BEYOND_M, RoadEdgeScores};

/// Probability of being there from which a claim counts as a confident one.
pub const CONFIDENT_FROM: f64 = 0.95;

/// The place of a followed feature in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Claim {
    /// Which feature of the route, counted from zero; none for one that the route does not have.
    pub place: Option<usize>,
    /// How it differs from the truth; none for a feature that is not there.
    pub error: Option<ClaimError>,
    /// How probable the run holds it that the feature is there, 0 to 1: what it says of that, or else its confidence.
    pub present: Option<f64>,
}

/// How a reported place differs from the true one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClaimError {
    /// Distance between them, metres.
    pub distance_m: f64,
    /// Difference forward and to the left by its standard deviation, unsigned.
    pub per_sigma: [f64; 2],
}

/// The distance of a feature by its first detection and by what was expected before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstDetection {
    /// By how much the detection is off, metres.
    pub detected_off_m: f64,
    /// By how much the expectation was, metres.
    pub expected_off_m: f64,
}

/// What a campaign keeps of a drive beside its summary.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DriveClaims {
    /// The places of followed features, frame by frame.
    pub claims: Vec<Claim>,
    /// First detections against what was expected.
    pub first_detections: Vec<FirstDetection>,
    /// The road's edges, frame by frame.
    pub road_edges: RoadEdgeScores,
}

impl ClaimError {
    /// The difference of a record from the true place, metres forward and left.
    pub(crate) fn new(feature: &FeatureRecord, [forward_m, left_m]: [f64; 2]) -> Self {
        let off_m = [feature.forward_m - forward_m, feature.left_m - left_m];
        let by_sigma = |axis: usize| (off_m[axis] / feature.sigma_m[axis]).abs();
        Self { distance_m: libm::hypot(off_m[0], off_m[1]), per_sigma: [by_sigma(0), by_sigma(1)] }
    }
}

impl Claim {
    fn is_confident(&self) -> bool {
        self.present.is_some_and(|present| present >= CONFIDENT_FROM)
    }

    fn is_off(&self) -> bool {
        self.error.is_none_or(|error| error.distance_m > FALSE_BEYOND_M)
    }
}

/// Writes what several drives claimed into their group.
pub(crate) fn summarise<'a>(group: &mut CampaignGroup, drives: impl Iterator<Item = &'a DriveClaims>) {
    let (mut errors_m, mut per_sigma) = (Vec::new(), Vec::new());
    let (mut feature_errors_m, mut feature_per_sigma) = (Vec::new(), Vec::new());
    let mut road_edges = RoadEdgeScores::default();
    for drive in drives {
        let mut of_feature: BTreeMap<usize, Vec<ClaimError>> = BTreeMap::new();
        for claim in &drive.claims {
            if claim.is_confident() {
                group.confident_frames += 1;
                group.confident_frames_off += u64::from(claim.is_off());
            }
            if let Some((place, error)) = claim.place.zip(claim.error) {
                of_feature.entry(place).or_default().push(error);
            }
        }
        for errors in of_feature.values() {
            feature_errors_m.extend(median(errors.iter().map(|error| error.distance_m)));
            for axis in [0, 1] {
                feature_per_sigma.extend(median(errors.iter().map(|error| error.per_sigma[axis])));
            }
            errors_m.extend(errors.iter().map(|error| error.distance_m));
            per_sigma.extend(errors.iter().flat_map(|error| error.per_sigma));
        }
        road_edges.extend(&drive.road_edges);
        for detection in &drive.first_detections {
            group.features_expected += 1;
            group.features_made_worse += u64::from(detection.detected_off_m > detection.expected_off_m);
        }
    }
    group.road_edges = road_edges.summary();
    group.position_error_m = error_quantiles(errors_m);
    group.error_per_sigma = sigma_quantiles(per_sigma);
    group.feature_error_m = error_quantiles(feature_errors_m);
    group.feature_error_per_sigma = sigma_quantiles(feature_per_sigma);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(place: usize, distance_m: f64, per_sigma: f64, present: f64) -> Claim {
        let error = ClaimError { distance_m, per_sigma: [per_sigma, 0.5 * per_sigma] };
        Claim { place: Some(place), error: Some(error), present: Some(present) }
    }

    #[test]
    fn a_feature_counts_once_however_long_it_is_followed() {
        let mut claims: Vec<Claim> = (0..99).map(|_| claim(0, 0.1, 0.5, 0.96)).collect();
        claims.extend([claim(1, 4.0, 8.0, 0.96), claim(1, 5.0, 9.0, 0.9)]);
        claims.push(Claim { place: Some(2), error: None, present: Some(0.96) });
        let first_detections = vec![
            FirstDetection { detected_off_m: 1.0, expected_off_m: 0.5 },
            FirstDetection { detected_off_m: 1.0, expected_off_m: 5.0 },
        ];
        let mut group = CampaignGroup::default();
        summarise(&mut group, [DriveClaims { claims, first_detections, ..DriveClaims::default() }].iter());
        assert!((group.position_error_m.unwrap().p95 - 0.1).abs() < 1e-9);
        let of_features = group.feature_error_m.unwrap();
        assert!(
            (of_features.p50 - 0.1).abs() < 1e-9 && (of_features.p95 - 4.0).abs() < 1e-9,
            "{of_features:?}"
        );
        let per_sigma = group.feature_error_per_sigma.unwrap();
        assert!((per_sigma.p68 - 4.0).abs() < 1e-9 && (per_sigma.max - 8.0).abs() < 1e-9, "{per_sigma:?}");
        assert_eq!((group.confident_frames, group.confident_frames_off), (101, 2));
        assert_eq!((group.features_expected, group.features_made_worse), (2, 1));
    }
}

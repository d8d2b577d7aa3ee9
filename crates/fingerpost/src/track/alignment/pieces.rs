//! The arms of a feature, cut into the pieces that are slid across their roads.

use std::sync::Arc;

use fingerpost_geometry::Polyline;
use nalgebra::{Point2, Vector2};

use super::AlignmentConfig;
use crate::feature_model::{ArmModel, FeatureModel};
use crate::kerbs::Kerbs;

/// Farthest piece of an arm from the node that is used, metres: beyond it arms bend away from the map.
const MAX_ALONG_M: f64 = 16.0;

/// An arm in pieces; cut once, because they stay the same in the feature's own frame.
#[derive(Debug)]
pub(in crate::track) struct ArmPieces {
    /// Label of the arm.
    pub(super) label: Arc<str>,
    /// Width of its road on the map, metres.
    pub(super) width_m: f64,
    /// Whether it leaves the line of the approach.
    pub(super) leaves_the_line: bool,
    /// The pieces, from its mouth outwards.
    pub(super) pieces: Vec<CutPiece>,
}

/// One piece of an arm, feature frame.
#[derive(Debug)]
pub(super) struct CutPiece {
    /// Its course outwards, metres.
    pub(super) course: Polyline,
    /// Its middle.
    pub(super) middle: Point2<f64>,
    /// Direction outwards at its middle, unit vector.
    pub(super) along: Vector2<f64>,
    /// Distance of its middle from the node along the arm, metres.
    pub(super) along_m: f64,
    /// How far the kerbs at its left and right stand back from the road's edge, metres; none where the edge is rather
    /// another road's.
    pub(super) flare_m: [Option<f64>; 2],
}

impl ArmPieces {
    /// The arms of `feature` in pieces.
    pub(in crate::track) fn of(config: &AlignmentConfig, feature: &FeatureModel) -> Vec<Self> {
        let cut = |arm: &ArmModel| Self {
            label: Arc::clone(&arm.label),
            width_m: arm.width_m,
            leaves_the_line: arm.leaves_the_line(),
            pieces: pieces(config, feature, arm),
        };
        feature.arms.iter().map(cut).collect()
    }
}

fn pieces(config: &AlignmentConfig, feature: &FeatureModel, arm: &ArmModel) -> Vec<CutPiece> {
    let kerbs = Kerbs::of(feature, arm, config.kerb_radius_m);
    let end_m = MAX_ALONG_M.min(arm.course.length_m());
    let mut pieces = Vec::new();
    let mut start_m = arm.mouth_m;
    while start_m + config.piece_length_m <= end_m {
        if let Ok(course) = arm.course.part(start_m, start_m + config.piece_length_m) {
            let (middle, along) = course.at(0.5 * course.length_m());
            let along_m = start_m + 0.5 * config.piece_length_m;
            let flare_m = [0, 1].map(|side| kerbs.flare_m(side, along_m));
            pieces.push(CutPiece { course, middle, along, along_m, flare_m });
        }
        start_m += config.piece_length_m;
    }
    pieces
}

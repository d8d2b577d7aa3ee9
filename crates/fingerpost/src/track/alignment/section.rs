//! Cross-sections: the edges of a road across one piece of an arm, and what became of them.

use std::sync::Arc;

use nalgebra::{Point2, Vector2};

use super::AlignmentConfig;
use super::pavement::RoadEdges;
use super::pieces::ArmPieces;

/// One piece of an arm, slid across its road.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSection {
    /// Label of the arm.
    pub label: Arc<str>,
    /// Middle of the piece where the arm was believed, vehicle frame, metres.
    pub p_in_vehicle: Point2<f64>,
    /// Left of the arm when one looks outwards along it, vehicle frame, unit vector.
    pub left: Vector2<f64>,
    /// Left and right edge of the road, metres to the left of the arm; none where an edge is not seen. Where a pavement may lie
    /// inside an edge, the mean of the two places.
    pub edges_m: [Option<f64>; 2],
    /// What is not known of them because a pavement may lie inside, standard deviations, metres.
    pub pavement_sigma_m: [f64; 2],
    /// Whether a line on the road shows the edge.
    pub by_line: [bool; 2],
    /// Whether the arm leaves the line of the approach.
    pub leaves_the_line: bool,
    /// What became of the measurement.
    pub section_use: CrossSectionUse,
}

/// What became of a cross-section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CrossSectionUse {
    /// It moved the feature.
    Accepted,
    /// No road, or no edge of it is seen.
    NoEdges,
    /// Every edge that is seen is still a kerb that curves into another arm.
    InTheMouth,
    /// The road there is not as wide as the map says.
    WidthDisagrees {
        /// Width measured, metres.
        width_m: f64,
        /// Width on the map, metres.
        map_width_m: f64,
    },
    /// It lies too far from where the feature can be.
    Gated {
        /// Distance in standard deviations.
        sigmas: f64,
    },
}

/// The cross-section with these edges, and whether they can be those of the arm's road.
pub(super) fn section(
    config: &AlignmentConfig,
    arm: &ArmPieces,
    p_in_vehicle: Point2<f64>,
    left: Vector2<f64>,
    RoadEdges { edges_m, pavement_sigma_m, by_line }: RoadEdges,
) -> CrossSection {
    let believed = config.min_width_share * arm.width_m..=arm.width_m + config.max_wider_m;
    let section_use = match edges_m {
        [None, None] => CrossSectionUse::NoEdges,
        [Some(left_m), Some(right_m)] if !believed.contains(&(left_m - right_m)) => {
            CrossSectionUse::WidthDisagrees { width_m: left_m - right_m, map_width_m: arm.width_m }
        }
        _ => CrossSectionUse::InTheMouth,
    };
    let (label, leaves_the_line) = (Arc::clone(&arm.label), arm.leaves_the_line);
    CrossSection {
        label,
        p_in_vehicle,
        left,
        edges_m,
        pavement_sigma_m,
        by_line,
        leaves_the_line,
        section_use,
    }
}

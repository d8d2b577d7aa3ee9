//! Alignment: where the road's middle really is under each arm.
//!
//! P(F) is flat while the narrow masks stay on the wide road, so the match alone leaves the place open by half a
//! road's width; paper 1, section V-C, suggests bracketing about the detected point. Here every arm is cut into short
//! pieces; each is slid across its road with the method's one primitive, and the two edges at which the probability
//! falls give the road's middle, its width, and how far the arm lies from it. An arm thus measures the feature's
//! place across itself, and arms at different angles fix it.
//!
//! Limits: a road whose edges are not seen, or which is far from as wide as the map says, measures nothing.

use fingerpost_geometry::Polyline;
use fingerpost_vision::span::{RowSums, SpanError, SpanMask};
use nalgebra::{Isometry2, Point2, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::pose_filter::{LineMeasurement, PoseFilter, Update};
use crate::feature_model::{ArmModel, FeatureModel};
use crate::matching::LaidSurface;

/// Settings of the alignment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AlignmentConfig {
    /// Length of a piece of an arm, metres, 0.5 to 10; default 3.
    pub piece_length_m: f64,
    /// Width of a piece, metres, 0.1 to 2; default 0.45.
    pub piece_width_m: f64,
    /// How far beyond the road's half width a piece is slid, metres; default 2.
    pub slide_beyond_m: f64,
    /// Step of the slide, metres; default 0.1.
    pub slide_step_m: f64,
    /// Probability that separates road from verge, 0 to 1; default 0.5.
    pub edge_probability: f64,
    /// Narrowest road believed, as a share of the map's width; default 0.55.
    pub min_width_share: f64,
    /// Widest road believed, as a share of the map's width; default 1.8.
    pub max_width_share: f64,
    /// Standard deviation of a road's middle between its edges, metres; default 0.2.
    pub sigma_m: f64,
    /// Standard deviation of the camera's pitch about its mount, degrees: far places are less sure; default 0.2.
    pub pitch_sigma_deg: f64,
}

impl Default for AlignmentConfig {
    fn default() -> Self {
        Self {
            piece_length_m: 3.0,
            piece_width_m: 0.45,
            slide_beyond_m: 2.0,
            slide_step_m: 0.1,
            edge_probability: 0.5,
            min_width_share: 0.55,
            max_width_share: 1.8,
            sigma_m: 0.2,
            pitch_sigma_deg: 0.2,
        }
    }
}

/// One piece of an arm, slid across its road.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSection {
    /// Label of the arm.
    pub label: String,
    /// Middle of the piece where the arm was believed, vehicle frame, metres.
    pub p_in_vehicle: Point2<f64>,
    /// Left of the arm when one looks outwards along it, vehicle frame, unit vector.
    pub left: Vector2<f64>,
    /// Left and right edge of the road, metres to the left of the arm; none where an edge is not seen.
    pub edges_m: Option<[f64; 2]>,
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
    /// No road, or no edge on one side.
    NoEdges,
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

/// Farthest piece of an arm from the node that is used, metres: beyond it arms bend away from the map.
const MAX_ALONG_M: f64 = 16.0;
/// Share of a piece that must be seen.
const MIN_SEEN_SHARE: f64 = 0.7;

/// Measures every arm of `feature` and moves `filter` accordingly; returns what was seen. The camera's height above
/// the road (metres) says how much a pitch error moves far places.
///
/// # Errors
/// [`SpanError`] when an arm cannot be drawn.
pub(super) fn align(
    config: &AlignmentConfig,
    camera_height_m: f64,
    laid: &LaidSurface<'_>,
    feature: &FeatureModel,
    filter: &mut PoseFilter,
) -> Result<Vec<CrossSection>, SpanError> {
    let mut sections = Vec::new();
    let mut measurements = Vec::new();
    let vehicle_from_feature = *filter.pose();
    for arm in &feature.arms {
        let first = sections.len();
        let mut along = arm.mouth_m;
        while along + config.piece_length_m <= MAX_ALONG_M.min(arm.course.length_m()) {
            if let Ok(piece) = arm.course.part(along, along + config.piece_length_m)
                && let Some((section, measurement)) =
                    measure(config, camera_height_m, laid, arm, &piece, &vehicle_from_feature)?
            {
                sections.push(section);
                measurements.push(measurement);
            }
            along += config.piece_length_m;
        }
        // Pieces of one arm share the errors of map and pitch: together they are worth little more than one.
        let bounded = measurements[first..].iter().flatten().count().max(1) as f64;
        measurements[first..].iter_mut().flatten().for_each(|m| m.sigma_m *= bounded.sqrt());
    }
    for (section, measurement) in sections.iter_mut().zip(&measurements) {
        let Some(measurement) = measurement else { continue };
        // Earlier sections have moved the filter: the innovation is against where it is now.
        let moved =
            filter.pose() * measurement.p_in_feature - vehicle_from_feature * measurement.p_in_feature;
        let innovation_m = measurement.innovation_m - measurement.normal.dot(&moved);
        match filter.update(&LineMeasurement { innovation_m, ..*measurement }) {
            Update::Accepted => section.section_use = CrossSectionUse::Accepted,
            Update::Gated(sigmas) => section.section_use = CrossSectionUse::Gated { sigmas },
        }
    }
    Ok(sections)
}

/// Slides one piece across its road; none when too little of it is seen.
fn measure(
    config: &AlignmentConfig,
    camera_height_m: f64,
    laid: &LaidSurface<'_>,
    arm: &ArmModel,
    piece: &Polyline,
    vehicle_from_feature: &Isometry2<f64>,
) -> Result<Option<(CrossSection, Option<LineMeasurement>)>, SpanError> {
    let grid = laid.grid();
    let piece_in_vehicle = piece.transformed(vehicle_from_feature);
    let (p_in_vehicle, along) = piece_in_vehicle.at(0.5 * piece.length_m());
    let left = Vector2::new(-along.y, along.x);
    let pixels: Vec<[f64; 2]> = piece_in_vehicle
        .points()
        .iter()
        .map(|&p| grid.ground_from_vehicle(p))
        .map(|pixel| [pixel.column, pixel.row])
        .collect();
    let mask = SpanMask::stroke(&pixels, config.piece_width_m / grid.metres_per_pixel())?;
    if laid.sums().cover(&mask, 0, 0).seen_share() < MIN_SEEN_SHARE {
        return Ok(None);
    }
    let reach = 0.5 * arm.width_m + config.slide_beyond_m;
    let profile = profile(config, laid.sums(), &mask, left / grid.metres_per_pixel(), reach);
    let mut section = CrossSection {
        label: arm.label.clone(),
        p_in_vehicle,
        left,
        edges_m: None,
        leaves_the_line: arm.leaves_the_line(),
        section_use: CrossSectionUse::NoEdges,
    };
    let Some([left_edge, right_edge]) = edges(&profile, config.edge_probability) else {
        return Ok(Some((section, None)));
    };
    section.edges_m = Some([left_edge, right_edge]);
    let width_m = left_edge - right_edge;
    if !(config.min_width_share * arm.width_m..=config.max_width_share * arm.width_m).contains(&width_m) {
        section.section_use = CrossSectionUse::WidthDisagrees { width_m, map_width_m: arm.width_m };
        return Ok(Some((section, None)));
    }
    let measurement = LineMeasurement {
        p_in_feature: vehicle_from_feature.inverse() * p_in_vehicle,
        normal: left,
        innovation_m: 0.5 * (left_edge + right_edge),
        sigma_m: sigma_m(config, camera_height_m, p_in_vehicle, left),
    };
    Ok(Some((section, Some(measurement))))
}

/// Standard deviation across a section, metres: a pitch error moves a place at distance x by x^2 / height.
fn sigma_m(
    config: &AlignmentConfig,
    camera_height_m: f64,
    p_in_vehicle: Point2<f64>,
    normal: Vector2<f64>,
) -> f64 {
    let pitch = config.pitch_sigma_deg.to_radians();
    let forward = p_in_vehicle.x * p_in_vehicle.x / camera_height_m * pitch;
    let sideways = p_in_vehicle.y * p_in_vehicle.x / camera_height_m * pitch;
    config.sigma_m.hypot(normal.x * forward + normal.y * sideways)
}

/// Mean probability under the piece against its shift to the left, metres; none where too little is seen.
fn profile(
    config: &AlignmentConfig,
    sums: &RowSums,
    mask: &SpanMask,
    left_px_per_m: Vector2<f64>,
    reach_m: f64,
) -> Vec<(f64, Option<f64>)> {
    let steps = (reach_m / config.slide_step_m).ceil() as i32;
    (-steps..=steps)
        .map(|k| {
            let shift_m = f64::from(k) * config.slide_step_m;
            // Left is smaller columns, forward smaller rows.
            let (column, row) = (-left_px_per_m.y * shift_m, -left_px_per_m.x * shift_m);
            let cover = sums.cover(mask, column.round() as i32, row.round() as i32);
            (shift_m, cover.probability().filter(|_| cover.seen_share() >= MIN_SEEN_SHARE))
        })
        .collect()
}

/// The stretch of the profile that is most road: the one with the largest sum of probability above the threshold.
/// Holes (markings, a shadow's rim) do not end it. None when it touches an end of what is seen.
fn edges(profile: &[(f64, Option<f64>)], edge_probability: f64) -> Option<[f64; 2]> {
    let seen =
        profile.iter().position(|(_, p)| p.is_some())?..=profile.iter().rposition(|(_, p)| p.is_some())?;
    let profile = &profile[seen];
    let (mut best, mut best_range, mut sum, mut start) = (0.0, None, 0.0, 0);
    for (i, (_, p)) in profile.iter().enumerate() {
        if sum <= 0.0 {
            (sum, start) = (0.0, i);
        }
        sum += p.unwrap_or(0.0) - edge_probability;
        if sum > best {
            (best, best_range) = (sum, Some((start, i)));
        }
    }
    let (first, last) = best_range?;
    if first == 0 || last + 1 == profile.len() {
        return None;
    }
    let crossing = |inside: usize, outside: usize| {
        let ((x_in, p_in), (x_out, p_out)) = (profile[inside], profile[outside]);
        let (p_in, p_out) = (p_in.unwrap_or(1.0), p_out.unwrap_or(0.0));
        let share =
            if p_in > p_out { ((p_in - edge_probability) / (p_in - p_out)).clamp(0.0, 1.0) } else { 0.5 };
        x_in + share * (x_out - x_in)
    };
    Some([crossing(last, last + 1), crossing(first, first - 1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_found_between_the_steps_and_over_holes() {
        let road = |x: f64| if (-2.05..2.95).contains(&x) && !(0.0..0.3).contains(&x) { 0.95 } else { 0.1 };
        let profile: Vec<_> = (-50..=50).map(|k| 0.1 * f64::from(k)).map(|x| (x, Some(road(x)))).collect();
        let [left, right] = edges(&profile, 0.5).unwrap();
        assert!((left - 2.95).abs() < 0.06 && (right + 2.05).abs() < 0.06, "{left} {right}");
    }

    #[test]
    fn a_plane_without_edges_measures_nothing() {
        let everywhere: Vec<_> = (-50..=50).map(|k| (0.1 * f64::from(k), Some(0.9))).collect();
        assert_eq!(edges(&everywhere, 0.5), None);
        let nowhere: Vec<_> = (-50..=50).map(|k| (0.1 * f64::from(k), Some(0.1))).collect();
        assert_eq!(edges(&nowhere, 0.5), None);
        let half_seen: Vec<_> = (-50..=50)
            .map(|k| (0.1 * f64::from(k), (k > -10).then_some(if k < 20 { 0.9 } else { 0.0 })))
            .collect();
        assert_eq!(edges(&half_seen, 0.5), None, "the right edge is outside the view");
    }
}

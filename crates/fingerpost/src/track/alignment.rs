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

use super::kerbs::Kerbs;
use super::pose_filter::{LineMeasurement, PoseFilter, Update};
use crate::feature_model::{ArmModel, FeatureModel};
use crate::matching::LaidSurface;

/// Settings of the alignment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AlignmentConfig {
    /// Length of a piece of an arm, metres, 0.5 to 10; default 1.5.
    pub piece_length_m: f64,
    /// Width of a piece, metres, 0.1 to 2; default 0.3.
    pub piece_width_m: f64,
    /// How far beyond the road's half width a piece is slid, metres; default 2.
    pub slide_beyond_m: f64,
    /// Step of the slide, metres; default 0.1.
    pub slide_step_m: f64,
    /// Probability that separates road from verge, 0 to 1; default 0.35.
    pub edge_probability: f64,
    /// Narrowest road believed, as a share of the map's width; default 0.55.
    pub min_width_share: f64,
    /// Widest road believed, as a share of the map's width; default 1.8.
    pub max_width_share: f64,
    /// Standard deviation of a road's middle between its edges, metres; default 0.2.
    pub sigma_m: f64,
    /// Standard deviation of a road's width against the map's, as a share of it: what a single edge says; default 0.08.
    pub width_sigma_share: f64,
    /// Radius of the kerbs where roads meet, metres: within them a road's edge is not its own; default 4.
    pub kerb_radius_m: f64,
    /// Standard deviation of the camera's pitch about its mount, degrees: far places are less sure; default 0.2.
    pub pitch_sigma_deg: f64,
}

impl Default for AlignmentConfig {
    fn default() -> Self {
        Self {
            piece_length_m: 1.5,
            piece_width_m: 0.3,
            slide_beyond_m: 2.0,
            slide_step_m: 0.1,
            edge_probability: 0.35,
            min_width_share: 0.55,
            max_width_share: 1.8,
            sigma_m: 0.2,
            width_sigma_share: 0.08,
            kerb_radius_m: 4.0,
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
    pub edges_m: [Option<f64>; 2],
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

/// Farthest piece of an arm from the node that is used, metres: beyond it arms bend away from the map.
const MAX_ALONG_M: f64 = 16.0;
/// Share of a piece that must be seen.
const MIN_SEEN_SHARE: f64 = 0.7;

/// Standard deviation of an edge within a piece, metres: what the direction of an arm is measured with.
const EDGE_SIGMA_M: f64 = 0.12;
/// Standard deviation of a width that was measured on the same arm, metres.
const MEASURED_WIDTH_SIGMA_M: f64 = 0.25;

/// One piece of an arm with what was measured on it.
struct Piece {
    section: CrossSection,
    /// Distance of its middle from the node along the arm, metres.
    along_m: f64,
    /// Edges without what the kerbs widen the road by, metres to the left of the arm.
    edges: [Option<Edge>; 2],
}

/// One edge of a road.
#[derive(Clone, Copy)]
struct Edge {
    left_m: f64,
    sigma_m: f64,
}

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
    let believed = *filter.pose();
    let mut sections = Vec::new();
    let mut lines = Vec::new();
    let mut headings = Vec::new();
    for arm in &feature.arms {
        let pieces = pieces(config, laid, feature, arm, &believed)?;
        headings.extend(heading(&pieces));
        let first = lines.len();
        let width = width(config, arm, &pieces);
        lines.extend(pieces.iter().map(|piece| line(config, camera_height_m, piece, width, &believed)));
        // Pieces of one arm share the errors of map and pitch: together they are worth little more than one.
        let used = lines[first..].iter().flatten().count().max(1) as f64;
        lines[first..]
            .iter_mut()
            .flatten()
            .for_each(|line: &mut LineMeasurement| line.sigma_m *= used.sqrt());
        sections.extend(pieces.into_iter().map(|piece| piece.section));
    }
    for (innovation_rad, sigma_rad) in headings {
        let turned = believed.rotation.angle_to(&filter.pose().rotation);
        filter.update_heading(innovation_rad - turned, sigma_rad);
    }
    for (section, line) in sections.iter_mut().zip(&lines) {
        let Some(line) = line else { continue };
        // Earlier measurements have moved the filter: the innovation is against where it is now.
        let moved = filter.pose() * line.p_in_feature - believed * line.p_in_feature;
        let innovation_m = line.innovation_m - line.normal.dot(&moved);
        match filter.update(&LineMeasurement { innovation_m, ..*line }) {
            Update::Accepted => section.section_use = CrossSectionUse::Accepted,
            Update::Gated(sigmas) => section.section_use = CrossSectionUse::Gated { sigmas },
        }
    }
    Ok(sections)
}

/// The pieces of an arm that are seen, from its mouth outwards.
fn pieces(
    config: &AlignmentConfig,
    laid: &LaidSurface<'_>,
    feature: &FeatureModel,
    arm: &ArmModel,
    vehicle_from_feature: &Isometry2<f64>,
) -> Result<Vec<Piece>, SpanError> {
    let kerbs = Kerbs::of(feature, arm, config.kerb_radius_m);
    let mut pieces = Vec::new();
    let mut start_m = arm.mouth_m;
    while start_m + config.piece_length_m <= MAX_ALONG_M.min(arm.course.length_m()) {
        if let Ok(course) = arm.course.part(start_m, start_m + config.piece_length_m)
            && let Some(section) = slide(config, laid, arm, &course.transformed(vehicle_from_feature))?
        {
            let along_m = start_m + 0.5 * config.piece_length_m;
            let believable = section.section_use == CrossSectionUse::InTheMouth;
            let edges = [0, 1].map(|side| {
                let measured_m = section.edges_m[side].filter(|_| believable)?;
                let flare_m = kerbs.flare_m(side, along_m)?;
                let outwards = if side == 0 { 1.0 } else { -1.0 };
                // The radius of a real kerb is anybody's guess within half.
                let sigma_m = EDGE_SIGMA_M.hypot(0.5 * flare_m);
                Some(Edge { left_m: measured_m - outwards * flare_m, sigma_m })
            });
            pieces.push(Piece { section, along_m, edges });
        }
        start_m += config.piece_length_m;
    }
    Ok(pieces)
}

/// Slides a piece, given in the vehicle frame, across its road; none when too little of it is seen.
fn slide(
    config: &AlignmentConfig,
    laid: &LaidSurface<'_>,
    arm: &ArmModel,
    course_in_vehicle: &Polyline,
) -> Result<Option<CrossSection>, SpanError> {
    let grid = laid.grid();
    let (p_in_vehicle, along) = course_in_vehicle.at(0.5 * course_in_vehicle.length_m());
    let left = Vector2::new(-along.y, along.x);
    let pixels: Vec<[f64; 2]> = course_in_vehicle
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
    let edges_m = edges(&profile, config.edge_probability);
    let believed = config.min_width_share * arm.width_m..=config.max_width_share * arm.width_m;
    let section_use = match edges_m {
        [None, None] => CrossSectionUse::NoEdges,
        [Some(left_m), Some(right_m)] if !believed.contains(&(left_m - right_m)) => {
            CrossSectionUse::WidthDisagrees { width_m: left_m - right_m, map_width_m: arm.width_m }
        }
        _ => CrossSectionUse::InTheMouth,
    };
    let (label, leaves_the_line) = (arm.label.clone(), arm.leaves_the_line());
    Ok(Some(CrossSection { label, p_in_vehicle, left, edges_m, leaves_the_line, section_use }))
}

/// The arm's width and its standard deviation, metres: measured where both edges are seen, else the map's.
fn width(config: &AlignmentConfig, arm: &ArmModel, pieces: &[Piece]) -> (f64, f64) {
    let measured: Vec<f64> = pieces
        .iter()
        .filter_map(|piece| match piece.edges {
            [Some(left), Some(right)] if left.is_sharp() && right.is_sharp() => {
                Some(left.left_m - right.left_m)
            }
            _ => None,
        })
        .collect();
    if measured.is_empty() {
        (arm.width_m, config.width_sigma_share * arm.width_m)
    } else {
        (measured.iter().sum::<f64>() / measured.len() as f64, MEASURED_WIDTH_SIGMA_M)
    }
}

impl Edge {
    /// Whether the edge is the road's own, not a kerb that curves.
    fn is_sharp(self) -> bool {
        self.sigma_m < 1.5 * EDGE_SIGMA_M
    }
}

/// How far the feature must turn for the arm to run along each of its edges, and the standard deviation, radians.
fn heading(pieces: &[Piece]) -> Option<(f64, f64)> {
    let side = |side: usize| {
        let sharp = |piece: &Piece| piece.edges[side].filter(|edge| edge.is_sharp());
        let mut seen = pieces.iter().filter_map(|piece| Some((piece.along_m, sharp(piece)?.left_m)));
        let first = seen.next()?;
        let last = seen.next_back()?;
        let length_m = last.0 - first.0;
        Some(((last.1 - first.1).atan2(length_m), 2_f64.sqrt() * EDGE_SIGMA_M / length_m))
    };
    match (side(0), side(1)) {
        (Some(left), Some(right)) => Some((0.5 * (left.0 + right.0), 0.5 * left.1.hypot(right.1))),
        (left, right) => left.or(right),
    }
}

/// The measurement of a piece: how far the road's middle lies from it.
fn line(
    config: &AlignmentConfig,
    camera_height_m: f64,
    piece: &Piece,
    (width_m, width_sigma_m): (f64, f64),
    vehicle_from_feature: &Isometry2<f64>,
) -> Option<LineMeasurement> {
    let (innovation_m, seen_sigma_m) = match piece.edges {
        [Some(left), Some(right)] => {
            (0.5 * (left.left_m + right.left_m), 0.5 * left.sigma_m.hypot(right.sigma_m))
        }
        [Some(edge), None] => (edge.left_m - 0.5 * width_m, edge.sigma_m.hypot(width_sigma_m)),
        [None, Some(edge)] => (edge.left_m + 0.5 * width_m, edge.sigma_m.hypot(width_sigma_m)),
        [None, None] => return None,
    };
    let own_sigma_m = config.sigma_m.hypot(seen_sigma_m);
    let CrossSection { p_in_vehicle, left, .. } = piece.section;
    Some(LineMeasurement {
        p_in_feature: vehicle_from_feature.inverse() * p_in_vehicle,
        normal: left,
        innovation_m,
        sigma_m: own_sigma_m.hypot(pitch_sigma_m(config, camera_height_m, p_in_vehicle, left)),
    })
}

/// Standard deviation across a section from the camera's pitch, metres: an error p moves a place at distance x by
/// p x^2 / height.
fn pitch_sigma_m(
    config: &AlignmentConfig,
    camera_height_m: f64,
    p_in_vehicle: Point2<f64>,
    normal: Vector2<f64>,
) -> f64 {
    let pitch = config.pitch_sigma_deg.to_radians();
    let forward = p_in_vehicle.x * p_in_vehicle.x / camera_height_m * pitch;
    let sideways = p_in_vehicle.y * p_in_vehicle.x / camera_height_m * pitch;
    (normal.x * forward + normal.y * sideways).abs()
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

/// The two ends, left and right, of the stretch of the profile that is most road: the one with the largest sum of
/// probability above the threshold. Holes (markings, a shadow's rim) do not end it. An end that is also the end of
/// what is seen is no edge.
fn edges(profile: &[(f64, Option<f64>)], edge_probability: f64) -> [Option<f64>; 2] {
    let (Some(start), Some(end)) =
        (profile.iter().position(|(_, p)| p.is_some()), profile.iter().rposition(|(_, p)| p.is_some()))
    else {
        return [None, None];
    };
    let profile = &profile[start..=end];
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
    let Some((first, last)) = best_range else { return [None, None] };
    let crossing = |inside: usize, outside: usize| {
        let ((x_in, p_in), (x_out, p_out)) = (profile[inside], profile[outside]);
        let (p_in, p_out) = (p_in.unwrap_or(1.0), p_out.unwrap_or(0.0));
        let share =
            if p_in > p_out { ((p_in - edge_probability) / (p_in - p_out)).clamp(0.0, 1.0) } else { 0.5 };
        x_in + share * (x_out - x_in)
    };
    let left = (last + 1 < profile.len()).then(|| crossing(last, last + 1));
    let right = (first > 0).then(|| crossing(first, first - 1));
    [left, right]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_found_between_the_steps_and_over_holes() {
        let road = |x: f64| if (-2.05..2.95).contains(&x) && !(0.0..0.3).contains(&x) { 0.95 } else { 0.1 };
        let profile: Vec<_> = (-50..=50).map(|k| 0.1 * f64::from(k)).map(|x| (x, Some(road(x)))).collect();
        let [Some(left), Some(right)] = edges(&profile, 0.5) else { panic!("both edges are there") };
        assert!((left - 2.95).abs() < 0.06 && (right + 2.05).abs() < 0.06, "{left} {right}");
    }

    #[test]
    fn a_plane_without_edges_measures_nothing() {
        let everywhere: Vec<_> = (-50..=50).map(|k| (0.1 * f64::from(k), Some(0.9))).collect();
        assert_eq!(edges(&everywhere, 0.5), [None, None]);
        let nowhere: Vec<_> = (-50..=50).map(|k| (0.1 * f64::from(k), Some(0.1))).collect();
        assert_eq!(edges(&nowhere, 0.5), [None, None]);
        let half_seen: Vec<_> = (-50..=50)
            .map(|k| (0.1 * f64::from(k), (k > -10).then_some(if k < 20 { 0.9 } else { 0.0 })))
            .collect();
        let [left, right] = edges(&half_seen, 0.5);
        assert!(
            left.is_some_and(|m| (m - 1.95).abs() < 0.06) && right.is_none(),
            "the right edge is out of view"
        );
    }
}

//! Cross-sections: a piece of an arm, slid across its road to find the road's edges.

use std::sync::Arc;

use fingerpost_vision::span::{RowSums, SpanError, SpanMask};
use nalgebra::{Isometry2, Point2, Vector2};

use super::AlignmentConfig;
use super::pieces::{ArmPieces, CutPiece};
use crate::matching::LaidSurface;

/// One piece of an arm, slid across its road.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSection {
    /// Label of the arm.
    pub label: Arc<str>,
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

/// Share of a piece that must be seen.
const MIN_SEEN_SHARE: f64 = 0.7;

/// Mean probability under a piece at a shift to the left, metres; none where too little is seen.
type Sample = (f64, Option<f64>);

/// Slides pieces across roads; its memory is reused from piece to piece.
#[derive(Debug)]
pub(super) struct Slide {
    config: AlignmentConfig,
    pixels: Vec<[f64; 2]>,
    mask: SpanMask,
    profile: Vec<Sample>,
}

impl Slide {
    /// A slide of pieces as wide as `config` says.
    pub(super) fn new(config: &AlignmentConfig) -> Self {
        let mask = SpanMask::default();
        Self { config: config.clone(), pixels: Vec::new(), mask, profile: Vec::new() }
    }

    /// Slides a piece of `arm` across its road; none when too little of it is seen.
    pub(super) fn across(
        &mut self,
        laid: &LaidSurface<'_>,
        arm: &ArmPieces,
        piece: &CutPiece,
        vehicle_from_feature: &Isometry2<f64>,
    ) -> Result<Option<CrossSection>, SpanError> {
        let (config, grid) = (&self.config, laid.grid());
        let along = vehicle_from_feature.rotation * piece.along;
        let left = Vector2::new(-along.y, along.x);
        self.pixels.clear();
        self.pixels.extend(piece.course.points().iter().map(|p_in_feature| {
            let pixel = grid.ground_from_vehicle(vehicle_from_feature * p_in_feature);
            [pixel.column, pixel.row]
        }));
        self.mask.redraw_stroke(&self.pixels, config.piece_width_m / grid.metres_per_pixel())?;
        if laid.sums().cover(&self.mask, 0, 0).seen_share() < MIN_SEEN_SHARE {
            return Ok(None);
        }
        let reach_m = 0.5 * arm.width_m + config.slide_beyond_m;
        let left_px_per_m = left / grid.metres_per_pixel();
        self.profile.clear();
        self.profile.extend(profile(config, laid.sums(), &self.mask, left_px_per_m, reach_m));
        let edges_m = edges(&self.profile, config.edge_probability);
        let believed = config.min_width_share * arm.width_m..=config.max_width_share * arm.width_m;
        let section_use = match edges_m {
            [None, None] => CrossSectionUse::NoEdges,
            [Some(left_m), Some(right_m)] if !believed.contains(&(left_m - right_m)) => {
                CrossSectionUse::WidthDisagrees { width_m: left_m - right_m, map_width_m: arm.width_m }
            }
            _ => CrossSectionUse::InTheMouth,
        };
        Ok(Some(CrossSection {
            label: Arc::clone(&arm.label),
            p_in_vehicle: vehicle_from_feature * piece.middle,
            left,
            edges_m,
            leaves_the_line: arm.leaves_the_line,
            section_use,
        }))
    }
}

/// What lies under the piece against its shift.
fn profile(
    config: &AlignmentConfig,
    sums: &RowSums,
    mask: &SpanMask,
    left_px_per_m: Vector2<f64>,
    reach_m: f64,
) -> impl Iterator<Item = Sample> {
    let steps = (reach_m / config.slide_step_m).ceil() as i32;
    (-steps..=steps).map(move |k| {
        let shift_m = f64::from(k) * config.slide_step_m;
        // Left is smaller columns, forward smaller rows.
        let (column, row) = (-left_px_per_m.y * shift_m, -left_px_per_m.x * shift_m);
        let cover = sums.cover(mask, column.round() as i32, row.round() as i32);
        (shift_m, cover.probability().filter(|_| cover.seen_share() >= MIN_SEEN_SHARE))
    })
}

/// The two ends, left and right, of the stretch of the profile that is most road: the one with the largest sum of
/// probability above the threshold. Holes (markings, a shadow's rim) do not end it. An end that is also the end of
/// what is seen is no edge.
fn edges(profile: &[Sample], edge_probability: f64) -> [Option<f64>; 2] {
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

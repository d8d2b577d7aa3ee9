//! Cross-sections: a piece of an arm, slid across its road to find the road's edges.

use std::sync::Arc;

use fingerpost_vision::span::{RowSums, SpanError, SpanMask};
use nalgebra::{Isometry2, Point2, Vector2};

use super::AlignmentConfig;
use super::pavement::{Pavements, RoadEdges, without_pavements};
use super::pieces::{ArmPieces, CutPiece};
use super::profile::{Profile, Sample};
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
    /// Left and right edge of the road, metres to the left of the arm; none where an edge is not seen. Where a pavement may lie
    /// inside an edge, the mean of the two places.
    pub edges_m: [Option<f64>; 2],
    /// What is not known of them because a pavement may lie inside, standard deviations, metres.
    pub pavement_sigma_m: [f64; 2],
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
/// Length on either side of an edge over which the probability is compared, metres: longer than a marking or a shadow's
/// rim is wide, shorter than a pavement.
const WINDOW_M: f64 = 0.8;
/// The same for a whole arm of which no piece shows an edge: far from the camera a kerb is drawn out over metres.
const WHOLE_WINDOW_M: f64 = 2.0;
/// A piece beside which the kerbs stand back by no more than this belongs to the straight part of its arm, metres.
const STRAIGHT_FLARE_M: f64 = 0.2;

/// Slides pieces across roads; its memory is reused from piece to piece.
#[derive(Debug)]
pub(super) struct Slide {
    config: AlignmentConfig,
    pixels: Vec<[f64; 2]>,
    mask: SpanMask,
    profile: Profile,
    /// The grey values under it.
    grey: Profile,
    pavements: Pavements,
    /// The mean of the arm's pieces beyond its kerbs.
    whole: Profile,
    /// Where along the arm they lie, metres.
    used_m: Vec<f64>,
}

impl Slide {
    /// A slide of pieces as wide as `config` says.
    pub(super) fn new(config: &AlignmentConfig) -> Self {
        let mask = SpanMask::default();
        Self {
            config: config.clone(),
            pixels: Vec::new(),
            mask,
            profile: Profile::default(),
            grey: Profile::default(),
            pavements: Pavements::default(),
            whole: Profile::default(),
            used_m: Vec::new(),
        }
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
        self.profile.take(profile(config, laid.sums(), &self.mask, left_px_per_m, reach_m));
        let edges_m = self.profile.edges_m(config.slide_step_m, WINDOW_M, config.min_edge_step);
        let road = match laid.grey() {
            Some(grey) => {
                self.grey.take(profile(config, grey, &self.mask, left_px_per_m, reach_m));
                let width = (arm.width_m, config.width_sigma_share * arm.width_m);
                without_pavements(&self.grey, config.slide_step_m, width, edges_m, &mut self.pavements)
            }
            None => RoadEdges::certain(edges_m),
        };
        if piece.flare_m.iter().all(|flare_m| flare_m.is_some_and(|flare_m| flare_m <= STRAIGHT_FLARE_M)) {
            self.whole.add(&self.profile);
            self.used_m.push(piece.along_m);
        }
        Ok(Some(section(config, arm, vehicle_from_feature * piece.middle, left, road)))
    }

    /// Starts a new arm.
    pub(super) fn start_arm(&mut self) {
        self.whole.clear();
        self.used_m.clear();
    }

    /// The cross-section of all pieces of the arm together that were slid since its start, beyond its kerbs, and its
    /// place along the arm, metres; none where there was none.
    pub(super) fn whole_arm(
        &mut self,
        arm: &ArmPieces,
        vehicle_from_feature: &Isometry2<f64>,
    ) -> Option<(CrossSection, f64)> {
        let middle_m = *self.used_m.get(self.used_m.len() / 2)?;
        let piece = arm.pieces.iter().find(|piece| piece.along_m >= middle_m)?;
        let along = vehicle_from_feature.rotation * piece.along;
        let config = &self.config;
        let edges_m = self.whole.edges_m(config.slide_step_m, WHOLE_WINDOW_M, 0.5 * config.min_edge_step);
        let left = Vector2::new(-along.y, along.x);
        let road = RoadEdges::certain(edges_m);
        Some((section(config, arm, vehicle_from_feature * piece.middle, left, road), piece.along_m))
    }
}

/// The cross-section with these edges, and whether they can be those of the arm's road.
fn section(
    config: &AlignmentConfig,
    arm: &ArmPieces,
    p_in_vehicle: Point2<f64>,
    left: Vector2<f64>,
    RoadEdges { edges_m, pavement_sigma_m }: RoadEdges,
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
    CrossSection { label, p_in_vehicle, left, edges_m, pavement_sigma_m, leaves_the_line, section_use }
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

//! Match: how probable a feature is at a pose.
//!
//! Paper 1, section V-C. P(F_sub) is the mean road probability under the seen part of a sub-mask (equation 1), P(F)
//! the smallest of them (equation 2), so that one arm that is not there cannot be made up for by the others.
//!
//! An arm of which too little is seen takes no part, and the evidence says so: nearly all of what is left would lie on
//! the crossing roads, and would be road whether the arm exists or not. What lies beside the arms is weighed too (`matching/verge.rs`).

mod laying;
mod verge;

use std::sync::Arc;

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, ValidityMask};
use fingerpost_vision::span::{Cover, RowSums, SpanError, SpanMask};
use nalgebra::Isometry2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::feature_masks::{FeatureMasks, MaskCache, SubMask, SubMaskKind, VergeStrips, node_pixel};
use crate::road_surface::RoadSurface;

pub use laying::FeatureMatcher;
pub use verge::Verge;

/// Settings of the match.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MatchConfig {
    /// What the masks are superimposed on.
    pub surface: MatchedSurface,
    /// Road probability from which a pixel of the binary mask is road.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub binary_threshold: f64,
    /// Share of a sub-mask inside the view that must be seen for it to take part.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_seen_share: f64,
    /// Length of an arm beyond the crossing roads that must be seen for it to take part, metres.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub min_seen_length_m: f64,
}

impl Default for MatchConfig {
    fn default() -> Self {
        Self {
            surface: MatchedSurface::Probability,
            binary_threshold: 0.5,
            min_seen_share: 0.3,
            min_seen_length_m: 2.5,
        }
    }
}

/// What the masks are superimposed on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MatchedSurface {
    /// The road probabilities themselves.
    Probability,
    /// Road or not, by a threshold.
    Binary,
}

/// Whether a sub-mask takes part in the match, and if not, why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Participation {
    /// It does.
    TakesPart,
    /// The validity mask cuts too much of it.
    CutByValidity,
    /// Too little of it reaches beyond the crossing roads within the view.
    TooShort,
}

/// One sub-mask's part in a match.
#[derive(Debug, Clone, PartialEq)]
pub struct SubMatch {
    /// `approach`, `exit`, `side_1`, ..., `driving_line`.
    pub label: Arc<str>,
    /// What the sub-mask stands for.
    pub kind: SubMaskKind,
    /// P(F_sub), equation 1; none where nothing of it is seen.
    pub p: Option<f64>,
    /// Seen share of its part inside the view.
    pub seen_share: f64,
    /// Whether it takes part.
    pub participation: Participation,
    /// Whether it leaves the line of the approach.
    pub leaves_the_line: bool,
    /// What was seen beside it on its left and right, when one looks outwards along it; none where there is no room for a
    /// verge or it is not seen.
    pub verges: [Option<Verge>; 2],
}

impl SubMatch {
    /// How much more it is road than its verges, -1 to 1: the mean of its sides, of which one that is not seen counts as
    /// without contrast; none where neither is seen.
    pub fn contrast(&self) -> Option<f64> {
        verge::contrast(&self.verges)
    }

    /// Probability that its verges are none but road, 0 to 1: the mean of its sides.
    fn verge_p(&self) -> f64 {
        let [left, right] = self.verges.map(|verge| verge.map_or(verge::UNSEEN_P, |verge| verge.verge_p));
        0.5 * (left + right)
    }

    /// Whether it takes part and would tell the feature from a plain road.
    fn tells(&self) -> bool {
        self.leaves_the_line && self.participation == Participation::TakesPart
    }
}

/// The match of a feature at one pose.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Match {
    /// The pose that was tried.
    pub vehicle_from_feature: Isometry2<f64>,
    /// Every sub-mask.
    pub subs: Vec<SubMatch>,
    /// P(F), equation 2, over the sub-masks that take part; none where none does.
    pub p: Option<f64>,
    /// Index in `subs` of the weakest sub-mask.
    pub weakest: Option<usize>,
}

impl Match {
    /// How much more the arms that tell the feature are road than their verges, -1 to 1: the mean over those that take
    /// part; none where no verge of theirs is seen.
    pub fn contrast(&self) -> Option<f64> {
        mean(self.subs.iter().filter(|sub| sub.tells()).filter_map(SubMatch::contrast))
    }

    /// How sure the feature is, 0 to 1: P(F) times the probability that the arms that tell it end at a verge. A verge
    /// that is not seen is as likely there as not.
    pub fn confidence(&self) -> Option<f64> {
        let verge_p = mean(self.subs.iter().filter(|sub| sub.tells()).map(SubMatch::verge_p));
        self.p.map(|p| p * (1.0 - verge_p.unwrap_or(verge::UNSEEN_P)))
    }
}

/// The mean; none of nothing.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    (count > 0.0).then(|| sum / count)
}

/// Lays masks over the road surface.
#[derive(Debug)]
pub struct Matcher {
    config: MatchConfig,
    grid: GroundGrid,
    binary: Plane<u8>,
    binary_sums: RowSums,
}

impl Matcher {
    /// A matcher on the raster `grid`.
    pub fn new(config: &MatchConfig, grid: &GroundGrid) -> Self {
        Self {
            config: config.clone(),
            grid: *grid,
            binary: Plane::default(),
            binary_sums: RowSums::default(),
        }
    }

    /// The surface that the masks are superimposed on: the probabilities themselves, or a road mask by the threshold.
    ///
    /// # Errors
    /// [`PictureError`] when surface and validity differ in size.
    pub fn laid<'a>(
        &'a mut self,
        surface: &'a RoadSurface,
        validity: &ValidityMask,
    ) -> Result<LaidSurface<'a>, PictureError> {
        self.threshold(surface, validity)?;
        let sums = match self.config.surface {
            MatchedSurface::Probability => &surface.sums,
            MatchedSurface::Binary => &self.binary_sums,
        };
        Ok(LaidSurface { config: &self.config, grid: &self.grid, sums })
    }

    /// Makes the road mask, where one is wanted.
    fn threshold(&mut self, surface: &RoadSurface, validity: &ValidityMask) -> Result<(), PictureError> {
        if self.config.surface == MatchedSurface::Probability {
            return Ok(());
        }
        let (width, height) = surface.probability.size();
        self.binary.reset(width, height, 0);
        let threshold = 255.0 * self.config.binary_threshold;
        let pixels = surface.probability.as_slice().iter();
        for (out, &p) in self.binary.as_mut_slice().iter_mut().zip(pixels) {
            *out = if f64::from(p) >= threshold { 255 } else { 0 };
        }
        self.binary_sums.rebuild(self.binary.view(), validity)
    }
}

/// A frame's road surface, ready for any number of masks.
#[derive(Debug, Clone, Copy)]
pub struct LaidSurface<'a> {
    config: &'a MatchConfig,
    grid: &'a GroundGrid,
    sums: &'a RowSums,
}

impl LaidSurface<'_> {
    /// The raster of the surface.
    pub const fn grid(&self) -> &GroundGrid {
        self.grid
    }

    /// The prefix sums of the surface.
    pub const fn sums(&self) -> &RowSums {
        self.sums
    }

    /// The match of a feature at one pose with every sub-mask's part in it and what lies beside the arms, into `matched`, whose memory is reused.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub fn explain(
        &self,
        masks: &mut MaskCache,
        vehicle_from_feature: &Isometry2<f64>,
        matched: &mut Match,
    ) -> Result<(), SpanError> {
        let parts = self.parts(masks.at(vehicle_from_feature.rotation.angle())?, vehicle_from_feature);
        matched.vehicle_from_feature = *vehicle_from_feature;
        matched.subs.clear();
        matched.subs.extend(parts.map(|(sub, cover, participation)| SubMatch {
            label: Arc::clone(&sub.label),
            kind: sub.kind,
            p: cover.probability(),
            seen_share: if cover.in_view > 0 { cover.seen as f64 / cover.in_view as f64 } else { 0.0 },
            participation,
            leaves_the_line: sub.leaves_the_line,
            verges: [None, None],
        }));
        let node = node_pixel(self.grid, vehicle_from_feature);
        let strips = masks.verges_at(vehicle_from_feature.rotation.angle())?;
        for (sub, strips) in matched.subs.iter_mut().zip(strips) {
            sub.verges = self.verges(strips, node);
        }
        let taking_part =
            matched.subs.iter().enumerate().filter(|(_, sub)| sub.participation == Participation::TakesPart);
        let weakest =
            taking_part.filter_map(|(i, sub)| sub.p.map(|p| (i, p))).min_by(|a, b| a.1.total_cmp(&b.1));
        matched.p = weakest.map(|(_, p)| p);
        matched.weakest = weakest.map(|(index, _)| index);
        Ok(())
    }

    /// What lies beside an arm with the feature's node at a pixel.
    fn verges(&self, strips: &VergeStrips<SpanMask>, node: (i32, i32)) -> [Option<Verge>; 2] {
        [&strips[0], &strips[1]]
            .map(|strip| Verge::of(strip.as_ref()?, self.sums, node, self.grid.metres_per_pixel()))
    }

    /// P(F) alone of [`LaidSurface::explain`].
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub fn probability(
        &self,
        masks: &mut MaskCache,
        vehicle_from_feature: &Isometry2<f64>,
    ) -> Result<Option<f64>, SpanError> {
        let parts = self.parts(masks.at(vehicle_from_feature.rotation.angle())?, vehicle_from_feature);
        let taking_part = parts.filter(|(.., participation)| *participation == Participation::TakesPart);
        Ok(taking_part.filter_map(|(_, cover, _)| cover.probability()).min_by(f64::total_cmp))
    }

    /// What each sub-mask covers at a pose, and whether it takes part.
    fn parts<'m>(
        &self,
        masks: &'m FeatureMasks,
        vehicle_from_feature: &Isometry2<f64>,
    ) -> impl Iterator<Item = (&'m SubMask, Cover, Participation)> {
        let (column, row) = node_pixel(self.grid, vehicle_from_feature);
        masks.subs.iter().map(move |sub| {
            let cover = self.sums.cover(&sub.spans, column, row);
            (sub, cover, self.participation(sub, &cover))
        })
    }

    fn participation(&self, sub: &SubMask, cover: &Cover) -> Participation {
        let needed_px = match sub.kind {
            SubMaskKind::Arm { .. } => {
                self.config.min_seen_length_m / self.grid.metres_per_pixel() * sub.width_px
            }
            // The curve lies wholly on the feature: the share alone decides.
            SubMaskKind::DrivingLine => 1.0,
        };
        if (cover.seen.saturating_sub(sub.mouth_px) as f64) < needed_px {
            if (cover.in_view.saturating_sub(sub.mouth_px) as f64) < needed_px {
                Participation::TooShort
            } else {
                Participation::CutByValidity
            }
        } else if (cover.seen as f64) < self.config.min_seen_share * cover.in_view as f64 {
            Participation::CutByValidity
        } else {
            Participation::TakesPart
        }
    }
}

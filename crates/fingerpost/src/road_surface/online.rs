//! A classifier trained as the drive goes, and the way it has to go from the vehicle.
//!
//! The place just ahead is road by assumption, the rows above the horizon are not. From both a few Gaussians of
//! log-chromaticity (H. Dahlkamp et al., "Self-supervised monocular road detection in desert terrain", 2006) and a linear
//! discriminant (R. A. Fisher, 1936) are retrained every frame and remembered over the drive. They alone do not hold on
//! real streets: pavement is as grey as the road. So road is what can be reached from the place ahead: the geodesic
//! distance (P. J. Toivanen, 1996) over a cost of steps in brightness, above all such as run towards the horizon (kerbs,
//! verges), and of unlike colours. A step between two colours known as road (a shadow's edge, a marking, a crack) costs less.
//! Markings, narrow and bright, are taken away first.
//!
//! It works on the camera picture, reduced to blocks, whatever picture is asked for. Nothing was trained on labels.
//!
//! Limits: an even way round a kerb (a drive, a lowered kerb) leads onto the pavement; the edge of a dark shadow never
//! seen before can end the road until the vehicle has driven through one; vehicles as dark as the road under dusk.

mod blocks;
mod discriminant;
mod layout;
mod surfaces;

use fingerpost_vision::colour_clusters::ColourCluster;
use fingerpost_vision::passage::FEATURES;
use fingerpost_vision::picture::Plane;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::perspective::clear_unseen;
use super::{RoadDetector, RoadError, RoadEvidence, RoadInput, SampleUse, UNINFORMED_LOG_ODDS_BY_COLOUR};
use blocks::Blocks;
use discriminant::Discriminant;
use layout::Layout;
use surfaces::Surfaces;

/// Settings of the classifier that is trained as the drive goes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OnlineConfig {
    /// Most columns of blocks that the camera picture is reduced to.
    #[schemars(range(min = 16, max = 2048))]
    pub columns: usize,
    /// Most rows of blocks.
    #[schemars(range(min = 16, max = 2048))]
    pub rows: usize,
    /// Surfaces (one for each kind and light) that are remembered.
    #[schemars(range(min = 1, max = 16))]
    pub surfaces: usize,
    /// Bright stripes up to this width are taken for markings, camera heights above the road.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub marking_width_heights: f64,
    /// Step in log-brightness, at an edge towards the vanishing point, across which the probability falls to a
    /// half.
    #[schemars(range(min = 0.05, max = 10.0))]
    pub half_step: f64,
    /// Share by which a step between two colours known as road counts less.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub known_step: f64,
    /// What the part of a slope that runs along lines to the vanishing point counts.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub edges_along: f64,
}

impl Default for OnlineConfig {
    fn default() -> Self {
        Self {
            columns: 256,
            rows: 192,
            surfaces: 4,
            // 0.17 m, with the camera at 1.4 m.
            marking_width_heights: 0.12,
            // A factor of 2.1.
            half_step: 0.75,
            known_step: 0.85,
            edges_along: 0.35,
        }
    }
}

/// How the classifier came to its surface.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OnlineEvidence {
    /// Columns and rows of the blocks that were looked at.
    pub grid: (usize, usize),
    /// Width and height of a block, pixels of the camera picture.
    pub block_px: (usize, usize),
    /// Blocks of the sample: the road by assumption.
    pub road_blocks: usize,
    /// Blocks that are certainly not road.
    pub other_blocks: usize,
    /// Rows of the camera picture that those are taken from, pixels: the first, and the one after the last.
    pub other_rows_px: (usize, usize),
    /// Row of the horizon, pixels of the camera picture.
    pub horizon_row_px: f64,
    /// Surfaces remembered.
    pub surfaces: usize,
    /// Surfaces that this frame founded.
    pub founded: usize,
    /// What the discriminant weighs: unlikeness to the surfaces, log-brightness, red-green, blue-green, texture; positive
    /// speaks against road.
    pub weights: [f32; FEATURES],
    /// Distance between road and other places along the discriminant, standard deviations.
    pub separation: f64,
    /// Share of the blocks below the horizon whose probability is at least a half.
    pub road_share: f64,
}

/// The classifier and what it has learned.
#[derive(Debug)]
pub struct Online {
    config: OnlineConfig,
    layout: Option<Layout>,
    surfaces: Surfaces,
    clusters: Vec<ColourCluster>,
    discriminant: Discriminant,
    blocks: Blocks,
}

impl Online {
    /// A classifier that has learned nothing yet.
    pub fn new(config: &OnlineConfig) -> Self {
        Self {
            config: config.clone(),
            layout: None,
            surfaces: Surfaces::new(config.surfaces),
            clusters: Vec::new(),
            discriminant: Discriminant::default(),
            blocks: Blocks::default(),
        }
    }
}

impl Online {
    /// Learns from a picture and finds the road in its blocks.
    pub(super) fn learn_from(&mut self, input: RoadInput<'_>) -> Result<RoadEvidence, RoadError> {
        let layout = match self.layout.take() {
            Some(layout) if layout.serves(&input) => layout,
            _ => Layout::new(&self.config, &input)?,
        };
        let layout = self.layout.insert(layout);
        self.blocks.measure(layout, &input)?;
        let founded = self.surfaces.learn(self.blocks.sample());
        self.surfaces.write_to(&mut self.clusters);
        let [road, other] = self.blocks.compare(layout, &self.clusters)?;
        self.discriminant.learn(road.map(Into::into), other.map(Into::into));
        let weights = self.discriminant.weights();
        self.blocks.reach(layout, &self.config, &weights)?;
        let evidence = OnlineEvidence {
            grid: (layout.columns, layout.rows),
            block_px: (layout.block.width, layout.block.height),
            road_blocks: layout.sample_blocks(),
            other_blocks: self.blocks.other_blocks(),
            other_rows_px: (
                layout.first_row * layout.block.height,
                (layout.first_row + layout.other_rows) * layout.block.height,
            ),
            horizon_row_px: layout.horizon_row_px(),
            surfaces: self.surfaces.len(),
            founded,
            weights: weights.linear.0,
            separation: weights.separation,
            road_share: self.blocks.road_share(layout),
        };
        Ok(RoadEvidence {
            detector: "online",
            uninformed_log_odds: UNINFORMED_LOG_ODDS_BY_COLOUR,
            sample: input.sample,
            sample_use: match (layout.sample.is_empty(), founded) {
                (true, _) => SampleUse::Unseen,
                (false, 0) => SampleUse::Learned,
                (false, _) => SampleUse::SurfaceChanged,
            },
            sample_probability: self.blocks.sample_likeness(),
            online: Some(evidence),
            ..RoadEvidence::default()
        })
    }

    /// Fills `probability` with the road of the picture that was learned from last.
    pub(super) fn project(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<(), RoadError> {
        if probability.size() != input.validity.size() {
            let (width, height) = input.validity.size();
            probability.reset(width, height, 0);
        }
        if let Some(layout) = &self.layout {
            layout.table.warp_grey(&self.blocks.nearness, probability)?;
        }
        clear_unseen(input.validity, probability);
        Ok(())
    }
}

impl RoadDetector for Online {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let evidence = self.learn_from(input)?;
        self.project(input, probability)?;
        Ok(evidence)
    }

    fn reset(&mut self) {
        self.surfaces.forget();
        self.discriminant.forget();
    }
}

#[cfg(test)]
mod tests;

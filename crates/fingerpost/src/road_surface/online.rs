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

mod discriminant;
mod layout;
mod surfaces;

use fingerpost_vision::colour_clusters::{ColourCluster, nearest_squared};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::geodesic::{GeodesicSweeps, UNREACHED, nearness};
use fingerpost_vision::line_gradient::LineGradient;
use fingerpost_vision::log_colour::{LogColour, LogColourReducer};
use fingerpost_vision::morphology::RowOpening;
use fingerpost_vision::passage::{FEATURES, PassageCost, PassageInput, PassageWeights, features};
use fingerpost_vision::picture::Plane;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::perspective::clear_unseen;
use super::{RoadDetector, RoadError, RoadEvidence, RoadInput, SampleUse};
use discriminant::{Discriminant, Kind, Weights};
use layout::Layout;
use surfaces::{Colour, Surfaces};

/// Distance at which the probability is a half, in the units of the sweeps: fine enough for the smallest costs.
const HALF_DISTANCE: u32 = 1 << 12;
/// Costs are half the price of crossing a block.
const COST_SCALE: f32 = 0.5 * HALF_DISTANCE as f32;
/// Price of a block for each unit of unlikeness: some forty blocks of wholly unlike colours halve the probability.
const UNLIKE_PRICE: f32 = 0.008;
/// Up, down and up again: from the vehicle to the horizon, back down into side roads, and out of those.
const SWEEPS: usize = 3;
/// Of the blocks above the horizon, every second one each way is enough.
const OTHER_STEP: usize = 2;
/// Nearness from which a block counts as road in the evidence.
const ROAD_NEARNESS: u8 = 128;

/// Settings of the classifier that is trained as the drive goes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OnlineConfig {
    /// Most columns of blocks that the camera picture is reduced to, 16 to 2048; default 256.
    pub columns: usize,
    /// Most rows of blocks, 16 to 2048; default 192.
    pub rows: usize,
    /// Surfaces (one for each kind and light) that are remembered, 1 to 16; default 4.
    pub surfaces: usize,
    /// Bright stripes up to this width are taken for markings, camera heights above the road, 0 to 1; default 0.12: with
    /// the camera at 1.4 m, 0.17 m.
    pub marking_width_heights: f64,
    /// Step in log-brightness, at an edge towards the vanishing point, across which the probability falls to a half, 0.05
    /// to 10; default 0.75, a factor of 2.1.
    pub half_step: f64,
    /// Share by which a step between two colours known as road counts less, 0 to 1; default 0.85.
    pub known_step: f64,
    /// What the part of a slope that runs along lines to the vanishing point counts, 0 to 1; default 0.35.
    pub edges_along: f64,
}

impl Default for OnlineConfig {
    fn default() -> Self {
        Self {
            columns: 256,
            rows: 192,
            surfaces: 4,
            marking_width_heights: 0.12,
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
    discriminant: Discriminant,
    blocks: Blocks,
}

/// The blocks' values, stage by stage, and the tools that make them.
#[derive(Debug, Default)]
struct Blocks {
    reducer: LogColourReducer,
    opening: RowOpening,
    gradient: LineGradient,
    passage: PassageCost,
    sweeps: GeodesicSweeps,
    colour: LogColour,
    slopes: Plane<f32>,
    texture: Plane<f32>,
    sample: Vec<Colour>,
    clusters: Vec<ColourCluster>,
    squared_distance: Plane<f32>,
    cost: Plane<u32>,
    distance: Plane<u32>,
    nearness: Plane<u8>,
}

impl Online {
    /// A classifier that has learned nothing yet.
    pub fn new(config: &OnlineConfig) -> Self {
        Self {
            config: config.clone(),
            layout: None,
            surfaces: Surfaces::new(config.surfaces),
            discriminant: Discriminant::default(),
            blocks: Blocks::default(),
        }
    }
}

impl RoadDetector for Online {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let layout = match self.layout.take() {
            Some(layout) if layout.serves(&input) => layout,
            _ => Layout::new(&self.config, &input)?,
        };
        let layout = self.layout.insert(layout);
        self.blocks.measure(layout, &input)?;
        let founded = self.surfaces.learn(&self.blocks.sample);
        self.surfaces.write_to(&mut self.blocks.clusters);
        self.blocks.compare()?;
        let other_columns = layout.columns.div_ceil(OTHER_STEP);
        let other_rows = layout.other_rows.div_ceil(OTHER_STEP);
        self.discriminant.learn(
            Kind::of(layout.sample.iter().map(|&(x, y)| self.blocks.features(x, y))),
            Kind::of(
                (0..other_columns * other_rows)
                    .map(|i| (OTHER_STEP * (i % other_columns), OTHER_STEP * (i / other_columns)))
                    .map(|(x, y)| self.blocks.features(x, y)),
            ),
        );
        let weights = self.discriminant.weights();
        self.blocks.reach(layout, &self.config, &weights)?;
        let evidence = OnlineEvidence {
            grid: (layout.columns, layout.rows),
            block_px: (layout.block.width, layout.block.height),
            road_blocks: layout.sample.len(),
            other_blocks: other_columns * other_rows,
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
        if probability.size() != input.validity.size() {
            let (width, height) = input.validity.size();
            probability.reset(width, height, 0);
        }
        layout.table.warp_grey(&self.blocks.nearness, probability)?;
        clear_unseen(input.validity, probability);
        Ok(RoadEvidence {
            detector: "online",
            sample: input.sample,
            sample_use: match (layout.sample.is_empty(), founded) {
                (true, _) => SampleUse::Unseen,
                (false, 0) => SampleUse::Learned,
                (false, _) => SampleUse::SurfaceChanged,
            },
            sample_probability: self.blocks.sample_likeness(layout),
            online: Some(evidence),
            ..RoadEvidence::default()
        })
    }

    fn reset(&mut self) {
        self.surfaces.forget();
        self.discriminant.forget();
    }
}

impl Blocks {
    /// Colour, slopes and texture of the blocks, and the colours of the sample.
    fn measure(&mut self, layout: &Layout, input: &RoadInput<'_>) -> Result<(), PictureError> {
        let (width, height) = (layout.columns, layout.rows);
        if self.colour.size() != (width, height) {
            self.colour.reset(width, height);
            for plane in [&mut self.slopes, &mut self.texture, &mut self.squared_distance] {
                plane.reset(width, height, 0.0);
            }
            self.cost.reset(width, height, 0);
            self.distance.reset(width, height, 0);
            self.nearness.reset(width, height.max(1), 0);
        }
        self.reducer.reduce(input.camera_picture(), layout.block, layout.first_row, &mut self.colour)?;
        self.opening.open(&mut self.colour.brightness, |row| layout.marking_widths[row]);
        self.gradient.slopes(&self.colour.brightness, layout.lines, &mut self.slopes)?;
        self.gradient.texture(&self.slopes, &mut self.texture)?;
        let LogColour { brightness, red_green, blue_green } = &self.colour;
        let colour = |&(x, y): &(usize, usize)| {
            Colour::new(
                f64::from(brightness.row(y)[x]),
                f64::from(red_green.row(y)[x]),
                f64::from(blue_green.row(y)[x]),
            )
        };
        self.sample.clear();
        self.sample.extend(layout.sample.iter().map(colour));
        Ok(())
    }

    /// How unlike the known surfaces every block is.
    fn compare(&mut self) -> Result<(), PictureError> {
        nearest_squared(&self.colour, &self.clusters, &mut self.squared_distance)
    }

    fn features(&self, x: usize, y: usize) -> [f32; FEATURES] {
        let LogColour { brightness, red_green, blue_green } = &self.colour;
        features(
            self.squared_distance.row(y)[x],
            brightness.row(y)[x],
            red_green.row(y)[x],
            blue_green.row(y)[x],
            self.texture.row(y)[x],
        )
    }

    /// How near every block is to the sample.
    fn reach(
        &mut self,
        layout: &Layout,
        config: &OnlineConfig,
        weights: &Weights,
    ) -> Result<(), PictureError> {
        let input = PassageInput {
            colour: &self.colour,
            squared_distance: &self.squared_distance,
            slopes: &self.slopes,
            texture: &self.texture,
        };
        let prices = PassageWeights {
            step: 1.0 / config.half_step as f32,
            known_step: config.known_step as f32,
            unlike: UNLIKE_PRICE,
            discriminant: weights.linear,
        };
        self.passage.compute(input, &prices, COST_SCALE, &mut self.cost)?;
        self.distance.as_mut_slice().fill(UNREACHED);
        for &(x, y) in &layout.starts {
            self.distance.row_mut(y)[x] = 0;
        }
        self.sweeps.spread(&self.cost, layout.other_rows, SWEEPS, &mut self.distance)?;
        nearness(&self.distance, HALF_DISTANCE, &mut self.nearness)
    }

    fn road_share(&self, layout: &Layout) -> f64 {
        let road = (layout.other_rows..layout.rows).flat_map(|y| self.nearness.row(y));
        let (all, near) = road.fold((0_usize, 0_usize), |(all, near), &nearness| {
            (all + 1, near + usize::from(nearness >= ROAD_NEARNESS))
        });
        near as f64 / all.max(1) as f64
    }

    /// Mean likeness of the sample to the surfaces, 0 to 1.
    fn sample_likeness(&self, layout: &Layout) -> f64 {
        let likeness = |&(x, y): &(usize, usize)| (-0.5 * f64::from(self.squared_distance.row(y)[x])).exp();
        layout.sample.iter().map(likeness).sum::<f64>() / layout.sample.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests;

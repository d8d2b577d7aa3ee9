//! The blocks' values, stage by stage.

use fingerpost_vision::colour_clusters::{ColourCluster, mean_likeness, nearest_squared};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::geodesic::{GeodesicSweeps, UNREACHED, nearness};
use fingerpost_vision::line_gradient::LineGradient;
use fingerpost_vision::log_colour::{LogColour, LogColourReducer};
use fingerpost_vision::moments::Moments;
use fingerpost_vision::morphology::RowOpening;
use fingerpost_vision::passage::{FEATURES, PassageCost, PassageInput, PassageWeights, unlikeness};
use fingerpost_vision::picture::Plane;

use super::discriminant::Weights;
use super::layout::Layout;
use super::surfaces::Sample;
use super::{OnlineConfig, RoadInput};

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

/// The blocks' values and the tools that make them.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    reducer: LogColourReducer,
    opening: RowOpening,
    gradient: LineGradient,
    passage: PassageCost,
    sweeps: GeodesicSweeps,
    colour: LogColour,
    slopes: Plane<f32>,
    texture: Plane<f32>,
    squared_distance: Plane<f32>,
    /// Of the sample, and of what is certainly not road.
    road: Taken,
    other: Taken,
    cost: Plane<u32>,
    distance: Plane<u32>,
    pub(super) nearness: Plane<u8>,
}

/// The values of some of the blocks, one after the other.
#[derive(Debug, Default)]
struct Taken {
    squared_distance: Vec<f32>,
    unlikeness: Vec<f32>,
    brightness: Vec<f32>,
    red_green: Vec<f32>,
    blue_green: Vec<f32>,
    texture: Vec<f32>,
}

impl Taken {
    fn features(&self) -> [&[f32]; FEATURES] {
        [&self.unlikeness, &self.brightness, &self.red_green, &self.blue_green, &self.texture]
    }

    /// Sets the unlikeness by the squared distance.
    fn judge(&mut self) {
        self.unlikeness.clear();
        self.unlikeness.extend(self.squared_distance.iter().map(|&squared| unlikeness(squared)));
    }
}

impl Blocks {
    /// Colour, slopes and texture of the blocks, and the colours of the sample.
    pub(super) fn measure(&mut self, layout: &Layout, input: &RoadInput<'_>) -> Result<(), PictureError> {
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
        let road = &mut self.road;
        for (plane, taken) in [
            (brightness, &mut road.brightness),
            (red_green, &mut road.red_green),
            (blue_green, &mut road.blue_green),
        ] {
            layout.take_sample(plane, taken);
        }
        Ok(())
    }

    /// The colours of the sample.
    pub(super) fn sample(&self) -> Sample<'_> {
        let Taken { brightness, red_green, blue_green, .. } = &self.road;
        Sample { brightness, red_green, blue_green }
    }

    /// How unlike the known surfaces every block is; what that and the other features are like on the road and elsewhere.
    pub(super) fn compare(
        &mut self,
        layout: &Layout,
        clusters: &[ColourCluster],
    ) -> Result<[Option<Moments<FEATURES>>; 2], PictureError> {
        nearest_squared(&self.colour, clusters, &mut self.squared_distance)?;
        let Self { road, other, colour, squared_distance, texture, .. } = self;
        layout.take_sample(squared_distance, &mut road.squared_distance);
        layout.take_sample(texture, &mut road.texture);
        for (plane, taken) in [
            (&*squared_distance, &mut other.squared_distance),
            (&colour.brightness, &mut other.brightness),
            (&colour.red_green, &mut other.red_green),
            (&colour.blue_green, &mut other.blue_green),
            (&*texture, &mut other.texture),
        ] {
            taken.clear();
            for row in (0..layout.other_rows).step_by(OTHER_STEP) {
                taken.extend(plane.row(row).iter().step_by(OTHER_STEP));
            }
        }
        Ok([road, other].map(|taken| {
            taken.judge();
            Moments::of(taken.features())
        }))
    }

    /// Number of blocks that are certainly not road.
    pub(super) fn other_blocks(&self) -> usize {
        self.other.texture.len()
    }

    /// How near every block is to the sample.
    pub(super) fn reach(
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

    /// Share of the blocks below the horizon whose probability is at least a half.
    pub(super) fn road_share(&self, layout: &Layout) -> f64 {
        let below = &self.nearness.as_slice()[layout.other_rows * layout.columns..];
        let near = below.iter().filter(|&&nearness| nearness >= ROAD_NEARNESS).count();
        near as f64 / (layout.columns * (layout.rows - layout.other_rows)).max(1) as f64
    }

    /// Mean likeness of the sample to the surfaces, 0 to 1.
    pub(super) fn sample_likeness(&self) -> f64 {
        f64::from(mean_likeness(&self.road.squared_distance))
    }
}

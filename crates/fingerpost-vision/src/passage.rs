//! What it costs to pass over each pixel on the way from a known surface.
//!
//! Two things stand in the way: steps in brightness, and colours unlike those known. A step between known colours counts
//! less (a shadow, a marking, a crack), unless a linear discriminant finds the place more like what is known not to
//! belong to the surface (R. A. Fisher, "The use of multiple measurements in taxonomic problems", 1936).

use crate::colour_clusters::FARTHEST;
use crate::elementary::{exp_minus, whole_part};
use crate::error::{PictureError, check_size};
use crate::filter::SeparableFilter;
use crate::geodesic::MAX_COST;
use crate::log_colour::LogColour;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Features of the discriminant: capped unlikeness, log-brightness, red-green, blue-green, texture.
pub const FEATURES: usize = 5;
/// Squared Mahalanobis distance at which a colour counts as unlike by 1: mean squared distance of three features is 3, and
/// light varies along a road.
const UNLIKE_SQUARED: f32 = 8.0;
/// Unlikeness beyond this is all the same to the discriminant.
const MOST_UNLIKE: f32 = 3.0;
/// Unlikeness that a colour adds at the most to the cost: what lies far outside is no harder to pass than what lies outside.
const SATURATION: f32 = 2.0;
/// Weights that spread an edge to its neighbours, so that gaps of a pixel do not open it.
const SPREAD: [f64; 3] = [0.25, 0.5, 0.25];

/// How unlike known colours a colour is for the discriminant, 0 to 3, by its squared Mahalanobis distance.
#[inline(always)]
#[must_use]
pub fn unlikeness(squared_distance: f32) -> f32 {
    let unlike = squared_distance * (1.0 / UNLIKE_SQUARED);
    if unlike < MOST_UNLIKE { unlike } else { MOST_UNLIKE }
}

/// What counts how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassageWeights {
    /// Cost of a step of 1 in log-brightness.
    pub step: f32,
    /// Share of that which a step between known colours costs less, 0 to 1.
    pub known_step: f32,
    /// Cost of a pixel for each unit of unlikeness.
    pub unlike: f32,
    /// The discriminant: weights of the features, and what is added to their sum; 0 stands for the surface, 1 for what is
    /// not, and it is cut to that range.
    pub discriminant: ([f32; FEATURES], f32),
}

/// What is known of each pixel; all of one size.
#[derive(Debug, Clone, Copy)]
pub struct PassageInput<'a> {
    /// Colour.
    pub colour: &'a LogColour,
    /// Squared Mahalanobis distance to the nearest known colour.
    pub squared_distance: &'a Plane<f32>,
    /// Slope of log-brightness a pixel.
    pub slopes: &'a Plane<f32>,
    /// Texture.
    pub texture: &'a Plane<f32>,
}

/// Computes costs, with the buffers that it needs.
#[derive(Debug, Clone)]
pub struct PassageCost {
    edges: Plane<f32>,
    spread_edges: Plane<f32>,
    unlike: Plane<f32>,
    filter: SeparableFilter,
}

impl Default for PassageCost {
    fn default() -> Self {
        let (edges, spread_edges, unlike) = Default::default();
        Self { edges, spread_edges, unlike, filter: SeparableFilter::new(&SPREAD) }
    }
}

impl PassageCost {
    /// Fills `target` with costs, `scale` for 1, rounded down, 1 to [`MAX_COST`].
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the pictures differ in size.
    pub fn compute(
        &mut self,
        input: PassageInput<'_>,
        weights: &PassageWeights,
        scale: f32,
        target: &mut Plane<u32>,
    ) -> Result<(), PictureError> {
        self.compute_on(CodePath::fastest(), input, weights, scale, target)
    }

    fn compute_on(
        &mut self,
        path: CodePath,
        input: PassageInput<'_>,
        weights: &PassageWeights,
        scale: f32,
        target: &mut Plane<u32>,
    ) -> Result<(), PictureError> {
        let PassageInput { colour, squared_distance, slopes, texture } = input;
        let size = colour.size();
        for found in [squared_distance.size(), slopes.size(), texture.size(), target.size()] {
            check_size("passage cost", size, found)?;
        }
        if self.edges.size() != size {
            for plane in [&mut self.edges, &mut self.spread_edges, &mut self.unlike] {
                plane.reset(size.0, size.1, 0.0);
            }
        }
        for y in 0..size.1 {
            weigh(
                path,
                squared_distance.row(y),
                colour.brightness.row(y),
                colour.red_green.row(y),
                colour.blue_green.row(y),
                texture.row(y),
                slopes.row(y),
                weights,
                self.edges.row_mut(y),
                self.unlike.row_mut(y),
            );
        }
        self.filter.apply(&self.edges, &mut self.spread_edges)?;
        total(
            path,
            self.edges.as_slice(),
            self.spread_edges.as_slice(),
            self.unlike.as_slice(),
            scale,
            target.as_mut_slice(),
        );
        Ok(())
    }
}

simd_kernel! {
    fn weigh(
        squared: &[f32], brightness: &[f32], red_green: &[f32], blue_green: &[f32], texture: &[f32],
        slopes: &[f32], weights: &PassageWeights, edges: &mut [f32], unlike: &mut [f32],
    ) {
        let width = edges.len();
        let (squared, brightness, red_green) = (&squared[..width], &brightness[..width], &red_green[..width]);
        let (blue_green, texture, slopes) = (&blue_green[..width], &texture[..width], &slopes[..width]);
        let unlike = &mut unlike[..width];
        let PassageWeights { step, known_step, unlike: price, discriminant: (w, offset) } = *weights;
        for x in 0..width {
            let f = [unlikeness(squared[x]), brightness[x], red_green[x], blue_green[x], texture[x]];
            let sum = offset + f[0] * w[0] + f[1] * w[1] + f[2] * w[2] + f[3] * w[3] + f[4] * w[4];
            let other = if sum > 0.0 { sum } else { 0.0 };
            let other = if other < 1.0 { other } else { 1.0 };
            let distance = if squared[x] < FARTHEST { squared[x] } else { FARTHEST } * (1.0 / UNLIKE_SQUARED);
            edges[x] = step * slopes[x] * (1.0 - known_step * exp_minus(distance) * (1.0 - other));
            unlike[x] = price * (distance / (1.0 + distance * (1.0 / SATURATION)) + other);
        }
    }
}

simd_kernel! {
    fn total(edges: &[f32], spread: &[f32], unlike: &[f32], scale: f32, out: &mut [u32]) {
        let length = out.len();
        let (edges, spread, unlike) = (&edges[..length], &spread[..length], &unlike[..length]);
        for i in 0..length {
            let edge = if edges[i] > spread[i] { edges[i] } else { spread[i] };
            let cost = (edge + unlike[i]) * scale;
            let cost = if cost < MAX_COST as f32 { cost } else { MAX_COST as f32 };
            let cost = if cost > 1.0 { cost } else { 1.0 };
            out[i] = whole_part(cost);
        }
    }
}

#[cfg(test)]
mod tests;

//! Colours of the ground and of what stands on it, linear light.

use crate::conditions::{Conditions, Markings};
use crate::ground::GroundPoint;
use crate::noise::{floor_int, mix, unit};
use crate::object::{Hit, Object, Part};
use crate::roads::{RoadNetwork, Stroke, Surface};
use crate::texture::{Grain, Texture};

/// Linear red, green, blue.
pub(crate) type Colour = [f32; 3];

/// Width of a white line, metres.
const LINE_M: f32 = 0.14;
/// Distance of an edge line's middle from the road's edge, metres.
pub(crate) const EDGE_LINE_M: f64 = 0.25;
/// Length of a dash and of dash and gap together, metres.
const DASH_M: [f32; 2] = [3.0, 9.0];
/// Narrowest two-way road with a centre line, metres.
const CENTRE_LINE_FROM_M: f64 = 5.0;
/// Narrowest road with edge lines, metres.
const EDGE_LINES_FROM_M: f64 = 5.4;
/// Lines stop this far from another road's edge, metres.
const MOUTH_M: f32 = 0.6;

/// A stroke as the pixels need it.
#[derive(Debug, Clone, Copy)]
struct Lane {
    start: [f32; 2],
    direction: [f32; 2],
    along_m: f32,
    half_width_m: f32,
    lines: Lines,
    surface: Surface,
}

/// Which white lines a road has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lines {
    /// A dashed line in the middle.
    pub(crate) centre: bool,
    /// A line along each edge.
    pub(crate) edges: bool,
}

impl Lines {
    /// The lines of a stroke under these markings.
    pub(crate) fn of(stroke: &Stroke, markings: Markings) -> Self {
        let drawn = markings == Markings::Lines && stroke.surface == Surface::Paved;
        let width_m = 2.0 * stroke.half_width_m;
        Self {
            centre: drawn && stroke.two_way && width_m >= CENTRE_LINE_FROM_M,
            edges: drawn && width_m >= EDGE_LINES_FROM_M,
        }
    }

    /// Whether lines are drawn at a place so far from another road's edge.
    pub(crate) fn interrupted(other_m: f32) -> bool {
        other_m < MOUTH_M
    }
}

/// How much ground a pixel covers and in which direction it is drawn out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footprint {
    /// Across the line of sight, metres.
    pub(crate) across_m: f32,
    /// Along the line of sight, metres.
    pub(crate) along_m: f32,
    /// Unit vector of the line of sight on the ground.
    pub(crate) sight: [f32; 2],
}

impl Footprint {
    /// Extent in the direction of a (unit) vector, metres.
    #[inline]
    fn extent_m(&self, [x, y]: [f32; 2]) -> f32 {
        let along = (x * self.sight[0] + y * self.sight[1]) * self.along_m;
        let across = (x * self.sight[1] - y * self.sight[0]) * self.across_m;
        (along * along + across * across).sqrt().max(1e-4)
    }
}

/// Textures and numbers of everything that is painted.
#[derive(Debug, Clone)]
pub(crate) struct Painter {
    asphalt: Texture,
    grass: Texture,
    soil: Texture,
    lanes: Vec<Lane>,
    bare_verge: f32,
    wear: f32,
}

impl Painter {
    /// Paint for these roads.
    pub(crate) fn new(seed: u64, conditions: &Conditions, roads: &RoadNetwork) -> Self {
        let lanes = roads.strokes().iter().map(|stroke| Lane {
            start: [stroke.start.x as f32, stroke.start.y as f32],
            direction: [stroke.direction.x as f32, stroke.direction.y as f32],
            along_m: stroke.along_m as f32,
            half_width_m: stroke.half_width_m as f32,
            lines: Lines::of(stroke, conditions.markings),
            surface: stroke.surface,
        });
        Self {
            asphalt: Texture::new(seed, Grain::Asphalt),
            grass: Texture::new(seed, Grain::Grass),
            soil: Texture::new(seed, Grain::Soil),
            lanes: lanes.collect(),
            bare_verge: conditions.bare_verge as f32,
            wear: conditions.road_wear as f32,
        }
    }

    /// Share of the pixel that is road, and its colour in full light.
    #[inline]
    pub(crate) fn ground(&self, x: f32, y: f32, point: &GroundPoint, footprint: &Footprint) -> (f32, Colour) {
        let road = if point.edge_m.abs() > footprint.along_m {
            // The edge is farther away than the pixel reaches in any direction.
            if point.edge_m < 0.0 { 1.0 } else { 0.0 }
        } else {
            (0.5 - point.edge_m / footprint.extent_m(point.edge_slope)).clamp(0.0, 1.0)
        };
        let fineness = (footprint.across_m * footprint.along_m).sqrt();
        let mut colour = [0.0; 3];
        if road > 0.0 {
            colour = self.road(x, y, point, footprint, fineness);
        }
        if road < 1.0 {
            let verge = self.verge(x, y, point, fineness);
            for i in 0..3 {
                colour[i] = verge[i] + (colour[i] - verge[i]) * road;
            }
        }
        (road, colour)
    }

    #[inline]
    fn road(&self, x: f32, y: f32, point: &GroundPoint, footprint: &Footprint, fineness: f32) -> Colour {
        let lane = point.stroke.map(|index| &self.lanes[index as usize]);
        let loose = lane.is_some_and(|lane| lane.surface == Surface::Loose);
        let texture = if loose { &self.soil } else { &self.asphalt };
        let grain = texture.sample(x, y, fineness);
        // The same tile turned and enlarged by irrational numbers: together they do not repeat within sight.
        let other = texture.sample(0.49 * x - 0.33 * y + 3.1, 0.33 * x + 0.49 * y + 7.7, 0.6 * fineness);
        let bright = 1.0 + self.wear * (0.40 * grain[0] + 0.30 * other[0] + 0.55 * point.tone);
        let warm = 0.5 * point.hue + 0.35 * grain[1] + 0.25 * other[1];
        let base = if loose { [0.36, 0.30, 0.225] } else { [0.200, 0.208, 0.222] };
        let bright = bright.max(0.15);
        let mut colour = [
            base[0] * bright * (1.0 + 0.10 * warm),
            base[1] * bright,
            base[2] * bright * (1.0 - 0.12 * warm),
        ];
        if let Some(lane) = lane {
            let paint = lane.paint(x, y, point, footprint) * (0.92 + 0.5 * grain[0].min(0.0));
            for (i, white) in [0.74, 0.74, 0.70].into_iter().enumerate() {
                colour[i] += (white - colour[i]) * paint.clamp(0.0, 1.0);
            }
        }
        colour
    }

    #[inline]
    fn verge(&self, x: f32, y: f32, point: &GroundPoint, fineness: f32) -> Colour {
        let grass = self.grass.sample(x, y, fineness);
        let tufts = self.grass.sample(0.31 * x + 0.22 * y, 0.31 * y - 0.22 * x, 0.4 * fineness);
        // Soil in a ragged strip along the road and in patches beyond.
        let strip = (1.0 - point.edge_m * (1.0 / 0.9)).clamp(0.0, 1.0);
        let patches = point.hue * 0.9 + 0.8 * tufts[1] + 0.4 * grass[1];
        let bare = ((self.bare_verge - 0.5) * 2.0 + patches + 1.1 * strip).clamp(0.0, 1.0);
        let bright = (1.0 + 0.45 * grass[0] + 0.30 * tufts[0] + 0.4 * point.tone).max(0.2);
        let green = [0.135 + 0.05 * point.tone, 0.195, 0.062];
        let grass_colour = green.map(|c| c * bright);
        if bare <= 0.0 {
            return grass_colour;
        }
        let stones = self.soil.sample(y, x, fineness);
        let earth = (1.0 + 0.45 * stones[0] + 0.3 * point.tone).max(0.2);
        let brown = [0.275, 0.205, 0.130];
        [0, 1, 2].map(|i| grass_colour[i] + (brown[i] * earth - grass_colour[i]) * bare)
    }

    /// Colour of an object in full light.
    pub(crate) fn object(&self, object: &Object, hit: &Hit, footprint_m: f32) -> Colour {
        let [along, up] = hit.surface_m;
        let shade = |i: u64| unit(mix(object.hash ^ i));
        match hit.part {
            Part::Wall => {
                let tone = 0.30 + 0.35 * shade(1);
                let plaster = 1.0 + 0.25 * self.soil.sample(along, up, footprint_m)[0];
                let wall = [tone, tone * (0.86 + 0.12 * shade(2)), tone * (0.70 + 0.25 * shade(3))];
                if window(along, up) { [0.06, 0.075, 0.09] } else { wall.map(|c| c * plaster) }
            }
            Part::Roof => {
                let tiles = 1.0 + 0.35 * self.soil.sample(along, 2.5 * up, footprint_m)[0];
                let red = 0.20 + 0.14 * shade(4);
                [red, 0.5 * red + 0.02, 0.36 * red + 0.02].map(|c| c * tiles)
            }
            Part::Trunk => [0.11, 0.085, 0.06],
            Part::Crown => {
                let leaves = self.grass.sample(0.35 * along, 0.35 * up, 0.35 * footprint_m);
                let bright = (1.0 + 0.9 * leaves[0]).max(0.15);
                let green = 0.10 + 0.07 * shade(5);
                [green * (0.62 + 0.25 * shade(6)), green, 0.30 * green].map(|c| c * bright)
            }
        }
    }
}

impl Lane {
    /// Share of the pixel that a white line covers.
    #[inline]
    fn paint(&self, x: f32, y: f32, point: &GroundPoint, footprint: &Footprint) -> f32 {
        if !(self.lines.centre || self.lines.edges) || Lines::interrupted(point.other_m) {
            return 0.0;
        }
        let (dx, dy) = (x - self.start[0], y - self.start[1]);
        let left = self.direction[0] * dy - self.direction[1] * dx;
        let edge = left.abs() - (self.half_width_m - EDGE_LINE_M as f32);
        if left.abs().min(edge.abs()) > 0.5 * LINE_M + footprint.along_m {
            return 0.0;
        }
        let across = footprint.extent_m([-self.direction[1], self.direction[0]]);
        let covered = |from_middle: f32, half: f32, extent: f32| {
            ((half - from_middle.abs()) / extent + 0.5).clamp(0.0, 1.0).min(2.0 * half / extent)
        };
        let mut paint = 0.0_f32;
        if self.lines.edges {
            paint = covered(edge, 0.5 * LINE_M, across);
        }
        if self.lines.centre {
            let line = covered(left, 0.5 * LINE_M, across);
            if line > 0.0 {
                let along = self.along_m + dx * self.direction[0] + dy * self.direction[1];
                let in_period = along - DASH_M[1] * floor_int(along / DASH_M[1]) as f32;
                let dash =
                    covered(in_period - 0.5 * DASH_M[0], 0.5 * DASH_M[0], footprint.extent_m(self.direction));
                paint = paint.max(line * dash.min(1.0));
            }
        }
        paint
    }
}

/// Windows of 1.1 x 1.3 m every 2.6 m of wall and every 2.8 m of height.
fn window(along: f32, up: f32) -> bool {
    let within = |value: f32, period: f32| value - period * floor_int(value / period) as f32;
    let (x, y) = (within(along + 100.0, 2.6), within(up, 2.8));
    (0.8..1.9).contains(&x) && (0.9..2.2).contains(&y)
}

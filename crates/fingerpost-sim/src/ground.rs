//! The ground around the route as a raster: how far the road's edge is, which stroke is nearest, tone and shadow.
//!
//! Square tiles of 16 m within [`REACH_M`] of the route, cells of 0.25 m, looked up bilinearly; straight road edges
//! come out exactly, because a distance is linear across them. Kerbs between roads of different chains are rounded by
//! the smooth minimum of their distances (Quilez's polynomial form), or joined by corners that are drawn one by one.

use std::collections::BTreeSet;

use fingerpost_geometry::Polyline;
use nalgebra::Point2;
use rayon::prelude::*;

use crate::corners::{Corner, CornerStyle, EdgeAt};
use crate::junctions::{ChainAt, Junction};
use crate::noise::{floor_int, value_noise};
use crate::roads::{RoadNetwork, Stroke};
use crate::scenery::Scenery;

/// Distance from the route up to which the ground is known, metres; beyond it is open country.
pub(crate) const REACH_M: f64 = 80.0;
/// Side of a cell, metres.
const CELL_M: f32 = 0.25;
/// Cells along a tile's side; one more row and column are kept so that interpolation stays inside a tile.
const TILE_CELLS: usize = 64;
/// Values in a tile.
const TILE_LEN: usize = (TILE_CELLS + 1) * (TILE_CELLS + 1);
/// Side of a tile, metres.
pub(crate) const TILE_M: f64 = CELL_M as f64 * TILE_CELLS as f64;
/// Radius of the circle around a tile, metres.
const TILE_RADIUS_M: f64 = 0.5 * TILE_M * std::f64::consts::SQRT_2;
/// Largest distance stored, metres.
const FAR_M: f64 = 30.0;
/// Steps of stored distances, metres.
const DISTANCE_STEP_M: f64 = 0.001;
/// Width of the smooth minimum, metres: kerbs at right angles are rounded by about 4 m.
const ROUNDING_M: f64 = 4.7;
/// A corner lies within this distance of its junction, metres: the longest tangent, and half of a wide road at an angle.
const CORNER_REACH_M: f64 = 30.0;

/// What is stored of a place.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// Distance to the road's edge, [`DISTANCE_STEP_M`], negative on the road.
    edge: i16,
    /// The same for the nearest road of another chain, without rounding.
    other: i16,
    /// Nearest stroke; none far from any.
    stroke: u32,
    /// Bytes from the lowest: share of the sunlight taken away, large-scale brightness, large-scale hue.
    tones: u32,
}

/// The ground at a place, interpolated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroundPoint {
    /// Distance to the road's edge, metres, negative on the road.
    pub(crate) edge_m: f32,
    /// Change of `edge_m` for each metre east and north.
    pub(crate) edge_slope: [f32; 2],
    /// Distance to the edge of the nearest road of another chain, metres.
    pub(crate) other_m: f32,
    /// Index of the nearest stroke; none far from any.
    pub(crate) stroke: Option<u32>,
    /// Share of the sunlight taken away, 0 to 1.
    pub(crate) shadow: f32,
    /// Large-scale brightness, -1 to 1.
    pub(crate) tone: f32,
    /// Large-scale hue, -1 to 1.
    pub(crate) hue: f32,
}

/// What one step of a blended tone is worth.
const PER_TONE: f32 = 1.0 / (255.0 * 256.0);
/// Mark of a place without a stroke nearby.
const NO_STROKE: u32 = u32::MAX;

impl GroundPoint {
    /// Country beyond the raster.
    pub(crate) const OPEN: Self = Self {
        edge_m: FAR_M as f32,
        edge_slope: [0.0; 2],
        other_m: FAR_M as f32,
        stroke: None,
        shadow: 0.0,
        tone: 0.0,
        hue: 0.0,
    };
}

/// The raster.
#[derive(Debug, Clone)]
pub(crate) struct GroundMap {
    low: [i32; 2],
    columns: usize,
    rows: usize,
    /// For each tile of the bounding rectangle its number among `cells`; none where nothing is known.
    numbers: Vec<Option<u32>>,
    cells: Vec<Cell>,
}

impl GroundMap {
    /// The ground around `route`.
    pub(crate) fn new(
        seed: u64,
        route: &Polyline,
        roads: &RoadNetwork,
        corners: CornerStyle,
        scenery: &Scenery,
    ) -> Self {
        let wanted = tiles_near(route);
        let low = [0, 1].map(|axis| wanted.iter().map(|tile| tile[axis]).min().unwrap_or(0));
        let high = [0, 1].map(|axis| wanted.iter().map(|tile| tile[axis]).max().unwrap_or(0));
        let (columns, rows) = ((high[0] - low[0] + 1) as usize, (high[1] - low[1] + 1) as usize);
        let mut numbers = vec![None; columns * rows];
        for (number, tile) in wanted.iter().enumerate() {
            numbers[(tile[1] - low[1]) as usize * columns + (tile[0] - low[0]) as usize] =
                Some(number as u32);
        }
        let tiles: Vec<[i32; 2]> = wanted.into_iter().collect();
        let filler = TileFiller { seed, roads, corners, scenery };
        let cells = tiles.par_iter().flat_map_iter(|&tile| filler.cells(tile)).collect();
        Self { low, columns, rows, numbers, cells }
    }

    /// The ground at a place of the map, metres.
    #[inline]
    pub(crate) fn at(&self, x: f32, y: f32) -> GroundPoint {
        let (cx, cy) = (x * (1.0 / CELL_M), y * (1.0 / CELL_M));
        let (column, row) = (floor_int(cx), floor_int(cy));
        let tile_column = (column >> TILE_CELLS.trailing_zeros()) - self.low[0];
        let tile_row = (row >> TILE_CELLS.trailing_zeros()) - self.low[1];
        if tile_column < 0
            || tile_row < 0
            || tile_column as usize >= self.columns
            || tile_row as usize >= self.rows
        {
            return GroundPoint::OPEN;
        }
        let Some(number) = self.numbers[tile_row as usize * self.columns + tile_column as usize] else {
            return GroundPoint::OPEN;
        };
        let mask = TILE_CELLS - 1;
        let (c, r) = (column as usize & mask, row as usize & mask);
        let start = number as usize * TILE_LEN + r * (TILE_CELLS + 1) + c;
        let (near, far) =
            (&self.cells[start..start + 2], &self.cells[start + TILE_CELLS + 1..start + TILE_CELLS + 3]);
        let (fx, fy) = (cx - column as f32, cy - row as f32);
        blend([&near[0], &near[1], &far[0], &far[1]], fx, fy)
    }
}

#[inline]
fn blend([a, b, c, d]: [&Cell; 4], fx: f32, fy: f32) -> GroundPoint {
    let mix = |value: fn(&Cell) -> f32| {
        let near = value(a) + (value(b) - value(a)) * fx;
        let far = value(c) + (value(d) - value(c)) * fx;
        near + (far - near) * fy
    };
    let step = DISTANCE_STEP_M as f32;
    let edge = |cell: &Cell| f32::from(cell.edge);
    let east = (edge(b) - edge(a)) * (1.0 - fy) + (edge(d) - edge(c)) * fy;
    let north = (edge(c) - edge(a)) * (1.0 - fx) + (edge(d) - edge(b)) * fx;
    let nearest = match (fx > 0.5, fy > 0.5) {
        (false, false) => a,
        (true, false) => b,
        (false, true) => c,
        (true, true) => d,
    };
    let (weight_x, weight_y) = ((fx * 256.0) as i32 as u32, (fy * 256.0) as i32 as u32);
    // Two bytes are blended at once, in lanes of 16 bits; the upper eight of each remain between the two steps.
    let lanes = |shift: u32| {
        let byte_pair = |cell: &Cell| (cell.tones >> shift) & 0x00FF_00FF;
        let row = |left: &Cell, right: &Cell| {
            ((byte_pair(left) * (256 - weight_x) + byte_pair(right) * weight_x) >> 8) & 0x00FF_00FF
        };
        row(a, b) * (256 - weight_y) + row(c, d) * weight_y
    };
    let (shadow_hue, tone) = (lanes(0), lanes(8));
    GroundPoint {
        edge_m: step * mix(|cell| f32::from(cell.edge)),
        edge_slope: [east * step / CELL_M, north * step / CELL_M],
        other_m: step * mix(|cell| f32::from(cell.other)),
        stroke: (nearest.stroke != NO_STROKE).then_some(nearest.stroke),
        shadow: (shadow_hue & 0xFFFF) as f32 * PER_TONE,
        tone: tone as f32 * (2.0 * PER_TONE) - 1.0,
        hue: (shadow_hue >> 16) as f32 * (2.0 * PER_TONE) - 1.0,
    }
}

/// Tiles within reach of the route, in a fixed order.
fn tiles_near(route: &Polyline) -> BTreeSet<[i32; 2]> {
    let mut tiles = BTreeSet::new();
    let span = (REACH_M / TILE_M).ceil() as i32 + 1;
    let samples = (route.length_m() / (0.5 * TILE_M)).ceil() as usize;
    for i in 0..=samples {
        let p = route.at((0.5 * TILE_M * i as f64).min(route.length_m())).0;
        let (column, row) = ((p.x / TILE_M).floor() as i32, (p.y / TILE_M).floor() as i32);
        for c in column - span..=column + span {
            for r in row - span..=row + span {
                if (tile_middle([c, r]) - p).norm() < REACH_M + TILE_RADIUS_M {
                    tiles.insert([c, r]);
                }
            }
        }
    }
    tiles
}

fn tile_middle(tile: [i32; 2]) -> Point2<f64> {
    Point2::new((f64::from(tile[0]) + 0.5) * TILE_M, (f64::from(tile[1]) + 0.5) * TILE_M)
}

/// Distance to the edge of the nearest road, metres, to that of the nearest of another chain, and the nearest stroke.
fn nearest_roads(p: Point2<f64>, strokes: &[Stroke], candidates: &[u32]) -> (f64, f64, u32) {
    let (mut best, mut second) = ((f64::INFINITY, NO_STROKE, NO_STROKE), f64::INFINITY);
    for &index in candidates {
        let stroke = &strokes[index as usize];
        let distance = stroke.edge_distance_m(p);
        if stroke.chain == best.1 {
            if distance < best.0 {
                best = (distance, stroke.chain, index);
            }
        } else if distance < best.0 {
            second = best.0;
            best = (distance, stroke.chain, index);
        } else {
            second = second.min(distance);
        }
    }
    (best.0, second, best.2)
}

/// The smooth minimum of the distances to two roads' edges, metres.
fn rounded(nearest_m: f64, second_m: f64) -> f64 {
    let overlap = (ROUNDING_M - (nearest_m - second_m).abs()).max(0.0) / ROUNDING_M;
    if second_m.is_finite() { nearest_m - overlap * overlap * ROUNDING_M * 0.25 } else { nearest_m }
}

struct TileFiller<'a> {
    seed: u64,
    roads: &'a RoadNetwork,
    corners: CornerStyle,
    scenery: &'a Scenery,
}

impl TileFiller<'_> {
    fn cells(&self, tile: [i32; 2]) -> Vec<Cell> {
        let middle = tile_middle(tile);
        let candidates = self.roads.within(middle, FAR_M + TILE_RADIUS_M);
        let junctions: Vec<&Junction> = match self.corners {
            CornerStyle::Alike => Vec::new(),
            CornerStyle::Drawn => {
                let near = |j: &&Junction| (j.p_in_map - middle).norm() < CORNER_REACH_M + TILE_RADIUS_M;
                self.roads.junctions().iter().filter(near).collect()
            }
        };
        let casters = self.scenery.casting_onto(middle, TILE_RADIUS_M);
        let side = TILE_CELLS as i32 + 1;
        (0..side * side)
            .map(|i| {
                let (column, row) =
                    (tile[0] * TILE_CELLS as i32 + i % side, tile[1] * TILE_CELLS as i32 + i / side);
                let (x, y) = (column as f32 * CELL_M, row as f32 * CELL_M);
                let p = Point2::new(f64::from(x), f64::from(y));
                let (nearest, other, stroke) = nearest_roads(p, self.roads.strokes(), &candidates);
                let edge = match self.corners {
                    CornerStyle::Alike => rounded(nearest, other),
                    CornerStyle::Drawn => {
                        let joins = junctions.iter().map(|junction| self.join_m(p, junction, nearest));
                        joins.fold(nearest, f64::min)
                    }
                };
                let stored = |distance: f64| (distance.clamp(-FAR_M, FAR_M) / DISTANCE_STEP_M).round() as i16;
                let wave = |i: u64, size: f32| value_noise(self.seed ^ i, x / size, y / size);
                let hue = (255.0 * (0.6 * wave(0xB1, 9.0) + 0.4 * wave(0xB2, 2.7))) as u32;
                let shadow = (255.0 * self.scenery.shadow(&casters, x, y)) as u32;
                Cell {
                    edge: stored(edge),
                    other: stored(other),
                    stroke,
                    tones: shadow | (u32::from(self.tone(x, y)) << 8) | (hue << 16),
                }
            })
            .collect()
    }

    /// Distance to the nearest join of a junction's corners, metres, negative on the road; infinite where there is none.
    /// `nearest_m` is the distance to the edge of the nearest road.
    fn join_m(&self, p: Point2<f64>, junction: &Junction, nearest_m: f64) -> f64 {
        let offset = p - junction.p_in_map;
        if offset.norm() > CORNER_REACH_M {
            return f64::INFINITY;
        }
        let edge = |met: &ChainAt| {
            let arm = met.arm_towards(offset)?;
            let stroke = &self.roads.strokes()[arm.stroke as usize];
            Some((EdgeAt::of(stroke, p), (arm, stroke.half_width_m)))
        };
        let mut join_m = f64::INFINITY;
        for (i, one) in junction.chains.iter().enumerate() {
            let Some((one_edge, one_arm)) = edge(one) else { continue };
            for other in &junction.chains[i + 1..] {
                let Some((other_edge, other_arm)) = edge(other) else { continue };
                // An arm goes on straight here; where the road itself bends away there is none.
                let is_inside = one_edge.distance_m < 0.0 || other_edge.distance_m < 0.0;
                if is_inside && nearest_m > 0.0 {
                    continue;
                }
                // A road that ends at the junction has no corner on the far side of the one that it joins.
                let is_there = |leaves: Option<nalgebra::Vector2<f64>>, joined: &EdgeAt| {
                    leaves.is_none_or(|direction| direction.dot(&joined.outwards) > 0.0)
                };
                if is_there(other.leaves, &one_edge) && is_there(one.leaves, &other_edge) {
                    let sides = [(one.chain, one_edge.is_left), (other.chain, other_edge.is_left)];
                    // From one road into the other the way turns by the angle between the edges' normals.
                    let turn_rad = one_edge.outwards.angle(&other_edge.outwards);
                    let corner = Corner::drawn(self.seed, junction.id, sides[0], sides[1]);
                    let corner = corner.between([one_arm, other_arm], turn_rad);
                    join_m = join_m.min(corner.edge_m(&one_edge, &other_edge));
                }
            }
        }
        join_m
    }

    /// Stains of several sizes, and the odd square patch where the road was opened.
    fn tone(&self, x: f32, y: f32) -> u8 {
        let wave = |i: u64, size: f32| value_noise(self.seed ^ (0xA0 + i), x / size, y / size);
        let stains = 0.35 * wave(0, 23.0) + 0.3 * wave(1, 7.0) + 0.2 * wave(2, 2.3) + 0.15 * wave(3, 0.9);
        let (column, row) = (floor_int(x / PATCH_CELL_M), floor_int(y / PATCH_CELL_M));
        let hash = crate::noise::cell_hash(self.seed ^ 0xC0, column, row);
        let part = |shift: u32| ((hash >> shift) & 0xFF) as f32 / 255.0;
        let (inside_x, inside_y) = (x - column as f32 * PATCH_CELL_M, y - row as f32 * PATCH_CELL_M);
        let (left, bottom) = (part(8) * 3.0, part(16) * 3.0);
        let patched = part(0) < PATCH_SHARE
            && (left..left + 1.0 + 2.0 * part(24)).contains(&inside_x)
            && (bottom..bottom + 1.0 + 2.0 * part(32)).contains(&inside_y);
        (255.0 * (stains - if patched { 0.22 } else { 0.0 }).clamp(0.0, 1.0)) as u8
    }
}

/// Squares of which some hold a repaired patch, metres.
const PATCH_CELL_M: f32 = 6.0;
/// Share of them that do.
const PATCH_SHARE: f32 = 0.3;

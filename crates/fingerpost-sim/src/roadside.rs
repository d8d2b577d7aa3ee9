//! Lamp posts and guard rails: where they stand, and the shadows that they throw across and along the road.
//!
//! Everything follows from the road (its chain of strokes) and the distance along it. The shadows are computed where they
//! fall, not looked up in the ground's raster, whose cells are as wide as a post's shadow.

use nalgebra::Point2;

use crate::Conditions;
use crate::noise::{floor_int, mix, unit};
use crate::object::{Object, Part, Shape};
use crate::relief::Relief;
use crate::roads::{RoadNetwork, Stroke};

/// Distance of posts and of the rail from the road's edge, metres.
const POST_ASIDE_M: f32 = 1.3;
const RAIL_ASIDE_M: f32 = 0.6;
/// Height and width of a lamp post, metres.
const POST_HEIGHT_M: f32 = 7.0;
const POST_WIDTH_M: f32 = 0.2;
/// Lower and upper edge of a rail's plank, metres; its pieces and the distance of its posts, and their width.
const PLANK_M: [f32; 2] = [0.45, 0.76];
const PIECE_M: f64 = 6.0;
const RAIL_POST_M: f32 = 3.0;
const RAIL_POST_WIDTH_M: f32 = 0.12;
/// Thickness of a plank, metres.
const PLANK_THICK_M: f32 = 0.08;
/// Length of roadside that has a rail or none, metres.
const RAIL_STRETCH_M: f32 = 180.0;
/// A sun that stands along the road throws no rail's shadow on it: metres across for each metre of height.
const LEAST_THROW: f32 = 0.05;

/// What stands along the roads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Roadside {
    seed: u64,
    post_spacing_m: f32,
    rails: f32,
    /// Where a shadow falls for each metre of height, metres east and north.
    throw: [f32; 2],
}

/// A place beside a road: its chain, distance along it and to its left, half of its width, its direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BesideRoad {
    pub(crate) chain: u32,
    pub(crate) along_m: f32,
    pub(crate) left_m: f32,
    pub(crate) half_width_m: f32,
    pub(crate) direction: [f32; 2],
}

/// Share of a pixel of that extent that a strip covers.
type Covered = fn(f32, f32, f32) -> f32;

impl Roadside {
    /// None where nothing stands along roads.
    pub(crate) fn new(seed: u64, conditions: &Conditions) -> Option<Self> {
        if conditions.posts_per_100_m <= 0.0 && conditions.guard_rails <= 0.0 {
            return None;
        }
        let (sin_up, cos_up) = libm::sincos(conditions.sun_elevation_rad);
        let (sin, cos) = libm::sincos(conditions.sun_azimuth_rad);
        // Posts stand on both sides in turns.
        let post_spacing_m =
            if conditions.posts_per_100_m > 0.0 { 200.0 / conditions.posts_per_100_m } else { 1e9 };
        Some(Self {
            seed,
            post_spacing_m: post_spacing_m as f32,
            rails: conditions.guard_rails as f32,
            throw: [-cos_up * cos / sin_up, -cos_up * sin / sin_up].map(|x| x as f32),
        })
    }

    fn draw(&self, topic: u64, chain: u32, number: i32) -> f32 {
        unit(mix(self.seed ^ mix(topic ^ mix((u64::from(chain) << 32) | u64::from(number as u32)))))
    }

    /// Where along its road the post of that number stands on a side, metres.
    fn post_m(&self, chain: u32, side: f32, number: i32) -> f32 {
        let topic = if side > 0.0 { 0x504c } else { 0x5052 };
        let offset = if side > 0.0 { 0.0 } else { 0.5 };
        (number as f32 + offset + 0.3 * (self.draw(topic, chain, number) - 0.5)) * self.post_spacing_m
    }

    fn has_rail(&self, chain: u32, side: f32, along_m: f32) -> bool {
        let topic = if side > 0.0 { 0x524c } else { 0x5252 };
        self.draw(topic, chain, floor_int(along_m / RAIL_STRETCH_M)) < self.rails
    }

    /// Share of the sunlight that posts and rails take from a pixel with these extents along and across the road, metres.
    pub(crate) fn shadow(
        &self,
        place: &BesideRoad,
        [along_extent_m, across_extent_m]: [f32; 2],
        covered: Covered,
    ) -> f32 {
        let [x, y] = place.direction;
        let along = self.throw[0] * x + self.throw[1] * y;
        let across = self.throw[1] * x - self.throw[0] * y;
        if across.abs() < LEAST_THROW {
            return 0.0;
        }
        let mut shadow = 0.0_f32;
        // Things on the sun's side alone throw shadows towards the road.
        let side = -across.signum();
        let length = (along * along + across * across).sqrt();
        // Height of what throws its shadow here, were it so far beside the road; and where along the road that stands.
        let thrown_by = |aside_m: f32| {
            let height_m = (place.left_m - side * (place.half_width_m + aside_m)) / across;
            (height_m, place.along_m - along * height_m)
        };
        // A strip's width across itself, seen along the road.
        let slant = across.abs() / length;
        let (height_m, foot_m) = thrown_by(POST_ASIDE_M);
        if (0.0..POST_HEIGHT_M).contains(&height_m) {
            let number = floor_int(foot_m / self.post_spacing_m + if side > 0.0 { 0.5 } else { 0.0 });
            let gap_m = (foot_m - self.post_m(place.chain, side, number)) * slant;
            shadow = covered(gap_m, POST_WIDTH_M, along_extent_m * slant + across_extent_m * (1.0 - slant));
        }
        let (height_m, foot_m) = thrown_by(RAIL_ASIDE_M);
        if height_m < 1.0 + across_extent_m
            && height_m > -across_extent_m
            && self.has_rail(place.chain, side, foot_m)
        {
            let plank = covered(
                (height_m - 0.5 * (PLANK_M[0] + PLANK_M[1])) * across.abs(),
                (PLANK_M[1] - PLANK_M[0]) * across.abs(),
                across_extent_m,
            );
            shadow = shadow.max(plank);
            if (0.0..PLANK_M[0]).contains(&height_m) {
                let gap_m = foot_m - RAIL_POST_M * floor_int(foot_m / RAIL_POST_M + 0.5) as f32;
                shadow = shadow.max(covered(gap_m * slant, RAIL_POST_WIDTH_M, along_extent_m * slant));
            }
        }
        shadow.clamp(0.0, 1.0)
    }

    /// All posts and rails along the roads where `wanted` says so.
    pub(crate) fn objects(
        &self,
        roads: &RoadNetwork,
        relief: &Relief,
        wanted: impl Fn(Point2<f64>) -> bool,
    ) -> Vec<Object> {
        let mut objects = Vec::new();
        for chain in roads.strokes().chunk_by(|a, b| a.chain == b.chain) {
            for side in [-1.0_f32, 1.0] {
                self.stand(chain, side, relief, &wanted, &mut objects);
            }
        }
        objects
    }

    fn stand(
        &self,
        chain: &[Stroke],
        side: f32,
        relief: &Relief,
        wanted: &impl Fn(Point2<f64>) -> bool,
        objects: &mut Vec<Object>,
    ) {
        let (Some(first), Some(last)) = (chain.first(), chain.last()) else { return };
        let (from_m, to_m) = (first.along_m, last.along_m + last.length_m);
        let number = |along_m: f64| (along_m / f64::from(self.post_spacing_m)) as i32;
        let foot = |place: Point2<f64>| [place.x as f32, place.y as f32, relief.height_m(place) as f32];
        for post in number(from_m)..=number(to_m) {
            let along_m = f64::from(self.post_m(first.chain, side, post));
            let Some(place) = beside(chain, along_m, side * POST_ASIDE_M).filter(|p| wanted(*p)) else {
                continue;
            };
            let half = 0.5 * POST_WIDTH_M;
            let shape = Shape::Beam {
                direction: [1.0, 0.0],
                half_m: [half; 2],
                height_m: [0.0, POST_HEIGHT_M],
                part: Part::Metal,
            };
            objects.push(Object { foot: foot(place), shape, hash: 0 });
        }
        let pieces = ((to_m - from_m) / PIECE_M) as usize;
        for along_m in (0..pieces).map(|i| from_m + i as f64 * PIECE_M) {
            if !self.has_rail(first.chain, side, along_m as f32) {
                continue;
            }
            let ends = [along_m, along_m + PIECE_M].map(|at_m| beside(chain, at_m, side * RAIL_ASIDE_M));
            let [Some(start), Some(end)] = ends else { continue };
            let (middle, way) = (nalgebra::center(&start, &end), end - start);
            if !wanted(middle) || way.norm() < 0.5 * PIECE_M {
                continue;
            }
            let direction = [(way.x / way.norm()) as f32, (way.y / way.norm()) as f32];
            let half_m = [0.5 * way.norm() as f32, 0.5 * PLANK_THICK_M];
            let plank = Shape::Beam { direction, half_m, height_m: PLANK_M, part: Part::Metal };
            objects.push(Object { foot: foot(middle), shape: plank, hash: 1 });
            let half = 0.5 * RAIL_POST_WIDTH_M;
            let post =
                Shape::Beam { direction, half_m: [half; 2], height_m: [0.0, PLANK_M[1]], part: Part::Metal };
            objects.push(Object { foot: foot(start), shape: post, hash: 1 });
        }
    }
}

/// The place beside a chain at a distance along it and from its edge, metres, to the left where positive.
pub(crate) fn beside(chain: &[Stroke], along_m: f64, aside_m: f32) -> Option<Point2<f64>> {
    let after = chain.partition_point(|stroke| stroke.along_m <= along_m);
    let stroke = chain.get(after.checked_sub(1)?)?;
    let left = nalgebra::Vector2::new(-stroke.direction.y, stroke.direction.x);
    let aside_m = f64::from(aside_m) + stroke.half_width_m * f64::from(aside_m.signum());
    let within = along_m <= stroke.along_m + stroke.length_m + 0.1;
    within.then(|| stroke.start + stroke.direction * (along_m - stroke.along_m) + left * aside_m)
}

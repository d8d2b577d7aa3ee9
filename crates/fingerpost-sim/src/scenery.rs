//! Houses, trees, posts, rails, walls and hedges along the roads, and the shadows that houses and trees cast.

use nalgebra::{Point2, Vector2};

use crate::Conditions;
use crate::frontage;
use crate::noise::{Stream, cell_hash, mix, unit, value_noise};
use crate::object::{Object, Part, Ray, Shape};
use crate::relief::Relief;
use crate::roads::{RoadNetwork, Stroke};
use crate::roadside::Roadside;
use crate::street::{self, Street};

/// Objects stand at most this much farther from the road than they must, metres.
const SETBACK_M: f64 = 9.0;

/// Everything that stands beside the roads.
#[derive(Debug, Clone)]
pub(crate) struct Scenery {
    objects: Vec<Object>,
    /// Unit vector towards the sun, map frame.
    to_sun: [f32; 3],
}

impl Scenery {
    /// Houses and trees where `wanted` says so, none on a road or nearer to one than the conditions' clearance.
    pub(crate) fn new(
        seed: u64,
        conditions: &Conditions,
        roads: &RoadNetwork,
        relief: &Relief,
        wanted: impl Fn(Point2<f64>) -> bool,
    ) -> Self {
        let mut planter = Planter { objects: Vec::new(), roads, relief, clearance_m: conditions.clearance_m };
        for (kind, per_100_m) in
            [(Kind::House, conditions.houses_per_100_m), (Kind::Tree, conditions.trees_per_100_m)]
        {
            for (i, stroke) in roads.strokes().iter().enumerate() {
                let mut stream = Stream::new(mix(seed ^ kind as u64), i as u64);
                for side in [-1.0, 1.0] {
                    planter.line(&mut stream, kind, stroke, side, per_100_m, &wanted);
                }
            }
        }
        if let Some(roadside) = Roadside::new(seed, conditions) {
            planter.objects.extend(roadside.objects(roads, relief, &wanted));
        }
        if let Some(street) = Street::new(seed, conditions) {
            let share = conditions.walls as f32;
            planter.objects.extend(street::standing(&street, share, roads, relief, &wanted));
        }
        planter.objects.extend(frontage::standing(seed, &conditions.streetscape, roads, relief, &wanted));
        let (sin_up, cos_up) = libm::sincos(conditions.sun_elevation_rad);
        let (sin, cos) = libm::sincos(conditions.sun_azimuth_rad);
        Self { objects: planter.objects, to_sun: [cos_up * cos, cos_up * sin, sin_up].map(|x| x as f32) }
    }

    /// All objects.
    pub(crate) fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Unit vector towards the sun, map frame.
    pub(crate) fn to_sun(&self) -> [f32; 3] {
        self.to_sun
    }

    /// Objects whose shadow may fall into a circle.
    pub(crate) fn casting_onto(&self, middle: Point2<f64>, radius_m: f64) -> Vec<Object> {
        let (x, y) = (middle.x as f32, middle.y as f32);
        let flat = (self.to_sun[0] * self.to_sun[0] + self.to_sun[1] * self.to_sun[1]).sqrt();
        let raised = self.objects.iter().filter(|object| {
            !matches!(object.shape, Shape::Beam { part: Part::Metal | Part::Painted | Part::Person, .. })
        });
        let objects = raised.filter(|object| {
            let throw = object.height_m() * flat / self.to_sun[2];
            let (dx, dy) = (object.foot[0] - x, object.foot[1] - y);
            let reach = radius_m as f32 + object.radius_m() + throw;
            dx * dx + dy * dy < reach * reach
        });
        objects.copied().collect()
    }

    /// Share of the sunlight that `casters` take from a place on the ground.
    pub(crate) fn shadow(&self, casters: &[Object], x: f32, y: f32) -> f32 {
        let mut light = 1.0;
        for caster in casters {
            // The ground's waves are low against any object: it is level from here to there.
            let ray = Ray { origin: [x, y, caster.foot[2] + 0.01], direction: self.to_sun };
            if caster.hit(&ray).is_some() {
                light *= match caster.shape {
                    Shape::House { .. }
                    | Shape::Beam { part: Part::Masonry | Part::Crown | Part::Fence, .. } => 0.0,
                    // Sun flecks under leaves.
                    Shape::Tree { .. } => 0.45 * (value_noise(caster.hash, x * 2.5, y * 2.5) - 0.35).max(0.0),
                    // What stands in the raster's way is too thin for it, or moves.
                    Shape::Beam { .. } | Shape::Vehicle(_) => 1.0,
                };
            }
        }
        1.0 - light
    }
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    House = 0x484f,
    Tree = 0x5452,
}

struct Planter<'a> {
    objects: Vec<Object>,
    roads: &'a RoadNetwork,
    relief: &'a Relief,
    clearance_m: f64,
}

impl Planter<'_> {
    fn line(
        &mut self,
        stream: &mut Stream,
        kind: Kind,
        stroke: &Stroke,
        side: f64,
        per_100_m: f64,
        wanted: &impl Fn(Point2<f64>) -> bool,
    ) {
        if per_100_m <= 0.0 {
            return;
        }
        let spacing_m = 100.0 / per_100_m;
        // A random start keeps the density where strokes are shorter than the spacing.
        let mut along_m = stream.unit() * spacing_m;
        while along_m < stroke.length_m {
            let mut object = draw(stream, kind, stroke.direction);
            let radius_m = f64::from(object.radius_m());
            let left_m = side
                * (stroke.half_width_m + self.clearance_m + radius_m + SETBACK_M * stream.unit().powi(2));
            let left = Vector2::new(-stroke.direction.y, stroke.direction.x);
            let place = stroke.start + stroke.direction * along_m + left * left_m;
            along_m += spacing_m * stream.between(0.6, 1.4);
            if wanted(place) && self.is_free(place, radius_m) {
                object.foot = [place.x as f32, place.y as f32, self.relief.height_m(place) as f32];
                self.objects.push(object);
            }
        }
    }

    fn is_free(&self, place: Point2<f64>, radius_m: f64) -> bool {
        self.roads.within(place, self.clearance_m + radius_m - 1e-6).is_empty()
            && self.objects.iter().all(|other| {
                let (dx, dy) = (f64::from(other.foot[0]) - place.x, f64::from(other.foot[1]) - place.y);
                let apart = radius_m + f64::from(other.radius_m());
                // Crowns may touch; walls may not.
                let least = if matches!(other.shape, Shape::Tree { .. }) { 0.7 * apart } else { apart };
                dx * dx + dy * dy > least * least
            })
    }
}

fn draw(stream: &mut Stream, kind: Kind, direction: Vector2<f64>) -> Object {
    let hash = cell_hash((stream.unit() * 1e9) as u64, kind as i32, 0);
    let mut size = |low: f64, high: f64| stream.between(low, high) as f32;
    let shape = match kind {
        Kind::House => {
            let eaves = size(3.0, 6.5);
            let half_m = [size(4.5, 8.0), size(3.5, 5.0)];
            let ridge = if unit(hash) < 0.6 { direction } else { Vector2::new(-direction.y, direction.x) };
            let ridge = [ridge.x as f32, ridge.y as f32];
            Shape::House { ridge, half_m, height_m: [eaves, eaves + size(1.5, 3.5)] }
        }
        Kind::Tree => {
            let crown_m = [size(1.1, 2.8), size(1.4, 3.4)];
            Shape::Tree { trunk_m: size(0.12, 0.28), crown_m, middle_m: crown_m[1] + size(1.4, 2.6) }
        }
    };
    Object { foot: [0.0; 3], shape, hash }
}

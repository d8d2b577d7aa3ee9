//! The ray caster: one ray a pixel, against the ground's raster and the few objects near its tile of the picture.
//!
//! Rays are taken through the lens once, in the camera frame; a frame's pose only turns them. The picture is worked in
//! bands of square tiles; a tile keeps the objects whose ball its cone of rays may touch, whatever the lens does.
//! Every pixel depends on the frame and its own place alone, so bands can be rendered in any order.

use fingerpost_geometry::Camera;
use fingerpost_vision::picture::{Plane, RgbImage};
use nalgebra::Isometry3;
use rayon::prelude::*;

use crate::conditions::Conditions;
use crate::ground::GroundMap;
use crate::lens::{Lens, TILE_PX};
use crate::noise::mix;
use crate::object::{Hit, Object, Ray, dot};
use crate::relief::ReliefRaster;
use crate::scenery::Scenery;
use crate::sky::Sky;
use crate::surface::{Colour, Footprint, Painter};
use crate::{SimError, tone};

/// Objects farther off than this are left to the haze, metres.
const OBJECT_REACH_M: f32 = 160.0;
/// Ground farther off than this is seen so flatly that its waves do not matter, metres.
const RELIEF_REACH_M: f32 = 300.0;
/// A step of the search for the ground that is shorter than this many pixels of ground is the last: the ground's slope
/// of a few hundredths leaves a tenth of a pixel after it.
const GUESS_TOLERANCE: f32 = 3.0;
/// Distant woods hide the ground beyond, metres.
const GROUND_REACH_M: f32 = 900.0;
/// Light of the open sky and of the sun on a surface that faces them.
const SKY_LIGHT: Colour = [0.33, 0.39, 0.50];
const SUN_LIGHT: Colour = [1.06, 1.00, 0.88];

/// Where the camera is in a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrameView {
    /// Number of the frame, for its noise.
    pub(crate) frame: u64,
    /// Pose of the camera in the map frame.
    pub(crate) map_from_camera: Isometry3<f64>,
    /// Height of the ground below the vehicle, metres.
    pub(crate) ground_m: f64,
}

/// Everything that does not change from frame to frame.
#[derive(Debug, Clone)]
pub(crate) struct Renderer {
    width: usize,
    height: usize,
    lens: Lens,
    pub(crate) ground: GroundMap,
    relief: ReliefRaster,
    scenery: Scenery,
    painter: Painter,
    sky: Sky,
    develop: tone::Development,
    seed: u64,
    shadow_strength: f32,
}

/// An object near the camera, relative to it, metres.
#[derive(Debug, Clone, Copy)]
struct Neighbour {
    object: u32,
    /// Middle of the ball around it.
    middle: [f32; 3],
    /// Radius of that ball.
    ball_m: f32,
    /// Distance of the ball's middle.
    distance_m: f32,
    /// Radius of the upright cylinder around it.
    radius_m: f32,
    /// Distance over ground at which that cylinder begins.
    from_m: f32,
    /// Height of its top above the camera.
    top_m: f32,
}

impl Neighbour {
    fn new(object: u32, shape: &Object, origin: [f32; 3]) -> Self {
        let (middle, ball_m) = shape.ball();
        let middle = [0, 1, 2].map(|i| middle[i] - origin[i]);
        let radius_m = shape.radius_m();
        let over_ground_m = (middle[0] * middle[0] + middle[1] * middle[1]).sqrt();
        Self {
            object,
            middle,
            ball_m,
            distance_m: dot(middle, middle).sqrt(),
            radius_m,
            from_m: (over_ground_m - radius_m).max(0.0),
            top_m: shape.foot[2] + shape.height_m() - origin[2],
        }
    }

    /// Whether a ray cannot meet the upright cylinder around the object, or is above its top when it gets there.
    #[inline]
    fn is_missed(&self, d: [f32; 3]) -> bool {
        let flat2 = d[0] * d[0] + d[1] * d[1];
        let beside = self.middle[0] * d[1] - self.middle[1] * d[0];
        // The square keeps the comparison free of roots; it is only right where both sides are positive.
        let rise = self.from_m * d[2];
        beside * beside > self.radius_m * self.radius_m * flat2
            || (rise > 0.0 && rise * rise > self.top_m * self.top_m.abs() * flat2)
    }
}

impl Renderer {
    pub(crate) fn new(
        camera: &Camera,
        conditions: &Conditions,
        seed: u64,
        ground: GroundMap,
        relief: ReliefRaster,
        scenery: Scenery,
        painter: Painter,
    ) -> Result<Self, SimError> {
        Ok(Self {
            width: camera.width(),
            height: camera.height(),
            lens: Lens::new(camera)?,
            ground,
            relief,
            scenery,
            painter,
            sky: Sky::new(seed),
            develop: tone::Development::new(conditions),
            seed,
            shadow_strength: conditions.shadow_strength as f32,
        })
    }

    /// The picture of a frame, and its mask of road: 255 where the pixel shows road, 0 elsewhere.
    pub(crate) fn render(&self, view: &FrameView) -> (RgbImage, Plane<u8>) {
        let mut picture = RgbImage::new(self.width, self.height);
        let mut road = Plane::new(self.width, self.height, 0_u8);
        let shot = Shot::new(self, view);
        let bands = picture
            .as_mut_slice()
            .par_chunks_mut(TILE_PX * self.width * 3)
            .zip(road.as_mut_slice().par_chunks_mut(TILE_PX * self.width));
        bands.enumerate().for_each(|(band, (pixels, mask))| shot.band(band, pixels, mask));
        (picture, road)
    }
}

/// A frame being rendered.
struct Shot<'a> {
    scene: &'a Renderer,
    /// Columns of the rotation from camera to map.
    rotation: [[f32; 3]; 3],
    origin: [f32; 3],
    ground_m: f32,
    noise_seed: u64,
    /// Objects within reach, nearest first.
    near: Vec<Neighbour>,
}

impl<'a> Shot<'a> {
    fn new(scene: &'a Renderer, view: &FrameView) -> Self {
        let matrix = view.map_from_camera.rotation.to_rotation_matrix();
        let rotation = [0, 1, 2].map(|c| [0, 1, 2].map(|r| matrix[(r, c)] as f32));
        let origin = [0, 1, 2].map(|i| view.map_from_camera.translation.vector[i] as f32);
        let objects = scene.scenery.objects().iter().enumerate();
        let mut near: Vec<Neighbour> = objects
            .map(|(index, object)| Neighbour::new(index as u32, object, origin))
            .filter(|near| near.distance_m < OBJECT_REACH_M && dot(near.middle, rotation[2]) > -near.ball_m)
            .collect();
        near.sort_by(|a, b| a.from_m.total_cmp(&b.from_m).then(a.object.cmp(&b.object)));
        let noise_seed = mix(scene.seed ^ mix(view.frame ^ 0x4652_414d));
        Self { scene, rotation, origin, ground_m: view.ground_m as f32, noise_seed, near }
    }

    fn turned(&self, d: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.rotation;
        [0, 1, 2].map(|i| x[i] * d[0] + y[i] * d[1] + z[i] * d[2])
    }

    fn band(&self, band: usize, pixels: &mut [u8], mask: &mut [u8]) {
        let width = self.scene.width;
        let first = band * TILE_PX * width;
        let mut candidates: Vec<Neighbour> = Vec::new();
        for (column, left) in (0..width).step_by(TILE_PX).enumerate() {
            self.candidates(band * width.div_ceil(TILE_PX) + column, &mut candidates);
            for row in 0..mask.len() / width {
                // Ground seen by neighbouring pixels is about as high: a good first guess.
                let mut ground_m = self.ground_m;
                for u in left..(left + TILE_PX).min(width) {
                    let i = row * width + u;
                    let (colour, road) = self.pixel(first + i, &candidates, &mut ground_m);
                    mask[i] = road;
                    pixels[3 * i..3 * i + 3].copy_from_slice(&colour);
                }
            }
        }
    }

    /// Objects whose ball the tile's cone of rays may touch, nearest first.
    fn candidates(&self, tile: usize, found: &mut Vec<Neighbour>) {
        found.clear();
        let (axis, cos, sin) = self.scene.lens.cones[tile];
        let axis = self.turned(axis);
        for near in &self.near {
            let touches = near.distance_m <= near.ball_m || {
                // Angle to the middle at most cone plus ball: compare cosines by the addition theorem.
                let ball_sin = near.ball_m / near.distance_m;
                let ball_cos = (1.0 - ball_sin * ball_sin).sqrt();
                let limit = cos * ball_cos - sin * ball_sin;
                let more_than_half_a_turn = sin * ball_cos + cos * ball_sin < 0.0;
                more_than_half_a_turn || dot(near.middle, axis) >= limit * near.distance_m
            };
            if touches {
                found.push(*near);
            }
        }
    }

    #[inline]
    fn pixel(&self, index: usize, candidates: &[Neighbour], ground_m: &mut f32) -> ([u8; 3], u8) {
        let scene = self.scene;
        let (in_camera, off_centre) = scene.lens.pixels[index];
        if dot(in_camera, in_camera) < 0.5 {
            return ([0; 3], 0);
        }
        let direction = self.turned(in_camera);
        let ground = self.ground_distance(direction, ground_m);
        let ray = Ray { origin: self.origin, direction };
        let (light, road) = match self.first_hit(&ray, ground, candidates) {
            Some((object, hit)) => (self.object_light(object, &hit), 0),
            None if ground < GROUND_REACH_M => self.ground_light(direction, ground),
            None => (scene.sky.colour(direction), 0),
        };
        let noise = mix(self.noise_seed ^ index as u64);
        (scene.develop.develop(light, off_centre, noise), road)
    }

    /// Distance along a ray to the ground, metres; infinite above the horizon. `ground_m` is a guess of the height
    /// there and becomes the height found.
    #[inline]
    fn ground_distance(&self, d: [f32; 3], ground_m: &mut f32) -> f32 {
        if d[2] > -1e-5 {
            return f32::INFINITY;
        }
        let relief = &self.scene.relief;
        let level = (self.origin[2] - self.ground_m) / -d[2];
        if relief.is_flat() || level > RELIEF_REACH_M {
            return level;
        }
        let height = |t: f32| relief.height_m(self.origin[0] + t * d[0], self.origin[1] + t * d[1]);
        let bounded = |t: f32| t.clamp(0.5 * level, 2.0 * level);
        let tolerance = GUESS_TOLERANCE * self.scene.lens.pixel_rad;
        let (mut before, mut gap_before) = (0.0, 0.0);
        let mut t = bounded((self.origin[2] - *ground_m) / -d[2]);
        for round in 0..4 {
            let found = height(t);
            *ground_m = found;
            let gap = self.origin[2] + t * d[2] - found;
            let slope = if round > 0 { (gap - gap_before) / (t - before) } else { d[2] };
            // A ray that skims a crest has no clear slope; the plain step is safe there.
            let step = if slope < 0.3 * d[2] { gap / -slope } else { gap / -d[2] };
            (before, gap_before) = (t, gap);
            t = bounded(t + step);
            if step.abs() < tolerance * t {
                break;
            }
        }
        t
    }

    #[inline]
    fn first_hit(&self, ray: &Ray, mut limit: f32, candidates: &[Neighbour]) -> Option<(&'a Object, Hit)> {
        let objects = self.scene.scenery.objects();
        let mut best = None;
        for near in candidates {
            if near.from_m > limit {
                break;
            }
            if near.is_missed(ray.direction) {
                continue;
            }
            let object = &objects[near.object as usize];
            if let Some(hit) = object.hit(ray).filter(|hit| hit.t < limit) {
                limit = hit.t;
                best = Some((object, hit));
            }
        }
        best
    }

    #[inline]
    fn ground_light(&self, d: [f32; 3], t: f32) -> (Colour, u8) {
        let (x, y) = (self.origin[0] + t * d[0], self.origin[1] + t * d[1]);
        let point = self.scene.ground.at(x, y);
        let flat = (d[0] * d[0] + d[1] * d[1]).sqrt().max(1e-6);
        let across_m = t * self.scene.lens.pixel_rad;
        let footprint = Footprint { across_m, along_m: across_m / -d[2], sight: [d[0] / flat, d[1] / flat] };
        let (road, colour) = self.scene.painter.ground(x, y, &point, &footprint);
        let sun = (1.0 - self.scene.shadow_strength * point.shadow) * self.scene.scenery.to_sun()[2].max(0.7);
        let lit = [0, 1, 2].map(|i| colour[i] * (SKY_LIGHT[i] + SUN_LIGHT[i] * sun));
        (Sky::hazed(lit, t), if road >= 0.5 { 255 } else { 0 })
    }

    fn object_light(&self, object: &Object, hit: &Hit) -> Colour {
        let footprint_m = hit.t * self.scene.lens.pixel_rad;
        let colour = self.scene.painter.object(object, hit, footprint_m);
        let facing = dot(hit.normal, self.scene.scenery.to_sun()).max(0.0);
        // Less sky is seen by what faces down.
        let sky = 0.7 + 0.3 * hit.normal[2];
        let lit = [0, 1, 2].map(|i| colour[i] * (SKY_LIGHT[i] * sky + SUN_LIGHT[i] * facing));
        Sky::hazed(lit, hit.t)
    }
}

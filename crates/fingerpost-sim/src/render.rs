//! The ray caster: one ray a pixel, against the ground's raster and the few objects near its tile of the picture.
//!
//! Rays are taken through the lens once, in the camera frame; a frame's pose only turns them. The picture is worked in
//! bands of square tiles; a tile keeps the objects whose ball its cone of rays may touch, whatever the lens does.
//! Every pixel depends on the frame and its own place alone, so bands can be rendered in any order.
//! Wet ground is a mirror: what it shows is what the camera's mirror image below the ground would see.

mod ground;
mod lamps;
mod nearby;
mod terrain;
mod things;

use fingerpost_geometry::Camera;
use fingerpost_vision::picture::{Plane, RgbImage};
use nalgebra::Isometry3;
use rayon::prelude::*;

use self::lamps::{Lamps, glare_along};
use self::nearby::{Candidates, Nearby, first_hit};
use self::terrain::Upwards;
use self::things::{SHADOW_REACH_M, Things};
use crate::bonnet::Bonnet;
use crate::conditions::Conditions;
use crate::dirt::Dirt;
use crate::ground::GroundMap;
use crate::lens::{Lens, TILE_PX};
use crate::light::{Light, mixed};
use crate::markings::Layout;
use crate::noise::mix;
use crate::object::{Object, Ray, dot};
use crate::rain::Rain;
use crate::relief::ReliefRaster;
use crate::roadside::Roadside;
use crate::scenery::Scenery;
use crate::shown::{PixelClass, Shown};
use crate::sky::Sky;
use crate::softening::Softening;
use crate::surface::{Colour, Painter};
use crate::{SimError, tone};

/// Ground farther off than this is seen so flatly that its waves do not matter, metres.
const RELIEF_REACH_M: f32 = 300.0;
/// A step of the search for the ground that is shorter than this many pixels of ground is the last: the ground's slope
/// of a few hundredths leaves a tenth of a pixel after it.
const GUESS_TOLERANCE: f32 = 3.0;
/// Height in the sky that a bonnet mirrors, sine of the angle.
const BONNET_SEES: f32 = 0.3;
/// Distant woods hide the ground beyond, metres.
const GROUND_REACH_M: f32 = 900.0;
/// Where the camera is in a frame.
#[derive(Debug, Clone)]
pub(crate) struct FrameView {
    /// Number of the frame, for its noise.
    pub(crate) frame: u64,
    /// Time of the frame, for what moves by itself, seconds.
    pub(crate) t_s: f64,
    /// Pose of the camera in the map frame.
    pub(crate) map_from_camera: Isometry3<f64>,
    /// Height of the ground below the vehicle, metres.
    pub(crate) ground_m: f64,
    /// Pose of the vehicle in the map frame: the plane that it stands on.
    pub(crate) map_from_vehicle: Isometry3<f64>,
    /// Other vehicles.
    pub(crate) vehicles: Vec<Object>,
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
    light: Light,
    dirt: Dirt,
    seed: u64,
    shadow_strength: f32,
    shadow_detail: f32,
    wetness: f32,
    roadside: Option<Roadside>,
    retroreflection: f32,
    lamps: f32,
    rain: f64,
    bonnet: Option<Bonnet>,
    softening: Option<Softening>,
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
        let sky = Sky::new(seed, conditions);
        let size_px = [camera.width(), camera.height()];
        Ok(Self {
            bonnet: Bonnet::new(seed, conditions, size_px, sky.blurred(BONNET_SEES)),
            softening: Softening::new(camera, &conditions.camera),
            width: camera.width(),
            height: camera.height(),
            lens: Lens::new(camera)?,
            ground,
            relief,
            scenery,
            painter,
            sky,
            develop: tone::Development::new(conditions),
            light: Light::new(conditions),
            dirt: Dirt::new(camera.width(), camera.height(), conditions, seed),
            seed,
            shadow_strength: conditions.shadow_strength as f32,
            shadow_detail: conditions.shadow_detail as f32,
            wetness: conditions.wetness as f32,
            roadside: Roadside::new(seed, conditions),
            retroreflection: conditions.retroreflection as f32,
            lamps: conditions.lamps as f32,
            rain: conditions.rain,
        })
    }

    /// Whether lines are drawn at a place of the map, metres, where there are any.
    pub(crate) fn bears_lines(&self, x: f32, y: f32) -> bool {
        let point = self.ground.at(x, y);
        !Layout::interrupted(point.other_m)
            && point.stroke.is_some_and(|stroke| self.painter.bears_paint(stroke, x, y))
    }

    /// The picture of a frame and what its pixels show.
    pub(crate) fn render(&self, view: &FrameView) -> Rendered {
        let mut picture = RgbImage::new(self.width, self.height);
        let mut road = Plane::new(self.width, self.height, 0_u8);
        let mut classes = Plane::new(self.width, self.height, 0_u8);
        let mut heights = Plane::new(self.width, self.height, 0_u16);
        let shot = Shot::new(self, view);
        let band_px = TILE_PX * self.width;
        let bands = picture
            .as_mut_slice()
            .par_chunks_mut(3 * band_px)
            .zip(road.as_mut_slice().par_chunks_mut(band_px))
            .zip(classes.as_mut_slice().par_chunks_mut(band_px))
            .zip(heights.as_mut_slice().par_chunks_mut(band_px));
        bands.enumerate().for_each(|(number, (((pixels, road), classes), heights))| {
            shot.band(number, &mut Band { pixels, road, classes, heights });
        });
        let picture = match &self.softening {
            Some(softening) => softening.applied(picture),
            None => picture,
        };
        Rendered { picture, road, classes, heights: self.has_street().then_some(heights) }
    }
}

/// A picture and what its pixels show.
#[derive(Debug)]
pub(crate) struct Rendered {
    pub(crate) picture: RgbImage,
    /// 255 where the pixel shows road, 0 elsewhere.
    pub(crate) road: Plane<u8>,
    /// [`PixelClass`] of each.
    pub(crate) classes: Plane<u8>,
    /// Height of the ground in steps, where streets have heights.
    pub(crate) heights: Option<Plane<u16>>,
}

/// Rows of a picture that is being rendered.
struct Band<'a> {
    pixels: &'a mut [u8],
    road: &'a mut [u8],
    classes: &'a mut [u8],
    heights: &'a mut [u16],
}

/// The mirror image of a place below level ground.
fn mirrored([x, y, up]: [f32; 3], ground_m: f32) -> [f32; 3] {
    [x, y, 2.0 * ground_m - up]
}

/// A frame being rendered.
struct Shot<'a> {
    scene: &'a Renderer,
    /// Columns of the rotation from camera to map.
    rotation: [[f32; 3]; 3],
    origin: [f32; 3],
    ground_m: f32,
    noise_seed: u64,
    t_s: f32,
    /// What stands within reach of the camera, and of the camera's mirror image below wet ground.
    near: Nearby,
    below: Nearby,
    shades: Nearby,
    things: Things<'a>,
    lamps: Lamps,
    rain: Option<Rain>,
    plane: Upwards,
}

impl<'a> Shot<'a> {
    fn new(scene: &'a Renderer, view: &'a FrameView) -> Self {
        let matrix = view.map_from_camera.rotation.to_rotation_matrix();
        let rotation = [0, 1, 2].map(|c| [0, 1, 2].map(|r| matrix[(r, c)] as f32));
        let origin = [0, 1, 2].map(|i| view.map_from_camera.translation.vector[i] as f32);
        let things = Things { standing: scene.scenery.objects(), moving: &view.vehicles };
        let ground_m = view.ground_m as f32;
        let near = Nearby::new(&things, origin, rotation[2]);
        let below = if scene.wetness > 0.0 {
            let [x, y, up] = rotation[2];
            Nearby::new(&things, mirrored(origin, ground_m), [x, y, -up])
        } else {
            Nearby::default()
        };
        let noise_seed = mix(scene.seed ^ mix(view.frame ^ 0x4652_414d));
        let lamps = Lamps::new(things.moving, origin, scene.lamps, |ray, to_m| {
            let mut on_the_way = Vec::new();
            near.touching((ray.direction, 1.0, 0.0), &mut on_the_way);
            first_hit(&things, ray, 0.0..to_m, &on_the_way).is_some()
        });
        let shades = Nearby::shades(things.moving, origin, SHADOW_REACH_M);
        let rain = Rain::new(scene.rain, [scene.width, scene.height], scene.seed, view.frame, view.t_s);
        let t_s = view.t_s as f32;
        let plane = Upwards::new(view);
        Self {
            plane,
            scene,
            rotation,
            origin,
            ground_m,
            noise_seed,
            t_s,
            near,
            below,
            shades,
            things,
            lamps,
            rain,
        }
    }

    fn turned(&self, d: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.rotation;
        [0, 1, 2].map(|i| x[i] * d[0] + y[i] * d[1] + z[i] * d[2])
    }

    fn band(&self, number: usize, band: &mut Band<'_>) {
        let width = self.scene.width;
        let first = number * TILE_PX * width;
        let mut candidates = Candidates::default();
        for (column, left) in (0..width).step_by(TILE_PX).enumerate() {
            let (axis, cos, sin) = self.scene.lens.cones[number * width.div_ceil(TILE_PX) + column];
            let axis = self.turned(axis);
            self.near.touching((axis, cos, sin), &mut candidates.seen);
            self.below.touching(([axis[0], axis[1], -axis[2]], cos, sin), &mut candidates.mirrored);
            self.lamps.dazzling(axis, cos, &mut candidates.dazzling);
            self.lamps.streaking([axis[0], axis[1], -axis[2]], cos, &mut candidates.streaking);
            self.shades.touching((axis, cos, sin), &mut candidates.shading);
            for row in 0..band.road.len() / width {
                // Ground seen by neighbouring pixels is about as high: a good first guess.
                let mut ground_m = self.ground_m;
                for u in left..(left + TILE_PX).min(width) {
                    let i = row * width + u;
                    let (colour, shown, height) = self.pixel(first + i, &candidates, &mut ground_m);
                    band.road[i] = shown.mask();
                    band.classes[i] = shown.class as u8;
                    band.heights[i] = height;
                    band.pixels[3 * i..3 * i + 3].copy_from_slice(&colour);
                }
            }
        }
    }

    #[inline]
    fn pixel(&self, index: usize, candidates: &Candidates, ground_m: &mut f32) -> ([u8; 3], Shown, u16) {
        let scene = self.scene;
        let (in_camera, off_centre) = scene.lens.pixels[index];
        if dot(in_camera, in_camera) < 0.5 {
            return ([0; 3], Shown::beside(PixelClass::Nothing), 0);
        }
        let noise = mix(self.noise_seed ^ index as u64);
        if let Some(light) = scene.bonnet.as_ref().and_then(|bonnet| bonnet.hides(index)) {
            return (scene.develop.develop(light, off_centre, noise), Shown::beside(PixelClass::Thing), 0);
        }
        let (mut light, shown, height) = self.seen(in_camera, candidates, ground_m);
        if let Some(bonnet) = &scene.bonnet {
            let veil = bonnet.veil(index);
            light = [0, 1, 2].map(|i| light[i] + veil[i]);
        }
        if let Some(rain) = &self.rain {
            light = self.through_rain(light, rain, index);
        }
        (scene.develop.develop(scene.dirt.through(light, index), off_centre, noise), shown, height)
    }

    /// The light from a direction (unit vector, camera frame), what it comes from, and how high that is where it is ground.
    #[inline]
    fn seen(&self, in_camera: [f32; 3], candidates: &Candidates, ground_m: &mut f32) -> (Colour, Shown, u16) {
        let direction = self.turned(in_camera);
        let ground = self.met(direction, self.ground_distance(direction, ground_m));
        let ray = Ray { origin: self.origin, direction };
        let mut height = 0;
        let (mut light, shown) = match first_hit(&self.things, &ray, 0.0..ground.t, &candidates.seen) {
            Some((object, hit)) => {
                (self.object_light(object, &hit, Some(in_camera)), Shown::beside(hit.part.class()))
            }
            None if ground.t < GROUND_REACH_M => {
                height = self.height(direction, ground.t);
                self.ground_light(direction, in_camera, ground, candidates)
            }
            None => self.scene.sky.seen(direction),
        };
        if !candidates.dazzling.is_empty() {
            let glare = glare_along(direction, &candidates.dazzling);
            light = [0, 1, 2].map(|i| light[i] + glare[i]);
        }
        (light, shown, height)
    }

    /// The light of a pixel behind falling drops and those on the windscreen.
    #[inline(never)]
    fn through_rain(&self, light: Colour, rain: &Rain, index: usize) -> Colour {
        let grey = self.scene.sky.blurred(0.1);
        let mut light = mixed(light, grey, rain.falling(index));
        if let Some((shown, share)) = rain.drop_at(index) {
            let in_camera = self.scene.lens.pixels[shown].0;
            let beyond = self.seen(in_camera, &Candidates::default(), &mut self.ground_m.clone()).0;
            light = mixed(light, beyond, share);
        }
        light
    }

    /// Distance along a ray to hilly ground, metres. A ray comes nearer to ground of at most this slope by at most
    /// `closing` for each metre, so that it may go on by its height above it divided by that without passing it: what is behind a crest is never seen.
    fn hill_distance(&self, d: [f32; 3], slope: f32) -> f32 {
        let relief = &self.scene.relief;
        let across = (d[0] * d[0] + d[1] * d[1]).sqrt();
        let closing = slope * across - d[2];
        if closing <= 0.0 {
            return f32::INFINITY;
        }
        let pixel_rad = self.scene.lens.pixel_rad;
        let mut t = 0.0;
        while t < RELIEF_REACH_M {
            let gap = self.origin[2] + t * d[2]
                - relief.height_m(self.origin[0] + t * d[0], self.origin[1] + t * d[1]);
            // Flat rays close in slowly: a tenth of a pixel is near enough.
            if gap < 0.1 * pixel_rad * t {
                return t;
            }
            t += gap / closing;
        }
        // Beyond there the land is level.
        if d[2] < -1e-5 { ((self.origin[2] - self.ground_m) / -d[2]).max(t) } else { f32::INFINITY }
    }

    /// Distance along a ray to the ground, metres; infinite above the horizon. `ground_m` is a guess of the height
    /// there and becomes the height found.
    #[inline]
    fn ground_distance(&self, d: [f32; 3], ground_m: &mut f32) -> f32 {
        if let Some(slope) = self.scene.relief.hill_slope {
            return self.hill_distance(d, slope);
        }
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
}

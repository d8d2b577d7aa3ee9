//! The light that ground and objects send to the camera.

use super::lamps::streaks_along;
use super::nearby::{Candidates, Neighbour, first_hit};
use super::terrain::Met;
use super::{Shot, mirrored};
use crate::ground::GroundPoint;
use crate::light::{Light, mixed};
use crate::object::{Hit, Object, Ray, dot};
use crate::shown::{PixelClass, Shown};
use crate::surface::{Colour, Footprint, Painted};
use crate::wet::Water;

/// Height of the vehicle's lamps above the road, metres, above which the low beam ends, over so much height, and the share
/// of its light that goes higher.
const LAMP_HEIGHT_M: f32 = 0.65;
const CUT_OFF_M: f32 = 0.6;
const ABOVE_CUT_OFF: f32 = 0.04;
/// What stands is met by so much of a beam that is stated for the road, share.
const UPRIGHT: f32 = 0.35;

impl Shot<'_> {
    /// The light of the ground where a ray meets it, and what is there.
    #[inline]
    pub(super) fn ground_light(
        &self,
        d: [f32; 3],
        in_camera: [f32; 3],
        met: Met,
        candidates: &Candidates,
    ) -> (Colour, Shown) {
        let scene = self.scene;
        let t = met.t;
        let (x, y) = (self.origin[0] + t * d[0], self.origin[1] + t * d[1]);
        let point = scene.ground_at(x, y);
        let flat = (d[0] * d[0] + d[1] * d[1]).sqrt().max(1e-6);
        let across_m = t * scene.lens.pixel_rad;
        let footprint = Footprint { across_m, along_m: across_m / -d[2], sight: [d[0] / flat, d[1] / flat] };
        let Painted { road, colour, paint, beside } = if met.face.is_some() {
            let colour = scene.painter.kerb_face(x, y, across_m);
            Painted { road: 0.0, colour, paint: 0.0, beside: PixelClass::Raised }
        } else {
            scene.painter.ground(x, y, &point, &footprint)
        };
        let shadow = if scene.shadow_detail > 0.0 {
            let detailed = scene.painter.detailed_shadow(x, y, &point, footprint.fineness_m());
            point.shadow + (detailed - point.shadow) * scene.shadow_detail
        } else {
            point.shadow
        };
        let (open, shadow) = self.shaded([x, y, t * d[2]], &point, &footprint, shadow, &candidates.shading);
        let to_sun = scene.scenery.to_sun();
        // What stands up sees half of the sky, and the sun where it faces it.
        let (facing, open) = match met.face {
            None => (to_sun[2].max(0.7), open),
            Some(out) => (dot(out, to_sun).max(0.0), 0.5 * open),
        };
        let sun = (1.0 - scene.shadow_strength * shadow) * facing;
        let Light { sky, sun: full_sun, .. } = scene.light;
        let mut lit = [0, 1, 2].map(|i| colour[i] * (sky[i] * open + full_sun[i] * sun));
        if scene.light.has_low_beam() {
            let beam = scene.light.low_beam(t * in_camera[2], t * in_camera[0]);
            let back = if scene.retroreflection > 0.0 { 1.0 + scene.retroreflection * paint } else { 1.0 };
            lit = [0, 1, 2].map(|i| lit[i] + colour[i] * beam[i] * back);
        }
        if self.lamps.any() {
            let others = self.lamps.on_ground(x, y, d, &scene.light);
            lit = [0, 1, 2].map(|i| lit[i] + colour[i] * others[i]);
        }
        if scene.wetness > 0.0 {
            let water = Water::at(scene.wetness, &point, road);
            let grain = scene.painter.grain(x, y, footprint.fineness_m());
            let direction = water.mirrored(d, grain);
            let mut mirrored = self.mirrored_light(direction, water.clear, &candidates.mirrored);
            if !candidates.streaking.is_empty() {
                let streaks = streaks_along(direction, &candidates.streaking);
                mirrored = [0, 1, 2].map(|i| mirrored[i] + streaks[i]);
            }
            lit = mixed(lit.map(|c| c * water.brightness), mirrored, water.mirrored_share(d));
        }
        let thickness = scene.sky.thickness(x, y, self.t_s);
        let shown = if road >= 0.5 { Shown::road(paint) } else { Shown::beside(beside) };
        (scene.sky.hazed(lit, t * thickness), shown)
    }

    /// What is left of the sky's light on the ground, and the share of the sun's that is taken, with vehicles, posts and
    /// rails.
    #[inline]
    fn shaded(
        &self,
        [x, y, below_camera_m]: [f32; 3],
        point: &GroundPoint,
        footprint: &Footprint,
        shadow: f32,
        shading: &[Neighbour],
    ) -> (f32, f32) {
        let scene = self.scene;
        let (mut open, mut shadow) = (1.0, shadow);
        if let Some(roadside) = &scene.roadside {
            shadow = shadow.max(scene.painter.roadside_shadow(roadside, x, y, point, footprint));
        }
        if !shading.is_empty() {
            let up = self.origin[2] + below_camera_m + 0.01;
            let (sky, in_shadow) = self.things.shade(shading, [x, y, up], scene.scenery.to_sun());
            (open, shadow) = (sky, if in_shadow { 1.0 } else { shadow });
        }
        (open, shadow)
    }

    /// What a mirrored ray meets, in a mirror that is `clear` or rough, taken from the mirror image of the camera.
    #[inline(never)]
    fn mirrored_light(&self, direction: [f32; 3], clear: f32, candidates: &[Neighbour]) -> Colour {
        let ray = Ray { origin: mirrored(self.origin, self.ground_m), direction };
        // Below ground it meets nothing.
        let from_ground = (self.origin[2] - self.ground_m).max(0.0) / direction[2];
        match first_hit(&self.things, &ray, from_ground..f32::INFINITY, candidates) {
            Some((object, hit)) => self.object_light(object, &hit, None),
            None => mixed(self.scene.sky.blurred(direction[2]), self.scene.sky.colour(direction), clear),
        }
    }

    /// The light of an object where it was hit, seen straight along a direction (camera frame) or in a mirror.
    pub(super) fn object_light(&self, object: &Object, hit: &Hit, in_camera: Option<[f32; 3]>) -> Colour {
        let scene = self.scene;
        let footprint_m = hit.t * scene.lens.pixel_rad;
        let (colour, lamp) = scene.painter.object(object, hit, footprint_m);
        let facing = dot(hit.normal, scene.scenery.to_sun()).max(0.0);
        // Less sky is seen by what faces down.
        let seen_sky = 0.7 + 0.3 * hit.normal[2];
        let Light { sky, sun, .. } = scene.light;
        let mut lit = [0, 1, 2].map(|i| colour[i] * (sky[i] * seen_sky + sun[i] * facing));
        if let Some(in_camera) = in_camera.filter(|_| scene.retroreflection > 0.0) {
            let beam = self.beam_on_upright(hit, in_camera);
            lit = [0, 1, 2].map(|i| lit[i] + colour[i] * beam[i]);
        }
        if scene.lamps > 0.0 {
            lit = [0, 1, 2].map(|i| lit[i] + lamp[i] * scene.lamps);
        }
        scene.sky.hazed(lit, hit.t)
    }

    /// The own low beam on what stands up: it meets it straight, but ends at the height of the lamps.
    fn beam_on_upright(&self, hit: &Hit, in_camera: [f32; 3]) -> Colour {
        let (ahead_m, aside_m) = (hit.t * in_camera[2], hit.t * in_camera[0]);
        let up_m = self.origin[2] + hit.t * self.turned(in_camera)[2] - self.ground_m;
        let below = ((LAMP_HEIGHT_M + CUT_OFF_M - up_m) / CUT_OFF_M).clamp(0.0, 1.0);
        let share =
            UPRIGHT * (ABOVE_CUT_OFF + (1.0 - ABOVE_CUT_OFF) * below) * (ahead_m / LAMP_HEIGHT_M).max(1.0);
        self.scene.light.low_beam(ahead_m, aside_m).map(|c| c * share)
    }
}

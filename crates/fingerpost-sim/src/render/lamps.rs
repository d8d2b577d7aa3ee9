//! The lamps of other vehicles: their glare in the lens, their streaks on wet ground, the road that they light.
//!
//! A lens and a windscreen spread the light of a bright lamp over the picture: a bloom a few pixels wide and a veil around
//! it that falls with the square of the angle.

use crate::light::Light;
use crate::object::{Object, Ray, Shape, dot};
use crate::surface::Colour;
use crate::vehicle::{HEADLAMP, LampKind, TAIL_LAMP};

/// Lamps are stated as bright as they are from here, metres; from nearer they dazzle more, but no more than so many times.
const LAMP_AT_M: f32 = 55.0;
const MOST_DAZZLING: f32 = 6.0;
/// Strength of bloom and veil, and their squared radii, radians squared: 0.4 and 2 degrees.
const BLOOM: f32 = 0.22;
const VEIL: f32 = 0.022;
const BLOOM_RAD2: f32 = 5.0e-5;
const VEIL_RAD2: f32 = 1.2e-3;
/// So much light is taken off what a lamp adds, and what then adds nothing is left out: no tile shows where that begins.
const LEAST_LIGHT: f32 = 0.001;
/// A streak on wet ground is so many times as long as it is wide.
const STREAK_STRETCH: f32 = 7.0;
const STREAK: f32 = 0.10;
const STREAK_RAD2: f32 = 2.0e-4;
/// Mirrored rays are turned aside by less than this, radians.
const STREAK_SPREAD: f32 = 0.08;
/// Asphalt met flatly throws light on rather than back.
const FORWARD: f32 = 2.5;
/// Lamps light the road no farther than this, metres.
const BEAM_REACH_M: f32 = 70.0;

/// A lamp that the camera sees.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lamp {
    /// Unit vector to it from the camera.
    to: [f32; 3],
    light: Colour,
}

/// Where a vehicle's low beam comes from and goes, over ground.
#[derive(Debug, Clone, Copy)]
struct Beam {
    from: [f32; 2],
    direction: [f32; 2],
}

/// The lamps of a frame.
#[derive(Debug, Default)]
pub(super) struct Lamps {
    lamps: Vec<Lamp>,
    beams: Vec<Beam>,
    brightness: f32,
}

impl Lamps {
    /// The lamps of the `moving` vehicles that nothing hides from the camera at `origin`.
    pub(super) fn new(
        moving: &[Object],
        origin: [f32; 3],
        brightness: f32,
        is_hidden: impl Fn(&Ray, f32) -> bool,
    ) -> Self {
        let mut found = Self { brightness, ..Self::default() };
        if brightness <= 0.0 {
            return found;
        }
        for object in moving {
            let Shape::Vehicle(shape) = object.shape else { continue };
            let [cos, sin] = shape.direction;
            let away = [object.foot[0] - origin[0], object.foot[1] - origin[1]];
            if (away[0] * away[0] + away[1] * away[1]).sqrt() < BEAM_REACH_M {
                found.beams.push(Beam { from: [object.foot[0], object.foot[1]], direction: shape.direction });
            }
            for (place, kind) in shape.lamps() {
                let to = [0, 1, 2].map(|i| object.foot[i] + place[i] - origin[i]);
                let distance_m = dot(to, to).sqrt().max(1.0);
                let to = to.map(|x| x / distance_m);
                let ahead = -(to[0] * cos + to[1] * sin);
                let (toward, glass, share) = match kind {
                    LampKind::Head => (ahead, HEADLAMP, 1.0),
                    LampKind::Tail => (-ahead, TAIL_LAMP, 0.25),
                };
                if toward <= 0.1 || is_hidden(&Ray { origin, direction: to }, distance_m - 0.1) {
                    continue;
                }
                let nearness = (LAMP_AT_M / distance_m).powi(2).min(MOST_DAZZLING);
                let strength = brightness * share * nearness * toward * toward;
                found.lamps.push(Lamp { to, light: glass.map(|c| c * strength) });
            }
        }
        found
    }

    /// Whether there are any.
    #[inline]
    pub(super) fn any(&self) -> bool {
        !self.lamps.is_empty() || !self.beams.is_empty()
    }

    /// The lamps whose glare a cone of rays (axis, cosine of its half angle) may show.
    pub(super) fn dazzling(&self, axis: [f32; 3], cos: f32, found: &mut Vec<Lamp>) {
        found.clear();
        let radius = (2.0 - 2.0 * cos).max(0.0).sqrt();
        found.extend(self.lamps.iter().filter(|lamp| {
            let apart = [0, 1, 2].map(|i| axis[i] - lamp.to[i]);
            let nearest = (dot(apart, apart).sqrt() - radius).max(0.0);
            lamp.light[0] * glare(nearest * nearest) > LEAST_LIGHT
        }));
    }

    /// The lamps whose streaks on wet ground a cone of mirrored rays may show.
    pub(super) fn streaking(&self, axis: [f32; 3], cos: f32, found: &mut Vec<Lamp>) {
        found.clear();
        let radius = (2.0 - 2.0 * cos).max(0.0).sqrt();
        found.extend(self.lamps.iter().filter(|lamp| {
            let aside = libm::hypotf(axis[0] - lamp.to[0], axis[1] - lamp.to[1]) - radius - STREAK_SPREAD;
            lamp.light[0] * streak(aside.max(0.0).powi(2)) > LEAST_LIGHT
        }));
    }

    /// Light of other vehicles' low beams on the ground, towards the camera that looks along `d`.
    #[inline]
    pub(super) fn on_ground(&self, x: f32, y: f32, d: [f32; 3], light: &Light) -> Colour {
        let mut sum = [0.0; 3];
        for beam in &self.beams {
            let (dx, dy) = (x - beam.from[0], y - beam.from[1]);
            let [cos, sin] = beam.direction;
            let ahead_m = cos * dx + sin * dy;
            if !(0.0..BEAM_REACH_M).contains(&ahead_m) {
                continue;
            }
            let falls = light.low_beam(ahead_m, cos * dy - sin * dx);
            // Towards the camera where the beam goes against the camera's ray.
            let against = -(d[0] * cos + d[1] * sin);
            let share = self.brightness * (1.0 + FORWARD * against.max(0.0));
            sum = [0, 1, 2].map(|i| sum[i] + falls[i] * share);
        }
        sum
    }
}

/// Share of a lamp's light at a squared angle from it.
#[inline]
fn glare(rad2: f32) -> f32 {
    let bloom = 1.0 + rad2 / BLOOM_RAD2;
    BLOOM / (bloom * bloom) + VEIL / (1.0 + rad2 / VEIL_RAD2)
}

/// The glare of lamps along a ray (unit vector).
#[inline]
pub(super) fn glare_along(d: [f32; 3], lamps: &[Lamp]) -> Colour {
    let mut sum = [0.0; 3];
    for lamp in lamps {
        let apart = [0, 1, 2].map(|i| d[i] - lamp.to[i]);
        let share = (glare(dot(apart, apart)) - LEAST_LIGHT / lamp.light[0]).max(0.0);
        sum = [0, 1, 2].map(|i| sum[i] + lamp.light[i] * share);
    }
    sum
}

/// Share of a lamp's light in its streak at a squared angle from the streak's middle.
#[inline]
fn streak(rad2: f32) -> f32 {
    let q = 1.0 + rad2 / STREAK_RAD2;
    STREAK / (q * q)
}

/// Light that the mirrored ray of a wet ground's pixel brings from lamps.
#[inline]
pub(super) fn streaks_along(mirrored: [f32; 3], lamps: &[Lamp]) -> Colour {
    let mut sum = [0.0; 3];
    for lamp in lamps {
        let apart = [0, 1, 2].map(|i| mirrored[i] - lamp.to[i]);
        let up = apart[2] / STREAK_STRETCH;
        let rad2 = apart[0] * apart[0] + apart[1] * apart[1] + up * up;
        let share = (streak(rad2) - LEAST_LIGHT / lamp.light[0]).max(0.0);
        sum = [0, 1, 2].map(|i| sum[i] + lamp.light[i] * share);
    }
    sum
}

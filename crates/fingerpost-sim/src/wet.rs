//! Water on the ground: it darkens what it covers and mirrors what stands above.
//!
//! A water film lets light in that then does not get out again, so wet ground is darker; its surface mirrors by
//! Fresnel's law (Schlick's form), much at the flat angles at which a camera sees the road. Chippings that stand out of
//! the film scatter the mirrored light: a film mirrors blurred and in part, a puddle clearly.

use crate::ground::GroundPoint;

/// Reflectance of water met at a right angle, for a refractive index of 1.33.
const NORMAL_REFLECTANCE: f32 = 0.02;
/// Share of its dry brightness that a film and a puddle take from the road.
const FILM_DARKENS: f32 = 0.45;
const PUDDLE_DARKENS: f32 = 0.65;
/// The same for a film on grass and soil.
const VERGE_DARKENS: f32 = 0.25;
/// Share of the surface that mirrors: of a film, and of a puddle.
const FILM_MIRRORS: f32 = 0.30;
const PUDDLE_MIRRORS: f32 = 0.95;
/// Stains darker than this are hollows in which water stands; the depth over which a puddle's rim fades.
const HOLLOW_TONE: f32 = 0.28;
const RIM_TONE: f32 = 0.06;
/// How far the chippings of a film turn mirrored rays, tangent of the angle, for a grain of one.
const FILM_SPREADS: f32 = 0.22;

/// The water of a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Water {
    /// Share of the dry brightness that is left.
    pub(crate) brightness: f32,
    /// Share of the light that is mirrored by what mirrors, were it met at any angle.
    mirrors: f32,
    /// How far mirrored rays are turned.
    spread: f32,
    /// Share of a clear mirror in what mirrors; the rest shows no more than the sky's gradient.
    pub(crate) clear: f32,
}

impl Water {
    /// The water at a place of which `road` is the share that is road.
    #[inline]
    pub(crate) fn at(wetness: f32, point: &GroundPoint, road: f32) -> Self {
        // Water stands in hollows, and runs to the road's edges.
        let to_edge = (1.0 + point.edge_m).clamp(0.0, 1.0) * 0.05;
        let puddle = ((-point.tone + to_edge - HOLLOW_TONE) * (1.0 / RIM_TONE)).clamp(0.0, 1.0) * wetness;
        let on_road = wetness * (FILM_DARKENS + (PUDDLE_DARKENS - FILM_DARKENS) * puddle);
        let darkens = wetness * VERGE_DARKENS * (1.0 - road) + on_road * road;
        let mirrors = wetness * (FILM_MIRRORS + (PUDDLE_MIRRORS - FILM_MIRRORS) * puddle) * road;
        Self { brightness: 1.0 - darkens, mirrors, spread: FILM_SPREADS * (1.0 - puddle), clear: puddle }
    }

    /// Share of the light that comes mirrored along a ray (unit vector) that goes down.
    #[inline]
    pub(crate) fn mirrored_share(&self, d: [f32; 3]) -> f32 {
        let grazing = (1.0 + d[2]).clamp(0.0, 1.0);
        let fresnel = NORMAL_REFLECTANCE + (1.0 - NORMAL_REFLECTANCE) * grazing.powi(5);
        self.mirrors * fresnel
    }

    /// Direction of the mirrored ray, turned by the ground's `grain`.
    #[inline]
    pub(crate) fn mirrored(&self, d: [f32; 3], grain: [f32; 2]) -> [f32; 3] {
        // Never along the ground, where nothing would be met.
        let up = (-d[2] + self.spread * grain[0]).max(0.01);
        let (x, y) = (d[0] + 0.3 * self.spread * grain[1] * d[1], d[1] - 0.3 * self.spread * grain[1] * d[0]);
        let length = (x * x + y * y + up * up).sqrt();
        [x / length, y / length, up / length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(tone: f32) -> GroundPoint {
        GroundPoint { edge_m: -2.0, tone, ..GroundPoint::OPEN }
    }

    #[test]
    fn flat_views_mirror_and_steep_ones_do_not() {
        let puddle = Water::at(1.0, &point(-0.5), 1.0);
        let (flat, steep) = ([0.995, 0.0, -0.1], [0.6, 0.0, -0.8]);
        assert!(puddle.mirrored_share(flat) > 0.5, "{}", puddle.mirrored_share(flat));
        assert!(puddle.mirrored_share(steep) < 0.05);
        let film = Water::at(1.0, &point(0.5), 1.0);
        assert!(film.mirrored_share(flat) < 0.4 * puddle.mirrored_share(flat));
        assert!(film.brightness > puddle.brightness);
    }

    #[test]
    fn a_puddle_mirrors_straight_and_grass_not_at_all() {
        let d = [0.8, 0.0, -0.6];
        let puddle = Water::at(1.0, &point(-0.5), 1.0);
        let up = puddle.mirrored(d, [1.0, 1.0]);
        assert!((up[0] - 0.8).abs() < 1e-6 && (up[2] - 0.6).abs() < 1e-6, "{up:?}");
        assert!(Water::at(1.0, &point(-0.5), 0.0).mirrored_share(d) < 1e-6);
        let dry = Water::at(0.0, &point(-0.5), 1.0);
        assert!(dry.mirrored_share(d) < 1e-9 && dry.brightness > 0.999);
    }
}

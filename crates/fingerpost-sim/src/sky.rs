//! What is seen above the ground: sky, clouds, a hazy line of woods on the horizon; and the air between.

use crate::Conditions;
use crate::light::mixed;
use crate::shown::{PixelClass, Shown};
use crate::surface::Colour;
use crate::texture::{Grain, Texture};

/// Colour of the haze into which distance fades, linear.
const HAZE: Colour = [0.62, 0.70, 0.80];
/// Colour of dust in the air in full light.
const DUST: Colour = [0.66, 0.56, 0.42];
/// Colour of a covered sky, and the light of its clouds' relief.
const COVER: Colour = [0.60, 0.62, 0.65];
const COVER_RELIEF: f32 = 0.35;
/// Colour of the clear sky overhead.
const TOP: Colour = [0.20, 0.38, 0.72];
/// Glow of a sun below the horizon.
const GLOW: Colour = [1.0, 0.62, 0.38];
/// Height of the distant woods, tangent of the angle.
const WOODS: f32 = 0.035;
/// A sky is this much brighter than the ground that it lights would let expect: the eye of a camera sees it directly.
const DIRECT: f32 = 2.6;

/// Speed of the wind from the east that drives dust, m/s: a light breeze.
const WIND_MPS: f32 = 1.5;

/// The sky of a seed.
#[derive(Debug, Clone)]
pub(crate) struct Sky {
    clouds: Texture,
    haze: Colour,
    haze_m: f32,
    dust: f32,
    overcast: f32,
    /// Brightness against a clear day's.
    brightness: f32,
    glow: f32,
}

impl Sky {
    pub(crate) fn new(seed: u64, conditions: &Conditions) -> Self {
        let sky_light = conditions.sky_light as f32;
        let brightness = if sky_light < 1.0 && conditions.sun_light < 1.0 { DIRECT * sky_light } else { 1.0 };
        let haze = mixed(HAZE, DUST, conditions.dust as f32);
        let haze = mixed(haze, COVER, conditions.overcast as f32 * (1.0 - conditions.dust as f32));
        Self {
            clouds: Texture::new(seed ^ 0x534b, Grain::Soil),
            haze: haze.map(|c| c * brightness),
            haze_m: conditions.haze_m as f32,
            dust: conditions.dust as f32,
            overcast: conditions.overcast as f32,
            brightness,
            glow: (conditions.sun_warmth * conditions.sky_light) as f32,
        }
    }

    /// Colour in a direction (unit vector, map frame), the distant woods included.
    #[inline]
    pub(crate) fn colour(&self, direction: [f32; 3]) -> Colour {
        self.seen(direction).0
    }

    /// The same, and whether it is that of the sky or of the woods.
    #[inline]
    pub(crate) fn seen(&self, [x, y, z]: [f32; 3]) -> (Colour, Shown) {
        let b = self.brightness;
        if z < 2.0 * WOODS {
            let crowns =
                self.clouds.sample(6.0 * x, 6.0 * y, 0.03)[0] + self.clouds.sample(1.4 * x, 1.4 * y, 0.03)[1];
            if z < WOODS * (1.0 + 0.7 * crowns) {
                let tone = 1.0 + 0.3 * crowns;
                let woods = [0.20 * tone, 0.27 * tone, 0.27 * tone];
                let seen = if self.dust > 0.0 { mixed(woods, self.haze, 0.9) } else { woods.map(|c| c * b) };
                return (seen, Shown::beside(PixelClass::Structure));
            }
        }
        let blue = (1.0 - 1.0 / (1.0 + 5.0 * z.max(0.0))).min(1.0);
        let top = TOP.map(|c| c * b);
        // Clouds lie on a plane high above; the look-up fades towards the horizon, where they crowd together.
        let (u, v) = (x / (z + 0.12), y / (z + 0.12));
        let layers = self.clouds.sample(0.7 * u, 0.7 * v, 0.03)[0]
            + 0.6 * self.clouds.sample(2.3 * v, 2.3 * u, 0.03)[1];
        let cloud = (1.4 * layers + 0.1).clamp(0.0, 0.85) * (4.0 * z).min(1.0);
        let sky = [0, 1, 2].map(|i| {
            let clear = self.haze[i] + (top[i] - self.haze[i]) * blue;
            clear + (0.92 * b - clear) * cloud
        });
        let sky = if self.overcast > 0.0 { self.covered(sky, layers, z) } else { sky };
        (sky, Shown::beside(PixelClass::Sky))
    }

    /// Colour in a direction of the sky without its clouds, as a rough mirror shows it.
    #[inline]
    pub(crate) fn blurred(&self, z: f32) -> Colour {
        let blue = 1.0 - 1.0 / (1.0 + 5.0 * z.max(0.0));
        let clear = mixed(self.haze, TOP.map(|c| c * self.brightness), blue);
        mixed(clear, COVER.map(|c| c * self.brightness), self.overcast)
    }

    /// A sky behind its cover, with the glow of a low sun.
    fn covered(&self, sky: Colour, layers: f32, z: f32) -> Colour {
        let relief = 1.0 + COVER_RELIEF * layers.clamp(-1.0, 1.0) * (4.0 * z).clamp(0.0, 1.0);
        let mut sky = mixed(sky, COVER.map(|c| c * relief * self.brightness), self.overcast);
        let low = 1.0 / (1.0 + 8.0 * z.max(0.0));
        for (c, glow) in sky.iter_mut().zip(GLOW) {
            *c += self.glow * glow * low;
        }
        sky
    }

    /// A colour seen through `distance_m` of air.
    #[inline]
    pub(crate) fn hazed(&self, colour: Colour, distance_m: f32) -> Colour {
        // The first-order form of 1 - exp(-x), below 1 for every distance.
        let share = distance_m / (distance_m + self.haze_m);
        [0, 1, 2].map(|i| colour[i] + (self.haze[i] - colour[i]) * share * share)
    }

    /// How much thicker the dust in the air is at a place of the map, at a time: it drifts in clouds. One without dust.
    #[inline]
    pub(crate) fn thickness(&self, x: f32, y: f32, t_s: f32) -> f32 {
        if self.dust <= 0.0 {
            return 1.0;
        }
        // Clouds of about ten metres.
        let cloud = self.clouds.sample(0.15 * (x + WIND_MPS * t_s), 0.15 * y, 0.2)[0];
        (1.0 + 1.2 * self.dust * cloud).max(0.2)
    }
}

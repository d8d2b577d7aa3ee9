//! What is seen above the ground: sky, clouds, a hazy line of woods on the horizon.

use crate::surface::Colour;
use crate::texture::{Grain, Texture};

/// Colour of the haze into which distance fades, linear.
const HAZE: Colour = [0.62, 0.70, 0.80];
/// Distance over which about two thirds of a colour is lost to haze, metres.
const HAZE_M: f32 = 330.0;
/// Height of the distant woods, tangent of the angle.
const WOODS: f32 = 0.035;

/// The sky of a seed.
#[derive(Debug, Clone)]
pub(crate) struct Sky {
    clouds: Texture,
}

impl Sky {
    pub(crate) fn new(seed: u64) -> Self {
        Self { clouds: Texture::new(seed ^ 0x534b, Grain::Soil) }
    }

    /// Colour in a direction (unit vector, map frame), the distant woods included.
    #[inline]
    pub(crate) fn colour(&self, [x, y, z]: [f32; 3]) -> Colour {
        if z < 2.0 * WOODS {
            let crowns =
                self.clouds.sample(6.0 * x, 6.0 * y, 0.03)[0] + self.clouds.sample(1.4 * x, 1.4 * y, 0.03)[1];
            if z < WOODS * (1.0 + 0.7 * crowns) {
                let tone = 1.0 + 0.3 * crowns;
                return [0.20 * tone, 0.27 * tone, 0.27 * tone];
            }
        }
        let blue = (1.0 - 1.0 / (1.0 + 5.0 * z.max(0.0))).min(1.0);
        let top = [0.20, 0.38, 0.72];
        // Clouds lie on a plane high above; the look-up fades towards the horizon, where they crowd together.
        let (u, v) = (x / (z + 0.12), y / (z + 0.12));
        let layers = self.clouds.sample(0.7 * u, 0.7 * v, 0.03)[0]
            + 0.6 * self.clouds.sample(2.3 * v, 2.3 * u, 0.03)[1];
        let cloud = (1.4 * layers + 0.1).clamp(0.0, 0.85) * (4.0 * z).min(1.0);
        [0, 1, 2].map(|i| {
            let clear = HAZE[i] + (top[i] - HAZE[i]) * blue;
            clear + (0.92 - clear) * cloud
        })
    }

    /// A colour seen through `distance_m` of air.
    #[inline]
    pub(crate) fn hazed(colour: Colour, distance_m: f32) -> Colour {
        // The first-order form of 1 - exp(-x), below 1 for every distance.
        let share = distance_m / (distance_m + HAZE_M);
        [0, 1, 2].map(|i| colour[i] + (HAZE[i] - colour[i]) * share * share)
    }
}

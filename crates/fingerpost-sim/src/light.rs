//! The light of a day: sun, open sky, the vehicle's low beam.

use crate::Conditions;
use crate::surface::Colour;

/// Light of a clear day's sky and sun on a surface that faces them.
const SKY_LIGHT: Colour = [0.33, 0.39, 0.50];
const SUN_LIGHT: Colour = [1.06, 1.00, 0.88];
/// Light of a covered sky: that of a clear one without its blue.
const GREY_SKY_LIGHT: Colour = [0.40, 0.41, 0.43];
/// Light of a sun just above the horizon.
const LOW_SUN_LIGHT: Colour = [1.10, 0.72, 0.42];
/// Colour of a halogen lamp.
const LAMP: Colour = [1.0, 0.88, 0.66];
/// Distance at which the conditions state the low beam's light, metres.
const LAMP_AT_M: f32 = 10.0;
/// The low beam's half width, tangent of the angle (20 degrees).
const LAMP_TANGENT: f32 = 0.36;
/// The ground is lit from here on, and fully from there on, metres: nearer ground lies below the beam.
const LAMP_FROM_M: [f32; 2] = [2.5, 9.0];

/// Mixes two colours: `share` of `other`.
#[inline(always)]
pub(crate) fn mixed(colour: Colour, other: Colour, share: f32) -> Colour {
    [0, 1, 2].map(|i| colour[i] + (other[i] - colour[i]) * share)
}

/// What falls on a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light {
    pub(crate) sky: Colour,
    pub(crate) sun: Colour,
    low_beam: f32,
    fading: i32,
}

impl Light {
    pub(crate) fn new(conditions: &Conditions) -> Self {
        let sky = mixed(SKY_LIGHT, GREY_SKY_LIGHT, conditions.overcast as f32);
        let sun = mixed(SUN_LIGHT, LOW_SUN_LIGHT, conditions.sun_warmth as f32);
        Self {
            sky: sky.map(|c| c * conditions.sky_light as f32),
            sun: sun.map(|c| c * conditions.sun_light as f32),
            low_beam: conditions.headlights as f32,
            fading: conditions.headlight_fading,
        }
    }

    /// Whether the vehicle has its low beam on.
    #[inline(always)]
    pub(crate) fn has_low_beam(&self) -> bool {
        self.low_beam > 0.0
    }

    /// Light of the low beam on ground so far ahead of the camera and to its side. Illumination falls with the square of
    /// the distance, and once more because farther ground is met more flatly; a beam that is strongest at its cut-off makes
    /// up for some of that.
    pub(crate) fn low_beam(&self, ahead_m: f32, aside_m: f32) -> Colour {
        let [from, fully] = LAMP_FROM_M;
        let rise = ((ahead_m - from) / (fully - from)).clamp(0.0, 1.0);
        let below = rise * rise * (3.0 - 2.0 * rise);
        let angle = aside_m / (LAMP_TANGENT * ahead_m.max(from));
        let strength =
            self.low_beam * below * (LAMP_AT_M / ahead_m.max(from)).powi(self.fading) / (1.0 + angle.powi(4));
        LAMP.map(|c| c * strength)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beam_is_brightest_ahead_and_leaves_out_what_is_under_the_bonnet() {
        let light = Light::new(&Conditions::DUSK);
        let at = |ahead_m: f32, aside_m: f32| light.low_beam(ahead_m, aside_m)[1];
        assert!(at(8.0, 0.0) > at(12.0, 0.0) && at(12.0, 0.0) > at(30.0, 0.0));
        assert!(at(8.0, 0.0) > 4.0 * at(8.0, 6.0), "aside");
        assert!(at(2.0, 0.0) < 1e-9, "too near");
        assert!(!Light::new(&Conditions::CLEAR).has_low_beam());
    }
}

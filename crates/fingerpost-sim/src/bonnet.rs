//! The vehicle's bonnet at the lower edge of the picture, and the dashboard's mirror image in the windscreen.

use crate::conditions::Conditions;
use crate::noise::{Stream, value_noise};
use crate::surface::Colour;
use crate::vehicle::LACQUERS;

/// A bonnet's edge falls away from its highest place by so much towards the picture's sides, share of its height.
const FALLS: [f64; 2] = [0.2, 1.0];
/// Share of the sky's light that lacquer mirrors at the bonnet's far edge and nearest to the camera.
const MIRRORED: [f32; 2] = [0.55, 0.12];
/// Share of the light that falls on it which lacquer gives back where it mirrors nothing.
const LIT: f32 = 0.7;
/// The mirror image fades out over the lower part of the picture, share of its height.
const VEIL_FROM: f32 = 0.35;

/// What is between the camera and the world, in the vehicle.
#[derive(Debug, Clone)]
pub(crate) struct Bonnet {
    size_px: [usize; 2],
    /// Height in the middle, shares of the picture's.
    height: f32,
    fall: f32,
    /// Column of its highest place, share of the picture's width.
    middle: f32,
    lacquer: Colour,
    sky: Colour,
    veil: f32,
    seed: u64,
}

impl Bonnet {
    /// None where neither is seen; `sky` is the light of the sky ahead.
    pub(crate) fn new(seed: u64, conditions: &Conditions, size_px: [usize; 2], sky: Colour) -> Option<Self> {
        let look = conditions.camera;
        let mut stream = Stream::new(seed, 0x424f_4e4e);
        let number = (stream.unit() * LACQUERS.len() as f64) as usize;
        (look.bonnet > 0.0 || look.veil > 0.0).then(|| Self {
            size_px,
            height: look.bonnet as f32,
            fall: stream.between(FALLS[0], FALLS[1]) as f32,
            middle: stream.between(0.35, 0.65) as f32,
            lacquer: LACQUERS[number.min(LACQUERS.len() - 1)],
            sky,
            veil: look.veil as f32,
            seed,
        })
    }

    /// The light of the bonnet where it hides a pixel.
    pub(crate) fn hides(&self, index: usize) -> Option<Colour> {
        let (x, y) = self.place(index);
        let aside = 2.0 * (x - self.middle);
        let edge = 1.0 - self.height * (1.0 - self.fall * aside * aside);
        if y <= edge || self.height <= 0.0 {
            return None;
        }
        let depth = ((y - edge) / self.height).min(1.0);
        // Shoulders and creases of the sheet turn the mirror.
        let crease = value_noise(self.seed, 6.0 * aside, 2.0 * depth) - 0.5;
        let share = (MIRRORED[0] + (MIRRORED[1] - MIRRORED[0]) * depth + 0.4 * crease).clamp(0.05, 0.8);
        Some([0, 1, 2].map(|i| self.sky[i] * (share + LIT * self.lacquer[i])))
    }

    /// The light that the windscreen adds to a pixel.
    pub(crate) fn veil(&self, index: usize) -> Colour {
        let (x, y) = self.place(index);
        let fades = ((y - VEIL_FROM) / (1.0 - VEIL_FROM)).max(0.0);
        let shape = value_noise(self.seed ^ 0x5645, 3.0 * x, 5.0 * y);
        self.sky.map(|c| c * self.veil * fades * shape)
    }

    /// A pixel's place in the picture, shares of its sides.
    fn place(&self, index: usize) -> (f32, f32) {
        let [width, height] = self.size_px;
        ((index % width) as f32 / width as f32, (index / width) as f32 / height as f32)
    }
}

//! Dirt on the lens: blots so near that they are out of focus, the same in every frame.

use crate::Conditions;
use crate::noise::Stream;
use crate::surface::Colour;

/// Radii of blots, shares of the picture's width.
const RADII: [f64; 2] = [0.006, 0.045];
/// Share of the light behind that a blot's middle takes away.
const OPACITIES: [f64; 2] = [0.25, 0.75];
/// Light that a blot scatters into the camera, where the day is clear.
const SCATTERED: Colour = [0.30, 0.265, 0.21];
/// Upper bound of the blots.
const MOST_BLOTS: usize = 2000;

/// What the lens takes from the light of each pixel, and what it scatters in its place.
#[derive(Debug, Clone)]
pub(crate) struct Dirt {
    /// Share taken, row by row; empty on a clean lens.
    taken: Vec<f32>,
    scattered: Colour,
}

impl Dirt {
    pub(crate) fn new(width: usize, height: usize, conditions: &Conditions, seed: u64) -> Self {
        let scattered = SCATTERED.map(|c| c * conditions.sky_light as f32);
        let mut taken = Vec::new();
        if conditions.lens_dirt > 0.0 {
            taken.resize(width * height, 0.0);
            let mut stream = Stream::new(seed, 0x4449_5254);
            let mut left_px = conditions.lens_dirt * (width * height) as f64;
            for _ in 0..MOST_BLOTS {
                let middle = [stream.unit() * width as f64, stream.unit() * height as f64];
                // Most are small.
                let size = stream.unit().powi(3);
                let radius = (RADII[0] + (RADII[1] - RADII[0]) * size) * width as f64;
                let opacity = stream.between(OPACITIES[0], OPACITIES[1]);
                blot(&mut taken, width, middle, radius, opacity as f32);
                left_px -= std::f64::consts::PI * radius * radius;
                if left_px <= 0.0 {
                    break;
                }
            }
        }
        Self { taken, scattered }
    }

    /// The light of a pixel behind the lens.
    #[inline(always)]
    pub(crate) fn through(&self, light: Colour, index: usize) -> Colour {
        match self.taken.get(index) {
            Some(&taken) => crate::light::mixed(light, self.scattered, taken),
            None => light,
        }
    }
}

/// Adds a disc that fades towards its rim.
fn blot(taken: &mut [f32], width: usize, [x, y]: [f64; 2], radius: f64, opacity: f32) {
    for (i, share) in taken.iter_mut().enumerate() {
        let (dx, dy) = ((i % width) as f64 - x, (i / width) as f64 - y);
        let inside = 1.0 - (dx * dx + dy * dy) / (radius * radius);
        if inside > 0.0 {
            let blot = opacity * (2.0 * inside).min(1.0) as f32;
            *share += (1.0 - *share) * blot;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blots_cover_about_the_share_asked_for() {
        let dirty = Conditions { lens_dirt: 0.2, ..Conditions::CLEAR };
        let dirt = Dirt::new(160, 120, &dirty, 3);
        let covered =
            dirt.taken.iter().filter(|&&taken| taken > 0.0).count() as f64 / dirt.taken.len() as f64;
        assert!((0.08..0.3).contains(&covered), "{covered}");
        let clean = Dirt::new(160, 120, &Conditions::CLEAR, 3);
        assert!(clean.through([0.5; 3], 7).iter().all(|c| (c - 0.5).abs() < 1e-9));
    }
}

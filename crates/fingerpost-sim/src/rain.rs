//! Rain as the camera sees it: drops that fall through the picture, and drops on the windscreen before it is wiped.

use crate::noise::{Stream, mix};

/// Falling drops in a picture of 640 by 480 pixels in a heavy shower.
const FALLING: f64 = 420.0;
/// Their length, share of the picture's height, and how much of the light they take.
const LENGTHS: [f64; 2] = [0.02, 0.11];
const OPACITIES: [f64; 2] = [0.05, 0.20];
/// Drops on the windscreen just before it is wiped.
const ON_SCREEN: f64 = 110.0;
/// Their radius, share of the picture's width.
const RADII: [f64; 2] = [0.003, 0.014];
/// The wiper comes this often, seconds.
const WIPED_S: f64 = 1.4;
/// A drop shows the scene upside down and this many times as small.
const SHRINKS: f32 = 5.0;
/// Share of the light that comes through a drop, the rest past it: drops are out of focus.
const DROP_OPACITY: f32 = 0.75;

/// Rain in one frame.
#[derive(Debug, Clone)]
pub(crate) struct Rain {
    /// Share of each pixel's light that falling drops take.
    falling: Vec<f32>,
    /// For each pixel the one that a drop shows in its place, and the drop's share.
    drops: Vec<(u32, f32)>,
}

impl Rain {
    /// The rain of a frame at a time; none on a dry day.
    pub(crate) fn new(
        strength: f64,
        [width, height]: [usize; 2],
        seed: u64,
        frame: u64,
        t_s: f64,
    ) -> Option<Self> {
        if strength <= 0.0 {
            return None;
        }
        let mut rain = Self { falling: vec![0.0; width * height], drops: vec![(0, 0.0); width * height] };
        let size = [width as f64, height as f64];
        let mut stream = Stream::new(mix(seed ^ mix(frame)), 0x5241_494e);
        for _ in 0..(strength * FALLING) as usize {
            rain.fall(&mut stream, size, width);
        }
        let wipe = (t_s / WIPED_S).floor();
        let since = t_s / WIPED_S - wipe;
        let mut stream = Stream::new(mix(seed ^ mix(wipe as u64)), 0x4452_4f50);
        for _ in 0..(strength * ON_SCREEN) as usize {
            let place = [size[0] * stream.unit(), size[1] * stream.unit()];
            let radius = size[0] * (RADII[0] + (RADII[1] - RADII[0]) * stream.unit().powi(3));
            // Each comes at a time of its own.
            if stream.unit() < since {
                rain.drop(place, radius, [width, height]);
            }
        }
        Some(rain)
    }

    fn fall(&mut self, stream: &mut Stream, [width, height]: [f64; 2], columns: usize) {
        let (u, v) = (width * stream.unit(), height * stream.unit());
        let length = height * stream.between(LENGTHS[0], LENGTHS[1]);
        let opacity = stream.between(OPACITIES[0], OPACITIES[1]) as f32;
        // Drops come towards a vehicle that drives: they fall away from the middle.
        let slant = 1.3 * (u / width - 0.5);
        for step in 0..length as usize {
            let (u, v) = (u + slant * step as f64, v + step as f64);
            if u < 0.0 || u >= width - 1.0 || v >= height {
                break;
            }
            let first = v as usize * columns + u as usize;
            let right = (u - u.floor()) as f32;
            self.falling[first] += opacity * (1.0 - right);
            self.falling[first + 1] += opacity * right;
        }
    }

    fn drop(&mut self, [u, v]: [f64; 2], radius: f64, [width, height]: [usize; 2]) {
        let span = |middle: f64, limit: usize| {
            (middle - radius).max(0.0) as usize..((middle + radius) as usize + 1).min(limit)
        };
        for row in span(v, height) {
            for column in span(u, width) {
                let (du, dv) = ((column as f64 - u) as f32, (row as f64 - v) as f32);
                let inside = 1.0 - (du * du + dv * dv) / (radius * radius) as f32;
                if inside <= 0.0 {
                    continue;
                }
                let there = |middle: f64, away: f32, limit: usize| {
                    ((middle as f32 - SHRINKS * away).max(0.0) as usize).min(limit - 1)
                };
                let shown = there(v, dv, height) * width + there(u, du, width);
                self.drops[row * width + column] = (shown as u32, DROP_OPACITY * (2.0 * inside).min(1.0));
            }
        }
    }

    /// Share of a pixel's light that falling drops take.
    #[inline]
    pub(crate) fn falling(&self, index: usize) -> f32 {
        self.falling[index].min(0.6)
    }

    /// The pixel that a drop on the windscreen shows in a pixel's place, and the drop's share.
    #[inline]
    pub(crate) fn drop_at(&self, index: usize) -> Option<(usize, f32)> {
        let (shown, share) = self.drops[index];
        (share > 0.0).then_some((shown as usize, share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drops_gather_until_they_are_wiped() {
        let drops = |t_s| {
            let rain = Rain::new(1.0, [320, 240], 7, 3, t_s).unwrap();
            (0..320 * 240).filter(|&i| rain.drop_at(i).is_some()).count()
        };
        assert!(drops(1.3) > 3 * drops(0.2).max(1) && drops(1.3) > 500, "{} {}", drops(1.3), drops(0.2));
        assert!(drops(1.45) < drops(1.35) / 3, "wiped");
        assert!(Rain::new(0.0, [320, 240], 7, 3, 1.0).is_none());
    }

    #[test]
    fn falling_drops_are_others_in_each_frame() {
        let falling = |frame| {
            let rain = Rain::new(1.0, [320, 240], 7, frame, 0.1).unwrap();
            (0..320 * 240).map(|i| rain.falling(i)).collect::<Vec<_>>()
        };
        assert_ne!(falling(1), falling(2));
        assert_eq!(falling(1), falling(1));
        assert!(falling(1).iter().all(|share| (0.0..=0.6).contains(share)));
    }
}

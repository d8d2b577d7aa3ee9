//! Whether two lines cross in a saddle, and which way they run.

use std::f64::consts::PI;

use crate::picture::PlaneView;

use super::subpixel::{brightness, refined};

/// Radius of the ring on which edges are looked for, pixels; a corner's smoothed edges are sharp there, its neighbours beyond.
const RADIUS_PX: f64 = 5.0;
/// Places on the ring.
const PLACES: usize = 32;
/// Pixels to either side by which a saddle's place is refined.
const REACH_PX: usize = 3;
/// Least difference of light and dark, grey levels: several times a camera's noise.
const LEAST_CONTRAST: f64 = 10.0;
/// Most that opposite places differ, as a share of that difference, on average.
const MOST_LOPSIDED: f64 = 0.35;
/// Least angle between the two lines, radians: 15 degrees.
const LEAST_ANGLE_RAD: f64 = PI / 12.0;

/// A saddle where two edges cross.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// Its place, `[u, v]`, pixels.
    pub(super) at: [f64; 2],
    /// Directions of the two edges, radians clockwise from the right, 0 to pi, the smaller first.
    pub(super) edges_rad: [f64; 2],
    /// Middle direction of the light, up to half a turn.
    pub(super) light_rad: f64,
    /// Difference of light and dark, grey levels.
    pub(super) contrast: f64,
}

impl Crossing {
    /// Directions that lead away along the edges, radians, clockwise one after the other.
    pub(super) fn directions_rad(&self) -> [f64; 4] {
        let [first, second] = self.edges_rad;
        [first, second, first + PI, second + PI]
    }

    /// Whether light and dark are exchanged between the two, as between neighbours of a board.
    pub(super) fn is_opposite(&self, other: &Self) -> bool {
        libm::cos(2.0 * (self.light_rad - other.light_rad)) < 0.0
    }
}

/// The crossing near a pixel; none where the picture shows something else.
pub(super) fn crossing_at(grey: PlaneView<'_, u8>, (x, y): (usize, usize)) -> Option<Crossing> {
    crossing_near(grey, [x as f64, y as f64])
}

/// The crossing near a place, within 3 pixels of it.
pub(super) fn crossing_near(grey: PlaneView<'_, u8>, near: [f64; 2]) -> Option<Crossing> {
    let at = refined(grey, near, REACH_PX)?;
    let mut ring = [0.0; PLACES];
    for (place, value) in ring.iter_mut().enumerate() {
        let angle = place as f64 * 2.0 * PI / PLACES as f64;
        *value =
            brightness(grey, [at[0] + RADIUS_PX * libm::cos(angle), at[1] + RADIUS_PX * libm::sin(angle)])?;
    }
    // A crossing looks the same after half a turn.
    const HALF: usize = PLACES / 2;
    let folded: [f64; HALF] = std::array::from_fn(|place| 0.5 * (ring[place] + ring[place + HALF]));
    let lopsided = (0..HALF).map(|place| (ring[place] - ring[place + HALF]).abs()).sum::<f64>() / HALF as f64;
    let (dark, light) = folded
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)));
    let contrast = light - dark;
    if contrast < LEAST_CONTRAST || lopsided > MOST_LOPSIDED * contrast {
        return None;
    }
    let edges_rad = edges(&folded, 0.5 * (light + dark))?;
    let between = edges_rad[1] - edges_rad[0];
    if !(LEAST_ANGLE_RAD..=PI - LEAST_ANGLE_RAD).contains(&between) {
        return None;
    }
    let middle = 0.5 * (edges_rad[0] + edges_rad[1]);
    let place = (middle / PI * HALF as f64) as usize % HALF;
    let light_rad = if folded[place] > 0.5 * (light + dark) { middle } else { middle + 0.5 * PI };
    Some(Crossing { at, edges_rad, light_rad, contrast })
}

/// The two directions in which a half ring passes a level, radians; none where it does so more often.
fn edges(folded: &[f64], level: f64) -> Option<[f64; 2]> {
    let count = folded.len();
    let mut passes = (0..count).filter_map(|place| {
        let (here, next) = (folded[place] - level, folded[(place + 1) % count] - level);
        ((here < 0.0) != (next < 0.0)).then(|| (place as f64 + here / (here - next)) * PI / count as f64)
    });
    let both = [passes.next()?, passes.next()?];
    passes.next().is_none().then_some(both)
}

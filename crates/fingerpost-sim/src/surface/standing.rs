//! Colours of what stands on the ground: houses, walls, fences, trees, vehicles, people.

use super::{Colour, Painter};
use crate::light::mixed;
use crate::noise::{floor_int, mix, unit};
use crate::object::{Hit, Object, Part, Shape};

/// Plaster and brick where every house has its own: white, cream, ochre, grey, brick red, brown, dark slate.
const FACADES: [Colour; 7] = [
    [0.78, 0.77, 0.75],
    [0.66, 0.60, 0.47],
    [0.52, 0.37, 0.19],
    [0.34, 0.34, 0.35],
    [0.30, 0.115, 0.075],
    [0.20, 0.13, 0.085],
    [0.08, 0.085, 0.095],
];
/// How far a house is brighter or darker than its kind, share.
const SPREAD: f32 = 0.3;
/// Glass of windows, from what mirrors a dark room to what mirrors the sky.
const GLASS: [f32; 2] = [0.03, 0.30];
/// Share of the houses with shop windows in their lowest floor, and where these begin and end, metres above the ground.
const SHOPS: f32 = 0.25;
const SHOP_M: [f32; 2] = [0.4, 2.6];
/// Distance of windows, their width, height of a floor and of a window, metres: from narrow to wide ones.
const WINDOW_EVERY_M: [f32; 2] = [2.0, 4.2];
const WINDOW_SHARE: [f32; 2] = [0.3, 0.6];
const FLOOR_M: [f32; 2] = [2.7, 3.6];
/// A window reaches from and to this share of a floor.
const WINDOW_UP: [f32; 2] = [0.32, 0.80];
/// Paint of fences: creosote, weathered wood, white, green.
const FENCES: [Colour; 4] = [[0.10, 0.06, 0.035], [0.27, 0.25, 0.22], [0.62, 0.62, 0.60], [0.06, 0.10, 0.06]];
/// Width of a fence's plank and of the gap beside it, metres.
const PLANK_M: f32 = 0.14;
const GAP_M: f32 = 0.05;
/// Paint of bins and signs, and cloth.
const PAINTS: [Colour; 6] = [
    [0.05, 0.05, 0.055],
    [0.04, 0.12, 0.05],
    [0.35, 0.03, 0.03],
    [0.05, 0.09, 0.28],
    [0.55, 0.42, 0.06],
    [0.55, 0.55, 0.54],
];
/// Skin, from dark to light.
const SKIN: [Colour; 2] = [[0.09, 0.05, 0.035], [0.42, 0.27, 0.20]];
/// Where a person's legs end and the head begins, shares of the height.
const LEGS: f32 = 0.5;
const HEAD: f32 = 0.88;

impl Painter {
    /// Colour of an object in full light, and the light of its own that it sends out for lamps of brightness 1.
    pub(crate) fn object(&self, object: &Object, hit: &Hit, footprint_m: f32) -> (Colour, Colour) {
        match object.shape {
            Shape::Vehicle(shape) => shape.colour(hit, object.hash),
            _ => (self.standing(object, hit, footprint_m), [0.0; 3]),
        }
    }

    fn standing(&self, object: &Object, hit: &Hit, footprint_m: f32) -> Colour {
        let [along, up] = hit.surface_m;
        let shade = |i: u64| unit(mix(object.hash ^ i));
        match hit.part {
            Part::Wall if self.materials.is_some() => {
                let plaster = 1.0 + 0.2 * self.soil.sample(along, up, footprint_m)[0];
                facade(object.hash, along, up).map(|c| c * plaster)
            }
            Part::Fence => {
                let gap = PLANK_M + GAP_M;
                let in_gap = along - gap * floor_int(along / gap) as f32 > PLANK_M;
                let paint = FENCES[(object.hash % FENCES.len() as u64) as usize];
                // From afar a fence is of the mean of its planks and gaps.
                if in_gap && footprint_m < GAP_M { paint.map(|c| 0.25 * c) } else { paint.map(|c| 0.85 * c) }
            }
            Part::Painted => PAINTS[(object.hash % PAINTS.len() as u64) as usize],
            Part::Person => person(object, up),
            Part::Wall => {
                let tone = 0.30 + 0.35 * shade(1);
                let plaster = 1.0 + 0.25 * self.soil.sample(along, up, footprint_m)[0];
                let wall = [tone, tone * (0.86 + 0.12 * shade(2)), tone * (0.70 + 0.25 * shade(3))];
                if window(along, up) { [0.06, 0.075, 0.09] } else { wall.map(|c| c * plaster) }
            }
            Part::Roof => {
                let tiles = 1.0 + 0.35 * self.soil.sample(along, 2.5 * up, footprint_m)[0];
                let red = 0.20 + 0.14 * shade(4);
                [red, 0.5 * red + 0.02, 0.36 * red + 0.02].map(|c| c * tiles)
            }
            Part::Trunk => [0.11, 0.085, 0.06],
            Part::Masonry => {
                let stone = 1.0 + 0.4 * self.soil.sample(along, up, footprint_m)[0];
                let tone = 0.22 + 0.2 * shade(1);
                [tone, 0.95 * tone, 0.86 * tone].map(|c| c * stone)
            }
            Part::Metal | Part::Body | Part::Glass => [0.36, 0.37, 0.38],
            Part::Crown => {
                let leaves = self.grass.sample(0.35 * along, 0.35 * up, 0.35 * footprint_m);
                let bright = (1.0 + 0.9 * leaves[0]).max(0.15);
                let green = 0.10 + 0.07 * shade(5);
                [green * (0.62 + 0.25 * shade(6)), green, 0.30 * green].map(|c| c * bright)
            }
        }
    }
}

/// A house of its own colour, with windows of its own size.
fn facade(hash: u64, along: f32, up: f32) -> Colour {
    let draw = |i: u64| unit(mix(hash ^ mix(i)));
    let between = |i: u64, [low, high]: [f32; 2]| low + (high - low) * draw(i);
    let kind = FACADES[((draw(11) * FACADES.len() as f32) as usize).min(FACADES.len() - 1)];
    let wall = kind.map(|c| c * (1.0 + SPREAD * (2.0 * draw(12) - 1.0)));
    let tone = between(13, GLASS);
    let glass = [0.85 * tone, 0.95 * tone, 1.1 * tone];
    if draw(14) < SHOPS && (SHOP_M[0]..SHOP_M[1]).contains(&up) {
        return mixed(glass, wall, 0.15);
    }
    let (every_m, floor_m) = (between(15, WINDOW_EVERY_M), between(16, FLOOR_M));
    let within = |value: f32, period: f32| value / period - floor_int(value / period) as f32;
    let aside = (within(along + 100.0, every_m) - 0.5).abs();
    let is_window = aside < 0.5 * between(17, WINDOW_SHARE)
        && (WINDOW_UP[0]..WINDOW_UP[1]).contains(&within(up, floor_m));
    if is_window { glass } else { wall }
}

/// Trousers, a coat and a head.
fn person(object: &Object, up: f32) -> Colour {
    let draw = |i: u64| unit(mix(object.hash ^ mix(i)));
    let cloth = |i: u64| PAINTS[((draw(i) * PAINTS.len() as f32) as usize).min(PAINTS.len() - 1)];
    match up / object.height_m() {
        share if share < LEGS => cloth(1).map(|c| 0.5 * c),
        share if share < HEAD => cloth(2),
        _ => mixed(SKIN[0], SKIN[1], draw(3)),
    }
}

/// Windows of 1.1 x 1.3 m every 2.6 m of wall and every 2.8 m of height.
fn window(along: f32, up: f32) -> bool {
    let within = |value: f32, period: f32| value - period * floor_int(value / period) as f32;
    let (x, y) = (within(along + 100.0, 2.6), within(up, 2.8));
    (0.8..1.9).contains(&x) && (0.9..2.2).contains(&y)
}

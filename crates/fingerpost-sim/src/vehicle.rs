//! Other vehicles: a body with bonnet or without, a cabin on it, wheels, lamps and windows as paint.

use crate::object::{Half, Hit, Part, convex_hit, turned_back};
use crate::surface::Colour;

/// Size of a vehicle, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VehicleShape {
    /// Half of its length and of its width.
    pub(crate) half_m: [f32; 2],
    /// Height of its body and of its roof; the same for a lorry, which has no cabin on top.
    pub(crate) height_m: [f32; 2],
    /// Cosine and sine of its direction.
    pub(crate) direction: [f32; 2],
}

/// The body begins so high above the road, metres; below it is dark.
const CLEARANCE_M: f32 = 0.04;
const SILL_M: f32 = 0.26;
/// Where the cabin begins and ends, shares of half of the length from the middle, and how far its windows lean, share of
/// its height.
const CABIN: [f32; 2] = [-0.92, 0.42];
const LEAN: f32 = 0.75;
const SIDE_LEAN: f32 = 0.25;
/// Wheels: distance of the axles from the middle as a share of half of the length, and radius, metres.
const AXLE: f32 = 0.62;
const WHEEL_M: f32 = 0.33;
/// Height of the lamps' middle, half of their height and width, and distance of their middle from the side, metres.
const LAMP_M: [f32; 4] = [0.68, 0.08, 0.17, 0.24];
/// A number plate's half width and the heights it reaches from and to, metres.
const PLATE_M: [f32; 3] = [0.26, 0.42, 0.53];

impl VehicleShape {
    /// Where a ray (in the frame of the foot) first meets it.
    pub(crate) fn hit(&self, origin: [f32; 3], direction: [f32; 3]) -> Option<Hit> {
        let [cos, sin] = self.direction;
        let turn = |v: [f32; 3]| [cos * v[0] + sin * v[1], -sin * v[0] + cos * v[1], v[2]];
        let (o, d) = (turn(origin), turn(direction));
        let ([half_length, half_width], [waist, roof]) = (self.half_m, self.height_m);
        let side = |normal, offset| Half { normal, offset, part: Part::Body };
        let body = convex_hit(
            o,
            d,
            &[
                side([1.0, 0.0, 0.0], half_length),
                side([-1.0, 0.0, 0.0], half_length),
                side([0.0, 1.0, 0.0], half_width),
                side([0.0, -1.0, 0.0], half_width),
                side([0.0, 0.0, 1.0], waist),
                side([0.0, 0.0, -1.0], -CLEARANCE_M),
            ],
        );
        let cabin = (roof > waist).then(|| {
            // A plane that leans in by `lean` metres for each metre of height and passes the waist `out` from the middle.
            let leaning = |x: f32, y: f32, lean: f32, out: f32| {
                let length = (1.0 + lean * lean).sqrt();
                Half {
                    normal: [x / length, y / length, lean / length],
                    offset: (out + lean * waist) / length,
                    part: Part::Glass,
                }
            };
            let [rear, front] = CABIN.map(|share| share * half_length);
            convex_hit(
                o,
                d,
                &[
                    leaning(1.0, 0.0, LEAN, front),
                    leaning(-1.0, 0.0, 0.5 * LEAN, -rear),
                    leaning(0.0, 1.0, SIDE_LEAN, 0.96 * half_width),
                    leaning(0.0, -1.0, SIDE_LEAN, 0.96 * half_width),
                    side([0.0, 0.0, 1.0], roof),
                    side([0.0, 0.0, -1.0], -0.9 * waist),
                ],
            )
        });
        let hit = match (body, cabin.flatten()) {
            (Some(a), Some(b)) => {
                if a.t < b.t {
                    a
                } else {
                    b
                }
            }
            (a, b) => a.or(b)?,
        };
        Some(turned_back(hit, o, d, [cos, sin]))
    }

    /// Its colour where it was hit, and the light of its own that it sends out from there for lamps of brightness 1.
    pub(crate) fn colour(&self, hit: &Hit, hash: u64) -> (Colour, Colour) {
        const DARK: Colour = [0.018, 0.018, 0.020];
        let [cos, sin] = self.direction;
        let ahead = hit.normal[0] * cos + hit.normal[1] * sin;
        let [along, up] = hit.surface_m;
        let paint = LACQUERS[(hash % LACQUERS.len() as u64) as usize];
        let unlit = |colour| (colour, [0.0; 3]);
        if hit.part == Part::Glass {
            // Side windows stand between pillars.
            let is_side = ahead.abs() < 0.5;
            let pillar = is_side && (along - 0.1 * self.half_m[0]).abs() < 0.06;
            return unlit(if pillar { paint } else { [0.035, 0.04, 0.045] });
        }
        if hit.normal[2] > 0.7 {
            return unlit(paint);
        }
        if ahead.abs() < 0.5 {
            let axle = AXLE * self.half_m[0];
            let wheel = ((along.abs() - axle).powi(2) + (up - WHEEL_M).powi(2)).sqrt();
            return unlit(match wheel {
                rim if rim < 0.55 * WHEEL_M => [0.24, 0.24, 0.25],
                tyre if tyre < WHEEL_M => DARK,
                _ if up < SILL_M => DARK,
                _ => paint,
            });
        }
        let [middle, half_height, half_width, from_side] = LAMP_M;
        let in_lamp = (along.abs() - (self.half_m[1] - from_side)).abs() < half_width
            && (up - middle).abs() < half_height;
        if in_lamp {
            return if ahead > 0.0 {
                ([0.75, 0.75, 0.72], HEADLAMP)
            } else {
                ([0.30, 0.02, 0.015], TAIL_LAMP)
            };
        }
        let [plate, low, high] = PLATE_M;
        if along.abs() < plate && (low..high).contains(&up) {
            return unlit([0.65, 0.65, 0.60]);
        }
        unlit(if up < SILL_M || (ahead > 0.0 && along.abs() < 0.5 && (0.5..0.72).contains(&up)) {
            DARK
        } else {
            paint
        })
    }

    /// Where its lamps are, from its foot, metres: two ahead, two behind.
    pub(crate) fn lamps(&self) -> [([f32; 3], LampKind); 4] {
        let [cos, sin] = self.direction;
        let [half_length, half_width] = self.half_m;
        let [up, .., from_side] = LAMP_M;
        let place = |x: f32, y: f32| [cos * x - sin * y, sin * x + cos * y, up];
        let (out, aside) = (half_length + 0.02, half_width - from_side);
        [
            (place(out, aside), LampKind::Head),
            (place(out, -aside), LampKind::Head),
            (place(-out, aside), LampKind::Tail),
            (place(-out, -aside), LampKind::Tail),
        ]
    }
}

/// A lamp of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LampKind {
    /// Low beam, to the front.
    Head,
    /// To the rear.
    Tail,
}

/// Light of a lamp's glass.
pub(crate) const HEADLAMP: Colour = [8.0, 7.4, 6.2];
pub(crate) const TAIL_LAMP: Colour = [1.6, 0.10, 0.05];

/// Colours of vehicles as common as they are: grey, white, black, silver, blue, red.
pub(crate) const LACQUERS: [Colour; 8] = [
    [0.13, 0.135, 0.14],
    [0.62, 0.62, 0.60],
    [0.025, 0.025, 0.028],
    [0.36, 0.37, 0.38],
    [0.04, 0.07, 0.20],
    [0.30, 0.02, 0.02],
    [0.55, 0.55, 0.53],
    [0.05, 0.055, 0.06],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn car() -> VehicleShape {
        VehicleShape { half_m: [2.2, 0.9], height_m: [0.9, 1.45], direction: [0.0, 1.0] }
    }

    #[test]
    fn a_car_has_a_rear_with_red_lamps_and_a_window_above_it() {
        // It drives north, 10 m to the north of the ray's origin.
        let seen = |east: f32, up: f32| car().hit([east, -10.0, up], [0.0, 1.0, 0.0]);
        let rear = seen(0.66, 0.68).unwrap();
        assert!((rear.t - 7.8).abs() < 1e-4 && rear.normal[1] < -0.99);
        let (colour, lamp) = car().colour(&rear, 3);
        assert!(colour[0] > 5.0 * colour[1] && lamp[0] > 1.0);
        assert_eq!(seen(0.0, 1.2).unwrap().part, Part::Glass);
        assert!(seen(0.0, 1.6).is_none() && seen(1.0, 0.5).is_none());
        let (_, dark) = car().colour(&seen(0.0, 0.8).unwrap(), 3);
        assert!(dark[0] < 1e-9);
    }

    #[test]
    fn lamps_are_where_the_paint_has_them() {
        for (place, kind) in car().lamps() {
            let toward = if kind == LampKind::Head { -1.0 } else { 1.0 };
            let hit = car().hit([place[0], place[1] - 5.0 * toward, place[2]], [0.0, toward, 0.0]).unwrap();
            let (_, lamp) = car().colour(&hit, 0);
            assert!(lamp[0] > 1.0, "{kind:?} at {place:?}");
        }
    }
}

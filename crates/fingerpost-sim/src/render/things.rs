//! What stands and what moves, under one numbering.

use super::nearby::Neighbour;
use crate::object::{Object, Ray, Shape, dot};
use crate::vehicle::VehicleShape;

/// All objects of a frame: those that stand come first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Things<'a> {
    pub(super) standing: &'a [Object],
    pub(super) moving: &'a [Object],
}

/// A vehicle shades ground this far from its sides, metres, were there no sun.
const SHADED_M: f32 = 0.7;
/// Share of the sky's light that is left below a vehicle.
const BELOW: f32 = 0.12;
/// A vehicle's shadow in the sun reaches no farther than this, metres.
pub(super) const SHADOW_REACH_M: f32 = 9.0;

impl<'a> Things<'a> {
    /// All of them, in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &'a Object> {
        self.standing.iter().chain(self.moving)
    }

    /// The object of that number.
    #[inline]
    pub(super) fn get(&self, number: u32) -> &'a Object {
        let number = number as usize;
        match number.checked_sub(self.standing.len()) {
            None => &self.standing[number],
            Some(moving) => &self.moving[moving],
        }
    }

    /// What the vehicles `near` leave of the sky's light at a place on the ground, and whether one keeps the sun away from it.
    #[inline]
    pub(super) fn shade(&self, near: &[Neighbour], [x, y, up]: [f32; 3], to_sun: [f32; 3]) -> (f32, bool) {
        let (mut sky, mut in_shadow) = (1.0_f32, false);
        for object in near.iter().map(|near| &self.moving[near.object as usize]) {
            let Shape::Vehicle(VehicleShape { half_m, direction: [cos, sin], .. }) = object.shape else {
                continue;
            };
            let (dx, dy) = (x - object.foot[0], y - object.foot[1]);
            if dx * dx + dy * dy > SHADOW_REACH_M * SHADOW_REACH_M {
                continue;
            }
            let out = [(cos * dx + sin * dy).abs() - half_m[0], (cos * dy - sin * dx).abs() - half_m[1]];
            let outside = out.map(|side| side.max(0.0));
            let away_m = dot([outside[0], outside[1], 0.0], [outside[0], outside[1], 0.0]).sqrt();
            let open = ((away_m + 0.05) / SHADED_M).min(1.0);
            sky = sky.min(BELOW + (1.0 - BELOW) * open);
            let ray = Ray { origin: [x, y, up], direction: to_sun };
            in_shadow = in_shadow || object.hit(&ray).is_some();
        }
        (sky, in_shadow)
    }
}

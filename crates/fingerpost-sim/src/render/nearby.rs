//! What stands near the camera, and which of it a tile of the picture may show.

use std::ops::Range;

use super::lamps::Lamp;
use super::things::Things;
use crate::object::{Hit, Object, Ray, dot};

/// Objects farther off than this are left to the haze, metres.
const OBJECT_REACH_M: f32 = 160.0;

/// An object near the camera, relative to it, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Neighbour {
    pub(super) object: u32,
    /// Middle of the ball around it.
    middle: [f32; 3],
    /// Radius of that ball.
    ball_m: f32,
    /// Distance of the ball's middle.
    distance_m: f32,
    /// Radius of the upright cylinder around it.
    radius_m: f32,
    /// Distance over ground at which that cylinder begins.
    from_m: f32,
    /// Height of its top above the camera.
    top_m: f32,
}

impl Neighbour {
    fn new(object: u32, shape: &Object, origin: [f32; 3]) -> Self {
        let (middle, ball_m) = shape.ball();
        let middle = [0, 1, 2].map(|i| middle[i] - origin[i]);
        let radius_m = shape.radius_m();
        let over_ground_m = (middle[0] * middle[0] + middle[1] * middle[1]).sqrt();
        Self {
            object,
            middle,
            ball_m,
            distance_m: dot(middle, middle).sqrt(),
            radius_m,
            from_m: (over_ground_m - radius_m).max(0.0),
            top_m: shape.foot[2] + shape.height_m() - origin[2],
        }
    }

    /// Whether a ray cannot meet the upright cylinder around the object, or is above its top when it gets there.
    #[inline]
    fn is_missed(&self, d: [f32; 3]) -> bool {
        let flat2 = d[0] * d[0] + d[1] * d[1];
        let beside = self.middle[0] * d[1] - self.middle[1] * d[0];
        // The square keeps the comparison free of roots; it is only right where both sides are positive.
        let rise = self.from_m * d[2];
        beside * beside > self.radius_m * self.radius_m * flat2
            || (rise > 0.0 && rise * rise > self.top_m * self.top_m.abs() * flat2)
    }
}

/// All objects within reach, nearest first.
#[derive(Debug, Default)]
pub(super) struct Nearby(Vec<Neighbour>);

/// Objects that a tile may show, and that its mirrored rays may meet, nearest first.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    pub(super) seen: Vec<Neighbour>,
    pub(super) mirrored: Vec<Neighbour>,
    /// Lamps that dazzle in the tile, and those that wet ground mirrors in it.
    pub(super) dazzling: Vec<Lamp>,
    pub(super) streaking: Vec<Lamp>,
    /// Moving objects whose shade the tile may show.
    pub(super) shading: Vec<Neighbour>,
}

impl Nearby {
    /// The objects within reach of `origin` that are not behind it, looking `forward`.
    pub(super) fn new(things: &Things<'_>, origin: [f32; 3], forward: [f32; 3]) -> Self {
        let mut near: Vec<Neighbour> = things
            .iter()
            .enumerate()
            .map(|(index, object)| Neighbour::new(index as u32, object, origin))
            .filter(|near| near.distance_m < OBJECT_REACH_M && dot(near.middle, forward) > -near.ball_m)
            .collect();
        near.sort_by(|a, b| a.from_m.total_cmp(&b.from_m).then(a.object.cmp(&b.object)));
        Self(near)
    }

    /// The `moving` objects with the shade around them, up to `reach_m` from their foot.
    pub(super) fn shades(moving: &[Object], origin: [f32; 3], reach_m: f32) -> Self {
        let numbered = (0..).zip(moving);
        Self(
            numbered
                .map(|(number, object)| Neighbour {
                    ball_m: reach_m,
                    ..Neighbour::new(number, object, origin)
                })
                .collect(),
        )
    }

    /// Objects whose ball a cone of rays (axis, cosine and sine of its half angle) may touch, nearest first.
    pub(super) fn touching(&self, (axis, cos, sin): ([f32; 3], f32, f32), found: &mut Vec<Neighbour>) {
        found.clear();
        for near in &self.0 {
            let touches = near.distance_m <= near.ball_m || {
                // Angle to the middle at most cone plus ball: compare cosines by the addition theorem.
                let ball_sin = near.ball_m / near.distance_m;
                let ball_cos = (1.0 - ball_sin * ball_sin).sqrt();
                let limit = cos * ball_cos - sin * ball_sin;
                let more_than_half_a_turn = sin * ball_cos + cos * ball_sin < 0.0;
                more_than_half_a_turn || dot(near.middle, axis) >= limit * near.distance_m
            };
            if touches {
                found.push(*near);
            }
        }
    }
}

/// The first of the candidates that a ray meets, between two distances along it.
#[inline]
pub(super) fn first_hit<'a>(
    things: &Things<'a>,
    ray: &Ray,
    within: Range<f32>,
    candidates: &[Neighbour],
) -> Option<(&'a Object, Hit)> {
    let mut limit = within.end;
    let mut best = None;
    for near in candidates {
        if near.from_m > limit {
            break;
        }
        if near.is_missed(ray.direction) {
            continue;
        }
        let object = things.get(near.object);
        if let Some(hit) = object.hit(ray).filter(|hit| hit.t < limit && hit.t > within.start) {
            limit = hit.t;
            best = Some((object, hit));
        }
    }
    best
}

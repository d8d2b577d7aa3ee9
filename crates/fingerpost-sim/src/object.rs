//! Houses, trees, posts, rails and vehicles, and where a ray meets them.
//!
//! A house is a box with a gabled roof: the common part of six half-spaces. A tree is a trunk, an upright cylinder,
//! and a crown, an ellipsoid whose rim is frayed by noise.

use crate::noise::value_noise;
use crate::shown::PixelClass;
use crate::vehicle::VehicleShape;

/// A ray: origin and direction (of any length), map frame, metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    /// Where it starts.
    pub(crate) origin: [f32; 3],
    /// Where it goes.
    pub(crate) direction: [f32; 3],
}

/// The part of an object that was hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// A wall.
    Wall,
    /// The roof.
    Roof,
    /// A trunk.
    Trunk,
    /// Leaves.
    Crown,
    /// A vehicle's body.
    Body,
    /// A vehicle's window.
    Glass,
    /// A post's or a rail's metal.
    Metal,
    /// A garden wall.
    Masonry,
    /// A fence's planks.
    Fence,
    /// A bin or a sign.
    Painted,
    /// Somebody.
    Person,
}

impl Part {
    /// What it is part of.
    pub(crate) const fn class(self) -> PixelClass {
        match self {
            Self::Wall | Self::Roof | Self::Trunk | Self::Crown | Self::Masonry | Self::Fence => {
                PixelClass::Structure
            }
            Self::Body | Self::Glass | Self::Metal | Self::Painted | Self::Person => PixelClass::Thing,
        }
    }
}

/// Where a ray meets an object.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit {
    /// Distance along the ray, in lengths of its direction.
    pub(crate) t: f32,
    /// Outward unit normal, map frame.
    pub(crate) normal: [f32; 3],
    /// What was hit.
    pub(crate) part: Part,
    /// Place on the surface for texture, metres: along and up.
    pub(crate) surface_m: [f32; 2],
}

/// The shape of an object.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Shape {
    /// A house.
    House {
        /// Cosine and sine of the ridge's direction.
        ridge: [f32; 2],
        /// Half of the length along the ridge and half of the width across, metres.
        half_m: [f32; 2],
        /// Height of the eaves and of the ridge, metres.
        height_m: [f32; 2],
    },
    /// A tree.
    Tree {
        /// Radius of the trunk, metres.
        trunk_m: f32,
        /// Half of the crown's width and of its height, metres.
        crown_m: [f32; 2],
        /// Height of the crown's middle, metres.
        middle_m: f32,
    },
    /// A beam that stands or lies: a post, a plank, a wall, a hedge.
    Beam {
        /// Cosine and sine of its direction over ground.
        direction: [f32; 2],
        /// Half of its length over ground and of its thickness, metres.
        half_m: [f32; 2],
        /// Height of its lower and upper end, metres.
        height_m: [f32; 2],
        /// What it is of.
        part: Part,
    },
    /// A vehicle.
    Vehicle(VehicleShape),
}

/// A thing beside the road.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Object {
    /// Its foot's middle, map frame, metres.
    pub(crate) foot: [f32; 3],
    /// Its shape.
    pub(crate) shape: Shape,
    /// A number of its own for colours.
    pub(crate) hash: u64,
}

impl Object {
    /// Height of its top above its foot, metres.
    pub(crate) fn height_m(&self) -> f32 {
        match self.shape {
            Shape::House { height_m, .. } | Shape::Beam { height_m, .. } => height_m[1],
            Shape::Vehicle(shape) => shape.height_m[1],
            Shape::Tree { crown_m, middle_m, .. } => middle_m + crown_m[1],
        }
    }

    /// Radius of the upright cylinder around it, metres.
    pub(crate) fn radius_m(&self) -> f32 {
        match self.shape {
            Shape::House { half_m: [a, b], .. }
            | Shape::Beam { half_m: [a, b], .. }
            | Shape::Vehicle(VehicleShape { half_m: [a, b], .. }) => (a * a + b * b).sqrt(),
            Shape::Tree { crown_m, .. } => crown_m[0],
        }
    }

    /// Middle and radius of the ball around it, metres.
    pub(crate) fn ball(&self) -> ([f32; 3], f32) {
        let (half, radius) = (0.5 * self.height_m(), self.radius_m());
        ([self.foot[0], self.foot[1], self.foot[2] + half], (half * half + radius * radius).sqrt())
    }

    /// Where the ray first meets the object in front of its origin.
    #[inline]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<Hit> {
        let origin = [0, 1, 2].map(|i| ray.origin[i] - self.foot[i]);
        match self.shape {
            Shape::House { ridge, half_m, height_m } => {
                house_hit(origin, ray.direction, ridge, half_m, height_m)
            }
            Shape::Beam { direction, half_m, height_m, part } => {
                beam_hit(origin, ray.direction, direction, half_m, height_m, part)
            }
            Shape::Vehicle(shape) => shape.hit(origin, ray.direction),
            Shape::Tree { trunk_m, crown_m, middle_m } => {
                let crown = crown_hit(origin, ray.direction, crown_m, middle_m);
                let trunk = trunk_hit(origin, ray.direction, trunk_m, middle_m);
                match (crown, trunk) {
                    (Some(a), Some(b)) => Some(if a.t < b.t { a } else { b }),
                    (a, b) => a.or(b),
                }
            }
        }
    }
}

fn house_hit(
    origin: [f32; 3],
    direction: [f32; 3],
    [cos, sin]: [f32; 2],
    half_m: [f32; 2],
    [eaves, top]: [f32; 2],
) -> Option<Hit> {
    let turn = |v: [f32; 3]| [cos * v[0] + sin * v[1], -sin * v[0] + cos * v[1], v[2]];
    let (o, d) = (turn(origin), turn(direction));
    let slope = (top - eaves) / half_m[1];
    let length = (1.0 + slope * slope).sqrt();
    let wall = |normal, offset| Half { normal, offset, part: Part::Wall };
    let roof = |normal| Half { normal, offset: top / length, part: Part::Roof };
    let hit = convex_hit(
        o,
        d,
        &[
            wall([1.0, 0.0, 0.0], half_m[0]),
            wall([-1.0, 0.0, 0.0], half_m[0]),
            wall([0.0, 1.0, 0.0], half_m[1]),
            wall([0.0, -1.0, 0.0], half_m[1]),
            roof([0.0, slope / length, 1.0 / length]),
            roof([0.0, -slope / length, 1.0 / length]),
        ],
    )?;
    Some(turned_back(hit, o, d, [cos, sin]))
}

fn beam_hit(
    origin: [f32; 3],
    direction: [f32; 3],
    [cos, sin]: [f32; 2],
    half_m: [f32; 2],
    [low, high]: [f32; 2],
    part: Part,
) -> Option<Hit> {
    let turn = |v: [f32; 3]| [cos * v[0] + sin * v[1], -sin * v[0] + cos * v[1], v[2]];
    let (o, d) = (turn(origin), turn(direction));
    let side = |normal, offset| Half { normal, offset, part };
    let hit = convex_hit(
        o,
        d,
        &[
            side([1.0, 0.0, 0.0], half_m[0]),
            side([-1.0, 0.0, 0.0], half_m[0]),
            side([0.0, 1.0, 0.0], half_m[1]),
            side([0.0, -1.0, 0.0], half_m[1]),
            side([0.0, 0.0, 1.0], high),
            side([0.0, 0.0, -1.0], -low),
        ],
    )?;
    Some(turned_back(hit, o, d, [cos, sin]))
}

/// A hit in an object's own directions, in those of the map; with its place on the face that was hit.
pub(crate) fn turned_back(hit: Hit, o: [f32; 3], d: [f32; 3], [cos, sin]: [f32; 2]) -> Hit {
    let p = [0, 1, 2].map(|i| o[i] + hit.t * d[i]);
    let [x, y, up] = hit.normal;
    let along = if x.abs() > 0.5 { p[1] } else { p[0] };
    Hit { normal: [cos * x - sin * y, sin * x + cos * y, up], surface_m: [along, p[2]], ..hit }
}

/// A half-space: the points p with normal . p <= offset.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Half {
    /// Outward unit normal.
    pub(crate) normal: [f32; 3],
    /// Distance of its plane from the origin.
    pub(crate) offset: f32,
    /// What its plane is part of.
    pub(crate) part: Part,
}

/// Where a ray first meets the common part of half-spaces, from outside; the place on the surface is left open.
#[inline]
pub(crate) fn convex_hit(o: [f32; 3], d: [f32; 3], halves: &[Half]) -> Option<Hit> {
    let (mut enter, mut leave, mut entered) = (0.0_f32, f32::INFINITY, None);
    for half in halves {
        let speed = dot(half.normal, d);
        let gap = half.offset - dot(half.normal, o);
        if speed.abs() < 1e-9 {
            if gap < 0.0 {
                return None;
            }
        } else {
            let t = gap / speed;
            if speed > 0.0 {
                leave = leave.min(t);
            } else if t > enter {
                (enter, entered) = (t, Some(half));
            }
        }
        if enter > leave {
            return None;
        }
    }
    let half = entered?;
    Some(Hit { t: enter, normal: half.normal, part: half.part, surface_m: [0.0; 2] })
}

fn trunk_hit(o: [f32; 3], d: [f32; 3], radius: f32, height: f32) -> Option<Hit> {
    let a = d[0] * d[0] + d[1] * d[1];
    let b = o[0] * d[0] + o[1] * d[1];
    let c = o[0] * o[0] + o[1] * o[1] - radius * radius;
    let under_root = b * b - a * c;
    if under_root <= 0.0 || a < 1e-12 {
        return None;
    }
    let t = (-b - under_root.sqrt()) / a;
    let z = o[2] + t * d[2];
    if t <= 0.0 || !(-0.5..height).contains(&z) {
        return None;
    }
    let normal = [(o[0] + t * d[0]) / radius, (o[1] + t * d[1]) / radius, 0.0];
    Some(Hit { t, normal, part: Part::Trunk, surface_m: [normal[0], z] })
}

fn crown_hit(o: [f32; 3], d: [f32; 3], half_m: [f32; 2], middle: f32) -> Option<Hit> {
    let scale = [1.0 / half_m[0], 1.0 / half_m[0], 1.0 / half_m[1]];
    let o = [o[0] * scale[0], o[1] * scale[1], (o[2] - middle) * scale[2]];
    let d = [0, 1, 2].map(|i| d[i] * scale[i]);
    let (a, b, c) = (dot(d, d), dot(o, d), dot(o, o) - 1.0);
    let under_root = b * b - a * c;
    if under_root <= 0.0 || c <= 0.0 {
        return None;
    }
    let t = (-b - under_root.sqrt()) / a;
    if t <= 0.0 {
        return None;
    }
    let p = [0, 1, 2].map(|i| o[i] + t * d[i]);
    // Zero at the rim, one where the ray goes through the middle.
    let depth = under_root.sqrt() / a.sqrt();
    let surface_m = [(p[0] - 0.7 * p[1]) * half_m[0], (p[2] + 0.5 * p[1]) * half_m[1]];
    let leaves = value_noise(0x1EAF, surface_m[0] * 2.2, surface_m[1] * 2.2);
    if depth < FRAY * leaves {
        return None;
    }
    let n = [0, 1, 2].map(|i| p[i] * scale[i]);
    let length = dot(n, n).sqrt();
    Some(Hit { t, normal: n.map(|x| x / length), part: Part::Crown, surface_m })
}

/// How far the frayed rim of a crown reaches towards its middle, share of the crown's half width.
const FRAY: f32 = 0.55;

/// Scalar product.
#[inline(always)]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests;

//! Direct alignment of two pictures: the sums that a Gauss-Newton step is made from.
//!
//! B. Lucas and T. Kanade, "An iterative image registration technique", 1981, in the inverse compositional form of S. Baker
//! and I. Matthews, "Lucas-Kanade 20 years on", 2004: gradients are taken once, in the older picture, and the newer one is
//! sampled where a warp leads. The older picture is kept as points with much gradient ([`Template`]), one in each small
//! cell, because the rest of a road says little. A warp is projective ([`ProjectiveMap`]), as a plane moves in a camera's
//! picture; the directions in which it may change are polynomials of second degree in the place ([`QuadraticField`]), which
//! is what a projective map's derivatives are.
//!
//! Residuals are weighted much as in P. Holland and R. Welsch, "Robust regression using iteratively reweighted
//! least-squares", 1977, so that gross errors have no say; their scale is that of Student's t distribution, as in C. Kerl et
//! al., "Robust odometry estimation for RGB-D cameras", 2013, which needs no sorting.
//!
//! Grey 0 stands for "unseen"; seen pixels are 1 to 255. A template point beside unseen pixels does not exist, and one that
//! is led between pixels of which one is unseen takes no part.
//!
//! Limits: at most a pixel or two of displacement; more needs a smaller picture first.

mod sums;
mod target;
mod template;
#[cfg(test)]
mod tests;

pub use sums::{Brightness, Residuals, Sums};
pub use target::{Target, mark_unseen};
pub use template::{Corridor, Template};

/// Lanes in which sums over points are kept, on every code path.
pub(crate) const LANES: usize = 16;
/// One number for each of so many points.
pub(crate) type Lanes = [f32; LANES];

/// Directions in which a warp may change.
pub const UNKNOWNS: usize = 7;

/// A field over a picture: two polynomials of second degree in the place (u, v), each as the coefficients of 1, u, v, u^2,
/// u v and v^2.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct QuadraticField {
    /// To the right, pixels.
    pub u: [f32; 6],
    /// Down, pixels.
    pub v: [f32; 6],
}

impl QuadraticField {
    /// The field's value at a place.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, u: f32, v: f32) -> [f32; 2] {
        let (uu, uv, vv) = (u * u, u * v, v * v);
        [self.u, self.v].map(|c| ((c[0] + c[1] * u) + (c[2] * v + c[3] * uu)) + (c[4] * uv + c[5] * vv))
    }
}

/// A projective map of the plane, from places of the older picture to places of the newer one, pixels: (u, v) goes to
/// `(right / scale, down / scale)`, each the sum of its coefficients times 1, u and v.
///
/// Places where `scale` is not positive have no image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProjectiveMap {
    /// To the right.
    pub right: [f32; 3],
    /// Down.
    pub down: [f32; 3],
    /// What both are divided by.
    pub scale: [f32; 3],
}

impl ProjectiveMap {
    /// The map that leaves every place where it is.
    pub const IDENTITY: Self = Self { right: [0.0, 1.0, 0.0], down: [0.0, 0.0, 1.0], scale: [1.0, 0.0, 0.0] };

    /// Where a place goes; not a number for a place without image.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, u: f32, v: f32) -> [f32; 2] {
        let sum = |c: &[f32; 3]| c[0] + (c[1] * u + c[2] * v);
        let scale = sum(&self.scale);
        let inverse = if scale > 0.0 { 1.0 / scale } else { f32::NAN };
        [sum(&self.right) * inverse, sum(&self.down) * inverse]
    }
}

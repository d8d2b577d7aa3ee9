//! A place in a camera picture.

use serde::{Deserialize, Serialize};

/// A place in the `image` frame: pixels, origin at the centre of the top-left pixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pixel {
    /// Pixels to the right.
    pub u: f64,
    /// Pixels down.
    pub v: f64,
}

impl Pixel {
    /// The place `u` pixels right of and `v` pixels below the centre of the top-left pixel.
    pub const fn new(u: f64, v: f64) -> Self {
        Self { u, v }
    }

    /// Distance to another place in the picture, pixels.
    pub fn distance(self, other: Self) -> f64 {
        libm::hypot(self.u - other.u, self.v - other.v)
    }
}

//! A picture at another size: which pixels show the same.

use crate::Pixel;

/// How a picture and the same picture at another size belong together: their outer edges coincide.
///
/// A pixel's centre has whole coordinates, so that a picture reaches from -1/2 to its width less 1/2 (`CONVENTIONS.md`): a
/// place `u` is at `(u + 1/2) s - 1/2` of the other picture, not at `u s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureScale {
    along_u: f64,
    along_v: f64,
}

impl PictureScale {
    /// Between pictures of two sizes, both width and height in pixels and neither zero.
    pub fn between(from: (usize, usize), to: (usize, usize)) -> Self {
        Self { along_u: to.0 as f64 / from.0 as f64, along_v: to.1 as f64 / from.1 as f64 }
    }

    /// Pixels of the other picture for one of the first, to the right and down.
    pub const fn factors(self) -> (f64, f64) {
        (self.along_u, self.along_v)
    }

    /// Where a place of the first picture is in the other one.
    pub fn scaled(self, pixel: Pixel) -> Pixel {
        Pixel::new((pixel.u + 0.5) * self.along_u - 0.5, (pixel.v + 0.5) * self.along_v - 0.5)
    }

    /// Where a place of the other picture is in the first one.
    pub fn unscaled(self, pixel: Pixel) -> Pixel {
        Pixel::new((pixel.u + 0.5) / self.along_u - 0.5, (pixel.v + 0.5) / self.along_v - 0.5)
    }
}

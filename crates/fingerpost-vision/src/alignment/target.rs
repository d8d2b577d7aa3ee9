//! The newer picture, laid out for bilinear sampling.

use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
use crate::simd::{CodePath, simd_kernel};

/// A grey picture as 2 x 2 neighbours a pixel, so that one look-up gives all that a bilinear sample needs.
#[derive(Debug, Clone, Default)]
pub struct Target {
    /// The pixel, its right neighbour, and the two below, lowest byte first; 0 beyond the last column and row.
    pub(super) cells: Plane<u32>,
}

impl Target {
    /// Takes in a picture in which 0 stands for unseen.
    pub fn fill(&mut self, grey: &Plane<u8>) {
        if self.cells.size() != grey.size() {
            self.cells.reset(grey.width(), grey.height(), 0);
        }
        neighbours(CodePath::fastest(), grey, &mut self.cells);
    }
}

simd_kernel! {
    pub(super) fn neighbours(grey: &Plane<u8>, cells: &mut Plane<u32>) {
        let width = grey.width().saturating_sub(1);
        for y in 0..grey.height().saturating_sub(1) {
            let (upper, lower) = (grey.row(y), grey.row(y + 1));
            let out = &mut cells.row_mut(y)[..width];
            let [right_above, right_below] = [upper, lower].map(|row| row.get(1..).unwrap_or_default());
            let rights = right_above.iter().zip(right_below);
            for (((out, &a), &c), (&b, &d)) in out.iter_mut().zip(upper).zip(lower).zip(rights) {
                *out = u32::from(a) | u32::from(b) << 8 | u32::from(c) << 16 | u32::from(d) << 24;
            }
        }
    }
}

/// Fills `grey` with `source` where `seen` is not 0, as at least 1, and with 0 elsewhere.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the sizes differ.
pub fn mark_unseen(
    source: PlaneView<'_, u8>,
    seen: &Plane<u8>,
    grey: &mut Plane<u8>,
) -> Result<(), PictureError> {
    check_size("mask of seen pixels", source.size(), seen.size())?;
    check_size("marked picture", source.size(), grey.size())?;
    mark(CodePath::fastest(), source, seen, grey);
    Ok(())
}

simd_kernel! {
    pub(super) fn mark(source: PlaneView<'_, u8>, seen: &Plane<u8>, grey: &mut Plane<u8>) {
        for y in 0..grey.height() {
            for ((out, &value), &seen) in grey.row_mut(y).iter_mut().zip(source.row(y)).zip(seen.row(y)) {
                *out = if seen != 0 { value.max(1) } else { 0 };
            }
        }
    }
}

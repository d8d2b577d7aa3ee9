//! The Sobel gradient: slopes of a 8-bit picture along both axes over 3 x 3 pixels, each smoothed across itself.
//!
//! Sobel and Feldman, "A 3x3 isotropic gradient operator for image processing", 1968. Weights are -1, 0, 1 along the slope
//! and 1, 2, 1 across it, so a slope of one level a pixel reads 8. Beyond its edges the picture is continued by a mirror
//! through the centre of the edge pixel (dcb|abcd).

use crate::blocks::fastest_for_unaligned_rows;
use crate::border::Border;
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
use crate::simd::{CodePath, simd_kernel};

/// Pixels that the window reaches to either side.
const REACH_PX: usize = 1;

/// The Sobel gradient, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::picture::Plane;
/// use fingerpost_vision::sobel::Sobel;
/// let ramp = Plane::from_vec(4, 3, [0_u8, 5, 10, 15].repeat(3))?;
/// let (mut dx, mut dy) = (Plane::new(4, 3, 0), Plane::new(4, 3, 0));
/// Sobel::new().gradient(ramp.view(), &mut dx, &mut dy)?;
/// assert_eq!(dx.row(1), &[0, 40, 40, 0]);
/// assert_eq!(dy.row(1), &[0; 4]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Sobel {
    columns: Columns,
}

/// A row's pixels with those above and below: their smoothed sums and their differences, with one value beyond either end.
#[derive(Debug, Clone, Default)]
pub(crate) struct Columns {
    pub(crate) smooth: Vec<i16>,
    pub(crate) difference: Vec<i16>,
}

impl Sobel {
    /// A gradient that has not seen a picture yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Slopes of `source` to the right, `dx`, and downwards, `dy`, both -1020 to 1020.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the three differ in size.
    pub fn gradient(
        &mut self,
        source: PlaneView<'_, u8>,
        dx: &mut Plane<i16>,
        dy: &mut Plane<i16>,
    ) -> Result<(), PictureError> {
        self.gradient_on(fastest_for_unaligned_rows(), source, dx, dy)
    }

    /// Slopes of `source` to the right alone, -1020 to 1020.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn horizontal(&mut self, source: PlaneView<'_, u8>, dx: &mut Plane<i16>) -> Result<(), PictureError> {
        self.horizontal_on(fastest_for_unaligned_rows(), source, dx)
    }

    /// Slopes of `source` downwards alone, -1020 to 1020.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn vertical(&mut self, source: PlaneView<'_, u8>, dy: &mut Plane<i16>) -> Result<(), PictureError> {
        self.vertical_on(fastest_for_unaligned_rows(), source, dy)
    }

    fn gradient_on(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        dx: &mut Plane<i16>,
        dy: &mut Plane<i16>,
    ) -> Result<(), PictureError> {
        check_size("horizontal gradient", source.size(), dx.size())?;
        check_size("vertical gradient", source.size(), dy.size())?;
        self.for_each_row(path, source, |y, columns| {
            slopes_right(path, &columns.smooth, dx.row_mut(y));
            slopes_down(path, &columns.difference, dy.row_mut(y));
        });
        Ok(())
    }

    fn horizontal_on(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        dx: &mut Plane<i16>,
    ) -> Result<(), PictureError> {
        check_size("horizontal gradient", source.size(), dx.size())?;
        self.for_each_row(path, source, |y, columns| slopes_right(path, &columns.smooth, dx.row_mut(y)));
        Ok(())
    }

    fn vertical_on(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        dy: &mut Plane<i16>,
    ) -> Result<(), PictureError> {
        check_size("vertical gradient", source.size(), dy.size())?;
        self.for_each_row(path, source, |y, columns| slopes_down(path, &columns.difference, dy.row_mut(y)));
        Ok(())
    }

    fn for_each_row(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        mut take: impl FnMut(usize, &Columns),
    ) {
        if source.width() > 0 {
            for y in 0..source.height() {
                self.columns.fill(path, source, y, Border::Mirror);
                take(y, &self.columns);
            }
        }
    }
}

impl Columns {
    /// Takes row `y` of `source`, which is at least one pixel wide.
    pub(crate) fn fill(&mut self, path: CodePath, source: PlaneView<'_, u8>, y: usize, border: Border) {
        let (width, height) = source.size();
        let above = source.row(border.inside(y as isize - 1, height));
        let below = source.row(border.inside(y as isize + 1, height));
        self.smooth.resize(width + 2 * REACH_PX, 0);
        self.difference.resize(width + 2 * REACH_PX, 0);
        let inner = REACH_PX..REACH_PX + width;
        let (smooth, difference) = (&mut self.smooth[inner.clone()], &mut self.difference[inner]);
        columns(path, [above, source.row(y), below], smooth, difference);
        border.pad(&mut self.smooth, REACH_PX);
        border.pad(&mut self.difference, REACH_PX);
    }
}

simd_kernel! {
    fn columns(rows: [&[u8]; 3], smooth: &mut [i16], difference: &mut [i16]) {
        let width = smooth.len().min(difference.len());
        let (above, here, below) = (&rows[0][..width], &rows[1][..width], &rows[2][..width]);
        let (smooth, difference) = (&mut smooth[..width], &mut difference[..width]);
        for x in 0..width {
            let (first, last) = (i16::from(above[x]), i16::from(below[x]));
            smooth[x] = first + 2 * i16::from(here[x]) + last;
            difference[x] = last - first;
        }
    }
}

simd_kernel! {
    fn slopes_right(smooth: &[i16], dx: &mut [i16]) {
        let (left, right) = (&smooth[..dx.len()], &smooth[2..][..dx.len()]);
        for ((dx, &left), &right) in dx.iter_mut().zip(left).zip(right) {
            *dx = right - left;
        }
    }
}

simd_kernel! {
    fn slopes_down(difference: &[i16], dy: &mut [i16]) {
        let width = dy.len();
        let (left, middle, right) =
            (&difference[..width], &difference[1..][..width], &difference[2..][..width]);
        for (((dy, &left), &middle), &right) in dy.iter_mut().zip(left).zip(middle).zip(right) {
            *dy = left + 2 * middle + right;
        }
    }
}

#[cfg(test)]
mod tests;

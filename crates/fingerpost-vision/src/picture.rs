//! Pictures in memory: single-channel planes, views of parts of them, and interleaved colour.
//!
//! A [`Plane`] owns tightly packed rows; a [`PlaneView`] or [`PlaneViewMut`] is a window on one with a stride, so that
//! a kernel can work on a region without a copy. Sizes are in pixels; a plane of no pixels is valid.

mod rgb;
mod validity;
mod view;

pub use rgb::RgbImage;
pub use validity::{Run, ValidityMask};
pub use view::{PlaneView, PlaneViewMut};

use crate::error::PictureError;

/// A rectangle of whole pixels inside a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Rect {
    /// Leftmost column, pixels.
    pub x: usize,
    /// Topmost row, pixels.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// A single-channel picture with tightly packed rows.
///
/// ```
/// use fingerpost_vision::picture::{Plane, Rect};
/// let plane = Plane::from_vec(3, 2, vec![1_u8, 2, 3, 4, 5, 6])?;
/// let right = plane.view().crop(Rect { x: 1, y: 0, width: 2, height: 2 })?;
/// assert_eq!(right.row(1), &[5, 6]);
/// assert_eq!(plane.get(2, 1), Some(6));
/// assert_eq!(plane.get(3, 0), None);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plane<T> {
    width: usize,
    height: usize,
    data: Vec<T>,
}

impl<T> Default for Plane<T> {
    /// A plane of no pixels.
    fn default() -> Self {
        Self { width: 0, height: 0, data: Vec::new() }
    }
}

impl<T: Copy> Plane<T> {
    /// A plane of `width` x `height` pixels, each `fill`.
    #[must_use]
    pub fn new(width: usize, height: usize, fill: T) -> Self {
        Self { width, height, data: vec![fill; width * height] }
    }

    /// A plane over `data`, row by row from the top.
    ///
    /// # Errors
    /// [`PictureError::BufferLength`] when `data` does not hold exactly `width * height` values.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Result<Self, PictureError> {
        check_length(width, height, 1, data.len())?;
        Ok(Self { width, height, data })
    }

    /// Gives the plane another size and sets every pixel to `fill`, reusing its memory.
    pub fn reset(&mut self, width: usize, height: usize, fill: T) {
        self.data.clear();
        self.data.resize(width * height, fill);
        self.width = width;
        self.height = height;
    }

    /// Width, pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The pixels of row `y`, left to right.
    ///
    /// # Panics
    /// When `y` is not below the height, as indexing a slice does.
    #[must_use]
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// The pixels of row `y`, to be changed.
    ///
    /// # Panics
    /// When `y` is not below the height, as indexing a slice does.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.width..(y + 1) * self.width]
    }

    /// The pixel in column `x` and row `y`, or `None` outside the plane.
    #[must_use]
    pub fn get(&self, x: usize, y: usize) -> Option<T> {
        if x < self.width { self.data.get(y * self.width + x).copied() } else { None }
    }

    /// All pixels, row by row from the top.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.data
    }

    /// All pixels, row by row from the top, to be changed.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// A view of the whole plane.
    #[must_use]
    pub fn view(&self) -> PlaneView<'_, T> {
        PlaneView { data: &self.data, width: self.width, height: self.height, stride: self.width }
    }

    /// A view of the whole plane through which its pixels can be changed.
    pub fn view_mut(&mut self) -> PlaneViewMut<'_, T> {
        PlaneViewMut { width: self.width, height: self.height, stride: self.width, data: &mut self.data }
    }
}

pub(crate) fn check_length(
    width: usize,
    height: usize,
    channels: usize,
    found: usize,
) -> Result<(), PictureError> {
    let expected = width.saturating_mul(height).saturating_mul(channels);
    if expected == found {
        Ok(())
    } else {
        Err(PictureError::BufferLength { width, height, expected, found })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_of_crops_keep_their_place() {
        let plane = Plane::from_vec(5, 4, (0..20_u8).collect()).unwrap();
        let outer = plane.view().crop(Rect { x: 1, y: 1, width: 4, height: 3 }).unwrap();
        let inner = outer.crop(Rect { x: 2, y: 1, width: 2, height: 2 }).unwrap();
        assert_eq!(inner.row(0), &[13, 14]);
        assert_eq!(inner.row(1), &[18, 19]);
    }

    #[test]
    fn a_crop_can_be_changed_without_touching_its_surroundings() {
        let mut plane = Plane::new(4, 3, 0_u8);
        let mut crop = plane.view_mut().crop(Rect { x: 2, y: 1, width: 2, height: 1 }).unwrap();
        crop.row_mut(0).fill(9);
        assert_eq!(plane.as_slice(), &[0, 0, 0, 0, 0, 0, 9, 9, 0, 0, 0, 0]);
    }

    #[test]
    fn wrong_sizes_are_errors() {
        assert!(matches!(
            Plane::from_vec(3, 2, vec![0_u8; 5]),
            Err(PictureError::BufferLength { expected: 6, found: 5, .. })
        ));
        assert!(Plane::from_vec(usize::MAX, 2, vec![0_u8; 5]).is_err());
        assert!(PlaneView::new(&[0_u8; 10], 4, 3, 3).is_err());
        assert!(PlaneView::new(&[0_u8; 10], 4, 3, 4).is_err());
        assert!(PlaneView::new(&[0_u8; 12], 4, 3, 4).is_ok());
        let plane = Plane::new(4, 3, 0_u8);
        for rect in [
            Rect { x: 1, y: 0, width: 4, height: 1 },
            Rect { x: 0, y: 3, width: 1, height: 1 },
            Rect { x: usize::MAX, y: 0, width: 2, height: 1 },
        ] {
            assert!(matches!(plane.view().crop(rect), Err(PictureError::CropOutside { .. })));
        }
    }

    #[test]
    fn an_empty_plane_has_no_pixel() {
        let plane = Plane::new(0, 3, 0_u8);
        assert_eq!(plane.get(0, 0), None);
        assert_eq!(plane.row(2), &[] as &[u8]);
        let nothing = plane.view().crop(Rect { x: 0, y: 3, width: 0, height: 0 }).unwrap();
        assert_eq!(nothing.size(), (0, 0));
    }
}

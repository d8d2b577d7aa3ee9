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

impl Rect {
    /// Checks that it lies inside a picture of `width` x `height` pixels.
    pub(crate) fn check_inside(self, (width, height): (usize, usize)) -> Result<(), PictureError> {
        let fits = |start: usize, length: usize, limit: usize| {
            start.checked_add(length).is_some_and(|end| end <= limit)
        };
        if fits(self.x, self.width, width) && fits(self.y, self.height, height) {
            return Ok(());
        }
        Err(PictureError::CropOutside { rect: self, width, height })
    }
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
///
/// The first pixel of a plane that was not made of somebody's vector lies at a cache line's start: vectors as wide as a line
/// are then read and written in one go wherever rows are whole lines long, which makes many kernels a fifth faster.
#[derive(Debug)]
pub struct Plane<T> {
    width: usize,
    height: usize,
    /// The pixels, behind `start` values that are nobody's.
    data: Vec<T>,
    start: usize,
}

/// Length of a cache line, and of the widest vectors, bytes.
const CACHE_LINE_BYTES: usize = 64;

impl<T> Default for Plane<T> {
    /// A plane of no pixels.
    fn default() -> Self {
        Self { width: 0, height: 0, data: Vec::new(), start: 0 }
    }
}

impl<T: Copy> Clone for Plane<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    fn clone_from(&mut self, source: &Self) {
        match source.as_slice().first() {
            Some(&first) => {
                self.reset(source.width, source.height, first);
                self.as_mut_slice().copy_from_slice(source.as_slice());
            }
            None => (self.width, self.height) = source.size(),
        }
    }
}

impl<T: PartialEq> PartialEq for Plane<T> {
    fn eq(&self, other: &Self) -> bool {
        (self.width, self.height) == (other.width, other.height) && self.pixels() == other.pixels()
    }
}

impl<T: Eq> Eq for Plane<T> {}

impl<T> Plane<T> {
    fn pixels(&self) -> &[T] {
        &self.data[self.start..self.start + self.width * self.height]
    }
}

impl<T: Copy> Plane<T> {
    /// A plane of `width` x `height` pixels, each `fill`.
    #[must_use]
    pub fn new(width: usize, height: usize, fill: T) -> Self {
        let mut plane = Self::default();
        plane.reset(width, height, fill);
        plane
    }

    /// A plane over `data`, row by row from the top.
    ///
    /// # Errors
    /// [`PictureError::BufferLength`] when `data` does not hold exactly `width * height` values.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Result<Self, PictureError> {
        check_length(width, height, 1, data.len())?;
        Ok(Self { width, height, data, start: 0 })
    }

    /// Gives the plane another size and sets every pixel to `fill`, reusing its memory.
    pub fn reset(&mut self, width: usize, height: usize, fill: T) {
        let spare = CACHE_LINE_BYTES / size_of::<T>().max(1);
        self.data.clear();
        self.data.resize(width * height + spare, fill);
        let to_line = self.data.as_ptr().align_offset(CACHE_LINE_BYTES);
        self.start = if to_line <= spare { to_line } else { 0 };
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
        &self.pixels()[y * self.width..(y + 1) * self.width]
    }

    /// The pixels of row `y`, to be changed.
    ///
    /// # Panics
    /// When `y` is not below the height, as indexing a slice does.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        let width = self.width;
        &mut self.as_mut_slice()[y * width..(y + 1) * width]
    }

    /// The pixel in column `x` and row `y`, or `None` outside the plane.
    #[must_use]
    pub fn get(&self, x: usize, y: usize) -> Option<T> {
        if x < self.width { self.pixels().get(y * self.width + x).copied() } else { None }
    }

    /// All pixels, row by row from the top.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        self.pixels()
    }

    /// All pixels, row by row from the top, to be changed.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        let end = self.start + self.width * self.height;
        &mut self.data[self.start..end]
    }

    /// A view of the whole plane.
    #[must_use]
    pub fn view(&self) -> PlaneView<'_, T> {
        PlaneView { data: self.pixels(), width: self.width, height: self.height, stride: self.width }
    }

    /// A view of the whole plane through which its pixels can be changed.
    pub fn view_mut(&mut self) -> PlaneViewMut<'_, T> {
        let (width, height) = self.size();
        PlaneViewMut { width, height, stride: width, data: self.as_mut_slice() }
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

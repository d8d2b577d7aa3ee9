//! Pictures in memory: single-channel planes, views of parts of them, and interleaved colour.
//!
//! A [`Plane`] owns tightly packed rows; a [`PlaneView`] or [`PlaneViewMut`] is a window on one with a stride, so that
//! a kernel can work on a region without a copy. Sizes are in pixels; a plane of no pixels is valid.

use crate::error::PictureError;

/// A rectangle of whole pixels inside a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// A window on a single-channel picture.
#[derive(Debug, Clone, Copy)]
pub struct PlaneView<'a, T> {
    data: &'a [T],
    width: usize,
    height: usize,
    stride: usize,
}

impl<'a, T: Copy> PlaneView<'a, T> {
    /// A view of `height` rows of `width` pixels that start `stride` values apart in `data`.
    ///
    /// # Errors
    /// [`PictureError::Stride`] when rows would overlap or end outside `data`.
    pub fn new(data: &'a [T], width: usize, height: usize, stride: usize) -> Result<Self, PictureError> {
        check_stride(width, height, stride, data.len())?;
        Ok(Self { data, width, height, stride })
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
    pub fn row(&self, y: usize) -> &'a [T] {
        &self.data[y * self.stride..y * self.stride + self.width]
    }

    /// The part of the view inside `rect`.
    ///
    /// # Errors
    /// [`PictureError::CropOutside`] when `rect` reaches outside the view.
    pub fn crop(&self, rect: Rect) -> Result<Self, PictureError> {
        let start = crop_start(rect, self.width, self.height, self.stride)?;
        let data = self.data.get(start..).unwrap_or(&[]);
        Ok(Self { data, width: rect.width, height: rect.height, stride: self.stride })
    }
}

/// A window on a single-channel picture through which its pixels can be changed.
#[derive(Debug)]
pub struct PlaneViewMut<'a, T> {
    data: &'a mut [T],
    width: usize,
    height: usize,
    stride: usize,
}

impl<'a, T: Copy> PlaneViewMut<'a, T> {
    /// A view of `height` rows of `width` pixels that start `stride` values apart in `data`.
    ///
    /// # Errors
    /// [`PictureError::Stride`] when rows would overlap or end outside `data`.
    pub fn new(data: &'a mut [T], width: usize, height: usize, stride: usize) -> Result<Self, PictureError> {
        check_stride(width, height, stride, data.len())?;
        Ok(Self { data, width, height, stride })
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

    /// The pixels of row `y`, to be changed.
    ///
    /// # Panics
    /// When `y` is not below the height, as indexing a slice does.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.stride..y * self.stride + self.width]
    }

    /// The part of the view inside `rect`.
    ///
    /// # Errors
    /// [`PictureError::CropOutside`] when `rect` reaches outside the view.
    pub fn crop(self, rect: Rect) -> Result<Self, PictureError> {
        let start = crop_start(rect, self.width, self.height, self.stride)?;
        let data = self.data.get_mut(start..).unwrap_or(&mut []);
        Ok(Self { data, width: rect.width, height: rect.height, stride: self.stride })
    }
}

/// A colour picture of 8 bits a channel, interleaved red, green, blue, tightly packed.
///
/// ```
/// use fingerpost_vision::picture::RgbImage;
/// let image = RgbImage::from_vec(1, 2, vec![255, 0, 0, 0, 0, 255])?;
/// assert_eq!(image.get(0, 1), Some([0, 0, 255]));
/// assert!(RgbImage::from_vec(2, 2, vec![0; 11]).is_err());
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RgbImage {
    width: usize,
    height: usize,
    data: Vec<u8>,
}

impl RgbImage {
    /// Channels a pixel.
    pub const CHANNELS: usize = 3;

    /// A black picture of `width` x `height` pixels.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, data: vec![0; width * height * Self::CHANNELS] }
    }

    /// A picture over `data`: red, green, blue of each pixel, row by row from the top.
    ///
    /// # Errors
    /// [`PictureError::BufferLength`] when `data` does not hold exactly `width * height * 3` bytes.
    pub fn from_vec(width: usize, height: usize, data: Vec<u8>) -> Result<Self, PictureError> {
        check_length(width, height, Self::CHANNELS, data.len())?;
        Ok(Self { width, height, data })
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

    /// The bytes of row `y`, three a pixel.
    ///
    /// # Panics
    /// When `y` is not below the height, as indexing a slice does.
    #[must_use]
    pub fn row(&self, y: usize) -> &[u8] {
        let length = self.width * Self::CHANNELS;
        &self.data[y * length..(y + 1) * length]
    }

    /// The bytes of row `y`, three a pixel, to be changed.
    ///
    /// # Panics
    /// When `y` is not below the height, as indexing a slice does.
    pub fn row_mut(&mut self, y: usize) -> &mut [u8] {
        let length = self.width * Self::CHANNELS;
        &mut self.data[y * length..(y + 1) * length]
    }

    /// Red, green and blue of the pixel in column `x` and row `y`, or `None` outside the picture.
    #[must_use]
    pub fn get(&self, x: usize, y: usize) -> Option<[u8; 3]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let (pixels, _) = self.row(y).as_chunks::<3>();
        pixels.get(x).copied()
    }

    /// All bytes, three a pixel, row by row from the top.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        &self.data
    }

    /// All bytes, three a pixel, row by row from the top, to be changed.
    pub fn as_mut_slice(&mut self) -> &mut [u8] {
        &mut self.data
    }

    /// The bytes themselves, three a pixel, row by row from the top.
    #[must_use]
    pub fn into_vec(self) -> Vec<u8> {
        self.data
    }
}

fn check_length(width: usize, height: usize, channels: usize, found: usize) -> Result<(), PictureError> {
    let expected = width.saturating_mul(height).saturating_mul(channels);
    if expected == found {
        Ok(())
    } else {
        Err(PictureError::BufferLength { width, height, expected, found })
    }
}

fn check_stride(width: usize, height: usize, stride: usize, found: usize) -> Result<(), PictureError> {
    let last_row_end = height.saturating_sub(1).saturating_mul(stride).saturating_add(width);
    if stride >= width && (height == 0 || last_row_end <= found) {
        Ok(())
    } else {
        Err(PictureError::Stride { width, height, stride, found })
    }
}

fn crop_start(rect: Rect, width: usize, height: usize, stride: usize) -> Result<usize, PictureError> {
    let fits =
        |start: usize, length: usize, limit: usize| start.checked_add(length).is_some_and(|end| end <= limit);
    if fits(rect.x, rect.width, width) && fits(rect.y, rect.height, height) {
        Ok(rect.y * stride + rect.x)
    } else {
        Err(PictureError::CropOutside { rect, width, height })
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

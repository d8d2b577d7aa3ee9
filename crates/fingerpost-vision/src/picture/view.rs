//! Windows on single-channel pictures.

use super::Rect;
use crate::error::PictureError;

/// A window on a single-channel picture.
#[derive(Debug, Clone, Copy)]
pub struct PlaneView<'a, T> {
    pub(super) data: &'a [T],
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) stride: usize,
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
    pub(super) data: &'a mut [T],
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) stride: usize,
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

fn check_stride(width: usize, height: usize, stride: usize, found: usize) -> Result<(), PictureError> {
    let last_row_end = height.saturating_sub(1).saturating_mul(stride).saturating_add(width);
    if stride >= width && (height == 0 || last_row_end <= found) {
        Ok(())
    } else {
        Err(PictureError::Stride { width, height, stride, found })
    }
}

fn crop_start(rect: Rect, width: usize, height: usize, stride: usize) -> Result<usize, PictureError> {
    rect.check_inside((width, height))?;
    Ok(rect.y * stride + rect.x)
}

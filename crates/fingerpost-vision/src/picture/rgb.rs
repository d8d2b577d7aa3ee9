//! Interleaved colour.

use super::check_length;
use crate::error::PictureError;

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

    /// All pixels, row by row from the top.
    pub(crate) fn pixels(&self) -> &[[u8; 3]] {
        self.data.as_chunks().0
    }

    /// All pixels, row by row from the top, to be changed.
    pub(crate) fn pixels_mut(&mut self) -> &mut [[u8; 3]] {
        self.data.as_chunks_mut().0
    }

    /// The bytes themselves, three a pixel, row by row from the top.
    #[must_use]
    pub fn into_vec(self) -> Vec<u8> {
        self.data
    }
}

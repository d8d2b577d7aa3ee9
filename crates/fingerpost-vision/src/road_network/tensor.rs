//! Activations: channels last, with a border of one place all around that stays what it was made of.

use crate::picture::Plane;

/// Activations of a level.
#[derive(Debug, Clone)]
pub(super) struct Tensor {
    width: usize,
    height: usize,
    channels: usize,
    /// Places with the border, the channels of each side by side.
    bytes: Plane<u8>,
}

impl Tensor {
    /// Activations that are all `padding`, the border for good.
    pub(super) fn new((width, height): (usize, usize), channels: usize, padding: u8) -> Self {
        let bytes = Plane::new((width + 2) * channels, height + 2, padding);
        Self { width, height, channels, bytes }
    }

    /// Rows without the border.
    pub(super) fn height(&self) -> usize {
        self.height
    }

    /// A row without the border.
    pub(super) fn row(&self, y: usize) -> &[u8] {
        &self.bytes.row(y + 1)[self.channels..][..self.width * self.channels]
    }

    /// The same, to be changed.
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [u8] {
        let (start, length) = (self.channels, self.width * self.channels);
        &mut self.bytes.row_mut(y + 1)[start..][..length]
    }

    /// A row and those above and below it, with the border.
    pub(super) fn window(&self, y: usize) -> [&[u8]; 3] {
        [0, 1, 2].map(|row| self.bytes.row(y + row))
    }
}

//! A recursive mean of the last frames, which closes the gaps of broken markings and averages noise away.
//!
//! Paper 3, III-A: the sum of n frames, each weighted by a gain K_n and normalised. As a recursion the mean moves towards
//! each new frame by 1/k of the difference, where k counts the frames so far up to n: the first n frames weigh alike, older
//! ones fade. Sums are kept in 128ths of a level, so that small differences are not lost to rounding.

use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
use crate::simd::{CodePath, simd_kernel};

/// Fractions of a level in which the mean is kept: the largest that leaves a difference room in 16 bits.
const FRACTION_BITS: u32 = 7;
/// Fractions in which the share of a new frame is kept.
const SHARE_BITS: u32 = 15;

/// The mean of the last frames.
///
/// ```
/// use fingerpost_vision::frame_buffer::FrameBuffer;
/// use fingerpost_vision::picture::Plane;
/// let mut buffer = FrameBuffer::new(2);
/// let mut mean = Plane::new(4, 1, 0_u8);
/// buffer.add(Plane::new(4, 1, 100_u8).view(), &mut mean)?;
/// buffer.add(Plane::new(4, 1, 200_u8).view(), &mut mean)?;
/// assert_eq!(mean.row(0), [150; 4]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone)]
pub struct FrameBuffer {
    frames: usize,
    taken: usize,
    size: (usize, usize),
    mean: Vec<i16>,
}

impl FrameBuffer {
    /// A buffer of `frames` frames, at least one.
    #[must_use]
    pub fn new(frames: usize) -> Self {
        Self { frames: frames.max(1), taken: 0, size: (0, 0), mean: Vec::new() }
    }

    /// Forgets all frames.
    pub fn clear(&mut self) {
        self.taken = 0;
    }

    /// Takes a frame in and sets `mean` to the mean. A frame of another size starts anew.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when `frame` and `mean` differ in size.
    pub fn add(&mut self, frame: PlaneView<'_, u8>, mean: &mut Plane<u8>) -> Result<(), PictureError> {
        self.add_on(CodePath::fastest(), frame, mean)
    }

    fn add_on(
        &mut self,
        path: CodePath,
        frame: PlaneView<'_, u8>,
        mean: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        check_size("frame buffer", frame.size(), mean.size())?;
        if self.size != frame.size() {
            self.size = frame.size();
            self.taken = 0;
            self.mean.resize(frame.width() * frame.height(), 0);
        }
        self.taken = (self.taken + 1).min(self.frames);
        let share = (1 << SHARE_BITS) / self.taken as i32;
        for (y, kept) in self.mean.chunks_exact_mut(frame.width().max(1)).enumerate() {
            add_row(path, frame.row(y), share, kept, mean.row_mut(y));
        }
        Ok(())
    }
}

simd_kernel! {
    /// Moves `kept` towards `new` by `share` and writes it rounded.
    fn add_row(new: &[u8], share: i32, kept: &mut [i16], mean: &mut [u8]) {
        for ((new, kept), mean) in new.iter().zip(kept.iter_mut()).zip(mean.iter_mut()) {
            let difference = (i32::from(*new) << FRACTION_BITS) - i32::from(*kept);
            let moved = i32::from(*kept) + ((difference * share + (1 << (SHARE_BITS - 1))) >> SHARE_BITS);
            *kept = moved as i16;
            *mean = ((moved + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS).clamp(0, 255) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_frames_weigh_alike_and_older_ones_fade() {
        let mut buffer = FrameBuffer::new(3);
        let mut mean = Plane::new(3, 2, 0_u8);
        for (level, expected) in [(0, 0), (90, 45), (210, 100), (100, 100), (250, 150), (250, 183)] {
            buffer.add(Plane::new(3, 2, level).view(), &mut mean).unwrap();
            assert_eq!(mean.as_slice(), &[expected; 6], "after {level}");
        }
        buffer.clear();
        buffer.add(Plane::new(3, 2, 7).view(), &mut mean).unwrap();
        assert_eq!(mean.as_slice(), &[7; 6]);
    }

    #[test]
    fn every_path_gives_the_bytes_of_the_portable_one() {
        let frame = |seed: usize| {
            let data = (0..67 * 5).map(|i| ((i * 7919 + seed * 104_729) % 256) as u8).collect();
            Plane::from_vec(67, 5, data).unwrap()
        };
        let run = |path| {
            let mut buffer = FrameBuffer::new(4);
            let mut mean = Plane::new(67, 5, 0_u8);
            for seed in 0..9 {
                buffer.add_on(path, frame(seed).view(), &mut mean).unwrap();
            }
            mean
        };
        let expected = run(CodePath::PORTABLE);
        for path in CodePath::available() {
            assert_eq!(run(path), expected, "{path:?}");
        }
    }

    #[test]
    fn another_size_starts_anew_and_unlike_sizes_are_refused() {
        let mut buffer = FrameBuffer::new(5);
        buffer.add(Plane::new(3, 2, 10).view(), &mut Plane::new(3, 2, 0)).unwrap();
        let mut mean = Plane::new(2, 2, 0_u8);
        buffer.add(Plane::new(2, 2, 200).view(), &mut mean).unwrap();
        assert_eq!(mean.as_slice(), &[200; 4]);
        assert!(buffer.add(Plane::new(2, 2, 0).view(), &mut Plane::new(2, 3, 0)).is_err());
    }
}

//! What the times of frames are from.

use crate::video::{StampClock, VideoPicture};

/// What the times of frames are from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameClock {
    /// Each frame has its own: the stamp of a video's frame, a line of `times.txt`, or when it came of a live input.
    Own,
    /// The names of the pictures are times.
    Names,
    /// The rate that the caller gives.
    Given,
    /// The rate that the video states.
    Stated,
    /// A rate that nothing states: [`DEFAULT_PICTURE_FPS`](crate::DEFAULT_PICTURE_FPS), or what ffmpeg takes for a bare stream of pictures.
    Guessed,
}

/// From a frame of a video to its time.
#[derive(Debug)]
pub(crate) enum VideoClock {
    /// By its stamp.
    Stamps(StampClock),
    /// By its index.
    Rate(f64),
}

impl VideoClock {
    /// Whether the time of the next frame that comes depends on the stamps of the two behind it.
    pub(crate) fn asks_for_those_behind(&self, picture: &VideoPicture) -> bool {
        match (self, picture.stamp_us) {
            (Self::Stamps(clock), Some(stamp_us)) => !clock.is_even(picture.index, stamp_us),
            _ => false,
        }
    }

    /// Time of the next frame that comes, or of what comes in its place, seconds since the first, given the stamps of the two behind it
    /// where they are known, microseconds.
    pub(crate) fn time_s(
        &mut self,
        index: u64,
        picture: Option<&VideoPicture>,
        behind_us: Option<[i64; 2]>,
    ) -> f64 {
        match (picture.and_then(|picture| picture.taken_s), &mut *self) {
            (Some(taken_s), _) => taken_s,
            (None, Self::Rate(fps)) => index as f64 / *fps,
            (None, Self::Stamps(clock)) => match picture {
                Some(picture) => clock.time_s(index, picture.stamp_us, behind_us),
                None => clock.next_s(),
            },
        }
    }
}

//! The last seconds of a run up to a frame, decoded once and kept in memory.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use fingerpost_io::decode_picture;
use fingerpost_look::Overview;
use fingerpost_record::FrameTime;
use fingerpost_server::Pictures;
use fingerpost_vision::picture::RgbImage;
use rayon::prelude::*;

use crate::picture_scaling::PictureScaling;

/// How long a stretch is, seconds.
const DURATION_S: f64 = 5.0;
/// What its pictures may take in memory, bytes: five seconds of 20 pictures of 1280 x 720 are 276 MB.
const MOST_BYTES: usize = 512 << 20;

/// When a stretch has to be there: the page waits no longer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Deadline(pub(super) Instant);

impl Deadline {
    fn is_over(self) -> bool {
        Instant::now() >= self.0
    }

    /// Refuses to go on with the frame after so many of a stretch where it is over.
    pub(super) fn check(self, done: usize, of: usize) -> Result<()> {
        if self.is_over() {
            bail!(
                "the stretch was not done in time, {done} of its {of} frames were; try again, or give coarser settings"
            );
        }
        Ok(())
    }
}

/// A frame of a stretch.
#[derive(Debug, Clone, Copy)]
pub(super) struct StretchFrame<'a> {
    pub(super) time: FrameTime,
    pub(super) picture: &'a RgbImage,
}

/// The frames of a run.
#[derive(Debug)]
pub(in crate::look) struct Frames {
    numbers: Vec<u64>,
    times_s: Vec<f64>,
}

impl Frames {
    /// Those of a run.
    pub(in crate::look) fn of(overview: &Overview) -> Self {
        Self { numbers: overview.frames().to_vec(), times_s: overview.times_s().to_vec() }
    }

    /// Number and time of a frame by its index in the run.
    pub(super) fn time(&self, index: usize) -> FrameTime {
        FrameTime { frame: self.numbers[index], t_s: self.times_s[index] }
    }

    /// Where the stretch of at most so many frames up to `index` begins.
    fn first(&self, index: usize, most: usize) -> usize {
        let from_s = self.times_s[index] - DURATION_S;
        let before = self.times_s[..index].iter().rev().take_while(|t_s| **t_s >= from_s).count();
        index - before.min(most.saturating_sub(1))
    }
}

/// Pictures that are decoded before the first of them is made smaller: enough for all cores, and little memory where they come large.
const DECODED_TOGETHER: usize = 16;

/// The pictures of one stretch, as the method gets them.
pub(in crate::look) struct StretchPictures {
    source: Box<dyn Pictures>,
    /// What makes them those of the camera, where they come larger.
    scaling: Option<PictureScaling>,
    size_px: (usize, usize),
    /// By their index in the run; none of a frame whose picture cannot be read.
    loaded: BTreeMap<usize, Option<RgbImage>>,
}

impl StretchPictures {
    /// Pictures of `source` of that size, to which `scaling` makes larger ones.
    pub(in crate::look) fn new(
        source: Box<dyn Pictures>,
        size_px: (usize, usize),
        scaling: Option<PictureScaling>,
    ) -> Self {
        Self { source, scaling, size_px, loaded: BTreeMap::new() }
    }

    /// Loads those of the stretch up to `index` that are not there yet, drops the others, and says where it begins.
    pub(super) fn load_up_to(&mut self, index: usize, frames: &Frames, deadline: Deadline) -> Result<usize> {
        let (width, height) = self.size_px;
        let first = frames.first(index, MOST_BYTES / (3 * width * height).max(1));
        self.loaded.retain(|at, _| (first..=index).contains(at));
        let missing: Vec<usize> = (first..=index).filter(|at| !self.loaded.contains_key(at)).collect();
        for together in missing.chunks(DECODED_TOGETHER) {
            if deadline.is_over() {
                let of = index + 1 - first;
                bail!(
                    "reading pictures takes long: {} of {of} are read and kept; change a setting again to go on",
                    self.loaded.len()
                );
            }
            let source = &*self.source;
            let decoded: Vec<Option<RgbImage>> = together
                .par_iter()
                .map(|at| {
                    let frame = frames.time(*at).frame;
                    let file = source.picture(frame).ok()?;
                    decode_picture(&file.bytes, &PathBuf::from(format!("frame {frame}"))).ok()
                })
                .collect();
            for (at, picture) in together.iter().zip(decoded) {
                let picture = picture.map(|picture| self.scaled(picture));
                self.loaded.insert(*at, picture);
            }
        }
        Ok(first)
    }

    /// A picture at the size at which the method gets it; one that fits neither is left to the method to refuse.
    fn scaled(&mut self, picture: RgbImage) -> RgbImage {
        if let Some(scaling) = self.scaling.as_mut().filter(|_| picture.size() != self.size_px)
            && scaling.shrink(&picture)
        {
            return scaling.picture().clone();
        }
        picture
    }

    /// Each frame whose picture can be read, in the order of the run.
    pub(super) fn loaded(&self, frames: &Frames) -> impl Iterator<Item = StretchFrame<'_>> {
        self.loaded.iter().filter_map(|(at, picture)| {
            Some(StretchFrame { time: frames.time(*at), picture: picture.as_ref()? })
        })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn what_is_not_there_in_time_says_how_far_it_came() {
        let now = Instant::now();
        assert!(Deadline(now + Duration::from_secs(60)).check(3, 100).is_ok());
        let cause = Deadline(now).check(3, 100).unwrap_err().to_string();
        assert!(cause.contains("3 of its 100 frames were"), "{cause}");
    }
}

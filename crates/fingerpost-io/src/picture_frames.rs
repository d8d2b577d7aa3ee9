//! The pictures of a folder, decoded ahead, with their times.

use std::{num::NonZeroUsize, path::PathBuf};

use fingerpost_vision::picture::RgbImage;

use crate::{
    decoders::{Decode, Decoded, Decoders},
    picture_file::{PictureFileError, read_picture_into},
    sampling::{Sampler, Sampling},
};

/// The pictures of a folder.
#[derive(Debug)]
pub(crate) struct PictureFrames {
    pictures: Decoders<PictureFiles>,
    /// Indices of those that are used, and how many of them have been taken.
    used: Vec<usize>,
    taken: usize,
    /// Of all in the folder, seconds since the first.
    times_s: Vec<f64>,
}

/// What became of a picture file.
type DecodedFile = Decoded<Result<RgbImage, PictureFileError>>;

/// Some of the pictures of a folder.
#[derive(Debug)]
struct PictureFiles(std::vec::IntoIter<PathBuf>);

impl Decode for PictureFiles {
    type Picture = Result<RgbImage, PictureFileError>;

    fn decode(&mut self, buffer: Vec<u8>) -> Option<Self::Picture> {
        self.0.next().map(|path| read_picture_into(&path, buffer))
    }
}

impl PictureFrames {
    /// Begins to decode the pictures of a folder that are used, each with its time, seconds since the first.
    pub(crate) fn new(
        paths: Vec<PathBuf>,
        times_s: Vec<f64>,
        sampling: Sampling,
        threads: NonZeroUsize,
    ) -> Self {
        let mut sampler = Sampler::new(sampling);
        let (mut used, mut used_paths) = (Vec::new(), Vec::new());
        for (index, (path, t_s)) in paths.into_iter().zip(&times_s).enumerate() {
            if sampler.wants(index as u64, *t_s) {
                used.push(index);
                used_paths.push(path);
            }
        }
        Self { pictures: decoders(&used_paths, threads), used, taken: 0, times_s }
    }

    /// Number of pictures that are used.
    pub(crate) fn used(&self) -> u64 {
        self.used.len() as u64
    }

    /// Times of all pictures of the folder, seconds since the first.
    pub(crate) fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The next picture that is used, with its index and time.
    pub(crate) fn next(&mut self) -> Option<(u64, f64, DecodedFile)> {
        let decoded = self.pictures.next()?;
        let index = *self.used.get(self.taken)?;
        self.taken += 1;
        Some((index as u64, *self.times_s.get(index)?, decoded))
    }

    /// Takes a buffer back for a later picture.
    pub(crate) fn recycle(&mut self, buffer: Vec<u8>) {
        self.pictures.recycle(buffer);
    }
}

/// Decoders of pictures that may use `threads` threads.
fn decoders(paths: &[PathBuf], threads: NonZeroUsize) -> Decoders<PictureFiles> {
    let count = threads.get().min(paths.len()).max(1);
    let every_nth = |first| paths.iter().skip(first).step_by(count).cloned().collect::<Vec<_>>();
    let mut files = (0..count).map(|first| PictureFiles(every_nth(first).into_iter()));
    match files.next() {
        Some(all) if threads == NonZeroUsize::MIN => Decoders::on_demand(all),
        first => Decoders::ahead(first.into_iter().chain(files)),
    }
}

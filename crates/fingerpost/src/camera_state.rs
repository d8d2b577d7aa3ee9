//! Whether the camera shows the road at all: a covered lens, darkness and a picture that stays the same are named, and
//! nothing is read out of them.
//!
//! What a picture shows stands out from its noise. The picture is thinned to at most 320 columns and cut into blocks of
//! 8 x 8; by how much the means of blocks differ from those of their four neighbours says what is shown, by how much
//! single samples do says how strong the noise is. Noise alone gives block differences of an eighth of the samples'. Slow
//! gradients, as of a cap held before the lens, have no such differences at all.
//!
//! A picture that is that of the frame before to the last bit shows nothing new: a sensor's noise never repeats.
//!
//! Limits: a lens that is covered in part is clear where it is not, and so is a blurred one whose shapes still show. A frozen picture in which the vehicle stood cannot
//! be told from a standing vehicle whose video repeats its pictures.

use fingerpost_vision::picture::RgbImage;

/// What the camera's picture is good for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum CameraState {
    /// It shows something, and something new.
    #[default]
    Clear,
    /// It is the picture of the frame before.
    Frozen,
    /// It is black.
    Black,
    /// Nothing in it stands out from noise: a covered or fogged lens, a white or grey picture, noise.
    NoContrast,
}

impl CameraState {
    /// The state in a word or two, as it stands in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Frozen => "frozen",
            Self::Black => "black",
            Self::NoContrast => "no_contrast",
        }
    }
}

/// How the state was judged.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CameraEvidence {
    /// What the picture is good for.
    pub state: CameraState,
    /// By how much a tenth of the picture's blocks differ from their neighbours at least, grey levels of 255.
    pub contrast: f64,
    /// What is needed to stand out from the noise and from what a video's compression makes.
    pub needed_contrast: f64,
}

/// Columns that a thinned picture has at most.
const MAX_COLUMNS: usize = 320;
/// Side of a block, samples.
const BLOCK: usize = 8;
/// Least contrast, grey levels: between black with noise after H.264 at a rate factor of 28, which has 0.9, and the darkest simulated
/// evening, 1.8 (their geometric mean). Simulated night has 4.1, the darkest of the pictures of eight recorded sets 7.6.
const LEAST_CONTRAST: f64 = 1.3;
/// How many times the contrast that noise alone gives is needed: simulated night has 4.2 times as much, recorded pictures
/// 12 and more, white noise of any strength 1.0.
const NOISE_FACTOR: f64 = 2.0;
/// Contrast that white noise gives to blocks over the median of its samples' differences from their neighbours: the
/// 90th percentile of a normal distribution's magnitude over its median, and an eighth for the mean of 64.
const CONTRAST_OF_NOISE: f64 = 1.645 / 0.6745 / BLOCK as f64;
/// Median sample below which a picture without contrast is black, grey levels: videos have black at 16, and noise above.
const BLACK_BELOW: u8 = 32;
/// Scale of a block's difference: four times a block's sum less its four neighbours' sums.
const BLOCK_SCALE: f64 = (4 * BLOCK * BLOCK) as f64;

/// Looks at every picture before anything is read out of it.
#[derive(Debug, Default)]
pub struct CameraWatch {
    /// The green channel, thinned; of this frame and of the one before.
    samples: Vec<u8>,
    before: Vec<u8>,
    /// Sums over blocks, row by row.
    sums: Vec<u32>,
    /// Magnitudes of the blocks' differences.
    differences: Vec<u32>,
}

impl CameraWatch {
    /// Judges the picture of the next frame.
    pub fn look_at(&mut self, frame: &RgbImage) -> CameraEvidence {
        std::mem::swap(&mut self.samples, &mut self.before);
        let (columns, rows) = thin(frame, &mut self.samples);
        let noise = median_difference(&self.samples, columns);
        self.sum_blocks(columns, rows);
        self.take_differences(columns / BLOCK, rows / BLOCK);
        let Some(contrast) = quantile_90(&mut self.differences) else {
            // A picture of so few samples can be neither clear nor covered; nobody sees a road in it anyway.
            return CameraEvidence::default();
        };
        let contrast = f64::from(contrast) / BLOCK_SCALE;
        let needed_contrast = LEAST_CONTRAST.max(NOISE_FACTOR * CONTRAST_OF_NOISE * noise);
        let state = if contrast < needed_contrast {
            if median(&self.samples) < BLACK_BELOW { CameraState::Black } else { CameraState::NoContrast }
        } else if self.samples == self.before {
            CameraState::Frozen
        } else {
            CameraState::Clear
        };
        CameraEvidence { state, contrast, needed_contrast }
    }

    fn sum_blocks(&mut self, columns: usize, rows: usize) {
        let (across, down) = (columns / BLOCK, rows / BLOCK);
        self.sums.clear();
        self.sums.resize(across * down, 0);
        if across == 0 {
            return;
        }
        for (y, row) in self.samples.chunks_exact(columns).take(down * BLOCK).enumerate() {
            let sums = &mut self.sums[y / BLOCK * across..][..across];
            for (sum, block) in sums.iter_mut().zip(row.chunks_exact(BLOCK)) {
                *sum += block.iter().map(|&sample| u32::from(sample)).sum::<u32>();
            }
        }
    }

    fn take_differences(&mut self, across: usize, down: usize) {
        self.differences.clear();
        for y in 1..down.saturating_sub(1) {
            for x in 1..across.saturating_sub(1) {
                let at = |x: usize, y: usize| self.sums[y * across + x];
                let neighbours = at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1);
                self.differences.push((4 * at(x, y)).abs_diff(neighbours));
            }
        }
    }
}

/// Every n-th sample of the green channel, which carries most of the brightness; gives columns and rows.
fn thin(frame: &RgbImage, samples: &mut Vec<u8>) -> (usize, usize) {
    let (width, height) = frame.size();
    let nth = width.div_ceil(MAX_COLUMNS).max(1);
    samples.clear();
    let rows = frame.as_slice().chunks_exact((width * RgbImage::CHANNELS).max(1)).step_by(nth);
    for row in rows {
        samples.extend(row.iter().skip(1).step_by(nth * RgbImage::CHANNELS));
    }
    (width.div_ceil(nth), height.div_ceil(nth))
}

/// Median difference of a sample from the mean of its four neighbours, grey levels; zero where there are none.
fn median_difference(samples: &[u8], columns: usize) -> f64 {
    let mut counts = [0_usize; 4 * 255 + 1];
    let mut all = 0;
    let rows = samples.len().checked_div(columns).unwrap_or(0);
    // Every other one in both directions: the same median in a quarter of the time.
    for y in (1..rows.saturating_sub(1)).step_by(2) {
        let [above, row, below] = [y - 1, y, y + 1].map(|y| &samples[y * columns..(y + 1) * columns]);
        for x in (1..columns.saturating_sub(1)).step_by(2) {
            let neighbours = [row[x - 1], row[x + 1], above[x], below[x]].map(u16::from);
            counts[usize::from((4 * u16::from(row[x])).abs_diff(neighbours.iter().sum()))] += 1;
            all += 1;
        }
    }
    rank(&counts, all / 2) as f64 / 4.0
}

/// Median of all samples.
fn median(samples: &[u8]) -> u8 {
    let mut counts = [0_usize; 256];
    samples.iter().for_each(|&sample| counts[usize::from(sample)] += 1);
    u8::try_from(rank(&counts, samples.len() / 2)).unwrap_or(u8::MAX)
}

/// The value that so many counted ones are not above.
fn rank(counts: &[usize], mut count: usize) -> usize {
    for (value, &here) in counts.iter().enumerate() {
        if count < here {
            return value;
        }
        count -= here;
    }
    0
}

/// The value that a tenth reaches; none of none.
fn quantile_90(values: &mut [u32]) -> Option<u32> {
    let place = (values.len() * 9 / 10).min(values.len().checked_sub(1)?);
    Some(*values.select_nth_unstable(place).1)
}

#[cfg(test)]
mod tests;

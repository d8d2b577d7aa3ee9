//! Pyramids of pictures for coarse-to-fine search.
//!
//! [`halve`] and [`reduce`] make 8-bit pictures of half the size. The levels of the flow are of `f32` and any scale: every
//! level is made from the full-size picture: smoothed by a Gaussian that suits the reduction, then resampled
//! bilinearly. The widths of the Gaussian and the smallest level are those of OpenCV's `calcOpticalFlowFarneback`, so that
//! flows can be compared with it.

mod halving;

pub use halving::{halve, reduce};

use crate::filter::{SeparableFilter, gaussian_taps};
use crate::picture::Plane;

/// Smallest side of a level, pixels: a coarser one would hold less than the flow's window.
const MIN_SIDE_PX: f64 = 32.0;
/// Weights for the level of full size: a little smoothing against noise.
const BINOMIAL: [f64; 3] = [0.25, 0.5, 0.25];
/// Length of the Gaussian's kernel in standard deviations.
const KERNEL_SIGMAS: f64 = 5.0;

/// One level of a pyramid.
#[derive(Debug, Clone)]
pub struct PyramidLevel {
    /// Size relative to the full picture, 0 to 1.
    pub scale: f64,
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Smoothing of the full-size picture before it is resampled to this level.
    pub smoothing: SeparableFilter,
}

/// The levels of a pyramid over a picture of the given size, coarsest first: the picture itself and up to `reductions`
/// smaller ones, each `scale` (between 0 and 1) times the size of the next.
#[must_use]
pub fn pyramid_levels(width: usize, height: usize, scale: f64, reductions: usize) -> Vec<PyramidLevel> {
    let shorter = width.min(height) as f64;
    let is_large_enough = |level: &i32| *level == 0 || shorter * scale.powi(*level) >= MIN_SIDE_PX;
    let reductions = i32::try_from(reductions).unwrap_or(i32::MAX);
    let mut levels: Vec<PyramidLevel> = (0..=reductions)
        .take_while(is_large_enough)
        .map(|level| {
            let scale = scale.powi(level);
            let side = |full: usize| (full as f64 * scale).round_ties_even() as usize;
            PyramidLevel {
                scale,
                width: side(width),
                height: side(height),
                smoothing: smoothing_for(level, scale),
            }
        })
        .collect();
    levels.reverse();
    levels
}

fn smoothing_for(level: i32, scale: f64) -> SeparableFilter {
    if level == 0 {
        return SeparableFilter::new(&BINOMIAL);
    }
    let sigma_px = 0.5 * (1.0 / scale - 1.0);
    let length = ((KERNEL_SIGMAS * sigma_px).round_ties_even() as usize | 1).max(BINOMIAL.len());
    SeparableFilter::new(&gaussian_taps(sigma_px, length / 2))
}

/// Resamples a picture bilinearly to another size, reusing its table of columns.
///
/// Pixel areas correspond: the picture's outer edges, not its outer pixel centres, stay where they are.
#[derive(Debug, Clone, Default)]
pub struct Resizer {
    columns: Vec<Neighbours>,
}

/// The two pixels of a row or column between which a resampled one lies.
#[derive(Debug, Clone, Copy)]
struct Neighbours {
    lower: usize,
    upper: usize,
    /// Weight of `upper`, 0 to 1.
    weight: f32,
}

impl Resizer {
    /// Fills `target` with `source` resampled to the target's size and multiplied by `gain`; a source without pixels
    /// gives zeros.
    pub fn resize(&mut self, source: &Plane<f32>, target: &mut Plane<f32>, gain: f32) {
        let (width, height) = target.size();
        if source.width() == 0 || source.height() == 0 {
            target.as_mut_slice().fill(0.0);
            return;
        }
        self.columns.clear();
        self.columns.extend((0..width).map(|x| neighbours(x, width, source.width())));
        for y in 0..height {
            let between = neighbours(y, height, source.height());
            let (upper, lower) = (source.row(between.upper), source.row(between.lower));
            for (out, column) in target.row_mut(y).iter_mut().zip(&self.columns) {
                let along = |row: &[f32]| lerp(row[column.lower], row[column.upper], column.weight);
                *out = gain * lerp(along(lower), along(upper), between.weight);
            }
        }
    }
}

fn lerp(from: f32, to: f32, weight: f32) -> f32 {
    from * (1.0 - weight) + to * weight
}

fn neighbours(index: usize, target_length: usize, source_length: usize) -> Neighbours {
    let last = source_length - 1;
    let place = (index as f64 + 0.5) * (source_length as f64 / target_length as f64) - 0.5;
    let place = place.clamp(0.0, last as f64);
    let lower = place as usize;
    Neighbours { lower, upper: (lower + 1).min(last), weight: (place - lower as f64) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_stop_before_they_are_too_small() {
        let sizes = |width, height, reductions| -> Vec<(usize, usize)> {
            pyramid_levels(width, height, 0.5, reductions).iter().map(|l| (l.width, l.height)).collect()
        };
        assert_eq!(sizes(128, 160, 3), vec![(32, 40), (64, 80), (128, 160)]);
        assert_eq!(sizes(128, 160, 1), vec![(64, 80), (128, 160)]);
        assert_eq!(sizes(20, 300, 5), vec![(20, 300)]);
    }

    #[test]
    fn halving_takes_the_mean_of_four_and_doubling_keeps_a_ramp() {
        let source = Plane::from_vec(4, 2, vec![0.0, 2.0, 4.0, 6.0, 10.0, 12.0, 14.0, 16.0]).unwrap();
        let mut half = Plane::new(2, 1, 0.0);
        Resizer::default().resize(&source, &mut half, 1.0);
        assert_eq!(half.as_slice(), &[6.0, 10.0]);
        let mut double = Plane::new(8, 2, 0.0);
        Resizer::default().resize(&source, &mut double, 2.0);
        assert_eq!(double.row(0), &[0.0, 1.0, 3.0, 5.0, 7.0, 9.0, 11.0, 12.0]);
    }

    #[test]
    fn nothing_resized_is_nothing() {
        let mut target = Plane::new(3, 3, 7.0);
        Resizer::default().resize(&Plane::new(0, 5, 1.0), &mut target, 1.0);
        assert!(target.as_slice().iter().all(|value| value.abs() <= 0.0));
    }
}

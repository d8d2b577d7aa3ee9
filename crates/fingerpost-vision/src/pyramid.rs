//! Pyramids of pictures for coarse-to-fine search.
//!
//! [`halve`] and [`reduce`] make 8-bit pictures of half the size. The levels of the flow are of `f32` and any scale: every
//! level is made from the full-size picture: smoothed by a Gaussian that suits the reduction, then resampled
//! bilinearly. The widths of the Gaussian and the smallest level are those of OpenCV's `calcOpticalFlowFarneback`, so that
//! flows can be compared with it.

mod grey;
mod halving;
mod resize;

pub use grey::GreyPyramid;
pub use halving::{halve, reduce};
pub use resize::Resizer;

use crate::filter::{SeparableFilter, gaussian_taps};

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
}

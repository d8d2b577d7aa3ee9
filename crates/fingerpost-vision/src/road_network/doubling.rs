//! A level's way up: doubled bilinearly, in whole 16ths, and joined with the level above it.
//!
//! The outer edges of both stay where they are: a doubled place lies a quarter of a place beyond the nearer of its two neighbours
//! along each side, and beyond the outermost ones these are repeated.

use super::requantising::{LANES, RECTIFIED, rounded};
use super::tensor::Tensor;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Doubles levels of one size.
#[derive(Debug, Clone)]
pub(super) struct Doubling {
    channels: usize,
    /// A row between two of the level's in quarters, its outermost places once more beyond both ends.
    between: Vec<i16>,
}

/// Factors of what is joined: of the doubled level in 16ths, and of the one above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    pub(super) doubled: f32,
    pub(super) level: f32,
}

impl Doubling {
    /// For levels of `width` places with `channels` channels.
    pub(super) fn new(width: usize, channels: usize) -> Self {
        Self { channels, between: vec![0; (width + 2) * channels] }
    }

    /// Fills `out` with the joined `level` and `small`, whose bytes are those of `i8`.
    pub(super) fn join(
        &mut self,
        path: CodePath,
        small: &Plane<u8>,
        level: &Tensor,
        scales: Scales,
        out: &mut Tensor,
    ) {
        let last = small.height().saturating_sub(1);
        for y in 0..level.height() {
            let near = y / 2;
            let far = if y % 2 == 0 { near.saturating_sub(1) } else { (near + 1).min(last) };
            mix(path, small.row(near), small.row(far), self.channels, &mut self.between);
            join(path, &self.between, self.channels, level.row(y), scales, out.row_mut(y));
        }
    }
}

simd_kernel! {
    /// Three quarters of one row and a quarter of the other.
    fn mix(near: &[u8], far: &[u8], channels: usize, between: &mut [i16]) {
        let length = near.len();
        for ((between, &near), &far) in between[channels..].iter_mut().zip(near).zip(far) {
            *between = 3 * i16::from(near as i8) + i16::from(far as i8);
        }
        between.copy_within(channels..2 * channels, 0);
        between.copy_within(length..length + channels, length + channels);
    }
}

simd_kernel! {
    fn join(between: &[i16], channels: usize, level: &[u8], scales: Scales, out: &mut [u8]) {
        let places = level.chunks_exact(2 * channels).zip(out.chunks_exact_mut(2 * channels));
        for (place, (level, out)) in places.enumerate() {
            let beside = &between[place * channels..][..3 * channels];
            let (left, rest) = beside.split_at(channels);
            let (middle, right) = rest.split_at(channels);
            let (first_level, second_level) = level.split_at(channels);
            let (first_out, second_out) = out.split_at_mut(channels);
            for (far, level, out) in [(left, first_level, first_out), (right, second_level, second_out)] {
                let (middle, far) = (middle.as_chunks::<LANES>().0, far.as_chunks::<LANES>().0);
                let lanes = level.as_chunks::<LANES>().0.iter().zip(out.as_chunks_mut::<LANES>().0);
                for ((middle, far), (level, out)) in middle.iter().zip(far).zip(lanes) {
                    for lane in 0..LANES {
                        let doubled = i32::from(3 * middle[lane] + far[lane]) as f32 * scales.doubled;
                        let joined = doubled + i32::from(level[lane]) as f32 * scales.level;
                        out[lane] = rounded(joined, RECTIFIED) as u8;
                    }
                }
            }
        }
    }
}

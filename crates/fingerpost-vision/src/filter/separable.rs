//! Smoothing by a symmetric kernel along columns and rows. Of small kernels there is a twin by hand for AVX-512.

#[cfg(target_arch = "x86_64")]
mod avx512;

use super::mirror;
use crate::error::{PictureError, check_size};
use crate::picture::Plane;
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;
use crate::simd::{CodePath, simd_kernel};

/// A smoothing by one symmetric row of weights, first along columns, then along rows.
///
/// Beyond its edges the picture is continued by a mirror through the centre of the edge pixel (dcb|abcd).
#[derive(Debug, Clone)]
pub struct SeparableFilter {
    /// Weights by distance from the middle.
    weights: Vec<f32>,
    /// A row of sums along columns, continued beyond both ends.
    row_sum: Vec<f32>,
}

impl SeparableFilter {
    /// A filter with the given weights, an odd number of them, the same to the left of the middle as to the right: those
    /// on the left are not read. Of an even number the last is left out.
    #[must_use]
    pub fn new(taps: &[f64]) -> Self {
        let odd = taps.len() - usize::from(taps.len().is_multiple_of(2) && !taps.is_empty());
        let weights = taps[..odd].iter().skip(odd / 2).map(|&weight| weight as f32).collect();
        Self { weights, row_sum: Vec::new() }
    }

    /// Filters `source` into `target`.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: &Plane<f32>, target: &mut Plane<f32>) -> Result<(), PictureError> {
        check_size("filter target", source.size(), target.size())?;
        self.smooth(CodePath::fastest(), source, target);
        Ok(())
    }

    /// Filters between pictures of one size.
    pub(super) fn smooth(&mut self, path: CodePath, source: &Plane<f32>, target: &mut Plane<f32>) {
        if source.width() == 0 {
            return;
        }
        match self.weights.split_first() {
            #[cfg(target_arch = "x86_64")]
            Some((&middle, beside))
                if path.instruction_set() == InstructionSet::Avx512
                    && avx512::can_filter(source.width(), beside.len()) =>
            {
                // SAFETY: a `CodePath` exists only where the processor has its instruction set.
                #[allow(unsafe_code)]
                unsafe {
                    avx512::filter(source, target, middle, beside);
                }
            }
            Some((&middle, beside)) => {
                self.row_sum.resize(source.width() + 2 * beside.len(), 0.0);
                filter(path, source, target, middle, beside, &mut self.row_sum);
            }
            None => target.as_mut_slice().fill(0.0),
        }
    }
}

simd_kernel! {
    fn filter(
        source: &Plane<f32>, target: &mut Plane<f32>, middle: f32, beside: &[f32], row_sum: &mut [f32],
    ) {
        let ((width, height), radius) = (source.size(), beside.len());
        for y in 0..height {
            let above = |distance: usize| source.row(mirror(y as isize - distance as isize, height));
            let below = |distance: usize| source.row(mirror((y + distance) as isize, height));
            let columns = &mut row_sum[radius..radius + width];
            weigh(columns, source.row(y), middle, beside, above, below);
            for beyond in 1..=radius {
                row_sum[radius - beyond] = row_sum[radius + mirror(-(beyond as isize), width)];
                let right = mirror((width - 1 + beyond) as isize, width);
                row_sum[radius + width - 1 + beyond] = row_sum[radius + right];
            }
            let left = |distance: usize| &row_sum[radius - distance..][..width];
            let right = |distance: usize| &row_sum[radius + distance..][..width];
            weigh(target.row_mut(y), &row_sum[radius..], middle, beside, left, right);
        }
    }
}

/// Sums what lies at each distance before and after, as many distances at a time as keep the sums in registers.
#[inline(always)]
fn weigh<'a>(
    out: &mut [f32],
    centre: &[f32],
    middle: f32,
    beside: &[f32],
    before: impl Fn(usize) -> &'a [f32],
    after: impl Fn(usize) -> &'a [f32],
) {
    let start = move |_: f32, centre: f32| middle * centre;
    let go_on = |sum: f32, _: f32| sum;
    match *beside {
        [] => out.iter_mut().zip(centre).for_each(|(out, &value)| *out = middle * value),
        [w] => add_pairs(out, centre, start, [w], [before(1)], [after(1)]),
        [v, w] => add_pairs(out, centre, start, [v, w], [before(1), before(2)], [after(1), after(2)]),
        [u, v, w, ref further @ ..] => {
            let [near, far] = [[before(1), before(2), before(3)], [after(1), after(2), after(3)]];
            add_pairs(out, centre, start, [u, v, w], near, far);
            let (threes, rest) = further.as_chunks::<3>();
            for (group, &weights) in threes.iter().enumerate() {
                let d = 3 * group + 4;
                let [near, far] =
                    [[before(d), before(d + 1), before(d + 2)], [after(d), after(d + 1), after(d + 2)]];
                add_pairs(out, centre, go_on, weights, near, far);
            }
            for (d, &w) in (3 * threes.len() + 4..).zip(rest) {
                add_pairs(out, centre, go_on, [w], [before(d)], [after(d)]);
            }
        }
    }
}

#[inline(always)]
fn add_pairs<const N: usize>(
    out: &mut [f32],
    centre: &[f32],
    start: impl Fn(f32, f32) -> f32,
    weights: [f32; N],
    mut before: [&[f32]; N],
    mut after: [&[f32]; N],
) {
    let length = out.len();
    let centre = &centre[..length];
    for pair in 0..N {
        before[pair] = &before[pair][..length];
        after[pair] = &after[pair][..length];
    }
    for i in 0..length {
        let mut sum = start(out[i], centre[i]);
        for pair in 0..N {
            sum += weights[pair] * (before[pair][i] + after[pair][i]);
        }
        out[i] = sum;
    }
}

//! Log-likelihoods of a height by each place's correlation there, in which they are linear.

use crate::elementary::whole_part;
use crate::simd::{CodePath, simd_kernel};

/// In place of the log-likelihood of a place that neither view shows.
pub const NOT_SEEN: i8 = i8::MIN;

/// The log-likelihood of each place of a row as a line over its correlation.
#[derive(Debug, Clone, Copy)]
pub struct LikelihoodLines<'a> {
    /// At a correlation of 0.
    pub offset: &'a [f32],
    /// What it grows by up to a correlation of 1.
    pub slope: &'a [f32],
}

/// The log-likelihood of each place of a row into `out`, to whole units, at most 127 either way: of correlations that lie `share` of
/// the way from `below` to `above`, those under 0 counting as 0. Where both are 0 it is [`NOT_SEEN`].
pub fn log_likelihoods(
    [below, above]: [&[f32]; 2],
    share: f32,
    LikelihoodLines { offset, slope }: LikelihoodLines<'_>,
    out: &mut [i8],
) {
    likelihood_row(CodePath::fastest(), below, above, share, offset, slope, out);
}

simd_kernel! {
    pub(super) fn likelihood_row(
        below: &[f32], above: &[f32], share: f32, offset: &[f32], slope: &[f32], out: &mut [i8],
    ) {
        // 128 for numbers below zero, and half of one to round to the nearest.
        let zero = 128.5;
        for ((((below, above), offset), slope), out) in
            below.iter().zip(above).zip(offset).zip(slope).zip(out)
        {
            let between = below + share * (above - below);
            let r = if between > 0.0 { between } else { 0.0 };
            let log_likelihood = (offset + slope * r).clamp(-127.0, 127.0);
            let is_seen = (*below != 0.0) | (*above != 0.0);
            let value = whole_part(log_likelihood + zero) as u8 ^ 0x80;
            *out = if is_seen { value as i8 } else { NOT_SEEN };
        }
    }
}

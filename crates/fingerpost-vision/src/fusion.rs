//! Fusion: the probability that follows from two independent ones.
//!
//! Bayes' rule for a yes-or-no question with even odds beforehand: the odds multiply. With p from a picture and q known
//! before, that is p q / (p q + (1 - p) (1 - q)). No single picture is believed without limit: p is kept away from 0 and 1.

use crate::elementary::whole_part;
use crate::error::PictureError;
use crate::simd::{CodePath, simd_kernel};

/// Probability 1 of an 8-bit prior: 128 is an even one, exactly.
const PRIOR_ONE: f32 = 256.0;
/// Probability 1 in an 8-bit probability plane.
const ONE: f32 = 255.0;

/// Bits behind the point of the share that is kept when log-odds fade.
const KEPT_BITS: u32 = 15;
const KEPT_ONE: i32 = 1 << KEPT_BITS;

/// Fills `fused` with the fusion of each pixel's probability (255 is 1), kept at least `doubt` away from 0 and 255, and its
/// prior (256 would be 1; a prior of 0 counts as 1/256).
///
/// ```
/// let mut fused = [0; 4];
/// fingerpost_vision::fusion::fuse(&[255, 255, 128, 26], &[128, 230, 230, 230], 26, &mut fused)?;
/// // 0.9 alone; 0.9 and 0.9: odds of 9 to 1 twice; 0.5 and 0.9; 0.1 and 0.9.
/// assert_eq!(fused, [229, 252, 229, 128]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
///
/// # Errors
/// [`PictureError::BufferLength`] when the three differ in length.
pub fn fuse(probability: &[u8], prior: &[u8], doubt: u8, fused: &mut [u8]) -> Result<(), PictureError> {
    for found in [probability.len(), prior.len()] {
        if found != fused.len() {
            return Err(PictureError::BufferLength {
                width: fused.len(),
                height: 1,
                expected: fused.len(),
                found,
            });
        }
    }
    let doubt = doubt.min(u8::MAX / 2);
    fuse_all(CodePath::fastest(), probability, prior, doubt, fused);
    Ok(())
}

simd_kernel! {
    fn fuse_all(probability: &[u8], prior: &[u8], doubt: u8, fused: &mut [u8]) {
        for ((fused, &p), &q) in fused.iter_mut().zip(probability).zip(prior) {
            *fused = fuse_one(p, q, doubt);
        }
    }
}

/// Multiplies log-odds by `kept`, 0 to 1 in steps of 2^-15, cut to whole numbers downwards: evidence that grows old.
///
/// ```
/// let mut log_odds = [1000, -7, 3];
/// fingerpost_vision::fusion::fade(&mut log_odds, 0.5);
/// assert_eq!(log_odds, [500, -4, 1]);
/// ```
pub fn fade(log_odds: &mut [i16], kept: f64) {
    let factor = (kept.clamp(0.0, 1.0) * f64::from(KEPT_ONE)) as i32;
    if factor < KEPT_ONE {
        fade_all(CodePath::fastest(), log_odds, factor);
    }
}

simd_kernel! {
    fn fade_all(log_odds: &mut [i16], factor: i32) {
        for value in log_odds {
            *value = ((i32::from(*value) * factor) >> KEPT_BITS) as i16;
        }
    }
}

#[inline(always)]
fn fuse_one(p: u8, q: u8, doubt: u8) -> u8 {
    let (p, q) = (f32::from(p.clamp(doubt, u8::MAX - doubt)), f32::from(q.max(1)));
    let (yes, no) = (p * q, (ONE - p) * (PRIOR_ONE - q));
    // `yes` and `no` are not both 0: p is 0 or 255 only without doubt, and q is neither 0 nor 256. The sum is at most 255.5,
    // so that its whole part fits 8 bits.
    whole_part(ONE * yes / (yes + no) + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_fuses_every_pair_as_the_formula_does() {
        for doubt in [0, 13, 127] {
            for q in 0..=255_u8 {
                let probability: Vec<u8> = (0..=255).collect();
                let prior = [q; 256];
                let expected = |p: u8| {
                    let p = f64::from(p.clamp(doubt, 255 - doubt)) / 255.0;
                    let q = f64::from(q.max(1)) / 256.0;
                    255.0 * p * q / (p * q + (1.0 - p) * (1.0 - q))
                };
                for path in CodePath::available() {
                    let mut fused = [0; 256];
                    fuse_all(path, &probability, &prior, doubt, &mut fused);
                    for (p, &found) in probability.iter().zip(&fused) {
                        let off = (f64::from(found) - expected(*p)).abs();
                        assert!(off <= 0.501, "{path:?}: {p}, {q}, {doubt}: {found}");
                        assert_eq!(found, fuse_one(*p, q, doubt), "{path:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_path_fades_alike_and_all_of_it_is_everything() {
        let all: Vec<i16> = (i16::MIN..=i16::MAX).step_by(37).collect();
        for factor in [0, 1, 9_999, KEPT_ONE - 1] {
            let expected: Vec<i16> =
                all.iter().map(|&value| (i32::from(value) * factor).div_euclid(KEPT_ONE) as i16).collect();
            for path in CodePath::available() {
                let mut faded = all.clone();
                fade_all(path, &mut faded, factor);
                assert_eq!(faded, expected, "{path:?}");
            }
        }
        let mut faded = all.clone();
        [1.0, 2.0].into_iter().for_each(|kept| fade(&mut faded, kept));
        assert_eq!(faded, all);
        [f64::NAN, 0.5].into_iter().for_each(|kept| fade(&mut faded, kept));
        assert!(faded.iter().all(|&value| value == 0), "what is not a number keeps nothing");
    }

    #[test]
    fn an_even_prior_changes_nothing_and_lengths_must_agree() {
        let all: Vec<u8> = (0..=255).collect();
        let mut fused = [0; 256];
        fuse(&all, &[128; 256], 0, &mut fused).unwrap();
        assert_eq!(fused[..], all);
        assert!(fuse(&all, &[128; 255], 0, &mut fused).is_err());
        assert!(fuse(&all[1..], &[128; 256], 0, &mut fused).is_err());
        fuse(&[], &[], 0, &mut []).unwrap();
    }
}

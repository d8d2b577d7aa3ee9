//! The sums of a Gauss-Newton step in registers: AVX-512.

use std::arch::x86_64::*;

use super::{LANES, Lanes, PRODUCTS, StepPoints, StepSums, UNKNOWNS};
use crate::avx512::{load, store};

/// [`super::accumulate`]: a group's lanes are a register. The compiler keeps the 36 sums in memory, which is four times as
/// slow on Zen 4; here the points are gone through three times, for as many rows of the Hessian as leave all their sums in
/// registers.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
pub(super) fn accumulate(points: &StepPoints<'_>) -> StepSums {
    let mut sums = StepSums {
        products: [[0.0; LANES]; PRODUCTS],
        gradient: [[0.0; LANES]; UNKNOWNS],
        unweighted: [0.0; LANES],
    };
    let rest = rows::<0, 2>(points, &mut sums.products, &mut sums.gradient);
    let rest = rows::<2, 4>(points, rest, &mut sums.gradient);
    rows::<4, UNKNOWNS>(points, rest, &mut sums.gradient);
    store(&mut sums.unweighted, 0, unweighted(points));
    sums
}

/// Sums the rows from `FIRST` to before `END`, from the diagonal on, into the beginning of `products`; the others are
/// returned.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
fn rows<'a, const FIRST: usize, const END: usize>(
    points: &StepPoints<'_>,
    products: &'a mut [Lanes],
    gradient: &mut [Lanes; UNKNOWNS],
) -> &'a mut [Lanes] {
    let mut of_products = [[_mm512_setzero_ps(); UNKNOWNS]; UNKNOWNS];
    let mut of_gradient = [_mm512_setzero_ps(); UNKNOWNS];
    let groups = points.residuals.len();
    let descent = points.descent.map(|lanes| &lanes[..groups]);
    let pairs = points.residuals.iter().zip(&points.weights[..groups]);
    for (group, (residuals, weights)) in pairs.enumerate() {
        let (residuals, weights) = (lanes(residuals), lanes(weights));
        for row in FIRST..END {
            let weighted = _mm512_mul_ps(weights, lanes(&descent[row][group]));
            of_gradient[row] = _mm512_add_ps(of_gradient[row], _mm512_mul_ps(weighted, residuals));
            for column in row..UNKNOWNS {
                let product = _mm512_mul_ps(weighted, lanes(&descent[column][group]));
                of_products[row][column] = _mm512_add_ps(of_products[row][column], product);
            }
        }
    }
    let mut rest = products.iter_mut();
    for row in FIRST..END {
        store(&mut gradient[row], 0, _mm512_castps_si512(of_gradient[row]));
        for (column, out) in (row..UNKNOWNS).zip(&mut rest) {
            store(out, 0, _mm512_castps_si512(of_products[row][column]));
        }
    }
    rest.into_slice()
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx2")]
fn unweighted(points: &StepPoints<'_>) -> __m512i {
    let mut sum = _mm512_setzero_ps();
    for ((slopes, weights), trust) in points.descent[0].iter().zip(points.weights).zip(points.trust) {
        let is_seen = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(lanes(weights), _mm512_setzero_ps());
        let slopes = lanes(slopes);
        let trusted = _mm512_maskz_mov_ps(is_seen, lanes(trust));
        sum = _mm512_add_ps(sum, _mm512_mul_ps(trusted, _mm512_mul_ps(slopes, slopes)));
    }
    _mm512_castps_si512(sum)
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn lanes(values: &Lanes) -> __m512 {
    _mm512_castsi512_ps(load(values, 0))
}

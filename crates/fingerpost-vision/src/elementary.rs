//! Logarithm, exponential and whole part in plain arithmetic, so that they become vectors and give the same bytes on every
//! path.

/// Bits of the square root of one half: mantissas are taken from there to its double.
const SQRT_HALF_BITS: i32 = 0x3f35_04f3;
const MANTISSA_BITS: i32 = 23;
const EXPONENT_BIAS: i32 = 127;
/// 1.5 times 2 to the 23rd: added to a small number, it leaves the nearest whole one in the lowest bits.
const ROUNDER: f32 = 12_582_912.0;
/// Exponents beyond this are cut: the result is then below 2e-35.
const MOST_EXPONENT: f32 = 80.0;

/// 2 to the 23rd: the 32-bit numbers from there to its double are whole, so that adding it rounds a smaller number to the
/// nearest whole one, which is then in the lowest bits.
const TO_WHOLE: f32 = 8_388_608.0;
const MANTISSA: u32 = 0x7f_ffff;

/// The whole part of `x`, from 0 to below 2 to the 23rd. A cast has to treat what does not fit, which no vector instruction
/// does: compilers then take the numbers one by one.
#[inline(always)]
pub(crate) fn whole_part(x: f32) -> u32 {
    let rounded = x + TO_WHOLE;
    let is_above = rounded - TO_WHOLE > x;
    (rounded.to_bits() & MANTISSA) - u32::from(is_above)
}

/// The natural logarithm of a positive, normal number; absolute error below 1e-6 for numbers up to 1e4.
#[inline(always)]
pub(crate) fn ln(x: f32) -> f32 {
    let bits = x.to_bits() as i32;
    let exponent = (bits - SQRT_HALF_BITS) >> MANTISSA_BITS;
    let mantissa = f32::from_bits((bits - (exponent << MANTISSA_BITS)) as u32);
    // ln m = 2 artanh t with t = (m - 1) / (m + 1), |t| below 0.172: the next term of the series is below 4e-8.
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let s = t * t;
    let series = 2.0 * t * (1.0 + s * (1.0 / 3.0 + s * (0.2 + s * (1.0 / 7.0))));
    exponent as f32 * std::f32::consts::LN_2 + series
}

/// e to the minus `x`, for `x` from 0 on; relative error below 1e-6 for x up to 10.
#[inline(always)]
pub(crate) fn exp_minus(x: f32) -> f32 {
    let x = if x < MOST_EXPONENT { x } else { MOST_EXPONENT };
    let power = -x * std::f32::consts::LOG2_E;
    let rounded = power + ROUNDER;
    let whole = rounded.to_bits() as i32 - ROUNDER.to_bits() as i32;
    let f = (power - (rounded - ROUNDER)) * std::f32::consts::LN_2;
    // Taylor's series, |f| up to 0.35: the next term is below 2e-7.
    let series =
        1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f / 720.0)))));
    series * f32::from_bits(((whole + EXPONENT_BIAS) << MANTISSA_BITS) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_is_close_to_the_exact_one() {
        for step in 1..20_000 {
            let x = f64::from(step) * 0.051;
            let error = f64::from(ln(x as f32)) - libm::log(f64::from(x as f32));
            assert!(error.abs() < 1e-6, "ln {x} is off by {error}");
        }
    }

    #[test]
    fn whole_parts_are_those_of_a_cast() {
        for step in 0..40_000_u32 {
            let x = step as f32 * 0.037;
            for x in [x, x.next_up(), x.round(), x.round().next_down().max(0.0), x * 5000.0] {
                assert_eq!(whole_part(x), x as u32, "{x}");
            }
        }
    }

    #[test]
    fn exponential_is_close_to_the_exact_one() {
        for step in 0..2_000 {
            let x = f64::from(step) * 0.005;
            let relative = f64::from(exp_minus(x as f32)) / libm::exp(-f64::from(x as f32)) - 1.0;
            assert!(relative.abs() < 1e-6, "exp -{x} is off by {relative}");
        }
        assert!(exp_minus(1e9) < 2e-35);
    }
}

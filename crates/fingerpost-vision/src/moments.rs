//! Mean and covariance of vectors that are given component by component.

use crate::simd::{CodePath, simd_kernel};

/// Partial sums, on every path: a register of the widest.
const LANES: usize = 8;

/// Mean and covariance of some vectors, the latter over their number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments<const N: usize> {
    /// Means of the components.
    pub mean: [f64; N],
    /// Covariance, row by row.
    pub covariance: [[f64; N]; N],
}

impl<const N: usize> Moments<N> {
    /// Of the vectors whose components are at the same place of each of `components`, as many as the shortest has; none
    /// when there are none.
    ///
    /// ```
    /// use fingerpost_vision::moments::Moments;
    /// let moments = Moments::of([&[1.0, 3.0], &[5.0, 1.0]]).unwrap();
    /// assert_eq!(moments.mean, [2.0, 3.0]);
    /// assert_eq!(moments.covariance, [[1.0, -2.0], [-2.0, 4.0]]);
    /// ```
    #[must_use]
    pub fn of(components: [&[f32]; N]) -> Option<Self> {
        Self::of_on(CodePath::fastest(), components)
    }

    fn of_on(path: CodePath, components: [&[f32]; N]) -> Option<Self> {
        let count = components.iter().map(|values| values.len()).min().filter(|&count| count > 0)?;
        let components = components.map(|values| &values[..count]);
        let scale = 1.0 / count as f64;
        let mean = components.map(|values| scale * sum(path, values));
        let mut covariance = [[0.0; N]; N];
        for row in 0..N {
            for column in row..N {
                let means = [mean[row], mean[column]];
                let product = scale * product_sum(path, components[row], components[column], means);
                covariance[row][column] = product;
                covariance[column][row] = product;
            }
        }
        Some(Self { mean, covariance })
    }
}

/// Number and sum of the values up to `limit`, and of those above it.
#[must_use]
pub fn sums_about(values: &[f32], limit: f64) -> [(usize, f64); 2] {
    let (count, low, high) = sums_about_limit(CodePath::fastest(), values, limit);
    [(count, low), (values.len() - count, high)]
}

simd_kernel! {
    fn sum(values: &[f32]) -> f64 {
        let mut sums = [0.0; LANES];
        let (blocks, rest) = values.as_chunks::<LANES>();
        for block in blocks {
            for lane in 0..LANES {
                sums[lane] += f64::from(block[lane]);
            }
        }
        sums.iter_mut().zip(rest).for_each(|(sum, &value)| *sum += f64::from(value));
        sums.iter().sum()
    }
}

simd_kernel! {
    fn product_sum(left: &[f32], right: &[f32], means: [f64; 2]) -> f64 {
        let product = |left: f32, right: f32| (f64::from(left) - means[0]) * (f64::from(right) - means[1]);
        let mut sums = [0.0; LANES];
        let ((left, last_left), (right, last_right)) = (left.as_chunks::<LANES>(), right.as_chunks::<LANES>());
        for (left, right) in left.iter().zip(right) {
            for lane in 0..LANES {
                sums[lane] += product(left[lane], right[lane]);
            }
        }
        for ((sum, &left), &right) in sums.iter_mut().zip(last_left).zip(last_right) {
            *sum += product(left, right);
        }
        sums.iter().sum()
    }
}

simd_kernel! {
    /// How many values are at most `limit`, their sum, and the sum of the others.
    fn sums_about_limit(values: &[f32], limit: f64) -> (usize, f64, f64) {
        let (mut counts, mut lows, mut highs) = ([0_u64; LANES], [0.0; LANES], [0.0; LANES]);
        let mut add = |lane: usize, value: f32| {
            let value = f64::from(value);
            let is_low = value <= limit;
            counts[lane] += u64::from(is_low);
            lows[lane] += if is_low { value } else { 0.0 };
            highs[lane] += if is_low { 0.0 } else { value };
        };
        let (blocks, rest) = values.as_chunks::<LANES>();
        for block in blocks {
            block.iter().enumerate().for_each(|(lane, &value)| add(lane, value));
        }
        rest.iter().enumerate().for_each(|(lane, &value)| add(lane, value));
        (counts.iter().sum::<u64>() as usize, lows.iter().sum(), highs.iter().sum())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::config;

    proptest! {
        #![proptest_config(config(80))]

        #[test]
        fn moments_are_those_of_the_definition_on_every_path(
            vectors in prop::collection::vec(prop::array::uniform3(-9.0..90.0_f32), 1..70),
        ) {
            let components: [Vec<f32>; 3] = [0, 1, 2].map(|i| vectors.iter().map(|v| v[i]).collect());
            let count = vectors.len() as f64;
            let mean = [0, 1, 2].map(|i: usize| vectors.iter().map(|v| f64::from(v[i])).sum::<f64>() / count);
            let first = Moments::of(components.each_ref().map(Vec::as_slice)).unwrap();
            for row in 0..3 {
                prop_assert!((first.mean[row] - mean[row]).abs() < 1e-9);
                for column in 0..3 {
                    let off = |v: &[f32; 3], i: usize| f64::from(v[i]) - mean[i];
                    let expected = vectors.iter().map(|v| off(v, row) * off(v, column)).sum::<f64>() / count;
                    prop_assert!((first.covariance[row][column] - expected).abs() < 1e-8);
                }
            }
            for path in CodePath::available() {
                let found = Moments::of_on(path, components.each_ref().map(Vec::as_slice));
                prop_assert_eq!(found, Some(first));
            }
        }

        #[test]
        fn values_are_parted_at_the_limit_on_every_path(
            values in prop::collection::vec(0..9_i32, 0..70), limit in -1..9_i32,
        ) {
            let (low, high): (Vec<i32>, Vec<i32>) = values.iter().partition(|&&value| value <= limit);
            let values: Vec<f32> = values.iter().map(|&value| value as f32).collect();
            let sum = |values: &[i32]| f64::from(values.iter().sum::<i32>());
            for path in CodePath::available() {
                let expected = (low.len(), sum(&low), sum(&high));
                prop_assert_eq!(sums_about_limit(path, &values, f64::from(limit)), expected);
            }
            let expected = [(low.len(), sum(&low)), (high.len(), sum(&high))];
            prop_assert_eq!(sums_about(&values, f64::from(limit)), expected);
        }
    }

    #[test]
    fn no_vectors_have_no_moments_and_the_shortest_component_says_how_many_there_are() {
        assert_eq!(Moments::of([&[], &[1.0]]), None);
        assert_eq!(Moments::of([&[1.0, 2.0], &[1.0]]), Moments::of([&[1.0], &[1.0]]));
    }
}

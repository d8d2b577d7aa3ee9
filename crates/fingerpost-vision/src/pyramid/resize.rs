//! Bilinear resampling of `f32` pictures to another size.

use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Resamples a picture bilinearly to another size, reusing its tables.
///
/// Pixel areas correspond: the picture's outer edges, not its outer pixel centres, stay where they are. Half and double
/// sizes take shorter ways than others.
#[derive(Debug, Clone, Default)]
pub struct Resizer {
    columns: Vec<Neighbours>,
    /// A row between two of the source's, with its outermost pixels once more beyond both ends.
    row: Vec<f32>,
}

/// The two pixels of a row or column between which a resampled one lies.
#[derive(Debug, Clone, Copy)]
struct Neighbours {
    /// Index of the first; the second follows it, or is the first itself at the end.
    lower: usize,
    /// Weight of the second, 0 to 1.
    weight: f32,
}

/// How columns of the target lie to those of the source.
#[derive(Debug, Clone, Copy)]
enum Columns {
    Same,
    Half,
    Double,
    Other,
}

impl Resizer {
    /// Fills `target` with `source` resampled to the target's size and multiplied by `gain`; a source without pixels
    /// gives zeros.
    pub fn resize(&mut self, source: &Plane<f32>, target: &mut Plane<f32>, gain: f32) {
        self.resize_with(CodePath::fastest(), source, target, gain);
    }

    fn resize_with(&mut self, path: CodePath, source: &Plane<f32>, target: &mut Plane<f32>, gain: f32) {
        let (width, height) = target.size();
        if source.width() == 0 || source.height() == 0 {
            target.as_mut_slice().fill(0.0);
            return;
        }
        let columns = match source.width() {
            full if full == width => Columns::Same,
            full if full == 2 * width => Columns::Half,
            full if 2 * full == width => Columns::Double,
            _ => Columns::Other,
        };
        self.columns.clear();
        if matches!(columns, Columns::Other) {
            self.columns.extend((0..width).map(|x| neighbours(x, width, source.width())));
        }
        self.row.resize(source.width() + 2, 0.0);
        for y in 0..height {
            let Neighbours { lower, weight } = neighbours(y, height, source.height());
            let below = source.row((lower + 1).min(source.height() - 1));
            mix_rows(path, source.row(lower), below, weight, gain, &mut self.row);
            let out = target.row_mut(y);
            match columns {
                Columns::Same => out.copy_from_slice(&self.row[1..=width]),
                Columns::Half => halve_columns(path, &self.row, out),
                Columns::Double => double_columns(path, &self.row, out),
                Columns::Other => pick_columns(path, &self.row, &self.columns, out),
            }
        }
    }
}

simd_kernel! {
    fn mix_rows(upper: &[f32], lower: &[f32], weight: f32, gain: f32, row: &mut [f32]) {
        let width = upper.len();
        for ((out, &upper), &lower) in row[1..=width].iter_mut().zip(upper).zip(lower) {
            *out = gain * lerp(upper, lower, weight);
        }
        row[0] = row[1];
        row[width + 1] = row[width];
    }
}

simd_kernel! {
    fn halve_columns(row: &[f32], out: &mut [f32]) {
        for (out, &[left, right]) in out.iter_mut().zip(row[1..].as_chunks::<2>().0) {
            *out = lerp(left, right, 0.5);
        }
    }
}

simd_kernel! {
    fn double_columns(row: &[f32], out: &mut [f32]) {
        let (pairs, _) = out.as_chunks_mut::<2>();
        let count = pairs.len();
        let (left, middle, right) = (&row[..count], &row[1..][..count], &row[2..][..count]);
        for i in 0..count {
            pairs[i] = [lerp(left[i], middle[i], 0.75), lerp(middle[i], right[i], 0.25)];
        }
    }
}

simd_kernel! {
    fn pick_columns(row: &[f32], columns: &[Neighbours], out: &mut [f32]) {
        let (pixels, beside) = (&row[1..], &row[2..]);
        for (out, column) in out.iter_mut().zip(columns) {
            *out = lerp(pixels[column.lower], beside[column.lower], column.weight);
        }
    }
}

#[inline(always)]
fn lerp(from: f32, to: f32, weight: f32) -> f32 {
    from * (1.0 - weight) + to * weight
}

fn neighbours(index: usize, target_length: usize, source_length: usize) -> Neighbours {
    let place = (index as f64 + 0.5) * (source_length as f64 / target_length as f64) - 0.5;
    let place = place.clamp(0.0, (source_length - 1) as f64);
    let lower = place as usize;
    Neighbours { lower, weight: (place - lower as f64) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    /// The pixel that bilinear interpolation gives, in `f64`.
    fn resize_plainly(source: &Plane<f32>, x: usize, y: usize, (width, height): (usize, usize)) -> f64 {
        let place = |index: usize, to: usize, from: usize| {
            ((index as f64 + 0.5) * from as f64 / to as f64 - 0.5).clamp(0.0, (from - 1) as f64)
        };
        let (u, v) = (place(x, width, source.width()), place(y, height, source.height()));
        let at = |x: f64, y: f64| {
            let (x, y) = ((x as usize).min(source.width() - 1), (y as usize).min(source.height() - 1));
            f64::from(source.row(y)[x])
        };
        let (left, top) = (u.floor(), v.floor());
        let along = |y: f64| at(left, y) * (1.0 - (u - left)) + at(left + 1.0, y) * (u - left);
        along(top) * (1.0 - (v - top)) + along(top + 1.0) * (v - top)
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            rng_seed: RngSeed::Fixed(5), ..ProptestConfig::default()
        })]

        #[test]
        fn every_path_interpolates(
            (width, height) in (1..70_usize, 1..20_usize),
            (other_width, other_height) in (1..70_usize, 1..20_usize),
            kind in 0..4_usize,
            seed in 0..1000_usize,
        ) {
            let size = match kind {
                0 => (width, height),
                1 => (2 * width, 2 * height),
                2 => (width.div_ceil(2), height.div_ceil(2)),
                _ => (other_width, other_height),
            };
            let values = (0..width * height).map(|index| ((index + seed) * 7919 % 251) as f32).collect();
            let source = Plane::from_vec(width, height, values).unwrap();
            let mut expected = Plane::new(size.0, size.1, 0.0);
            let mut resizer = Resizer::default();
            resizer.resize_with(CodePath::PORTABLE, &source, &mut expected, 3.0);
            for (index, &found) in expected.as_slice().iter().enumerate() {
                let plain = 3.0 * resize_plainly(&source, index % size.0, index / size.0, size);
                prop_assert!((f64::from(found) - plain).abs() < 1e-3, "{} at {}", found, index);
            }
            for path in CodePath::available() {
                let mut target = Plane::new(size.0, size.1, 0.0);
                resizer.resize_with(path, &source, &mut target, 3.0);
                prop_assert_eq!(&target, &expected);
            }
        }
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

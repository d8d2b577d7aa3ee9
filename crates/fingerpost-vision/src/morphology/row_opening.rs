//! Opening along rows: what is brighter than its surroundings and narrower than a width is taken away.

use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Opens a picture's rows, each with a width of its own.
#[derive(Debug, Clone, Default)]
pub struct RowOpening {
    /// A row with half a window beyond either end.
    padded: Vec<f32>,
}

impl RowOpening {
    /// Opens row `y` of `plane` with a window of `width(y)` pixels about each pixel, an odd number; even ones are taken
    /// one larger, and 0 and 1 leave the row as it is. Pixels beyond the picture do not count.
    pub fn open(&mut self, plane: &mut Plane<f32>, width: impl Fn(usize) -> usize) {
        self.open_on(CodePath::fastest(), plane, width);
    }

    fn open_on(&mut self, path: CodePath, plane: &mut Plane<f32>, width: impl Fn(usize) -> usize) {
        for y in 0..plane.height() {
            let half = width(y) / 2;
            if half == 0 {
                continue;
            }
            let row = plane.row_mut(y);
            self.pad(row, half, f32::INFINITY);
            slide::<true>(path, &self.padded, 2 * half + 1, row);
            self.pad(row, half, f32::NEG_INFINITY);
            slide::<false>(path, &self.padded, 2 * half + 1, row);
        }
    }

    fn pad(&mut self, row: &[f32], half: usize, beyond: f32) {
        self.padded.clear();
        self.padded.resize(half, beyond);
        self.padded.extend_from_slice(row);
        self.padded.resize(row.len() + 2 * half, beyond);
    }
}

simd_kernel! {
    /// The least, or else the greatest, of `width` values from each place on.
    fn slide<const LEAST: bool>(padded: &[f32], width: usize, out: &mut [f32]) {
        let length = out.len();
        out.copy_from_slice(&padded[..length]);
        for shift in 1..width {
            for (out, &value) in out.iter_mut().zip(&padded[shift..][..length]) {
                let is_better = if LEAST { value < *out } else { value > *out };
                *out = if is_better { value } else { *out };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::config;

    fn plain(row: &[f32], half: usize) -> Vec<f32> {
        let window = |row: &[f32], x: usize| -> Vec<f32> {
            row[x.saturating_sub(half)..(x + half + 1).min(row.len())].to_vec()
        };
        let least: Vec<f32> =
            (0..row.len()).map(|x| window(row, x).into_iter().fold(f32::INFINITY, f32::min)).collect();
        (0..row.len()).map(|x| window(&least, x).into_iter().fold(f32::NEG_INFINITY, f32::max)).collect()
    }

    proptest! {
        #![proptest_config(config(80))]

        #[test]
        fn rows_are_opened_as_the_definition_says(
            values in prop::collection::vec(-9.0..9.0_f32, 0..70), width in 0..15_usize,
        ) {
            for path in CodePath::available() {
                let mut plane = Plane::from_vec(values.len(), 1, values.clone()).unwrap();
                RowOpening::default().open_on(path, &mut plane, |_| width);
                prop_assert_eq!(plane.as_slice(), plain(&values, width / 2));
            }
        }
    }

    #[test]
    fn a_narrow_stripe_goes_and_a_wide_one_stays() {
        let mut row = vec![1.0; 20];
        row[3..5].fill(2.0);
        row[10..16].fill(2.0);
        let mut plane = Plane::from_vec(20, 1, row).unwrap();
        RowOpening::default().open(&mut plane, |_| 3);
        let bright: Vec<usize> = (0..20).filter(|&x| plane.row(0)[x] > 1.5).collect();
        assert_eq!(bright, (10..16).collect::<Vec<_>>());
    }
}

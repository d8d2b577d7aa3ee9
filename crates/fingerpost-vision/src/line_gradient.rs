//! The gradient, as it bears on lines towards a vanishing point, and the texture made of it.
//!
//! Kerbs, verges and walls beside a road run towards the vanishing point; shadows and cracks mostly run across. So the
//! slope across such lines counts in full and the slope along them by a share.

use crate::elementary::ln;
use crate::error::{PictureError, check_size};
use crate::filter::BoxMean;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Half the side of the window of the texture, pixels.
const TEXTURE_RADIUS_PX: usize = 2;
/// Added to a mean slope before its logarithm: a slope too small to be seen in 8 bits.
const TEXTURE_FLOOR: f32 = 0.01;
/// The Sobel weights' sum: divided by it, slopes are a pixel's.
const SOBEL_SUM: f32 = 8.0;

/// Towards which point of a picture lines run, and what the slope along them counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineDirection {
    /// Column of the vanishing point, pixels.
    pub column: f32,
    /// Row of the vanishing point, pixels.
    pub row: f32,
    /// What the slope along the lines counts, 0 to 1; 1 gives the plain gradient.
    pub along: f32,
}

/// Measures slopes and texture, with the buffers that it needs.
#[derive(Debug, Clone)]
pub struct LineGradient {
    smooth: Vec<f32>,
    difference: Vec<f32>,
    mean: BoxMean,
}

impl Default for LineGradient {
    fn default() -> Self {
        Self { smooth: Vec::new(), difference: Vec::new(), mean: BoxMean::new(TEXTURE_RADIUS_PX) }
    }
}

impl LineGradient {
    /// Fills `target` with the slope of `source` a pixel (Sobel). Beyond its edges the picture is continued by its edge
    /// pixels.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn slopes(
        &mut self,
        source: &Plane<f32>,
        lines: LineDirection,
        target: &mut Plane<f32>,
    ) -> Result<(), PictureError> {
        self.slopes_on(CodePath::fastest(), source, lines, target)
    }

    fn slopes_on(
        &mut self,
        path: CodePath,
        source: &Plane<f32>,
        lines: LineDirection,
        target: &mut Plane<f32>,
    ) -> Result<(), PictureError> {
        check_size("gradient target", source.size(), target.size())?;
        let (width, height) = source.size();
        if width == 0 {
            return Ok(());
        }
        self.smooth.resize(width + 2, 0.0);
        self.difference.resize(width + 2, 0.0);
        for y in 0..height {
            let (above, below) = (source.row(y.saturating_sub(1)), source.row((y + 1).min(height - 1)));
            columns(
                path,
                above,
                source.row(y),
                below,
                &mut self.smooth[1..=width],
                &mut self.difference[1..=width],
            );
            for sums in [&mut self.smooth, &mut self.difference] {
                (sums[0], sums[width + 1]) = (sums[1], sums[width]);
            }
            let down = y as f32 - lines.row;
            slopes_of_row(path, &self.smooth, &self.difference, lines, down, target.row_mut(y));
        }
        Ok(())
    }

    /// Fills `target` with the logarithm of the mean slope about each pixel, 5 x 5 pixels.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn texture(&mut self, slopes: &Plane<f32>, target: &mut Plane<f32>) -> Result<(), PictureError> {
        self.mean.apply(slopes, target)?;
        logarithms(CodePath::fastest(), target.as_mut_slice());
        Ok(())
    }
}

simd_kernel! {
    fn columns(above: &[f32], here: &[f32], below: &[f32], smooth: &mut [f32], difference: &mut [f32]) {
        let width = here.len();
        let (above, below) = (&above[..width], &below[..width]);
        let (smooth, difference) = (&mut smooth[..width], &mut difference[..width]);
        for x in 0..width {
            smooth[x] = above[x] + 2.0 * here[x] + below[x];
            difference[x] = below[x] - above[x];
        }
    }
}

simd_kernel! {
    fn slopes_of_row(
        smooth: &[f32], difference: &[f32], lines: LineDirection, down: f32, out: &mut [f32],
    ) {
        let width = out.len();
        let (left, right) = (&smooth[..width], &smooth[2..][..width]);
        let (before, here, after) = (&difference[..width], &difference[1..][..width], &difference[2..][..width]);
        for x in 0..width {
            let dx = (right[x] - left[x]) * (1.0 / SOBEL_SUM);
            let dy = (before[x] + 2.0 * here[x] + after[x]) * (1.0 / SOBEL_SUM);
            let aside = x as i32 as f32 - lines.column;
            let across = aside * dy - down * dx;
            let along = lines.along * (aside * dx + down * dy);
            // One pixel beside the vanishing point direction means nothing; the 1 keeps the quotient finite there.
            let length = aside * aside + down * down + 1.0;
            out[x] = ((across * across + along * along) / length).sqrt();
        }
    }
}

simd_kernel! {
    fn logarithms(values: &mut [f32]) {
        for value in values {
            *value = ln(*value + TEXTURE_FLOOR);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::{config, grey_pictures};

    fn plain(source: &Plane<f32>, lines: LineDirection, x: usize, y: usize) -> f64 {
        let at = |dx: isize, dy: isize| {
            let x = (x as isize + dx).clamp(0, source.width() as isize - 1) as usize;
            let y = (y as isize + dy).clamp(0, source.height() as isize - 1) as usize;
            f64::from(source.row(y)[x])
        };
        let dx = (at(1, -1) + 2.0 * at(1, 0) + at(1, 1) - at(-1, -1) - 2.0 * at(-1, 0) - at(-1, 1)) / 8.0;
        let dy = (at(-1, 1) + 2.0 * at(0, 1) + at(1, 1) - at(-1, -1) - 2.0 * at(0, -1) - at(1, -1)) / 8.0;
        let (u, v) = (x as f64 - f64::from(lines.column), y as f64 - f64::from(lines.row));
        let (across, along) = (u * dy - v * dx, f64::from(lines.along) * (u * dx + v * dy));
        ((across * across + along * along) / (u * u + v * v + 1.0)).sqrt()
    }

    proptest! {
        #![proptest_config(config(60))]

        #[test]
        fn slopes_are_as_the_formula_says_on_every_path(
            picture in grey_pictures(), column in -3.0..90.0_f32, row in -9.0..20.0_f32, along in 0.0..1.0_f32,
        ) {
            let view = picture.view();
            let values: Vec<f32> =
                (0..view.height()).flat_map(|y| view.row(y).iter().map(|&v| f32::from(v) / 40.0)).collect();
            let source = Plane::from_vec(view.width(), view.height(), values).unwrap();
            let lines = LineDirection { column, row, along };
            let mut first: Option<Plane<f32>> = None;
            for path in CodePath::available() {
                let mut target = Plane::new(source.width(), source.height(), -1.0);
                LineGradient::default().slopes_on(path, &source, lines, &mut target).unwrap();
                for y in 0..source.height() {
                    for x in 0..source.width() {
                        let (found, expected) = (f64::from(target.row(y)[x]), plain(&source, lines, x, y));
                        prop_assert!((found - expected).abs() < 1e-3, "({x}, {y}): {found}, not {expected}");
                    }
                }
                prop_assert!(first.as_ref().is_none_or(|first| first.as_slice() == target.as_slice()));
                first = Some(target);
            }
        }
    }

    #[test]
    fn a_line_to_the_vanishing_point_counts_in_full_and_one_across_by_its_share() {
        let lines = LineDirection { column: 10.0, row: -200.0, along: 0.25 };
        let step =
            |is_bright: fn(usize) -> bool| (0..441).map(|i| f32::from(u8::from(is_bright(i)))).collect();
        let slope_of = |values| {
            let source = Plane::from_vec(21, 21, values).unwrap();
            let mut target = Plane::new(21, 21, 0.0);
            LineGradient::default().slopes(&source, lines, &mut target).unwrap();
            target.row(10)[10]
        };
        let (kerb, shadow) = (slope_of(step(|i| i % 21 >= 10)), slope_of(step(|i| i / 21 >= 10)));
        assert!((kerb - 0.5).abs() < 0.01 && (shadow - 0.125).abs() < 0.01, "{kerb} and {shadow}");
    }
}

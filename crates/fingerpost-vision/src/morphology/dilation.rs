//! Dilation by a union of rectangles: for each, maxima of columns and then of rows. A lower rectangle's columns are part of
//! the next one's, so every row of the element is read once. With AVX-512 there is a twin by hand, whose intermediate values
//! stay in registers.

#[cfg(target_arch = "x86_64")]
mod avx512;

use super::element::{MAX_SIZE_PX, Rectangle, StructuringElement};
use crate::blocks::{BAND_ROWS, BLOCK, PaddedRows, block_starts, double_block_starts, single_pixels};
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;
use crate::simd::{CodePath, simd_kernel};

/// A dilation of 8-bit pictures, with the buffer that it needs.
///
/// ```
/// use fingerpost_vision::morphology::{Dilation, StructuringElement};
/// use fingerpost_vision::picture::Plane;
/// let mut dot = Plane::new(5, 3, 0_u8);
/// dot.row_mut(1)[2] = 255;
/// let mut grown = Plane::new(5, 3, 0);
/// Dilation::new(StructuringElement::cross(3, 3)?).apply(dot.view(), &mut grown)?;
/// assert_eq!(grown.row(0), &[0, 0, 255, 0, 0]);
/// assert_eq!(grown.row(1), &[0, 255, 255, 255, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Dilation {
    element: StructuringElement,
    /// Pixels that the element reaches to either side.
    reach_x: usize,
    /// Maxima of the columns in a band of rows, each row with `reach_x` zeros, which never win, beyond either end.
    maxima: PaddedRows<u8>,
}

impl Dilation {
    /// A dilation by `element`.
    #[must_use]
    pub fn new(element: StructuringElement) -> Self {
        let reach_x = element.rectangles.iter().map(|rectangle| rectangle.reach_x).max().unwrap_or(0);
        Self { element, reach_x, maxima: PaddedRows::default() }
    }

    /// Dilates `source` into `target`.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: PlaneView<'_, u8>, target: &mut Plane<u8>) -> Result<(), PictureError> {
        self.apply_on(CodePath::fastest(), source, target)
    }

    fn apply_on(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        target: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        check_size("dilated picture", source.size(), target.size())?;
        #[cfg(target_arch = "x86_64")]
        if path.instruction_set() == InstructionSet::Avx512 {
            // SAFETY: a `CodePath` exists only where the processor has its instruction set. Benefit: see the function.
            #[allow(unsafe_code)]
            unsafe {
                avx512::dilate(&self.element, source, target);
            }
            return Ok(());
        }
        let (width, height) = source.size();
        self.maxima.reset(width, self.reach_x, BAND_ROWS);
        let mut rows = [&[][..]; MAX_SIZE_PX];
        for band_start in (0..height).step_by(BAND_ROWS) {
            let band = band_start..height.min(band_start + BAND_ROWS);
            let mut next = 0;
            for &Rectangle { reach_x, reach_y } in &self.element.rectangles {
                let (find_columns, find_rows): (RaiseColumns, RaiseRows) = if next == 0 {
                    (column_maxima::<FROM_NOTHING>, row_maxima::<FROM_NOTHING>)
                } else {
                    (column_maxima::<FURTHER>, row_maxima::<FURTHER>)
                };
                for (number, y) in band.clone().enumerate() {
                    let mut count = 0;
                    for distance in next..=reach_y {
                        let above = y.checked_sub(distance);
                        let below = Some(y + distance).filter(|&below| below < height && distance > 0);
                        for row in [above, below].into_iter().flatten() {
                            rows[count] = source.row(row);
                            count += 1;
                        }
                    }
                    find_columns(path, &rows[..count], self.maxima.inner_mut(number));
                }
                next = reach_y + 1;
                for (number, y) in band.clone().enumerate() {
                    find_rows(path, self.maxima.row(number, reach_x), target.row_mut(y));
                }
            }
        }
        Ok(())
    }
}

type RaiseColumns = fn(CodePath, &[&[u8]], &mut [u8]);
type RaiseRows = fn(CodePath, &[u8], &mut [u8]);

/// Maxima are found whatever the target held.
const FROM_NOTHING: bool = false;
/// The target's values are raised further.
const FURTHER: bool = true;

/// The larger of `maxima` and the `N` pixels of `row` from `x` on.
#[inline(always)]
fn raise<const N: usize>(mut maxima: [u8; N], row: &[u8], x: usize) -> [u8; N] {
    for (maximum, &pixel) in maxima.iter_mut().zip(&row[x..x + N]) {
        *maximum = (*maximum).max(pixel);
    }
    maxima
}

/// The largest pixel of each of `N` columns of `rows` from `x` on, or of those and `maxima`.
#[inline(always)]
fn raise_columns<const KEEP: bool, const N: usize>(rows: &[&[u8]], maxima: &mut [u8], x: usize) {
    let mut block = [0; N];
    if KEEP {
        block = raise(block, maxima, x);
    }
    for row in rows {
        block = raise(block, row, x);
    }
    maxima[x..x + N].copy_from_slice(&block);
}

simd_kernel! {
    /// Finds the largest pixel of each column of `rows`, or of those and `maxima`.
    fn column_maxima<const KEEP: bool>(rows: &[&[u8]], maxima: &mut [u8]) {
        if maxima.len() >= 2 * BLOCK {
            for x in double_block_starts(maxima.len()) {
                raise_columns::<KEEP, { 2 * BLOCK }>(rows, maxima, x);
            }
            return;
        }
        for x in block_starts(maxima.len()) {
            raise_columns::<KEEP, BLOCK>(rows, maxima, x);
        }
        for x in single_pixels(maxima.len()) {
            raise_columns::<KEEP, 1>(rows, maxima, x);
        }
    }
}

/// The largest pixel of each of `N` windows of `row` from `x` on, or of those and `out`.
#[inline(always)]
fn raise_windows<const KEEP: bool, const N: usize>(row: &[u8], out: &mut [u8], x: usize) {
    let mut block = [0; N];
    if KEEP {
        block = raise(block, out, x);
    }
    for tap in 0..row.len() - out.len() + 1 {
        block = raise(block, row, x + tap);
    }
    out[x..x + N].copy_from_slice(&block);
}

simd_kernel! {
    /// Finds the largest pixel of the windows of `row`, or of those and `out`. `row` is longer than `out` by the window
    /// less one.
    fn row_maxima<const KEEP: bool>(row: &[u8], out: &mut [u8]) {
        if out.len() >= 2 * BLOCK {
            for x in double_block_starts(out.len()) {
                raise_windows::<KEEP, { 2 * BLOCK }>(row, out, x);
            }
            return;
        }
        for x in block_starts(out.len()) {
            raise_windows::<KEEP, BLOCK>(row, out, x);
        }
        for x in single_pixels(out.len()) {
            raise_windows::<KEEP, 1>(row, out, x);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::{Framed, config, grey_pictures};

    fn plain(picture: &Framed, element: &StructuringElement, reach: isize) -> Plane<u8> {
        let (width, height) = picture.view().size();
        let mut target = Plane::new(width, height, 0);
        for y in 0..height {
            for x in 0..width {
                let window = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
                let covered = window.filter(|&(dx, dy)| element.covers(dx, dy));
                let pixels = covered.map(|(dx, dy)| picture.get(x as isize + dx, y as isize + dy, 0));
                target.row_mut(y)[x] = pixels.max().unwrap();
            }
        }
        target
    }

    /// Those of common elements, and every other that there is.
    fn reaches() -> impl Strategy<Value = usize> {
        prop_oneof![6 => 0..6_usize, 1 => 0..=MAX_SIZE_PX / 2]
    }

    proptest! {
        #![proptest_config(config(80))]

        #[test]
        fn a_pixel_becomes_the_largest_under_the_element_on_every_path(
            picture in grey_pictures(),
            (reach_x, reach_y) in (reaches(), reaches()),
            shape in 0..3_usize,
        ) {
            let make =
                [StructuringElement::rectangle, StructuringElement::cross, StructuringElement::ellipse][shape];
            let element = make(2 * reach_x + 1, 2 * reach_y + 1).unwrap();
            let expected = plain(&picture, &element, reach_x.max(reach_y) as isize);
            let mut dilation = Dilation::new(element);
            for path in CodePath::available() {
                let mut target = Plane::new(expected.width(), expected.height(), 3);
                dilation.apply_on(path, picture.view(), &mut target).unwrap();
                prop_assert_eq!(&target, &expected, "{:?}", path);
            }
        }
    }

    #[test]
    fn a_target_of_another_size_is_an_error() {
        let mut dilation = Dilation::new(StructuringElement::rectangle(3, 3).unwrap());
        assert!(dilation.apply(Plane::new(4, 3, 0).view(), &mut Plane::new(3, 4, 0)).is_err());
    }
}

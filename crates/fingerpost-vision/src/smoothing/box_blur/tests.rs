use proptest::prelude::*;

use super::*;
use crate::smoothing::MAX_SIZE_PX;
use crate::test_pictures::{config, grey_pictures};

fn plain(source: PlaneView<'_, u8>, size_px: usize) -> Plane<u8> {
    let (width, height) = source.size();
    let reach = size_px as isize / 2;
    let mut target = Plane::new(width, height, 0);
    for y in 0..height {
        for x in 0..width {
            let rows = (-reach..=reach).map(|j| source.row(Border::Mirror.inside(y as isize + j, height)));
            let of_row = |row: &[u8]| -> u32 {
                (-reach..=reach).map(|i| u32::from(row[Border::Mirror.inside(x as isize + i, width)])).sum()
            };
            let mean = f64::from(rows.map(of_row).sum::<u32>()) / (size_px * size_px) as f64;
            target.row_mut(y)[x] = mean.round() as u8;
        }
    }
    target
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn a_blur_is_the_rounded_mean_on_every_path(picture in grey_pictures(), reach in 0..=15_usize) {
        let size_px = 2 * reach + 1;
        let expected = plain(picture.view(), size_px);
        let mut blur = BoxBlur::new(size_px).unwrap();
        for path in CodePath::available() {
            let mut target = Plane::new(expected.width(), expected.height(), 1);
            blur.apply_on(path, picture.view(), &mut target).unwrap();
            prop_assert_eq!(&target, &expected, "{:?}", path);
        }
    }
}

#[test]
fn divisions_by_products_are_exact() {
    for size in (3..=WIDEST_16_BIT_PX as u16).step_by(2) {
        let area = size * size;
        let (factor, shift) = division_by(area);
        for dividend in 0..=255 * area + area / 2 {
            let quotient = (u32::from(dividend) * u32::from(factor)) >> (16 + shift);
            assert_eq!(quotient, u32::from(dividend / area), "{dividend} / {area}");
        }
    }
    for size in (WIDEST_16_BIT_PX + 2..=MAX_SIZE_PX).step_by(2) {
        // All columns alike: every mean that there is, with every remainder.
        let sums: Vec<u16> = (0..=255 * size as u16).collect();
        for &sum in &sums {
            let mut out = [0];
            running_means(&vec![sum; size], size, &mut out);
            let area = (size * size) as u32;
            assert_eq!(u32::from(out[0]), (u32::from(sum) * size as u32 + area / 2) / area);
        }
    }
}

#[test]
fn a_flat_picture_stays_as_it_is_and_sizes_that_do_not_fit_are_errors() {
    let picture = Plane::new(100, 40, 255);
    for size_px in (1..=MAX_SIZE_PX).step_by(2) {
        let mut target = Plane::new(100, 40, 0);
        BoxBlur::new(size_px).unwrap().apply(picture.view(), &mut target).unwrap();
        assert_eq!(target, picture, "{size_px}");
    }
    assert_eq!(BoxBlur::new(4).unwrap_err(), SmoothingError::Size { size_px: 4 });
    assert!(BoxBlur::new(3).unwrap().apply(picture.view(), &mut Plane::new(40, 100, 0)).is_err());
}

use proptest::prelude::*;

use super::*;
use crate::test_pictures::{config, grey_pictures};

/// The exact convolution with whole 256ths, rounded half up.
fn plain(source: PlaneView<'_, u8>, weights: &[u16]) -> Plane<u8> {
    let (width, height) = source.size();
    let reach = weights.len() as isize - 1;
    let mut target = Plane::new(width, height, 0);
    for y in 0..height {
        for x in 0..width {
            let mut sum = 0;
            for j in -reach..=reach {
                for i in -reach..=reach {
                    let row = source.row(Border::Mirror.inside(y as isize + j, height));
                    let pixel = row[Border::Mirror.inside(x as isize + i, width)];
                    let weight = u32::from(weights[i.unsigned_abs()]) * u32::from(weights[j.unsigned_abs()]);
                    sum += weight * u32::from(pixel);
                }
            }
            target.row_mut(y)[x] = ((sum + (1 << 15)) >> 16) as u8;
        }
    }
    target
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn a_blur_is_the_exact_convolution_on_every_path(
        picture in grey_pictures(),
        reach in prop_oneof![0..4_usize, 4..=15_usize],
        sigma_px in prop_oneof![Just(0.0), 0.3..6.0_f64],
    ) {
        let size_px = 2 * reach + 1;
        let expected = plain(picture.view(), &fixed_point_weights(size_px, sigma_px));
        let mut blur = GaussianBlur::new(size_px, sigma_px).unwrap();
        for path in CodePath::available() {
            let mut target = Plane::new(expected.width(), expected.height(), 1);
            blur.apply_on(path, picture.view(), &mut target).unwrap();
            prop_assert_eq!(&target, &expected, "{:?}", path);
        }
    }

    #[test]
    fn weights_sum_to_one_and_fall_outwards(reach in 0..=15_usize, sigma_px in 0.0..20.0_f64) {
        let weights = fixed_point_weights(2 * reach + 1, sigma_px);
        prop_assert_eq!(weights[0] + 2 * weights[1..].iter().sum::<u16>(), ONE);
        // Carried errors can lift a weight by one over its inner neighbour.
        prop_assert!(weights.windows(2).all(|pair| pair[0] + 1 >= pair[1]), "{:?}", weights);
    }
}

#[test]
fn weights_are_those_of_opencv() {
    assert_eq!(fixed_point_weights(3, 0.0), [128, 64]);
    assert_eq!(fixed_point_weights(5, 0.0), [96, 64, 16]);
    assert_eq!(fixed_point_weights(5, 1.1), [94, 63, 18]);
    assert_eq!(fixed_point_weights(7, 0.0), [72, 56, 28, 8]);
    assert_eq!(fixed_point_weights(9, 0.0), [60, 51, 30, 13, 4]);
    assert_eq!(fixed_point_weights(15, 2.5), [40, 38, 30, 20, 11, 6, 2, 1]);
    assert_eq!(fixed_point_weights(31, 5.0), [20, 20, 19, 17, 15, 13, 10, 7, 6, 4, 3, 2, 1, 0, 1, 0]);
}

#[test]
fn windows_and_targets_that_do_not_fit_are_errors() {
    for size_px in [0, 2, 33] {
        assert_eq!(GaussianBlur::new(size_px, 1.0).unwrap_err(), SmoothingError::Size { size_px });
    }
    assert!(matches!(GaussianBlur::new(3, f64::NAN), Err(SmoothingError::Sigma { .. })));
    assert!(matches!(GaussianBlur::new(3, -1.0), Err(SmoothingError::Sigma { .. })));
    let picture = Plane::new(4, 3, 0);
    let mut blur = GaussianBlur::new(3, 1.0).unwrap();
    assert!(blur.apply(picture.view(), &mut Plane::new(3, 4, 0)).is_err());
}

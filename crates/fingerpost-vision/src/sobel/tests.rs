use proptest::prelude::*;

use super::*;
use crate::test_pictures::{config, grey_pictures};

/// The sum over the window with its nine weights; `weights[row][column]`.
fn plain(source: PlaneView<'_, u8>, weights: [[i16; 3]; 3]) -> Plane<i16> {
    let (width, height) = source.size();
    let mut target = Plane::new(width, height, 0);
    for y in 0..height {
        for x in 0..width {
            for (j, weights) in weights.iter().enumerate() {
                let row = source.row(Border::Mirror.inside((y + j) as isize - 1, height));
                for (i, weight) in weights.iter().enumerate() {
                    let pixel = row[Border::Mirror.inside((x + i) as isize - 1, width)];
                    target.row_mut(y)[x] += weight * i16::from(pixel);
                }
            }
        }
    }
    target
}

proptest! {
    #![proptest_config(config(80))]

    #[test]
    fn slopes_are_sums_over_the_window_on_every_path(picture in grey_pictures()) {
        let source = picture.view();
        let expected_dx = plain(source, [[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]]);
        let expected_dy = plain(source, [[-1, -2, -1], [0, 0, 0], [1, 2, 1]]);
        let blank = Plane::new(source.width(), source.height(), 7);
        let mut sobel = Sobel::new();
        for path in CodePath::available() {
            let (mut dx, mut dy) = (blank.clone(), blank.clone());
            sobel.gradient_on(path, source, &mut dx, &mut dy).unwrap();
            prop_assert_eq!(&dx, &expected_dx, "{:?}", path);
            prop_assert_eq!(&dy, &expected_dy, "{:?}", path);
            let (mut dx, mut dy) = (blank.clone(), blank.clone());
            sobel.horizontal_on(path, source, &mut dx).unwrap();
            sobel.vertical_on(path, source, &mut dy).unwrap();
            prop_assert_eq!(&dx, &expected_dx, "{:?}", path);
            prop_assert_eq!(&dy, &expected_dy, "{:?}", path);
        }
    }
}

#[test]
fn a_target_of_another_size_is_an_error() {
    let picture = Plane::new(4, 3, 0);
    let (mut fitting, mut other) = (Plane::new(4, 3, 0), Plane::new(3, 3, 0));
    assert!(Sobel::new().gradient(picture.view(), &mut fitting, &mut other).is_err());
    assert!(Sobel::new().gradient(picture.view(), &mut other, &mut fitting).is_err());
    assert!(Sobel::new().horizontal(picture.view(), &mut other).is_err());
    assert!(Sobel::new().vertical(picture.view(), &mut other).is_err());
}

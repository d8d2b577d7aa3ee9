//! Every path against the recommendations' equations.

#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const CODINGS: [YuvCoding; 4] = [
    YuvCoding { matrix: YuvMatrix::Bt601, range: YuvRange::Limited },
    YuvCoding { matrix: YuvMatrix::Bt601, range: YuvRange::Full },
    YuvCoding { matrix: YuvMatrix::Bt709, range: YuvRange::Limited },
    YuvCoding { matrix: YuvMatrix::Bt709, range: YuvRange::Full },
];

/// The equations of the recommendations.
fn exact([y, u, v]: [u8; 3], coding: YuvCoding) -> [f64; 3] {
    let (kr, kb) = match coding.matrix {
        YuvMatrix::Bt601 => (0.299, 0.114),
        YuvMatrix::Bt709 => (0.2126, 0.0722),
    };
    let kg = 1.0 - kr - kb;
    let (y, u, v) = match coding.range {
        YuvRange::Limited => {
            ((f64::from(y) - 16.0) / 219.0, (f64::from(u) - 128.0) / 224.0, (f64::from(v) - 128.0) / 224.0)
        }
        YuvRange::Full => {
            (f64::from(y) / 255.0, (f64::from(u) - 128.0) / 255.0, (f64::from(v) - 128.0) / 255.0)
        }
    };
    let red = y + 2.0 * (1.0 - kr) * v;
    let blue = y + 2.0 * (1.0 - kb) * u;
    let green = (y - kr * red - kb * blue) / kg;
    [red, green, blue].map(|value| (255.0 * value).clamp(0.0, 255.0))
}

fn view<'a>((width, height): (usize, usize), plane: &'a [u8]) -> PlaneView<'a, u8> {
    PlaneView::new(plane, width, height, width).unwrap()
}

/// Planes without anything between their rows.
fn packed<'a>(size: (usize, usize), y: &'a [u8], u: &'a [u8], v: &'a [u8]) -> Yuv420<'a> {
    let half = (size.0.div_ceil(2), size.1.div_ceil(2));
    Yuv420 { y: view(size, y), u: view(half, u), v: view(half, v) }
}

#[test]
fn every_colour_is_the_exact_one_but_for_ties() {
    for coding in CODINGS {
        let factors = Factors::new(coding);
        for y in 0..=255 {
            for u in (0..=255).step_by(3) {
                for v in (0..=255).step_by(5) {
                    let found = rgb_of([y, u, v], &factors);
                    for (found, exact) in found.into_iter().zip(exact([y, u, v], coding)) {
                        let apart = (f64::from(found) - exact).abs();
                        assert!(apart <= 0.55, "{coding:?} {y} {u} {v}: {found}, not {exact}");
                    }
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 60,
        rng_seed: RngSeed::Fixed(25),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn pictures_are_converted_pixel_by_pixel_on_every_path(
        (width, height) in (0..150_usize, 0..6_usize),
        values in prop::collection::vec(any::<u8>(), 150 * 6 * 2),
        coding in 0..4_usize,
    ) {
        let half = width.div_ceil(2) * height.div_ceil(2);
        let (y, rest) = values.split_at(width * height);
        let (u, rest) = rest.split_at(half);
        let v = &rest[..half];
        let planes = packed((width, height), y, u, v);
        let factors = Factors::new(CODINGS[coding]);
        for path in CodePath::available() {
            let mut image = RgbImage::new(width, height);
            convert(path, planes, CODINGS[coding], &mut image).unwrap();
            for row in 0..height {
                for col in 0..width {
                    let at = row / 2 * width.div_ceil(2) + col / 2;
                    let expected = rgb_of([y[row * width + col], u[at], v[at]], &factors);
                    prop_assert_eq!(image.get(col, row), Some(expected), "{:?} ({}, {})", path, col, row);
                }
            }
        }
    }
}

#[test]
fn what_lies_between_the_rows_of_planes_is_not_looked_at() {
    let coding = CODINGS[0];
    let mut padded = RgbImage::new(3, 2);
    let y = PlaneView::new(&[90, 91, 92, 7, 7, 93, 94, 95], 3, 2, 5).unwrap();
    let (u, v) = ([100, 120, 7], [140, 90, 7]);
    let [u_view, v_view] = [&u, &v].map(|plane| PlaneView::new(plane, 2, 1, 3).unwrap());
    rgb_from_yuv420(Yuv420 { y, u: u_view, v: v_view }, coding, &mut padded).unwrap();
    let mut tight = RgbImage::new(3, 2);
    let planes = packed((3, 2), &[90, 91, 92, 93, 94, 95], &u[..2], &v[..2]);
    rgb_from_yuv420(planes, coding, &mut tight).unwrap();
    assert_eq!(padded, tight);
}

#[test]
fn planes_of_wrong_sizes_are_refused() {
    let coding = CODINGS[0];
    let planes = packed((3, 3), &[9; 9], &[1; 4], &[1; 4]);
    let mut image = RgbImage::new(3, 3);
    rgb_from_yuv420(planes, coding, &mut image).unwrap();
    let [narrow, low] = [(1, 2), (2, 1)].map(|size| view(size, &[1; 4]));
    for wrong in [
        Yuv420 { y: view((3, 2), &[9; 9]), ..planes },
        Yuv420 { u: narrow, ..planes },
        Yuv420 { v: low, ..planes },
    ] {
        assert!(matches!(rgb_from_yuv420(wrong, coding, &mut image), Err(PictureError::SizeMismatch { .. })));
    }
    let refused = rgb_from_yuv420(planes, coding, &mut RgbImage::new(3, 2));
    assert!(matches!(refused, Err(PictureError::SizeMismatch { .. })));
}

use proptest::prelude::*;

use super::*;
use crate::test_pictures::{Framed, config, grey_pictures};

/// The detector as its definition reads: whole pictures, floating point for directions, a search for hysteresis.
fn plain(picture: &Framed, params: CannyParams) -> Plane<u8> {
    let (width, height) = picture.view().size();
    let mut edges = Plane::new(width, height, 0);
    let gradient = |x: usize, y: usize| {
        let pixel = |i: isize, j: isize| {
            let x = Border::Replicate.inside(x as isize + i, width);
            let y = Border::Replicate.inside(y as isize + j, height);
            i32::from(picture.view().row(y)[x])
        };
        let dx = |j| pixel(1, j) - pixel(-1, j);
        let dy = |i| pixel(i, 1) - pixel(i, -1);
        (dx(-1) + 2 * dx(0) + dx(1), dy(-1) + 2 * dy(0) + dy(1))
    };
    let strength = |x: isize, y: isize| {
        if x < 0 || y < 0 || x as usize >= width || y as usize >= height {
            return 0;
        }
        let (dx, dy) = gradient(x as usize, y as usize);
        match params.norm {
            GradientNorm::L1 => dx.abs() + dy.abs(),
            GradientNorm::L2 => dx * dx + dy * dy,
        }
    };
    let threshold = |level: f64| match params.norm {
        GradientNorm::L1 => level.floor() as i32,
        GradientNorm::L2 => (level * level).floor() as i32,
    };
    let kept = |x: usize, y: usize| {
        let (dx, dy) = gradient(x, y);
        let (u, v) = (x as isize, y as isize);
        let tangent = f64::from(dy.abs()) / f64::from(dx.abs());
        let here = strength(u, v);
        if tangent < 13573.0 / 32768.0 {
            here > strength(u - 1, v) && here >= strength(u + 1, v)
        } else if tangent > 2.0 + 13573.0 / 32768.0 {
            here > strength(u, v - 1) && here >= strength(u, v + 1)
        } else {
            let side = if (dx < 0) == (dy < 0) { 1 } else { -1 };
            here > strength(u - side, v - 1) && here > strength(u + side, v + 1)
        }
    };
    let candidate =
        |x: usize, y: usize, level: f64| strength(x as isize, y as isize) > threshold(level) && kept(x, y);
    let all: Vec<(usize, usize)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    let weak: Vec<_> = all.iter().copied().filter(|&(x, y)| candidate(x, y, params.low)).collect();
    for &(x, y) in weak.iter().filter(|&&(x, y)| candidate(x, y, params.high)) {
        edges.row_mut(y)[x] = 255;
    }
    loop {
        let before = edges.clone();
        for &(x, y) in &weak {
            let beside = |&(u, v): &(usize, usize)| {
                u.abs_diff(x) <= 1 && v.abs_diff(y) <= 1 && edges.get(u, v) == Some(255)
            };
            if weak.iter().any(beside) {
                edges.row_mut(y)[x] = 255;
            }
        }
        if edges == before {
            return edges;
        }
    }
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn edges_are_those_of_the_definition_on_every_path(
        picture in grey_pictures(),
        low in 0.0..500.0_f64,
        above in 0.0..700.0_f64,
        norm in prop_oneof![Just(GradientNorm::L1), Just(GradientNorm::L2)],
    ) {
        let params = CannyParams { low, high: low + above, norm };
        let expected = plain(&picture, params);
        let mut canny = Canny::new(params).unwrap();
        for path in CodePath::available() {
            let mut edges = Plane::new(expected.width(), expected.height(), 9);
            canny.apply_on(path, picture.view(), &mut edges).unwrap();
            prop_assert_eq!(&edges, &expected, "{:?}", path);
        }
    }
}

#[test]
fn a_weak_line_counts_as_far_as_it_hangs_on_a_strong_pixel() {
    // Two upright lines where the picture gets 30 levels brighter; the left one is stronger in one place.
    let mut picture = Plane::new(24, 9, 0_u8);
    for y in 0..9 {
        let row = picture.row_mut(y);
        row[6..].fill(30);
        row[16..].fill(60);
    }
    picture.row_mut(4)[6] = 90;
    let params = CannyParams { low: 100.0, high: 200.0, norm: GradientNorm::L1 };
    let mut edges = Plane::new(24, 9, 0);
    Canny::new(params).unwrap().apply(picture.view(), &mut edges).unwrap();
    assert!((0..9).all(|y| edges.row(y)[4..8].contains(&255)), "{edges:?}");
    assert!(edges.row(0)[14..18].iter().all(|&edge| edge == 0), "{edges:?}");
}

#[test]
fn thresholds_and_targets_that_do_not_fit_are_errors() {
    for (low, high) in [(-1.0, 5.0), (6.0, 5.0), (f64::NAN, 5.0), (1.0, f64::NAN)] {
        let params = CannyParams { low, high, norm: GradientNorm::L1 };
        assert!(matches!(Canny::new(params), Err(CannyError::Thresholds { .. })));
    }
    let params = CannyParams { low: 0.0, high: f64::INFINITY, norm: GradientNorm::L2 };
    let picture = Plane::new(4, 3, 0);
    assert!(Canny::new(params).unwrap().apply(picture.view(), &mut Plane::new(3, 4, 0)).is_err());
}

use super::*;
use crate::picture::Plane;
use crate::simd::CodePath;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn pattern(width: usize, height: usize) -> Plane<f32> {
    let values = (0..width * height).map(|index| ((index * 7919 + 13) % 101) as f32).collect();
    Plane::from_vec(width, height, values).unwrap()
}

#[test]
fn separable_filter_equals_the_sum_over_the_window() {
    for (width, height, radius) in
        [(9, 7, 2), (1, 5, 2), (2, 2, 1), (16, 1, 2), (70, 3, 4), (41, 30, 9), (5, 6, 0)]
    {
        let (taps, reach) = (gaussian_taps(0.6 * radius as f64, radius), radius as isize);
        let source = pattern(width, height);
        let mut target = Plane::new(width, height, 0.0);
        SeparableFilter::new(&taps).apply(&source, &mut target).unwrap();
        for y in 0..height {
            for x in 0..width {
                let mut sum = 0.0;
                for (j, wy) in taps.iter().enumerate() {
                    for (i, wx) in taps.iter().enumerate() {
                        let row = mirror(y as isize + j as isize - reach, height);
                        let col = mirror(x as isize + i as isize - reach, width);
                        sum += wx * wy * f64::from(source.row(row)[col]);
                    }
                }
                assert!((f64::from(target.row(y)[x]) - sum).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn mirrors_leave_out_the_edge_pixel() {
    let folded: Vec<usize> = (-3..7).map(|index| mirror(index, 4)).collect();
    assert_eq!(folded, vec![3, 2, 1, 0, 1, 2, 3, 2, 1, 0]);
}

#[test]
fn box_mean_equals_the_sum_over_the_window() {
    for (width, height, radius) in
        [(9, 7, 2), (3, 4, 7), (1, 1, 3), (12, 5, 0), (70, 20, 7), (33, 9, 5), (40, 3, 6)]
    {
        let source = pattern(width, height);
        let mut target = Plane::new(width, height, 0.0);
        BoxMean::new(radius).apply(&source, &mut target).unwrap();
        let reach = radius as isize;
        let clamp = |index: isize, length: usize| index.clamp(0, length as isize - 1) as usize;
        for y in 0..height {
            for x in 0..width {
                let mut sum = 0.0;
                for j in -reach..=reach {
                    for i in -reach..=reach {
                        let row = source.row(clamp(y as isize + j, height));
                        sum += f64::from(row[clamp(x as isize + i, width)]);
                    }
                }
                let mean = sum / ((2 * radius + 1) * (2 * radius + 1)) as f64;
                assert!((f64::from(target.row(y)[x]) - mean).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn a_gaussian_sums_to_one_and_none_is_a_single_tap() {
    assert!((gaussian_taps(1.5, 4).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(gaussian_taps(0.0, 1), vec![0.0, 1.0, 0.0]);
    let mut same = Plane::new(4, 3, 0.0);
    SeparableFilter::new(&gaussian_taps(0.0, 1)).apply(&pattern(4, 3), &mut same).unwrap();
    assert_eq!(same, pattern(4, 3));
    assert!(SeparableFilter::new(&[1.0]).apply(&pattern(4, 3), &mut Plane::new(3, 4, 0.0)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn every_path_gives_the_same_bytes(
        (width, height) in (1..150_usize, 1..30_usize),
        radius in 0..12_usize,
        seed in 0..1000_usize,
    ) {
        let values = (0..width * height).map(|index| ((index + seed) * 7919 % 251) as f32 * 0.37).collect();
        let source = Plane::from_vec(width, height, values).unwrap();
        let (mut smoothed, mut means) = (source.clone(), source.clone());
        let mut smoothing = SeparableFilter::new(&gaussian_taps(2.0, radius));
        smoothing.smooth(CodePath::PORTABLE, &source, &mut smoothed);
        BoxMean::new(radius).average(CodePath::PORTABLE, &source, &mut means);
        for path in CodePath::available() {
            let mut found = source.clone();
            smoothing.smooth(path, &source, &mut found);
            prop_assert_eq!(&found, &smoothed);
            BoxMean::new(radius).average(path, &source, &mut found);
            prop_assert_eq!(&found, &means);
        }
    }
}

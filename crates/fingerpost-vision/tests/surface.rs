//! Warp, colour and back-projection against plain twins and known places.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use fingerpost_vision::backprojection::{
    BackProjectionError, BackProjector, MAX_DISC_RADIUS_PX, ratio_lookup,
};
use fingerpost_vision::colour::{self, BinDivision, HueSaturationBins, grey_of, hue_saturation_of};
use fingerpost_vision::histogram::{BinCounter, Histogram};
use fingerpost_vision::picture::{Plane, Rect, RgbImage, ValidityMask};
use fingerpost_vision::span::SpanMask;
use fingerpost_vision::warp::WarpTable;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 120,
        rng_seed: RngSeed::Fixed(21),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_warp_is_the_bilinear_value_of_its_place(
        (width, height) in (1..9_usize, 1..9_usize),
        seed in any::<u8>(),
        place in [-1.5..9.5_f64, -1.5..9.5_f64],
    ) {
        let value = |x: usize, y: usize| (x * 53 + y * 91 + usize::from(seed)) as u8;
        let pixels = (0..width * height).map(|index| value(index % width, index / width)).collect();
        let source = Plane::from_vec(width, height, pixels).unwrap();
        let table = WarpTable::new(1, 1, width, height, |_, _| Some(place)).unwrap();
        let mut target = Plane::new(1, 1, 77);
        table.warp_grey(&source, &mut target).unwrap();
        let inside = (0.0..=(width - 1) as f64).contains(&place[0]) && (0.0..=(height - 1) as f64).contains(&place[1]);
        prop_assert_eq!(table.validity().plane().get(0, 0), Some(u8::from(inside)));
        let expected = if inside {
            let [u, v] = place.map(|coordinate| (coordinate * 32.0).round_ties_even() / 32.0);
            let (x, y) = (u as usize, v as usize);
            let (x1, y1) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
            let row = |y: usize| f64::from(value(x, y)) * (1.0 - u.fract()) + f64::from(value(x1, y)) * u.fract();
            (row(y) * (1.0 - v.fract()) + row(y1) * v.fract() + 0.5).floor() as u8
        } else {
            0
        };
        prop_assert_eq!(target.get(0, 0), Some(expected));
    }

    #[test]
    fn the_disc_takes_the_rounded_mean_of_the_seen_pixels(
        (width, height) in (1..20_usize, 1..14_usize),
        radius in 0..=8_u16,
        seed in any::<u64>(),
    ) {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        let lookup: Vec<u8> = (0..16).map(|_| next() as u8).collect();
        let bin = Plane::from_vec(width, height, (0..width * height).map(|_| (next() % 16) as u16).collect()).unwrap();
        let seen = (0..width * height).map(|_| u8::from(next() % 4 > 0)).collect();
        let validity = Plane::from_vec(width, height, seen).unwrap();
        let mask = ValidityMask::from_plane(validity.clone());
        let mut probability = Plane::new(width, height, 9);
        let mut projector = BackProjector::new(radius).unwrap();
        // Another picture first: nothing of it stays.
        projector.project(&bin, &ValidityMask::all_seen(width, height), &[255; 16], &mut probability).unwrap();
        projector.project(&bin, &mask, &lookup, &mut probability).unwrap();
        let reach = i64::from(radius);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let (mut sum, mut count) = (0_u32, 0_u32);
            for (dy, dx) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dy, dx))) {
                let (Ok(col), Ok(row)) = (usize::try_from(x as i64 + dx), usize::try_from(y as i64 + dy)) else {
                    continue;
                };
                if dx * dx + dy * dy <= reach * reach && validity.get(col, row) == Some(1) {
                    sum += u32::from(lookup[usize::from(bin.row(row)[col])]);
                    count += 1;
                }
            }
            let expected = if validity.row(y)[x] == 0 { 0 } else { (2 * sum + count) / (2 * count) };
            prop_assert_eq!(u32::from(probability.row(y)[x]), expected);
        }
    }
}

#[test]
fn the_largest_disc_keeps_full_certainty_full() {
    let validity = ValidityMask::all_seen(90, 80);
    let mut probability = Plane::new(90, 80, 0);
    let mut projector = BackProjector::new(MAX_DISC_RADIUS_PX).unwrap();
    projector.project(&Plane::new(90, 80, 0), &validity, &[255], &mut probability).unwrap();
    assert!(probability.as_slice().iter().all(|&value| value == 255));
}

#[test]
fn a_warp_mirrors_left_and_right_where_it_is_told_to() {
    let source = RgbImage::from_vec(3, 1, vec![1, 2, 3, 4, 5, 6, 7, 8, 9]).unwrap();
    let table = WarpTable::new(3, 2, 3, 1, |col, row| (row == 0).then_some([2.0 - col as f64, 0.0])).unwrap();
    let mut target = RgbImage::from_vec(3, 2, vec![99; 18]).unwrap();
    table.warp_rgb(&source, &mut target).unwrap();
    assert_eq!(target.row(0), &[7, 8, 9, 4, 5, 6, 1, 2, 3]);
    assert_eq!(target.row(1), &[0; 9]);
    assert!(table.warp_rgb(&target, &mut RgbImage::new(3, 2)).is_err());
    assert!(table.warp_grey(&Plane::new(3, 1, 0), &mut Plane::new(3, 1, 0)).is_err());
}

#[test]
fn places_that_are_not_numbers_are_unseen_and_an_empty_source_shows_nothing() {
    let table =
        WarpTable::new(2, 1, 5, 5, |col, _| Some(if col == 0 { [f64::NAN, 1.0] } else { [1.0, 4.0] }))
            .unwrap();
    assert_eq!(table.validity().plane().as_slice(), &[0, 1]);
    let table = WarpTable::new(2, 2, 0, 5, |_, _| Some([0.0, 0.0])).unwrap();
    let mut target = Plane::new(2, 2, 5);
    table.warp_grey(&Plane::new(0, 5, 0), &mut target).unwrap();
    assert_eq!(target.as_slice(), &[0; 4]);
    assert!(WarpTable::new(1, 1, usize::MAX, 2, |_, _| None).is_err());
}

/// The hexcone model in floating point (Smith 1978).
fn plain_hue_saturation([r, g, b]: [u8; 3]) -> (f64, f64) {
    let [r, g, b] = [f64::from(r), f64::from(g), f64::from(b)];
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let spread = high - low;
    if spread <= 0.0 {
        return (0.0, 0.0);
    }
    let sixths = if r >= high {
        (g - b) / spread
    } else if g >= high {
        2.0 + (b - r) / spread
    } else {
        4.0 + (r - g) / spread
    };
    ((30.0 * sixths).rem_euclid(180.0), 255.0 * spread / high)
}

#[test]
fn colours_equal_the_floating_point_model_within_half_a_step() {
    // Steps of 5 and 3 share no factor with the hexcone's corners, so that every sixth of the circle is hit unevenly.
    for r in (0..=255).step_by(5) {
        for g in (0..=255).step_by(3) {
            for b in (0..=255).step_by(5) {
                let rgb = [r, g, b];
                let (hue, saturation) = hue_saturation_of(rgb);
                let (plain_hue, plain_saturation) = plain_hue_saturation(rgb);
                let apart = (f64::from(hue) - plain_hue).abs();
                assert!(
                    hue < 180 && apart.min(180.0 - apart) < 0.51,
                    "hue of {rgb:?}: {hue}, not {plain_hue}"
                );
                assert!((f64::from(saturation) - plain_saturation).abs() < 0.51, "saturation of {rgb:?}");
                let luma = 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
                assert!((f64::from(grey_of(rgb)) - luma).abs() < 0.51, "grey of {rgb:?}");
            }
        }
    }
}

#[test]
fn one_pass_gives_what_the_separate_ones_give() {
    let bytes = (0..30 * 20 * 3_usize).map(|index| ((index * 2_654_435_761) >> 7) as u8).collect();
    let image = RgbImage::from_vec(30, 20, bytes).unwrap();
    let bins = HueSaturationBins { hue: 32, saturation: 17 };
    let (mut grey, mut bin) = (Plane::new(30, 20, 0), Plane::new(30, 20, 0));
    let division = BinDivision::new(bins).unwrap();
    colour::grey_and_bins(&image, &division, &mut grey, &mut bin).unwrap();
    let (mut plain_grey, mut hue, mut saturation) = (grey.clone(), grey.clone(), grey.clone());
    colour::grey(&image, &mut plain_grey).unwrap();
    colour::hue_saturation(&image, &mut hue, &mut saturation).unwrap();
    assert_eq!(grey, plain_grey);
    for (index, &bin) in bin.as_slice().iter().enumerate() {
        let (hue, saturation) =
            (usize::from(hue.as_slice()[index]), usize::from(saturation.as_slice()[index]));
        assert_eq!(usize::from(bin), hue * 32 / 180 * 17 + saturation * 17 / 256);
        assert!(usize::from(bin) < bins.count());
    }
    let too_many = HueSaturationBins { hue: 32, saturation: 257 };
    assert!(BinDivision::new(too_many).is_err());
    assert!(colour::grey_and_bins(&image, &division, &mut Plane::new(20, 30, 0), &mut bin).is_err());
}

#[test]
fn a_surface_stands_out_from_its_surroundings() {
    // The left half is the surface (bin 2), the right half something else (bin 1).
    let mut bin = Plane::new(8, 4, 1_u16);
    (0..4).for_each(|y| bin.row_mut(y)[..4].fill(2));
    let all_seen = ValidityMask::all_seen(8, 4);
    let bins = HueSaturationBins { hue: 1, saturation: 4 };
    let histogram_of = |rect: Rect| {
        let mut histogram = Histogram::new(bins).unwrap();
        let region = SpanMask::from_rect(rect);
        BinCounter::default().count(bin.view(), &all_seen, &region, &mut histogram).unwrap();
        histogram.normalise();
        histogram
    };
    let surface = histogram_of(Rect { x: 0, y: 2, width: 5, height: 2 });
    let picture = histogram_of(Rect { x: 0, y: 0, width: 8, height: 4 });
    let mut lookup = Vec::new();
    ratio_lookup(&surface, &picture, 1.0, &mut lookup).unwrap();
    // 0.8 of the surface against half of the picture; 0.2 against half.
    assert_eq!(lookup, vec![0, 102, 255, 0]);
    ratio_lookup(&surface, &picture, 0.5, &mut lookup).unwrap();
    assert_eq!(lookup, vec![0, 51, 204, 0]);

    let mut projector = BackProjector::new(0).unwrap();
    let mut probability = Plane::new(8, 4, 0);
    projector.project(&bin, &all_seen, &lookup, &mut probability).unwrap();
    assert_eq!(probability.row(1), &[204, 204, 204, 204, 51, 51, 51, 51]);
    let short = projector.project(&bin, &all_seen, &lookup[..2], &mut probability);
    assert_eq!(short, Err(BackProjectionError::BinOutside { bin: 2, count: 2 }));
    for gain in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = ratio_lookup(&surface, &picture, gain, &mut lookup);
        assert!(matches!(refused, Err(BackProjectionError::Gain { .. })));
    }
    assert!(BackProjector::new(MAX_DISC_RADIUS_PX + 1).is_err());
    let other = Histogram::new(HueSaturationBins { hue: 4, saturation: 1 }).unwrap();
    assert!(ratio_lookup(&surface, &other, 1.0, &mut lookup).is_err());
}

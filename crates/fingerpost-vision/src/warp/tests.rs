//! Every path against the plain formula.

#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use super::*;
use crate::colour::{HueSaturationBins, grey_of, hue_saturation_of};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The value of a place of `source` in double precision; places are multiples of 1/32, so that it is exact.
fn plain(source: &RgbImage, [u, v]: [f64; 2]) -> [u8; 3] {
    let (x, y) = (u as usize, v as usize);
    let (x1, y1) = ((x + 1).min(source.width() - 1), (y + 1).min(source.height() - 1));
    std::array::from_fn(|channel| {
        let value = |x: usize, y: usize| f64::from(source.row(y)[3 * x + channel]);
        let row = |y: usize| value(x, y) * (1.0 - u.fract()) + value(x1, y) * u.fract();
        (row(y) * (1.0 - v.fract()) + row(y1) * v.fract() + 0.5).floor() as u8
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        rng_seed: RngSeed::Fixed(26),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_path_gives_the_values_of_the_plain_formula(
        (source_width, source_height) in (1..40_usize, 1..12_usize),
        (width, height) in (1..70_usize, 1..6_usize),
        pixels in prop::collection::vec(any::<u8>(), 40 * 12 * 3),
        places in prop::collection::vec((0..1500_u32, 0..450_u32), 70 * 6),
        unseen in prop::collection::vec(0..70 * 6_usize, 0..12),
    ) {
        let pixels = pixels[..3 * source_width * source_height].to_vec();
        let source = RgbImage::from_vec(source_width, source_height, pixels).unwrap();
        // Folded into the source, its last pixels included.
        let within = |steps: u32, length: usize| f64::from(steps % (32 * (length as u32 - 1) + 1)) / 32.0;
        let place_of = |col: usize, row: usize| {
            let (u, v) = places[row * width + col];
            (!unseen.contains(&(row * width + col)))
                .then(|| [within(u, source_width), within(v, source_height)])
        };
        let table = WarpTable::new(width, height, source_width, source_height, place_of).unwrap();
        let division = BinDivision::new(HueSaturationBins { hue: 23, saturation: 31 }).unwrap();
        let reds: Vec<u8> = source.as_slice().iter().step_by(3).copied().collect();
        let reds = Plane::from_vec(source_width, source_height, reds).unwrap();
        for path in CodePath::available() {
            let mut red = Plane::new(width, height, 7);
            table.warp_grey_on(path, &reds, &mut red).unwrap();
            let mut alone = RgbImage::from_vec(width, height, vec![7; 3 * width * height]).unwrap();
            table.warp_rgb_on(path, &source, &mut alone).unwrap();
            let mut colour = RgbImage::from_vec(width, height, vec![9; 3 * width * height]).unwrap();
            let (mut grey, mut bin) = (Plane::new(width, height, 11), Plane::new(width, height, 13));
            table.warp_ground_on(path, &source, &division, (&mut colour, &mut grey, &mut bin)).unwrap();
            prop_assert_eq!(&alone, &colour);
            for row in 0..height {
                for col in 0..width {
                    let place = place_of(col, row);
                    let rgb = place.map_or([0; 3], |place| plain(&source, place));
                    prop_assert_eq!(colour.get(col, row), Some(rgb), "{:?} ({}, {}) {:?}", path, col, row, place);
                    prop_assert_eq!(red.get(col, row), Some(rgb[0]));
                    prop_assert_eq!(grey.get(col, row), Some(grey_of(rgb)));
                    let (hue, saturation) = hue_saturation_of(rgb);
                    let expected = place.map_or(0, |_| division.bins().bin_of(hue, saturation));
                    prop_assert_eq!(bin.get(col, row).map(usize::from), Some(expected));
                }
            }
        }
    }
}

/// Neighbours that look at neighbours, one way, the other and askew: what the windows are for, and where they do not reach.
#[test]
fn every_path_stretches_and_shrinks_grey_alike() {
    let values = (0..90 * 40_usize).map(|index| (index * index % 251) as u8).collect();
    let source = Plane::from_vec(90, 40, values).unwrap();
    for [right, down] in [[0.3, 0.0], [-0.3, 0.002], [3.9, 0.0], [4.3, 0.01], [0.2, 0.2], [0.0, 0.4]] {
        let table = WarpTable::new(203, 30, 90, 40, |col, row| {
            let (col, row) = (col as f64, row as f64);
            Some([45.0 + right * (col - 101.0), 2.0 + 1.2 * row + down * (col - 101.0)])
        });
        let table = table.unwrap();
        let warped = |path| {
            let mut target = Plane::new(203, 30, 9);
            table.warp_grey_on(path, &source, &mut target).unwrap();
            target
        };
        for path in CodePath::available() {
            assert_eq!(warped(path), warped(CodePath::PORTABLE), "{path:?}, {right} and {down}");
        }
    }
}

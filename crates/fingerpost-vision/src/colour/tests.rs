//! Every path against the plain formula, and the plain formula against exact fractions.

#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use super::*;

#[test]
fn quotients_are_rounded_exactly() {
    for divisor in 1..=255 {
        for numerator in 0..=330 * divisor {
            let (whole, rest) = (numerator / divisor, numerator % divisor);
            let nearest = match (2 * rest).cmp(&divisor) {
                std::cmp::Ordering::Less => whole,
                std::cmp::Ordering::Greater => whole + 1,
                std::cmp::Ordering::Equal => whole + whole % 2,
            };
            assert_eq!(rounded_quotient(numerator, divisor), nearest, "{numerator} / {divisor}");
        }
    }
}

#[test]
fn every_division_numbers_bins_as_the_plain_one() {
    for hue_bins in 1..=HUES {
        for saturation in [1, 2, 31, 32, 255, 256] {
            let bins = HueSaturationBins { hue: hue_bins, saturation };
            let division = BinDivision::new(bins).unwrap();
            for hue in 0..=179 {
                for level in [0, 1, 127, 128, 254, 255] {
                    assert_eq!(usize::from(division.bin_of(hue, level)), bins.bin_of(hue, level), "{bins:?}");
                }
            }
        }
    }
}

#[test]
fn every_path_gives_the_same_bin_to_every_second_colour() {
    let division = BinDivision::new(HueSaturationBins { hue: 180, saturation: 256 }).unwrap();
    for r in 0..=255 {
        let levels = || (0..=255_u8).step_by(2).map(|level| level | (r & 1));
        let rgb: Vec<[u8; 3]> = levels().flat_map(|g| levels().map(move |b| [r, g, b])).collect();
        for path in CodePath::available() {
            let (mut grey, mut bin) = (vec![1; rgb.len()], vec![2; rgb.len()]);
            grey_and_bins_of_all(path, &rgb, &division, &mut grey, &mut bin);
            for (i, &rgb) in rgb.iter().enumerate() {
                let (hue, saturation) = hue_saturation_of(rgb);
                assert_eq!(usize::from(bin[i]), usize::from(hue) * 256 + usize::from(saturation), "{rgb:?}");
                assert_eq!(grey[i], grey_of(rgb), "{path:?} {rgb:?}");
            }
        }
    }
}

#[test]
fn every_path_gives_the_same_colours_at_every_length() {
    // Steps that share no factor with 256 pass through unlike colours soon; greys and black are among them.
    let colours: Vec<[u8; 3]> = (0..1003_u32)
        .map(|i| if i % 17 == 0 { [i as u8; 3] } else { [i * 37, i * 91 + 5, i * 151 + 77].map(|v| v as u8) })
        .collect();
    let division = BinDivision::new(HueSaturationBins { hue: 32, saturation: 17 }).unwrap();
    for length in (0..70).chain([255, 256, 257, 511, 1003]) {
        let rgb = &colours[..length];
        for path in CodePath::available() {
            let (mut grey, mut grey_again) = (vec![1; length], vec![2; length]);
            let (mut hue, mut saturation) = (vec![3; length], vec![4; length]);
            let mut bin = vec![5; length];
            kernel::grey_of_all(path, rgb, &mut grey);
            kernel::hue_saturation_of_all(path, rgb, &mut hue, &mut saturation);
            grey_and_bins_of_all(path, rgb, &division, &mut grey_again, &mut bin);
            for (i, &rgb) in rgb.iter().enumerate() {
                let expected = hue_saturation_of(rgb);
                assert_eq!(grey[i], grey_of(rgb), "{path:?}, pixel {i} of {length}");
                assert_eq!(grey_again[i], grey[i]);
                assert_eq!((hue[i], saturation[i]), expected, "{path:?}, pixel {i} of {length}");
                assert_eq!(bin[i], division.bin_of(expected.0, expected.1));
            }
        }
    }
}

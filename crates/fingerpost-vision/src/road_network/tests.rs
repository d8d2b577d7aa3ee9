mod made_up;

use made_up::{Filling, MadeUp, Random};

use super::*;

fn noise(random: &mut Random, width: usize, height: usize) -> RgbImage {
    let bytes = (0..3 * width * height).map(|_| (random.next() >> 24) as u8).collect();
    RgbImage::from_vec(width, height, bytes).unwrap()
}

fn whole(picture: &RgbImage) -> Rect {
    Rect { x: 0, y: 0, width: picture.width(), height: picture.height() }
}

/// A network of made-up sizes.
fn drawn(random: &mut Random, filling: Filling) -> MadeUp {
    let mut sides = [0; 2].map(|_| 16 * (1 + random.below(7) as usize));
    if random.below(4) == 0 {
        sides[0] = 16;
    }
    let channels = [0; 4].map(|_| 16 * (1 + random.below(3) as usize));
    let blocks = [0; 3].map(|_| random.below(3) as usize);
    let outputs = 1 + random.below(16) as usize;
    MadeUp::new(random, sides, channels, blocks, outputs, filling)
}

/// What a network sees, border and all.
fn input_of(network: &RoadNetwork) -> Vec<u8> {
    (0..network.input.height()).flat_map(|y| network.input.row(y).to_vec()).collect()
}

#[test]
fn every_path_gives_what_the_definition_gives() {
    let mut random = Random(7);
    let mut spread = [0; 3];
    for case in 0..40 {
        let filling = match case % 8 {
            6 => Filling::All(127),
            7 => Filling::All(-127),
            _ => Filling::Noise,
        };
        let made_up = drawn(&mut random, filling);
        let picture = noise(&mut random, made_up.size[0], made_up.size[1]);
        let mut network = RoadNetwork::from_bytes(&made_up.bytes()).unwrap();
        for path in CodePath::available() {
            network.see_on(path, &picture, whole(&picture)).unwrap();
            let expected = made_up.logits(&input_of(&network));
            for (output, expected) in expected.iter().enumerate() {
                assert_eq!(network.logits(output), Some(expected), "{path:?}, case {case}: {made_up:?}");
                for &logit in expected.as_slice() {
                    spread[usize::from(logit > -127) + usize::from(logit == 127)] += 1;
                }
            }
        }
    }
    // Or the comparison would be one of saturated numbers alone.
    let [low, between, high] = spread;
    assert!(between > 2 * (low + high), "{spread:?}");
}

#[test]
fn the_largest_sums_are_the_same_on_every_path() {
    let mut random = Random(11);
    for weight in [127, -127, -128] {
        let mut made_up =
            MadeUp::new(&mut random, [32, 16], [256, 16, 256, 256], [1, 0, 1], 4, Filling::All(weight));
        for layer in &mut made_up.layers {
            layer.bias.fill(if weight < 0 { 1 << 23 } else { -(1 << 23) });
            layer.multiplier.fill(64.0 / (1 << 24) as f32);
        }
        made_up.layers[0].bias.fill(1 << 23);
        let picture = noise(&mut random, 32, 16);
        let mut network = RoadNetwork::from_bytes(&made_up.bytes()).unwrap();
        for path in CodePath::available() {
            network.see_on(path, &picture, whole(&picture)).unwrap();
            let expected = made_up.logits(&input_of(&network));
            for (output, expected) in expected.iter().enumerate() {
                assert_eq!(network.logits(output), Some(expected), "{path:?}, {weight}");
            }
        }
    }
}

#[test]
fn the_input_is_what_its_formulas_give() {
    let mut random = Random(3);
    let made_up = MadeUp::new(&mut random, [64, 48], [16; 4], [0; 3], 1, Filling::Noise);
    let picture = noise(&mut random, 64, 48);
    let mut network = RoadNetwork::from_bytes(&made_up.bytes()).unwrap();
    let colour = |x: usize, y: usize| picture.get(x, y).unwrap().map(|level| f64::from(level) / 255.0);
    // Rows and columns of 0.86, 0.36 and 0.64, rounded down.
    let strip: Vec<[f64; 3]> = (41..48).flat_map(|y| (23..40).map(move |x| colour(x, y))).collect();
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| strip.iter().map(of).sum::<f64>() / strip.len() as f64;
    let means = [0, 1, 2].map(|c| mean(&|pixel| pixel[c]));
    let spreads = [0, 1, 2].map(|c| mean(&|pixel| (pixel[c] - means[c]).powi(2)).sqrt());
    let grey_of_strip = means.iter().sum::<f64>() / 3.0;
    for path in CodePath::available() {
        network.see_on(path, &picture, whole(&picture)).unwrap();
        let mut off = 0;
        for (x, y) in (0..64).flat_map(|x| (0..48).map(move |y| (x, y))) {
            let rgb = colour(x, y);
            let sum: f64 = rgb.iter().sum();
            let against = [0, 1, 2].map(|c| (rgb[c] - means[c]) / (4.0 * (spreads[c] + 0.03)));
            let chroma = [0, 1].map(|c| ((rgb[c] + 0.016) / (sum + 0.05) - 0.333) * 4.0);
            let log = libm::log(sum / 3.0 + 0.02) - libm::log(grey_of_strip + 0.02);
            let row = -1.0 + 2.0 * y as f64 / 47.0;
            let numbers = [
                (against[0], 3.0),
                (against[1], 3.0),
                (against[2], 3.0),
                (chroma[0], 2.0),
                (chroma[1], 2.0),
                (log, 2.0),
                (row, 1.0),
                (sum / 3.0 - 0.5, 0.5),
            ];
            for (channel, (number, limit)) in numbers.into_iter().enumerate() {
                let steps = number.clamp(-limit, limit) * 63.0 / limit;
                let found = f64::from(network.input.row(y)[8 * x + channel]) - 64.0;
                assert!((found - steps).abs() < 0.5 + 1e-4, "{x} {y} {channel}: {found} for {steps}");
                off += usize::from((found - steps).abs() > 0.5);
            }
        }
        assert!(off < 8, "{off} numbers on the other side of a half, {path:?}");
    }
}

#[test]
fn a_part_is_seen_as_if_it_were_the_picture() {
    let mut random = Random(5);
    let made_up = MadeUp::new(&mut random, [32, 32], [16; 4], [1, 0, 0], 2, Filling::Noise);
    let picture = noise(&mut random, 90, 50);
    let part = Rect { x: 7, y: 11, width: 70, height: 20 };
    let mut cut = RgbImage::new(70, 20);
    for y in 0..20 {
        cut.row_mut(y).copy_from_slice(&picture.row(11 + y)[21..231]);
    }
    let mut network = RoadNetwork::from_bytes(&made_up.bytes()).unwrap();
    network.see(&picture, part).unwrap();
    let of_part = network.logits(1).unwrap().clone();
    network.see(&cut, whole(&cut)).unwrap();
    assert_eq!(network.logits(1), Some(&of_part));
    network.see(&picture, whole(&picture)).unwrap();
    assert_ne!(network.logits(1), Some(&of_part));
    assert_eq!((network.outputs(), network.logit_size(), network.logits(2)), (2, (16, 16), None));
    assert!(matches!(
        network.see(&cut, Rect { width: 71, ..whole(&cut) }),
        Err(PictureError::CropOutside { .. })
    ));
}

#[test]
fn files_that_are_no_network_are_refused() {
    let mut random = Random(1);
    let made_up = MadeUp::new(&mut random, [32, 16], [16; 4], [1, 0, 0], 3, Filling::Noise);
    let bytes = made_up.bytes();
    let refused = |bytes: &[u8]| RoadNetwork::from_bytes(bytes).unwrap_err();
    assert_eq!(refused(b"PNG"), RoadNetworkError::NotANetwork);
    for length in (8..bytes.len()).step_by(7) {
        assert!(matches!(refused(&bytes[..length]), RoadNetworkError::Short { .. }), "{length}");
    }
    let long = [&bytes[..], &[0]].concat();
    assert_eq!(refused(&long), RoadNetworkError::Long { end: bytes.len(), found: long.len() });
    let with = |at: usize, word: [u8; 4]| {
        let mut bytes = bytes.clone();
        bytes[at..at + 4].copy_from_slice(&word);
        refused(&bytes)
    };
    for (word, wrong) in
        [(0, 0), (0, 24), (1, 1040), (6, 8), (8, 272), (9, u32::MAX), (10, 65), (13, 0), (13, 17)]
    {
        let error = with(8 + 4 * word, wrong.to_le_bytes());
        assert!(matches!(error, RoadNetworkError::Size { found, .. } if found == wrong), "{word}: {error}");
    }
    for (word, wrong) in [(2, f32::NAN), (2, -0.1), (3, 1.1), (4, 0.7), (5, 0.36)] {
        let error = with(8 + 4 * word, wrong.to_le_bytes());
        assert!(matches!(error, RoadNetworkError::Strip { .. }), "{word}: {error}");
    }
    let stem = 8 + 14 * 4 + 72 * 16;
    for (at, wrong) in [(stem, i32::MIN.to_le_bytes()), (stem, ((1 << 23) + 1_i32).to_le_bytes())] {
        assert!(matches!(with(at, wrong), RoadNetworkError::Number { what: "bias", .. }));
    }
    for wrong in [f32::NAN, f32::INFINITY, -64.1] {
        assert!(matches!(
            with(stem + 64, wrong.to_le_bytes()),
            RoadNetworkError::Number { what: "scale", .. }
        ));
        assert!(matches!(with(bytes.len() - 4, wrong.to_le_bytes()), RoadNetworkError::Number { .. }));
    }
}

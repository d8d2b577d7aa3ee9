use proptest::prelude::*;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::*;
use crate::picture::RgbImage;
use crate::test_pictures::config;

const SAMPLINGS: [ChromaSampling; 2] = [ChromaSampling::Halved, ChromaSampling::Full];

fn encoded(path: CodePath, picture: &RgbImage, quality: u8, sampling: ChromaSampling) -> Vec<u8> {
    let mut file = Vec::new();
    let planes = JpegPlanes::on(path, picture, sampling);
    JpegEncoder::new(quality).encode_on(path, &planes, &mut file).unwrap();
    file
}

/// The picture as somebody else reads it.
fn decoded(file: &[u8]) -> RgbImage {
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB).set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(file), options);
    let pixels = decoder.decode().unwrap();
    let info = decoder.info().unwrap();
    RgbImage::from_vec(usize::from(info.width), usize::from(info.height), pixels).unwrap()
}

/// Root of the mean square of what two pictures differ by.
fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.size(), b.size());
    let squares = a.as_slice().iter().zip(b.as_slice()).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2));
    (squares.sum::<f64>() / a.as_slice().len() as f64).sqrt()
}

/// Slopes of colour with edges between them.
fn scene(width: usize, height: usize) -> RgbImage {
    let mut picture = RgbImage::new(width, height);
    for y in 0..height {
        for (x, pixel) in picture.row_mut(y).chunks_exact_mut(3).enumerate() {
            let road = y * 3 > x + 20;
            let value = |slope: usize, base: usize| ((x * slope + y * 2) / 3 % 160 + base) as u8;
            pixel.copy_from_slice(&if road {
                [value(1, 60), value(1, 62), value(1, 66)]
            } else {
                [40, value(1, 70), 20]
            });
        }
    }
    picture
}

#[test]
fn another_reader_sees_the_picture() {
    for (width, height) in [(160, 96), (97, 33), (16, 16), (1, 1), (65, 130)] {
        let picture = scene(width, height);
        for sampling in SAMPLINGS {
            let file = encoded(CodePath::PORTABLE, &picture, 85, sampling);
            let away = difference(&decoded(&file), &picture);
            assert!(away < 6.0, "{width} x {height}, {sampling:?}: {away}");
        }
    }
}

#[test]
fn full_chroma_keeps_coloured_lines() {
    let line = |at: usize| if at.is_multiple_of(5) { [230, 30, 60] } else { [40, 60, 200] };
    let picture = RgbImage::from_vec(60, 20, (0..1200).flat_map(line).collect()).unwrap();
    let [halved, full] = SAMPLINGS
        .map(|sampling| difference(&decoded(&encoded(CodePath::PORTABLE, &picture, 90, sampling)), &picture));
    assert!(full < 4.0 && halved > 20.0, "{full} and {halved}");
}

#[test]
fn single_colours_stay_to_a_level_or_two() {
    for colour in
        [[0, 0, 0], [255, 255, 255], [255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128], [90, 140, 200]]
    {
        let picture = RgbImage::from_vec(24, 24, colour.repeat(24 * 24)).unwrap();
        for (path, sampling) in CodePath::available().flat_map(|path| SAMPLINGS.map(|of| (path, of))) {
            let away = difference(&decoded(&encoded(path, &picture, 95, sampling)), &picture);
            assert!(away < 2.0, "{colour:?} on {path:?}, {sampling:?}: {away}");
        }
    }
}

#[test]
fn a_higher_quality_is_nearer_and_larger() {
    let picture = scene(200, 120);
    let files = [20, 50, 85, 95]
        .map(|quality| encoded(CodePath::PORTABLE, &picture, quality, ChromaSampling::Halved));
    let away = files.each_ref().map(|file| difference(&decoded(file), &picture));
    assert!(files.windows(2).all(|pair| pair[0].len() < pair[1].len()));
    assert!(away.windows(2).all(|pair| pair[0] > pair[1]), "{away:?}");
}

#[test]
fn sizes_that_jpeg_does_not_have_are_refused() {
    for (width, height) in [(0, 0), (0, 5), (MOST_SIDE + 1, 1), (1, MOST_SIDE + 1)] {
        let planes = JpegPlanes::of(&RgbImage::new(width, height), ChromaSampling::Halved);
        let mut file = Vec::new();
        let error = JpegEncoder::new(85).encode(&planes, &mut file).unwrap_err();
        assert_eq!(error, JpegError::Size { width, height });
        assert!(file.is_empty());
    }
}

/// Pictures of any size with noise as strong as it can be, with patches of black and white, or smooth.
fn pictures() -> impl Strategy<Value = RgbImage> {
    (1..150_usize, 1..40_usize, any::<u64>(), 0..3_u32).prop_map(|(width, height, seed, kind)| {
        let mut state = seed;
        let bytes = (0..3 * width * height).map(|at| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            match kind {
                0 => (state >> 56) as u8,
                1 => ((state >> 63) * 255) as u8,
                _ => (at / 7 % 200) as u8,
            }
        });
        RgbImage::from_vec(width, height, bytes.collect()).unwrap()
    })
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn every_path_gives_the_same_file_and_it_is_read(picture in pictures(), quality in 1..=95_u8) {
        for sampling in SAMPLINGS {
            let expected = encoded(CodePath::PORTABLE, &picture, quality, sampling);
            prop_assert_eq!(decoded(&expected).size(), picture.size());
            for path in CodePath::available() {
                prop_assert!(encoded(path, &picture, quality, sampling) == expected, "{:?}, {:?}", path, sampling);
            }
        }
    }

    #[test]
    fn quotients_are_rounded_ones(quality in 1..=95_u8) {
        // Of a block whose pixels are those of one cosine alone, one coefficient is large: it must be the nearest to its size.
        for (across, down) in [(0, 0), (1, 0), (0, 3), (2, 5), (7, 7)] {
            let wave = |x: usize, k: usize| libm::cos((2 * x + 1) as f64 * k as f64 * std::f64::consts::PI / 16.0);
            let mut pixels = [0_u8; BLOCK_VALUES];
            for (at, pixel) in pixels.iter_mut().enumerate() {
                *pixel = (128.0 + 120.0 * wave(at % 8, across) * wave(at / 8, down)).round() as u8;
            }
            let mut sum = 0.0;
            for (at, pixel) in pixels.iter().enumerate() {
                sum += (f64::from(*pixel) - 128.0) * wave(at % 8, across) * wave(at / 8, down);
            }
            let norm = |k: usize| if k == 0 { 0.5_f64.sqrt() } else { 1.0 };
            let coefficient = 0.25 * norm(across) * norm(down) * sum;
            let quantiser = Quantiser::new(&quantiser::LUMA_STEPS, quality);
            let at = quantiser::ZIGZAG.iter().position(|place| usize::from(*place) == 8 * down + across).unwrap();
            let step = f64::from(quantiser.steps_in_zigzag()[at]);
            let mut to = Vec::new();
            transform(CodePath::PORTABLE, &pixels, &quantiser, &mut to);
            let found = f64::from(to[0].values[at]);
            prop_assert!((found - coefficient / step).abs() < 0.5 + 1.5 / step, "{} is {} in steps of {}", found, coefficient, step);
        }
    }
}

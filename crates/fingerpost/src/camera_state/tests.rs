use fingerpost_vision::picture::RgbImage;

use super::*;

const SEED: u64 = 10;

/// Numbers that follow from a seed (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// About normal, of standard deviation 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| (self.next() >> 11) as f64 / (1_u64 << 53) as f64).sum::<f64>() - 6.0
    }
}

/// A picture of a brightness with noise of a standard deviation.
fn picture((width, height): (usize, usize), noise: f64, brightness: impl Fn(f64, f64) -> f64) -> RgbImage {
    let mut random = Random(SEED + noise.to_bits());
    let mut data = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            let level = brightness(x as f64 / width as f64, y as f64 / height as f64);
            let level = (level + noise * random.normal()).round().clamp(0.0, 255.0) as u8;
            data.extend([level; 3]);
        }
    }
    RgbImage::from_vec(width, height, data).unwrap()
}

/// Grey levels at a share of the width and the height.
type Brightness<'a> = &'a dyn Fn(f64, f64) -> f64;

const SIZES: [(usize, usize); 5] = [(64, 64), (320, 240), (641, 479), (1241, 376), (1280, 720)];

fn state(frame: &RgbImage) -> CameraState {
    CameraWatch::default().look_at(frame).state
}

/// A sky, a road and a field, with a line on the road: what little a dull day shows.
fn road(contrast: f64) -> impl Fn(f64, f64) -> f64 {
    move |x, y| {
        let line = (x - 0.5).abs() < 0.01 + 0.03 * y && y > 0.4;
        let shade = if y < 0.4 {
            1.0
        } else if line {
            0.9
        } else if (x - 0.5).abs() < 0.1 + 0.4 * (y - 0.4) {
            0.3
        } else {
            0.5
        };
        128.0 + contrast * (shade - 0.5)
    }
}

#[test]
fn what_shows_nothing_is_named() {
    for size in SIZES {
        for noise in [0.0, 0.5, 2.0, 6.0] {
            assert_eq!(state(&picture(size, noise, |_, _| 0.0)), CameraState::Black, "{size:?} {noise}");
            let vignette = |x: f64, y: f64| 90.0 - 120.0 * ((x - 0.5).powi(2) + (y - 0.5).powi(2));
            let covers: [(&str, Brightness<'_>); 4] = [
                ("grey", &|_, _| 128.0),
                ("white", &|_, _| 255.0),
                ("vignette", &vignette),
                ("gradient", &|x, y| 60.0 + 100.0 * (0.7 * x + 0.3 * y)),
            ];
            for (name, cover) in covers {
                // On so few pixels a vignette is as steep as a road's edge.
                let steep = size == (64, 64) && matches!(name, "vignette" | "gradient");
                let found = state(&picture(size, noise, cover));
                assert!(steep || found == CameraState::NoContrast, "{size:?} {noise} {name}: {found:?}");
            }
        }
        for noise in [20.0, 50.0, 120.0] {
            let found = state(&picture(size, noise, |_, _| 128.0));
            assert_eq!(found, CameraState::NoContrast, "{size:?} {noise}");
        }
    }
}

#[test]
fn a_road_is_clear_as_long_as_it_stands_out_from_the_noise() {
    for size in SIZES.into_iter().skip(1) {
        for (contrast, noise) in [(200.0, 0.0), (200.0, 8.0), (100.0, 3.0), (60.0, 1.0)] {
            let evidence = CameraWatch::default().look_at(&picture(size, noise, road(contrast)));
            assert_eq!(evidence.state, CameraState::Clear, "{size:?} {contrast} {noise}: {evidence:?}");
            assert!(evidence.contrast >= evidence.needed_contrast);
        }
        let fog = state(&picture(size, 3.0, road(4.0)));
        assert_eq!(fog, CameraState::NoContrast, "{size:?}");
    }
}

#[test]
fn a_picture_that_comes_again_is_frozen_and_a_noisy_one_is_not() {
    let mut watch = CameraWatch::default();
    let (first, second) = (picture((320, 240), 1.0, road(150.0)), picture((320, 240), 1.1, road(150.0)));
    let frames = [&first, &second, &second, &second, &first, &first];
    let states = frames.map(|frame| watch.look_at(frame).state);
    use CameraState::{Clear, Frozen};
    assert_eq!(states, [Clear, Clear, Frozen, Frozen, Clear, Frozen]);
}

#[test]
fn a_covered_lens_is_covered_in_every_frame() {
    let mut watch = CameraWatch::default();
    let black = picture((320, 240), 0.0, |_, _| 0.0);
    for _ in 0..3 {
        assert_eq!(watch.look_at(&black).state, CameraState::Black, "and not frozen");
    }
}

#[test]
fn pictures_of_any_size_are_judged() {
    for (width, height) in
        [(0, 0), (1, 1), (7, 7), (8, 8), (23, 40), (24, 24), (5000, 1), (1, 5000), (321, 25)]
    {
        let evidence = CameraWatch::default().look_at(&RgbImage::new(width, height));
        assert!(matches!(evidence.state, CameraState::Clear | CameraState::Black), "{width} x {height}");
    }
}

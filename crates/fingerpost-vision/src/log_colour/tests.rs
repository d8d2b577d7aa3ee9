use proptest::prelude::*;

use super::*;
use crate::test_pictures::config;

/// The formula, pixel by pixel.
fn plain(source: &RgbImage, block: Block, column: usize, row: usize) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for y in row * block.height..(row + 1) * block.height {
        for x in column * block.width..(column + 1) * block.width {
            let pixel = source.get(x, y).unwrap();
            (0..3).for_each(|channel| sums[channel] += f64::from(pixel[channel]));
        }
    }
    let [r, g, b] =
        sums.map(|sum| libm::log(sum / (block.width * block.height) as f64 + f64::from(NOISE_FLOOR)));
    [(r + g + b) / 3.0, r - g, b - g]
}

fn picture(width: usize, height: usize, seed: u64) -> RgbImage {
    let mut state = seed;
    let bytes = (0..width * height * 3).map(|_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    });
    RgbImage::from_vec(width, height, bytes.collect()).unwrap()
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn blocks_are_means_and_all_paths_agree(
        (columns, rows) in (0..40_usize, 0..6_usize), block_width in 1..8_usize, block_height in 1..4_usize,
        (over_x, over_y) in (0..3_usize, 0..3_usize), first_row in 0..2_usize, seed in any::<u64>(),
    ) {
        let block = Block { width: block_width, height: block_height };
        let source =
            picture(columns * block_width + over_x, (first_row + rows) * block_height + over_y, seed);
        let mut first: Option<LogColour> = None;
        for path in CodePath::available() {
            let mut target = LogColour::default();
            target.reset(columns, rows);
            LogColourReducer::default().reduce_on(path, &source, block, first_row, &mut target).unwrap();
            for y in 0..rows {
                for x in 0..columns {
                    let expected = plain(&source, block, x, first_row + y);
                    let planes = [&target.brightness, &target.red_green, &target.blue_green];
                    for (plane, expected) in planes.into_iter().zip(expected) {
                        let found = f64::from(plane.row(y)[x]);
                        prop_assert!((found - expected).abs() < 1e-5, "({x}, {y}): {found}, not {expected}");
                    }
                }
            }
            if let Some(first) = &first {
                prop_assert_eq!(first.brightness.as_slice(), target.brightness.as_slice());
                prop_assert_eq!(first.red_green.as_slice(), target.red_green.as_slice());
                prop_assert_eq!(first.blue_green.as_slice(), target.blue_green.as_slice());
            }
            first = Some(target);
        }
    }
}

#[test]
fn half_the_light_leaves_chromaticity_nearly_as_it_is() {
    let mut target = LogColour::default();
    target.reset(2, 1);
    let source = RgbImage::from_vec(2, 1, vec![200, 160, 120, 100, 80, 60]).unwrap();
    let block = Block { width: 1, height: 1 };
    LogColourReducer::default().reduce(&source, block, 0, &mut target).unwrap();
    let step = |plane: &Plane<f32>| plane.row(0)[1] - plane.row(0)[0];
    assert!((step(&target.brightness) + std::f32::consts::LN_2).abs() < 0.03);
    assert!(step(&target.red_green).abs() < 0.02 && step(&target.blue_green).abs() < 0.02);
}

#[test]
fn a_target_beyond_the_picture_is_refused() {
    let mut target = LogColour::default();
    target.reset(3, 3);
    let block = Block::for_at_most(3, 3, 8, 7);
    assert_eq!((block, block.grid(8, 7)), (Block { width: 3, height: 3 }, (2, 2)));
    let refused = LogColourReducer::default().reduce(&RgbImage::new(8, 7), block, 0, &mut target);
    assert!(matches!(refused, Err(PictureError::SizeMismatch { .. })));
}

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Rect, RgbImage, ValidityMask};

use super::*;
use crate::ground_view::GroundPicture;
use crate::road_surface::Perspective;

const WIDTH: usize = 480;
const HEIGHT: usize = 360;
/// Row of the painted horizon.
const HORIZON: usize = 150;

/// What a painted street shows at a place: column and row, and metres to the right of the middle and ahead.
type Paint<'a> = dyn Fn(usize, usize, f64, f64) -> [u8; 3] + 'a;

/// A street seen by a camera 1.4 m above it with a focal length of 400 pixels.
fn street(paint: &Paint<'_>) -> GroundPicture {
    let mut colour = RgbImage::new(WIDTH, HEIGHT);
    for row in 0..HEIGHT {
        let line = colour.row_mut(row).as_chunks_mut::<3>().0;
        for (column, pixel) in line.iter_mut().enumerate() {
            *pixel = if row <= HORIZON {
                // Fronts of houses: stripes of windows and walls.
                if (column / 12 + row / 9) % 2 == 0 { [150, 120, 100] } else { [60, 60, 70] }
            } else {
                let ahead_m = 400.0 * 1.4 / (row - HORIZON) as f64;
                let right_m = (column as f64 - 239.5) / 400.0 * ahead_m;
                paint(column, row, right_m, ahead_m)
            };
        }
    }
    GroundPicture { colour, ..GroundPicture::new(0, 0, HueSaturationBins { hue: 2, saturation: 2 }) }
}

/// Grey with a little noise that depends on the place alone.
fn grey(level: u8, noise: u64, column: usize, row: usize) -> [u8; 3] {
    let hash = ((column * 7919 + row * 104_729) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
    [level + (hash % (noise + 1)) as u8; 3]
}

fn estimate(detector: &mut Online, picture: &GroundPicture) -> (Plane<u8>, OnlineEvidence) {
    let validity = ValidityMask::all_seen(WIDTH, HEIGHT);
    let sample = Rect { x: 190, y: 280, width: 100, height: 50 };
    let perspective = Perspective::Camera { horizon_row: HORIZON as f64 };
    let input = RoadInput { picture, validity: &validity, sample, perspective, motion: None };
    let mut probability = Plane::default();
    let evidence = detector.estimate(input, &mut probability).unwrap();
    (probability, evidence.online.unwrap())
}

/// Intersection over union of the probability at one half with where `is_road` holds, below the horizon's haze.
fn overlap(probability: &Plane<u8>, is_road: impl Fn(f64, f64) -> bool) -> f64 {
    let (mut both, mut either) = (0, 0);
    for row in HORIZON + 15..HEIGHT {
        let ahead_m = 400.0 * 1.4 / (row - HORIZON) as f64;
        for column in 0..WIDTH {
            let found = probability.row(row)[column] >= 128;
            let expected = is_road((column as f64 - 239.5) / 400.0 * ahead_m, ahead_m);
            both += usize::from(found && expected);
            either += usize::from(found || expected);
        }
    }
    both as f64 / either as f64
}

fn first_frame(paint: &Paint<'_>) -> Plane<u8> {
    estimate(&mut Online::new(&OnlineConfig::default()), &street(paint)).0
}

/// A road 6 m wide, its kerbs darker, pavements a little brighter than the road beyond them.
fn with_kerbs(column: usize, row: usize, right_m: f64, road: u8) -> [u8; 3] {
    match right_m.abs() {
        ..3.0 => grey(road, 4, column, row),
        ..3.25 => grey(40, 4, column, row),
        _ => grey(120, 4, column, row),
    }
}

#[test]
fn kerbs_bound_a_road_as_grey_as_the_pavement() {
    let probability = first_frame(&|column, row, right_m, _| with_kerbs(column, row, right_m, 92));
    let overlap = overlap(&probability, |right_m, _| right_m.abs() < 3.0);
    assert!(overlap > 0.88, "{overlap}");
}

#[test]
fn a_texture_edge_alone_bounds_the_road() {
    let probability = first_frame(&|column, row, right_m, _| {
        if right_m.abs() < 3.0 { grey(90, 4, column, row) } else { grey(50, 90, column, row) }
    });
    let overlap = overlap(&probability, |right_m, _| right_m.abs() < 3.0);
    assert!(overlap > 0.75, "{overlap}");
}

#[test]
fn markings_neither_end_the_road_nor_leave_holes() {
    let probability = first_frame(&|column, row, right_m, ahead_m| {
        let is_line = right_m.abs() < 0.06 && ahead_m % 6.0 < 3.0 || (right_m - 2.6).abs() < 0.06;
        if is_line { [220; 3] } else { with_kerbs(column, row, right_m, 92) }
    });
    let overlap = overlap(&probability, |right_m, _| right_m.abs() < 3.0);
    assert!(overlap > 0.88, "{overlap}");
}

#[test]
fn a_side_road_is_reached_round_the_corner() {
    let in_side = |right_m: f64, ahead_m: f64| right_m > 3.0 && (8.0..13.0).contains(&ahead_m);
    let probability = first_frame(&|column, row, right_m, ahead_m| {
        if in_side(right_m, ahead_m) {
            grey(92, 4, column, row)
        } else {
            with_kerbs(column, row, right_m, 92)
        }
    });
    let row = HORIZON + (400.0 * 1.4 / 10.0) as usize;
    let column_at = |right_m: f64| (239.5 + right_m * 400.0 / 10.0) as usize;
    assert!(probability.row(row)[column_at(5.0)] > 200);
    assert!(probability.row(row)[column_at(-5.0)] < 128);
}

#[test]
fn a_shadow_is_road_once_the_vehicle_has_driven_through_one() {
    let mut detector = Online::new(&OnlineConfig::default());
    let scene = |shadow_m: f64| {
        street(&move |column, row, right_m, ahead_m| {
            let lit = with_kerbs(column, row, right_m, 92);
            let is_shaded = ahead_m > shadow_m && ahead_m < shadow_m + 6.0;
            // Half the light, a little bluer.
            let dimmed = |level: u8, share: f64| (f64::from(level) * share) as u8;
            if is_shaded { [dimmed(lit[0], 0.4), dimmed(lit[1], 0.4), dimmed(lit[2], 0.45)] } else { lit }
        })
    };
    let is_road = |right_m: f64, _: f64| right_m.abs() < 3.0;
    let before = overlap(&estimate(&mut detector, &scene(8.0)).0, is_road);
    let surfaces: Vec<usize> =
        (0..12).map(|step| estimate(&mut detector, &scene(8.0 - f64::from(step))).1.surfaces).collect();
    let after = overlap(&estimate(&mut detector, &scene(8.0)).0, is_road);
    assert!(after > 0.85 && after >= before, "{before}, then {after}");
    assert!(surfaces[0] == 1 && surfaces[11] >= 2, "{surfaces:?}");
}

#[test]
fn evidence_names_samples_and_weights_and_reset_forgets() {
    let picture = street(&|column, row, right_m, _| with_kerbs(column, row, right_m, 92));
    let mut detector = Online::new(&OnlineConfig::default());
    let (first, evidence) = estimate(&mut detector, &picture);
    assert_eq!((evidence.block_px, evidence.grid.0), ((2, 2), 240));
    assert!((evidence.horizon_row_px - HORIZON as f64).abs() < 1e-3);
    assert!(evidence.road_blocks > 1000 && evidence.other_blocks > 500 && evidence.founded == 1);
    assert!(evidence.other_rows_px.1 <= HORIZON + 1 && evidence.separation > 1.0);
    assert!((0.3..0.9).contains(&evidence.road_share));
    let (second, evidence) = estimate(&mut detector, &picture);
    assert_eq!(evidence.founded, 0);
    assert_eq!(second.row(300), first.row(300));
    detector.reset();
    assert_eq!(estimate(&mut detector, &picture).0.as_slice(), first.as_slice());
}

#[test]
fn odd_pictures_give_no_road_rather_than_a_panic() {
    for (width, height) in [(1, 1), (3, 500), (500, 3), (17, 16)] {
        let colour = RgbImage::new(width, height);
        let picture =
            GroundPicture { colour, ..GroundPicture::new(0, 0, HueSaturationBins { hue: 2, saturation: 2 }) };
        let validity = ValidityMask::all_seen(width, height);
        for horizon_row in [f64::NAN, -1e9, 0.0, 2.0, 1e9] {
            for sample in
                [Rect { x: 0, y: 0, width: 0, height: 0 }, Rect { x: width, y: height, width: 9, height: 9 }]
            {
                let perspective = Perspective::Camera { horizon_row };
                let input =
                    RoadInput { picture: &picture, validity: &validity, sample, perspective, motion: None };
                let mut probability = Plane::default();
                let evidence =
                    Online::new(&OnlineConfig::default()).estimate(input, &mut probability).unwrap();
                assert_eq!(evidence.sample_use, SampleUse::Unseen);
                assert!(probability.as_slice().iter().all(|&p| p == 0));
            }
        }
    }
}

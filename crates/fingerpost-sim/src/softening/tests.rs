use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};

use super::*;

fn softened(look: CameraLook, picture: RgbImage) -> RgbImage {
    let intrinsics = Intrinsics { fx: 40.0, fy: 40.0, cx: 31.5, cy: 23.5 };
    let camera = Camera::calibrated(64, 48, intrinsics, Distortion::None, Mount::level(1.5)).unwrap();
    Softening::new(&camera, &look).unwrap().applied(picture)
}

/// A white pixel on black.
fn dot(u: usize, v: usize) -> RgbImage {
    let mut picture = RgbImage::new(64, 48);
    picture.row_mut(v)[3 * u..3 * u + 3].fill(255);
    picture
}

fn lit(picture: &RgbImage) -> Vec<(usize, usize)> {
    let places = (0..48).flat_map(|v| (0..64).map(move |u| (u, v)));
    places.filter(|&(u, v)| picture.get(u, v).unwrap()[1] > 20).collect()
}

#[test]
fn motion_draws_a_place_away_from_the_vanishing_point_and_not_sideways() {
    let look = CameraLook { motion_blur: 0.15, ..CameraLook::PLAIN };
    let near = lit(&softened(look, dot(31, 45)));
    assert!(near.len() > 2 && near.iter().all(|&(u, v)| (30..=32).contains(&u) && v >= 45), "{near:?}");
    assert_eq!(lit(&softened(look, dot(32, 24))).len(), 1);
}

#[test]
fn defocus_keeps_the_light() {
    let soft = softened(CameraLook { defocus: 0.25, ..CameraLook::PLAIN }, dot(20, 20));
    let total: u32 = soft.as_slice().iter().map(|&level| u32::from(level)).sum();
    assert!((total as i32 - 3 * 255).abs() < 30, "{total}");
    assert_eq!(lit(&soft).len(), 5);
}

#[test]
fn compression_keeps_even_ground_and_takes_fine_detail() {
    let look = CameraLook { compression: 2.0, ..CameraLook::PLAIN };
    let even = RgbImage::from_vec(64, 48, vec![120; 64 * 48 * 3]).unwrap();
    assert!(softened(look, even).as_slice().iter().all(|&level| level.abs_diff(120) <= 2));
    let mut grain = RgbImage::new(64, 48);
    for (i, level) in grain.as_mut_slice().iter_mut().enumerate() {
        *level = if (i / 3 + i / (3 * 64)) % 2 == 0 { 115 } else { 125 };
    }
    assert!(softened(look, grain).as_slice().iter().all(|&level| level.abs_diff(120) <= 3));
}

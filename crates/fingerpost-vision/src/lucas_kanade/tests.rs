use proptest::prelude::*;

use super::*;
use crate::test_pictures::config;

/// A smooth texture, looked at from `shift` further right and down, with another brightness.
fn texture(width: usize, height: usize, shift: [f32; 2], brightness: f32) -> Plane<u8> {
    let mut plane = Plane::new(width, height, 0);
    for y in 0..height {
        for (x, pixel) in plane.row_mut(y).iter_mut().enumerate() {
            let (u, v) = (x as f32 + shift[0], y as f32 + shift[1]);
            let waves = libm::sinf(0.31 * u + 0.12 * v)
                + libm::cosf(0.23 * v - 0.17 * u)
                + libm::sinf(0.05 * u * 0.9 + 0.043 * v);
            *pixel = (120.0 + brightness + 35.0 * waves) as u8;
        }
    }
    plane
}

fn pyramid(plane: &Plane<u8>) -> GreyPyramid {
    let mut pyramid = GreyPyramid::default();
    let painted = pyramid.fill(plane.size(), 3, 16, |base| {
        base.clone_from(plane);
        Ok::<(), ()>(())
    });
    painted.unwrap();
    pyramid
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn a_moved_texture_is_found_and_every_path_gives_the_same_bytes(
        size in (90..170_usize, 90..150_usize),
        moved in (-9.0..9.0_f32, -7.0..7.0_f32),
        at in (0.3..0.7_f32, 0.3..0.7_f32),
        brightness in -20.0..20.0_f32,
    ) {
        let previous = pyramid(&texture(size.0, size.1, [0.0, 0.0], 0.0));
        let current = pyramid(&texture(size.0, size.1, [-moved.0, -moved.1], brightness));
        let from = [at.0 * size.0 as f32, at.1 * size.1 as f32];
        let tracker = LucasKanade::default();
        let tracks: Vec<Option<Track>> = CodePath::available()
            .map(|path| tracker.track_on(path, (&previous, &current), 0, from, [0.0, 0.0]))
            .collect();
        for track in &tracks {
            prop_assert_eq!(track, &tracks[0]);
        }
        let track = tracks[0].unwrap();
        let error = libm::hypotf(track.to[0] - from[0] - moved.0, track.to[1] - from[1] - moved.1);
        prop_assert!(error < 0.1, "{error} px off: {track:?}");
        prop_assert!(track.residual < 2.0, "{track:?}");
        let coarse = tracker.track(&previous, &current, 1, from, [0.0, 0.0]).unwrap();
        let error = libm::hypotf(coarse.to[0] - from[0] - moved.0, coarse.to[1] - from[1] - moved.1);
        prop_assert!(error < 0.25, "{error} px off at half the size");
    }

    #[test]
    fn nothing_panics_at_edges_and_without_texture(
        size in (1..60_usize, 1..60_usize), from in (-20.0..80.0_f32, -20.0..80.0_f32), guess in -100.0..100.0_f32,
    ) {
        let flat = pyramid(&Plane::new(size.0, size.1, 77));
        let waves = pyramid(&texture(size.0, size.1, [0.0, 0.0], 0.0));
        let tracker = LucasKanade::default();
        prop_assert_eq!(tracker.track(&flat, &flat, 0, [from.0, from.1], [0.0, 0.0]), None);
        let there = tracker.track(&waves, &waves, 0, [from.0, from.1], [guess, -guess]);
        prop_assert!(there.is_none_or(|track| track.to[0].is_finite() && track.to[1].is_finite()));
        prop_assert_eq!(tracker.track(&waves, &waves, 0, [f32::NAN, from.1], [0.0, 0.0]), None);
    }
}

/// Root mean square difference by the formula, with the mean slopes taken out: its minimum is where the window is found.
#[test]
fn the_place_found_is_where_the_windows_differ_least() {
    let (previous, current) = (texture(80, 70, [0.0, 0.0], 0.0), texture(80, 70, [-1.6, 0.7], 5.0));
    let track = LucasKanade::default()
        .track(&pyramid(&previous), &pyramid(&current), 0, [40.0, 35.0], [0.0, 0.0])
        .unwrap();
    let at = |plane: &Plane<u8>, u: f32, v: f32| -> f32 {
        let (x, y) = (u as usize, v as usize);
        let (right, lower) = (u - x as f32, v - y as f32);
        let row =
            |y: usize| f32::from(plane.row(y)[x]) * (1.0 - right) + f32::from(plane.row(y)[x + 1]) * right;
        row(y) * (1.0 - lower) + row(y + 1) * lower
    };
    let left_over = |to: [f32; 2]| {
        let mut differences = Vec::new();
        for dv in -6..=6 {
            for du in -6..=6 {
                let (du, dv) = (du as f32, dv as f32);
                differences.push(at(&current, to[0] + du, to[1] + dv) - at(&previous, 40.0 + du, 35.0 + dv));
            }
        }
        let mean = differences.iter().sum::<f32>() / differences.len() as f32;
        differences.iter().map(|d| (d - mean) * (d - mean)).sum::<f32>() / differences.len() as f32
    };
    let best = left_over(track.to);
    assert!((best.sqrt() - track.residual).abs() < 0.1, "{} against {}", best.sqrt(), track.residual);
    for [du, dv] in [[0.3, 0.0], [-0.3, 0.0], [0.0, 0.3], [0.0, -0.3]] {
        assert!(left_over([track.to[0] + du, track.to[1] + dv]) > best, "{track:?}");
    }
}

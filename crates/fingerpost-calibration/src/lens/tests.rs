//! Lenses that are known, from boards that they would show.

use fingerpost_geometry::Distortion;
use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::*;

const SIZE: (usize, usize) = (1280, 720);
const LENS: Intrinsics = Intrinsics { fx: 1157.0, fy: 1151.0, cx: 655.0, cy: 371.0 };
const BARREL: [f64; 5] = [-0.26, 0.08, -0.0004, 0.0006, -0.02];
/// Turns of the board that fix a lens, radians about the camera's axes.
const TURNS: [[f64; 3]; 6] =
    [[0.0, 0.0, 0.1], [0.6, 0.0, 0.0], [-0.6, 0.1, 0.2], [0.1, 0.6, 0.0], [0.0, -0.6, -0.2], [0.4, 0.4, 0.1]];
/// Where the board's middle is, metres.
const PLACES: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.4],
    [-0.12, 0.02, 0.45],
    [0.12, -0.05, 0.45],
    [-0.1, -0.06, 0.5],
    [0.1, 0.06, 0.4],
    [0.0, 0.03, 0.35],
];

/// Where a board of 9 x 6 corners, 25 mm apart, is when it is turned about its middle.
fn pose(turn: [f64; 3], place: [f64; 3]) -> Isometry3<f64> {
    Isometry3::new(Vector3::from(place), Vector3::from(turn)) * Isometry3::translation(-0.1, -0.0625, 0.0)
}

fn poses() -> Vec<Isometry3<f64>> {
    TURNS.into_iter().zip(PLACES).map(|(turn, place)| pose(turn, place)).collect()
}

fn board(lens: Intrinsics, coefficients: [f64; 5], camera_from_board: &Isometry3<f64>) -> Vec<BoardPoint> {
    let distortion = Distortion::brown_conrady(&coefficients).unwrap();
    let corners = (0..54).map(|i| Point2::new(f64::from(i % 9), f64::from(i / 9)) * 0.025);
    corners
        .map(|p_in_board| {
            let p = camera_from_board * Point3::new(p_in_board.x, p_in_board.y, 0.0);
            let bent = distortion.distort(p.coords).unwrap();
            let pixel = Pixel::new(lens.fx * bent.x + lens.cx, lens.fy * bent.y + lens.cy);
            BoardPoint { p_in_board, pixel }
        })
        .collect()
}

fn boards(lens: Intrinsics, coefficients: [f64; 5], poses: &[Isometry3<f64>]) -> Vec<Vec<BoardPoint>> {
    poses.iter().map(|pose| board(lens, coefficients, pose)).collect()
}

/// Moves points by up to `most_px` either way, the same at every call.
fn shake(boards: &mut [Vec<BoardPoint>], most_px: f64) {
    shake_from(&mut 1, boards, most_px);
}

/// Moves points by up to `most_px` either way, from a state of the generator that is left for the next call.
fn shake_from(state: &mut u64, boards: &mut [Vec<BoardPoint>], most_px: f64) {
    let mut next = || {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        most_px * ((*state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0)
    };
    for point in boards.iter_mut().flatten() {
        point.pixel = Pixel::new(point.pixel.u + next(), point.pixel.v + next());
    }
}

fn calibrate(boards: &[Vec<BoardPoint>]) -> Result<LensCalibration, LensCalibrationError> {
    calibrate_lens(boards, SIZE.0, SIZE.1)
}

#[test]
fn a_known_lens_and_known_poses_are_found() {
    let found = calibrate(&boards(LENS, BARREL, &poses())).unwrap();
    let k = found.intrinsics;
    // The principal point lies right of and below the picture's middle at (639.5, 359.5), and so it is found.
    for (value, expected) in [(k.fx, LENS.fx), (k.fy, LENS.fy), (k.cx, LENS.cx), (k.cy, LENS.cy)] {
        assert!((value - expected).abs() < 1e-4, "{k:?}");
    }
    assert!(found.coefficients[0] < 0.0, "a barrel's first coefficient is negative: {found:?}");
    for (value, expected) in found.coefficients.into_iter().zip(BARREL) {
        assert!((value - expected).abs() < 1e-5, "{found:?}");
    }
    for (outcome, expected) in found.boards.iter().zip(poses()) {
        let BoardOutcome::Used { camera_from_board, rms_px } = *outcome else { panic!("{outcome:?}") };
        assert!(rms_px < 1e-4);
        assert!((camera_from_board.translation.vector - expected.translation.vector).norm() < 1e-6);
        assert!(camera_from_board.rotation.angle_to(&expected.rotation) < 1e-6);
    }
    // Without noise there still is a standard deviation.
    assert!(found.intrinsics_sigma.fx > 0.0 && found.coefficients_sigma.iter().all(|&sigma| sigma > 0.0));
}

#[test]
fn a_pincushion_lens_has_a_positive_coefficient() {
    let found = calibrate(&boards(LENS, [0.15, 0.0, 0.0, 0.0, 0.0], &poses())).unwrap();
    assert!((found.coefficients[0] - 0.15).abs() < 1e-5, "{found:?}");
}

#[test]
fn errors_are_what_the_standard_deviations_say() {
    const ROUNDS: u32 = 200;
    let mut state = 1;
    let mut squares = [0.0; 5];
    for _ in 0..ROUNDS {
        let mut shaken = boards(LENS, BARREL, &poses());
        shake_from(&mut state, &mut shaken, 0.5);
        let found = calibrate(&shaken).unwrap();
        // Even noise between -0.5 and 0.5 pixels either way has a root mean square of 0.41; the fit takes up some of it.
        assert!((found.rms_px - 0.39).abs() < 0.05, "{}", found.rms_px);
        let (k, sigma) = (found.intrinsics, found.intrinsics_sigma);
        let errors = [
            (k.fx - LENS.fx) / sigma.fx,
            (k.fy - LENS.fy) / sigma.fy,
            (k.cx - LENS.cx) / sigma.cx,
            (k.cy - LENS.cy) / sigma.cy,
            (found.coefficients[0] - BARREL[0]) / found.coefficients_sigma[0],
        ];
        for (sum, error) in squares.iter_mut().zip(errors) {
            *sum += error * error;
        }
    }
    // Of 200 rounds, a root mean square that is 1 is known within 0.05.
    let rms = squares.map(|sum| (sum / f64::from(ROUNDS)).sqrt());
    assert!(rms.iter().all(|rms| (0.85..=1.15).contains(rms)), "of fx, fy, cx, cy and k1: {rms:?}");
}

#[test]
fn the_start_does_not_depend_on_the_unit_of_the_board() {
    let mut shaken = boards(LENS, BARREL, &poses());
    shake(&mut shaken, 0.5);
    let start = |square: f64| {
        let mut boards = shaken.clone();
        for point in boards.iter_mut().flatten() {
            point.p_in_board *= square / 0.025;
        }
        let views: Vec<_> = boards.iter().map(Vec::as_slice).collect();
        closed_form::start(&views, SIZE.0, SIZE.1).unwrap().intrinsics
    };
    let (small, large) = (start(0.001), start(1000.0));
    for (small, large) in
        [(small.fx, large.fx), (small.fy, large.fy), (small.cx, large.cx), (small.cy, large.cy)]
    {
        assert!((small / large - 1.0).abs() < 1e-6, "{small} {large}");
    }
}

#[test]
fn a_board_that_fits_far_worse_is_left_out() {
    let mut shaken = boards(LENS, BARREL, &poses());
    shake(&mut shaken, 0.3);
    // A bent board: its middle columns stand out.
    for point in &mut shaken[3] {
        let along = point.p_in_board.x / 0.2;
        point.pixel.v += 12.0 * along * (1.0 - along);
    }
    let found = calibrate(&shaken).unwrap();
    assert!(
        matches!(found.boards[3], BoardOutcome::LeftOut { rms_px, median_px } if rms_px > 3.0 * median_px)
    );
    let used = |outcome: &&BoardOutcome| matches!(outcome, BoardOutcome::Used { .. });
    assert_eq!(found.boards.iter().filter(used).count(), 5);
    assert!((found.intrinsics.fx - LENS.fx).abs() < 3.0 * found.intrinsics_sigma.fx, "{found:?}");
}

#[test]
fn boards_that_do_not_fix_a_lens_are_refused() {
    let two = boards(LENS, BARREL, &poses()[..2]);
    assert_eq!(calibrate(&two), Err(LensCalibrationError::TooFewBoards { found: 2, needed: 3 }));

    // Squarely in front of the camera, and all tilted alike: the focal length is anyone's guess.
    for turn in [[0.0, 0.0, 0.0], [0.5, 0.1, 0.0]] {
        let parallel: Vec<_> = PLACES.into_iter().map(|place| pose(turn, place)).collect();
        for most_px in [0.0, 0.3] {
            let mut boards = boards(LENS, BARREL, &parallel);
            shake(&mut boards, most_px);
            let refused = calibrate(&boards).unwrap_err();
            assert!(refused.to_string().contains("in different directions"), "{refused}");
        }
    }

    let mut line = boards(LENS, BARREL, &poses());
    line[1].truncate(9);
    assert_eq!(calibrate(&line), Err(LensCalibrationError::NoPlane { board: 1 }));
    let mut broken = boards(LENS, BARREL, &poses());
    broken[2][0].pixel.u = f64::NAN;
    assert_eq!(calibrate(&broken), Err(LensCalibrationError::NoPlane { board: 2 }));

    let mut contradicting = boards(LENS, BARREL, &poses());
    shake(&mut contradicting, 15.0);
    assert!(matches!(calibrate(&contradicting), Err(LensCalibrationError::PoorFit { .. })));
}

#[test]
fn any_lens_is_found_from_any_boards_that_fix_it() {
    let mut runner = TestRunner::new_with_rng(
        Config { cases: 64, failure_persistence: None, ..Config::default() },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    );
    let lens = (700.0..2500.0, 0.97..1.03, -60.0..60.0, -40.0..40.0);
    let distortion = (-0.3..0.15, -0.05..0.05, -0.002..0.002, -0.002..0.002);
    let turns = proptest::collection::vec((-0.1..0.1, -0.1..0.1, -3.0..3.0), TURNS.len());
    runner
        .run(&(lens, distortion, turns), |((fx, ratio, right, down), (k1, k2, p1, p2), turns)| {
            let lens = Intrinsics { fx, fy: ratio * fx, cx: 639.5 + right, cy: 359.5 + down };
            let poses: Vec<_> = TURNS
                .into_iter()
                .zip(PLACES)
                .zip(turns)
                .map(|((turn, [x, y, z]), (a, b, c))| {
                    // As large in the picture whatever the focal length, turned any way in its own plane.
                    let place = Vector3::new(x, y, z * fx / LENS.fx);
                    let tilt = nalgebra::Rotation3::new(Vector3::new(turn[0] + a, turn[1] + b, 0.0));
                    let turned = tilt * nalgebra::Rotation3::new(Vector3::new(0.0, 0.0, c));
                    Isometry3::from_parts(place.into(), turned.into())
                        * Isometry3::translation(-0.1, -0.0625, 0.0)
                })
                .collect();
            let found = calibrate(&boards(lens, [k1, k2, p1, p2, 0.0], &poses)).unwrap();
            prop_assert!(found.rms_px < 1e-4, "{:?}", found);
            prop_assert!((found.intrinsics.fx - fx).abs() < 1e-3 * fx, "{:?}", found);
            prop_assert!((found.intrinsics.cx - lens.cx).abs() < 0.5, "{:?}", found);
            prop_assert!((found.coefficients[0] - k1).abs() < 1e-2, "{:?}", found);
            Ok(())
        })
        .unwrap();
}

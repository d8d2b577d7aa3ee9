//! `calibrate chessboard` from outside: rendered boards, and pictures that are none.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use fingerpost_format::camera_from_toml;
use fingerpost_geometry::{Distortion, Intrinsics, View};
use fingerpost_io::write_png;
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Isometry3, Vector2, Vector3};
use tempfile::TempDir;

use crate::program::call_line;

const SIZE: (usize, usize) = (320, 240);
const LENS: Intrinsics = Intrinsics { fx: 280.0, fy: 276.0, cx: 165.0, cy: 115.0 };
const K1: f64 = -0.2;
/// Inner corners of the board.
const CORNERS: (i64, i64) = (7, 5);
const SQUARE_M: f64 = 0.03;
/// The boards' turns about the camera's axes, radians, and where their middles are, metres.
const BOARDS: [([f64; 3], [f64; 3]); 7] = [
    ([0.0, 0.0, 0.1], [0.0, 0.0, 0.36]),
    ([0.6, 0.0, 0.0], [-0.03, 0.0, 0.36]),
    ([-0.6, 0.1, 0.2], [0.03, -0.02, 0.38]),
    ([0.1, 0.6, 0.0], [-0.04, -0.03, 0.38]),
    ([0.0, -0.6, -0.2], [0.04, 0.03, 0.38]),
    ([0.4, 0.4, 0.1], [0.05, 0.02, 0.4]),
    ([-0.4, -0.4, 0.0], [-0.05, 0.03, 0.4]),
];

/// The lens's view of the board.
fn picture(turn: [f64; 3], place: [f64; 3]) -> RgbImage {
    picture_of(CORNERS, turn, place)
}

/// The lens's view of a board with so many inner corners: squares that are dark in every second place, on a light wall.
fn picture_of(corners: (i64, i64), turn: [f64; 3], place: [f64; 3]) -> RgbImage {
    const SAMPLES: usize = 36;
    const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
    /// A pixel's light comes from a pixel and a half, so that edges are as soft as a lens makes them.
    const REACH_PX: f64 = 0.75;
    let distortion = Distortion::brown_conrady(&[K1, 0.0, 0.0, 0.0]).unwrap();
    let board_from_camera = Isometry3::new(Vector3::from(place), Vector3::from(turn)).inverse();
    let ray = |u: f64, v: f64| {
        let bent = Vector2::new((u - LENS.cx) / LENS.fx, (v - LENS.cy) / LENS.fy);
        board_from_camera.rotation * distortion.undistort(bent).unwrap().into_inner()
    };
    let is_dark = |ray: Vector3<f64>| {
        let eye = board_from_camera.translation.vector;
        let seen = eye - ray * (eye.z / ray.z);
        let square = |place_m: f64, corners: i64| {
            let square = (place_m / SQUARE_M + 0.5 * (corners as f64 + 1.0)).floor() as i64;
            Some(square).filter(|square| (0..=corners).contains(square))
        };
        square(seen.x, corners.0).zip(square(seen.y, corners.1)).is_some_and(|(x, y)| (x + y) % 2 == 0)
    };
    let mut picture = RgbImage::new(SIZE.0, SIZE.1);
    for y in 0..SIZE.1 {
        for (x, pixel) in picture.row_mut(y).chunks_exact_mut(3).enumerate() {
            let (x, y) = (x as f64, y as f64);
            let [above, below] =
                [y - REACH_PX, y + REACH_PX].map(|v| [ray(x - REACH_PX, v), ray(x + REACH_PX, v)]);
            // A lattice by the golden ratio: no edge runs along a row of its samples.
            let dark = (0..SAMPLES).filter(|&i| {
                let (right, down) = ((i as f64 + 0.5) / SAMPLES as f64, (i as f64 / GOLDEN_RATIO).fract());
                is_dark(above[0].lerp(&above[1], right).lerp(&below[0].lerp(&below[1], right), down))
            });
            pixel.fill(220 - (180 * dark.count() / SAMPLES) as u8);
        }
    }
    picture
}

/// Seven boards, rendered when they are first asked for.
fn boards() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        for (i, (turn, place)) in BOARDS.into_iter().enumerate() {
            write_png(&folder.path().join(format!("board{i}.png")), &picture(turn, place)).unwrap();
        }
        folder
    });
    folder.path()
}

/// The command for all pictures of a folder.
fn line(folder: &Path, out: &Path) -> String {
    format!("calibrate chessboard {} --corners 7x5 --height-m 1.4 --out {}", folder.display(), out.display())
}

/// A folder with the named boards, as `0.png` and so on.
fn folder_of(boards_used: impl IntoIterator<Item = usize>) -> TempDir {
    let folder = TempDir::new().unwrap();
    for (i, board) in boards_used.into_iter().enumerate() {
        fs::copy(boards().join(format!("board{board}.png")), folder.path().join(format!("{i}.png"))).unwrap();
    }
    folder
}

#[test]
fn a_lens_is_found_from_rendered_boards() {
    let (folder, results) = (folder_of(0..BOARDS.len()), TempDir::new().unwrap());
    let out = results.path().join("camera.toml");
    write_png(&folder.path().join("wall.png"), &picture([0.0; 3], [3.0, 0.0, 0.4])).unwrap();
    write_png(&folder.path().join("half.png"), &picture([0.0; 3], [0.15, 0.0, 0.36])).unwrap();
    fs::write(folder.path().join("broken.png"), "no picture").unwrap();
    let done = call_line(&format!("{} --square-m {SQUARE_M} --json", line(folder.path(), &out))).done();
    for words in [
        "wall.png: no chessboard was found",
        "half.png: corners are cut off by the picture's edge",
        "broken.png",
        "neither PNG, JPEG nor binary PPM",
        "7 of 10 pictures",
        "calibrate mount",
    ] {
        assert!(done.stderr.contains(words), "{words:?} is not in: {}", done.stderr);
    }

    let camera = camera_from_toml(&fs::read_to_string(&out).unwrap()).unwrap();
    assert_eq!((camera.width(), camera.height()), SIZE);
    let View::Calibrated { intrinsics: k, distortion, mount, .. } = camera.view() else {
        panic!("{camera:?}")
    };
    assert!((k.fx - LENS.fx).abs() < 1.0 && (k.fy - LENS.fy).abs() < 1.0, "{k:?}");
    assert!((k.cx - LENS.cx).abs() < 1.0 && (k.cy - LENS.cy).abs() < 1.0, "{k:?}");
    assert!(
        matches!(distortion, Distortion::BrownConrady { coefficients, .. }
        if (coefficients[0] - K1).abs() < 0.03),
        "{distortion:?}"
    );
    assert!((mount.height_m - 1.4).abs() < 1e-12 && mount.pitch_rad.abs() < 1e-12, "{mount:?}");

    let told: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
    assert!(
        told["fx"]["sigma"].as_f64().unwrap() > 0.0
            && told["distortion"]["k1"]["value"].as_f64().unwrap() < 0.0
    );
    assert!(told["rms_px"].as_f64().unwrap() < 0.15, "{told}");
    let pictures = told["pictures"].as_array().unwrap();
    let used: Vec<_> = pictures.iter().filter(|picture| picture["used"] == true).collect();
    assert_eq!((pictures.len(), used.len()), (10, 7));
    // The second board is turned by 0.6 radians, and its first corner some 0.3 m away.
    assert!((used[1]["tilt_deg"].as_f64().unwrap() - 34.4).abs() < 1.0, "{}", used[1]);
    assert!((used[1]["distance_m"].as_f64().unwrap() - 0.35).abs() < 0.1, "{}", used[1]);
    let reasons = pictures.iter().filter(|picture| picture["used"] == false);
    assert!(reasons.clone().count() == 3 && reasons.clone().all(|picture| picture["reason"].is_string()));
}

#[test]
fn a_board_that_was_bent_is_named_and_left_out() {
    let (folder, results) = (folder_of(0..BOARDS.len()), TempDir::new().unwrap());
    let out = results.path().join("camera.toml");
    // A picture stretched in its lower half is one of no flat board.
    let whole = picture(BOARDS[0].0, BOARDS[0].1);
    let mut bent = RgbImage::new(SIZE.0, SIZE.1);
    for y in 0..SIZE.1 {
        let from = y - (y.saturating_sub(120)) / 4;
        bent.row_mut(y).copy_from_slice(whole.row(from));
    }
    write_png(&folder.path().join("bent.png"), &bent).unwrap();
    let done = call_line(&line(folder.path(), &out)).done();
    assert!(done.stderr.contains("bent.png: its corners are"), "{}", done.stderr);
    assert!(done.stderr.contains("7 of 8 pictures"), "{}", done.stderr);
}

#[test]
fn pictures_that_do_not_fix_a_lens_are_refused() {
    let results = TempDir::new().unwrap();
    let out = results.path().join("camera.toml");
    let refused = |folder: &Path, words: &[&str]| {
        let called = call_line(&line(folder, &out));
        called.refused(1, words);
        called.refused(1, &["nothing was written"]);
        assert!(!out.exists());
    };
    let two = folder_of([0, 1]);
    refused(two.path(), &["2 usable pictures", "at least 3", "take 10 to 20"]);
    // The same picture again is no other view.
    let again = format!("{} --corners", two.path().join("0.png").display());
    call_line(&line(two.path(), &out).replace("--corners", &again)).refused(1, &["2 usable pictures"]);

    // All boards face the camera squarely.
    let square = TempDir::new().unwrap();
    for (i, (x, z)) in [(0.0, 0.36), (0.03, 0.4), (-0.05, 0.45), (0.05, 0.5)].into_iter().enumerate() {
        write_png(&square.path().join(format!("{i}.png")), &picture([0.0; 3], [x, 0.0, z])).unwrap();
    }
    refused(square.path(), &["focal length", "tilt the board by 30 to 45 degrees in different directions"]);

    let mixed = folder_of(0..4);
    write_png(&mixed.path().join("small.png"), &RgbImage::new(160, 120)).unwrap();
    refused(
        mixed.path(),
        &["different sizes", "small.png has 160 x 120", "most have 320 x 240", "one setting"],
    );

    let broken = TempDir::new().unwrap();
    fs::write(broken.path().join("a.png"), "no picture").unwrap();
    refused(broken.path(), &["a.png", "no picture can be read"]);

    // Another number of corners: no picture shows such a board, and the one that they show is named.
    for corners in ["9x6", "8x5", "5x4", "6x9"] {
        let wrong = call_line(&line(folder_of(0..4).path(), &out).replace("7x5", corners));
        let named =
            format!("no picture shows a board of {corners} inner corners; one of 7x5 is seen in 4 of 4");
        wrong.refused(1, &[&named, "--corners 7x5", "nothing was written"]);
    }
    assert!(!out.exists());
}

#[test]
fn a_board_that_most_pictures_contradict_is_refused_and_the_one_they_show_is_named() {
    let results = TempDir::new().unwrap();
    let out = results.path().join("camera.toml");
    let shorter = |folder: &Path, boards: std::ops::Range<usize>| {
        for board in boards {
            let (turn, place) = BOARDS[board];
            write_png(&folder.join(format!("shorter{board}.png")), &picture_of((7, 4), turn, place)).unwrap();
        }
    };
    for (count, named) in [(1, "1 picture shows a board of 7x4"), (3, "3 pictures show a board of 7x4")] {
        let folder = folder_of(0..4);
        shorter(folder.path(), 0..count);
        let wrong = call_line(&line(folder.path(), &out).replace("7x5", "7x4"));
        let seen = format!("one of 7x5 is seen in 4 of {}", 4 + count);
        wrong.refused(1, &[named, &seen, "give --corners 7x5", "nothing was written"]);
        assert!(!out.exists());
    }
    // What few pictures show beside the board is left out.
    let folder = folder_of(0..BOARDS.len());
    shorter(folder.path(), 0..1);
    let done = call_line(&line(folder.path(), &out)).done();
    assert!(done.stderr.contains("7 of 8 pictures"), "{}", done.stderr);
}

/// A row and a column more than the other pictures, as some programs save them.
#[test]
fn a_size_that_is_a_pixel_off_is_used_and_said() {
    let (folder, results) = (folder_of(0..BOARDS.len()), TempDir::new().unwrap());
    let out = results.path().join("camera.toml");
    let whole = picture(BOARDS[2].0, BOARDS[2].1);
    let mut larger = RgbImage::new(SIZE.0 + 1, SIZE.1 + 1);
    for y in 0..=SIZE.1 {
        let row = whole.row(y.min(SIZE.1 - 1));
        larger.row_mut(y)[..row.len()].copy_from_slice(row);
    }
    write_png(&folder.path().join("2.png"), &larger).unwrap();
    let done = call_line(&line(folder.path(), &out)).done();
    assert!(
        done.stderr.contains("2.png has 321 x 241 pixels and is used as one of 320 x 240"),
        "{}",
        done.stderr
    );
    let camera = camera_from_toml(&fs::read_to_string(&out).unwrap()).unwrap();
    assert_eq!((camera.width(), camera.height()), SIZE);
}

#[test]
fn wrong_arguments_are_told() {
    let (folder, results) = (folder_of([0]), TempDir::new().unwrap());
    let out = results.path().join("camera.toml");
    let good = line(folder.path(), &out);
    call_line(&good.replace("7x5", "7")).refused(2, &["--corners", "COLUMNSxROWS"]);
    call_line(&good.replace("7x5", "2x5")).refused(2, &["--corners", "3 to 64"]);
    call_line(&good.replace("--height-m 1.4", "")).refused(2, &["--height-m"]);
    call_line(&good.replace("1.4", "140")).refused(2, &["--height-m", "0.05 to 20 metres"]);
    call_line(&format!("{good} --square-m 0")).refused(2, &["--square-m", "0.001 to 1 metres"]);
    call_line("calibrate chessboard --corners 9x6 --height-m 1 --out a.toml").refused(2, &["PICTURES"]);
    call_line(&line(Path::new("none.png"), &out)).refused(1, &["none.png", "check the path"]);
    let picture = folder.path().join("0.png");
    call_line(&line(&picture, &picture)).refused(1, &["0.png"]);
    call_line(&line(folder.path(), &picture)).refused(1, &["0.png"]);
    assert!(!out.exists() && picture.exists());
}

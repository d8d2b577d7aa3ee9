//! Lenses that are covered in part: the cover is found where it is, nothing is read out of it, and on no kind of day is what shows the
//! scene called covered.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost::camera_state::{CameraState, CameraWatch};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost_sim::{Conditions, RoadCourse, SimConfig, Simulator, windscreen_camera};
use fingerpost_vision::picture::RgbImage;

const FPS: f64 = 10.0;
const SPEED_MPS: f64 = 10.0;
/// The first frame of the simulated drive that is shown.
const FIRST: usize = 5;

fn simulator(camera: &Camera, conditions: &str) -> Simulator {
    let (graph, route) = RoadCourse::country(2, 400.0).roads().unwrap();
    let conditions = Conditions::named(conditions).unwrap();
    let config =
        SimConfig { seed: 2, conditions, cruise_speed_mps: SPEED_MPS, fps: FPS, ..SimConfig::default() };
    Simulator::new(&graph, &route, camera, &config).unwrap()
}

/// A camera so high above the road, looking so far down.
fn mounted(width: usize, height: usize, height_m: f64, pitch_deg: f64) -> Camera {
    let f = 0.8 * width as f64;
    let intrinsics =
        Intrinsics { fx: f, fy: f, cx: 0.5 * (width as f64 - 1.0), cy: 0.5 * (height as f64 - 1.0) };
    let mount = Mount {
        height_m,
        pitch_rad: pitch_deg.to_radians(),
        yaw_rad: 0.0,
        roll_rad: 0.0,
        x_m: 1.5,
        y_m: 0.0,
    };
    Camera::calibrated(width, height, intrinsics, Distortion::None, mount).unwrap()
}

fn cameras() -> [Camera; 4] {
    [
        windscreen_camera(320, 240).unwrap(),
        mounted(160, 120, 1.2, 6.0),
        mounted(256, 192, 2.2, 10.0),
        mounted(640, 480, 1.6, 3.0),
    ]
}

/// Whether a place of the picture is covered, by its column and row as shares of width and height.
type Part = fn(f64, f64) -> bool;
/// The grey level of a cover, by column, row and frame.
type Paint = fn(usize, usize, usize) -> u8;

const LOWER_THIRD: (&str, Part) = ("the lower third", |_, v| v >= 0.667);
const LEFT_HALF: (&str, Part) = ("the left half", |u, _| u < 0.5);
const RIGHT_HALF: (&str, Part) = ("the right half", |u, _| u >= 0.5);
const BONNET: (&str, Part) = ("a bonnet", |u, v| v >= 0.75 + 0.6 * (u - 0.5) * (u - 0.5));
const CORNER: (&str, Part) = ("a lower corner", |u, v| u >= 0.7 && v >= 0.65);
const UPPER_CORNER: (&str, Part) = ("an upper corner", |u, v| u < 0.3 && v < 0.3);
const PARTS: [(&str, Part); 6] = [LOWER_THIRD, LEFT_HALF, RIGHT_HALF, BONNET, CORNER, UPPER_CORNER];

const BLACK: Paint = |_, _, _| 0;
const BLACK_OF_A_VIDEO: Paint = |u, v, frame| 14 + ((u * 7 + v * 13 + frame * 5) % 5) as u8;
/// Blots of some pixels, with a level of noise.
const DIRT: Paint = |u, v, frame| {
    let blot = (u / 3).wrapping_mul(2_654_435_761) ^ (v / 3).wrapping_mul(40_503);
    60 + (blot % 97) as u8 + ((u + 3 * v + frame) % 2) as u8
};

fn painted(seen: &RgbImage, part: Part, paint: Paint, frame: usize) -> RgbImage {
    let mut picture = seen.clone();
    let (width, height) = seen.size();
    for v in 0..height {
        for (u, pixel) in picture.row_mut(v).chunks_exact_mut(3).enumerate() {
            if part(u as f64 / width as f64, v as f64 / height as f64) {
                pixel.fill(paint(u, v, frame));
            }
        }
    }
    picture
}

/// The shares of the covered and of the other pixels that are hidden; of those two blocks and more from the cover's edge.
fn hidden_shares(watch: &CameraWatch, (width, height): (usize, usize), part: Part) -> [f64; 2] {
    let (mut hidden, mut all) = ([0_usize; 2], [0_usize; 2]);
    let block = 8 * width.div_ceil(320);
    let is_covered = |u: usize, v: usize| part(u as f64 / width as f64, v as f64 / height as f64);
    for v in (0..height).step_by(4) {
        for u in (0..width).step_by(4) {
            let here = is_covered(u, v);
            let far = [(2 * block, 0), (0, 2 * block)].iter().any(|&(x, y)| {
                is_covered(u.saturating_sub(x), v.saturating_sub(y)) != here
                    || is_covered((u + x).min(width - 1), (v + y).min(height - 1)) != here
            });
            if !far {
                let index = usize::from(!here);
                all[index] += 1;
                hidden[index] += usize::from(watch.hidden().hides(u, v));
            }
        }
    }
    [0, 1].map(|index| hidden[index] as f64 / all[index].max(1) as f64)
}

#[test]
fn a_cover_is_found_where_it_is_and_forgotten_when_it_is_wiped_off() {
    for camera in cameras() {
        let simulator = simulator(&camera, "clear");
        let size = (camera.width(), camera.height());
        let frames: Vec<RgbImage> =
            (FIRST..FIRST + 100).map(|frame| simulator.frame(frame).picture).collect();
        let black = PARTS.map(|part| (part, BLACK)).into_iter();
        let of_video = [LOWER_THIRD, UPPER_CORNER].map(|part| (part, BLACK_OF_A_VIDEO));
        for ((name, part), paint) in black.chain(of_video).chain([(CORNER, DIRT)]) {
            let mut watch = CameraWatch::new(&camera);
            for (frame, seen) in frames.iter().enumerate() {
                // It comes on the way, and goes again.
                let is_covered = (10..70).contains(&frame);
                let picture = if is_covered { painted(seen, part, paint, frame) } else { seen.clone() };
                let share = watch.look_at(&picture, None).covered_share;
                if frame == 9 || frame == 99 {
                    assert!(share == 0.0, "{name} of {size:?}, frame {frame}: {share}");
                }
                if frame == 69 {
                    let [covered, other] = hidden_shares(&watch, size, part);
                    assert!(
                        covered > 0.9 && other < 0.02,
                        "{name} of {size:?}: {covered:.2} hidden, and {other:.2} of the rest"
                    );
                }
            }
        }
    }
}

/// What a drive of eight seconds behind a black part says.
#[derive(Debug, Default)]
struct Read {
    named_at: Option<usize>,
    /// Way by the camera from two seconds on, as a share of the true one, in frames that are not passed over.
    way_share: f64,
    passed_over_frames: usize,
    turned_frames: usize,
    /// Pixels of the ground view that are called seen and show the cover, from two seconds on.
    black_seen: usize,
}

fn read(camera: &Camera, simulator: &Simulator, frames: &[RgbImage], part: Part) -> Read {
    let mut pipeline = Pipeline::new(&Config::default(), camera, None, None).unwrap();
    let (mut read, mut true_m, mut seen_m) = (Read::default(), 0.0, 0.0);
    for (frame, seen) in frames.iter().enumerate() {
        let picture = painted(seen, part, BLACK, frame);
        let sensors = Sensors { dt_s: (frame > 0).then_some(1.0 / FPS), ..Sensors::default() };
        let (output, evidence) = pipeline.step(&picture, sensors, &mut |_| {}).unwrap();
        if output.camera.covered_share > 0.0 {
            read.named_at.get_or_insert(frame);
            assert!(output.why.contains("of the picture does not move"), "{}", output.why);
        }
        read.turned_frames += usize::from(output.mount.is_some_and(|mount| mount.fault.is_some()));
        if output.camera.state != CameraState::Clear {
            read.passed_over_frames += 1;
        } else if frame >= 20 {
            let (after, before) = (simulator.truth(frame + FIRST), simulator.truth(frame + FIRST - 1));
            true_m += libm::hypot(after.x_m - before.x_m, after.y_m - before.y_m);
            seen_m += output.motion.unwrap().previous_from_current.translation.x;
            let validity = evidence.validity.as_slice().iter();
            let colour = evidence.ground.colour.as_slice().chunks_exact(3);
            read.black_seen +=
                validity.zip(colour).filter(|(seen, rgb)| **seen != 0 && *rgb == [0; 3]).count();
        }
    }
    Read { way_share: seen_m / true_m, ..read }
}

#[test]
fn nothing_is_read_out_of_a_part_that_is_covered_from_the_start() {
    for camera in cameras() {
        let (simulator, size) = (simulator(&camera, "clear"), (camera.width(), camera.height()));
        let frames: Vec<RgbImage> = (FIRST..FIRST + 80).map(|frame| simulator.frame(frame).picture).collect();
        for (name, part) in PARTS {
            let read = read(&camera, &simulator, &frames, part);
            assert!(read.named_at.is_some_and(|frame| frame <= 15), "{name} of {size:?}: {read:?}");
            // What is left of the smallest picture's road is far ahead, and few rows high.
            let is_too_little = camera.width() < 200 && name == LOWER_THIRD.0;
            if is_too_little {
                assert!(read.passed_over_frames > 50, "{name} of {size:?}: {read:?}");
            } else {
                assert_eq!(read.passed_over_frames, 0, "{name} of {size:?}: {read:?}");
                assert!((read.way_share - 1.0).abs() < 0.05, "{name} of {size:?}: {read:?}");
            }
            assert_eq!((read.turned_frames, read.black_seen), (0, 0), "{name} of {size:?}: {read:?}");
        }
    }
}

#[test]
fn on_no_kind_of_day_is_what_shows_the_scene_called_covered() {
    // Dirt on the lens is what these two days have.
    for name in Conditions::names().iter().filter(|name| !["dirty_lens", "dust"].contains(name)) {
        for camera in cameras().iter().take(3) {
            let simulator = simulator(camera, name);
            let mut watch = CameraWatch::new(camera);
            for frame in 0..80 {
                let share =
                    watch.look_at(&simulator.frame(frame).picture, Some(SPEED_MPS / FPS)).covered_share;
                assert!(share == 0.0, "{name}, {} columns, frame {frame}: {share}", camera.width());
            }
        }
    }
}

#[test]
fn a_standing_vehicle_past_which_others_drive_covers_nothing() {
    let camera = windscreen_camera(320, 240).unwrap();
    let still = simulator(&camera, "clear").frame(5).picture;
    for driven_m in [None, Some(0.0)] {
        let mut watch = CameraWatch::new(&camera);
        for frame in 0..90 {
            // A van of a third of the picture's width, with windows and doors.
            let left = frame * 9 % 400;
            let mut picture = still.clone();
            for v in 60..200 {
                for u in left..(left + 100).min(camera.width()) {
                    let level = if ((u - left) / 9 + v / 11) % 2 == 0 { 210 } else { 70 };
                    picture.row_mut(v)[3 * u..3 * u + 3].fill(level);
                }
            }
            picture.row_mut(0)[0] = frame as u8;
            let share = watch.look_at(&picture, driven_m).covered_share;
            assert!(share == 0.0, "frame {frame}: {share}");
        }
    }
}

#[test]
fn frames_whose_road_ahead_is_covered_are_passed_over_until_it_is_wiped_off() {
    let camera = windscreen_camera(320, 240).unwrap();
    let simulator = simulator(&camera, "clear");
    // The first leaves the outer parts of the nearest road ahead, the others only what lies beside it.
    let parts: [(Part, CameraState); 3] = [
        (|u, v| (0.331..0.669).contains(&u) && v >= 0.467, CameraState::Clear),
        (|u, v| (0.188..0.812).contains(&u) && v >= 0.4, CameraState::NoContrast),
        (|u, v| (0.156..0.844).contains(&u) && v >= 0.4, CameraState::NoContrast),
    ];
    for (index, (part, state)) in parts.into_iter().enumerate() {
        let mut pipeline = Pipeline::new(&Config::default(), &camera, None, None).unwrap();
        for frame in 0..90 {
            let seen = simulator.frame(5 + frame).picture;
            let picture = if frame < 50 { painted(&seen, part, BLACK, frame) } else { seen };
            let sensors = Sensors { dt_s: (frame > 0).then_some(1.0 / FPS), ..Sensors::default() };
            let (output, evidence) = pipeline.step(&picture, sensors, &mut |_| {}).unwrap();
            if frame == 49 {
                let validity = evidence.validity.as_slice();
                let seen = validity.iter().filter(|&&seen| seen != 0).count() as f64 / validity.len() as f64;
                assert!(seen > 0.05, "{index}: {seen}");
                assert_eq!(output.camera.state, state, "{index}: {}", output.why);
            }
            if frame == 89 {
                assert_eq!(output.camera.state, CameraState::Clear, "{index}");
                assert!(output.motion.unwrap().quality > 0.3, "{index}: {:?}", output.motion);
            }
        }
    }
}

#[test]
fn a_cover_is_hidden_to_the_edge_of_a_picture_that_blocks_do_not_fill() {
    let parts: [(&str, Part); 2] = [("the bottom", |_, v| v >= 0.7), ("the right", |u, _| u >= 0.8)];
    for (width, height) in [(1241, 376), (650, 470)] {
        let camera = mounted(width, height, 1.4, 3.0);
        let simulator = simulator(&camera, "clear");
        let frames: Vec<RgbImage> = (FIRST..FIRST + 24).map(|frame| simulator.frame(frame).picture).collect();
        for (name, part) in parts {
            let mut watch = CameraWatch::new(&camera);
            for (frame, seen) in frames.iter().enumerate() {
                watch.look_at(&painted(seen, part, BLACK, frame), Some(SPEED_MPS / FPS));
            }
            let hidden = watch.hidden();
            for (u, v) in [(width - 1, height - 1), (width / 8, height - 1), (width - 1, height / 8)] {
                let is_covered = part(u as f64 / width as f64, v as f64 / height as f64);
                assert_eq!(hidden.hides(u, v), is_covered, "{name} of {width} x {height}, at {u}, {v}");
            }
        }
    }
}

//! Lenses that are covered in part: the cover is found where it is, nothing is read out of it, and on no kind of day is what shows the
//! scene called covered.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost::camera_state::{CameraState, CameraWatch};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_geometry::Camera;
use fingerpost_sim::{Conditions, RoadCourse, SimConfig, Simulator, windscreen_camera};
use fingerpost_vision::picture::RgbImage;

const FPS: f64 = 10.0;
const SIZE: (usize, usize) = (320, 240);

fn drive(conditions: &str) -> (Camera, Simulator) {
    let (graph, route) = RoadCourse::country(2, 400.0).roads().unwrap();
    let conditions = Conditions::named(conditions).unwrap();
    let config = SimConfig { seed: 2, conditions, cruise_speed_mps: 10.0, fps: FPS, ..SimConfig::default() };
    let camera = windscreen_camera(SIZE.0, SIZE.1).unwrap();
    let simulator = Simulator::new(&graph, &route, &camera, &config).unwrap();
    (camera, simulator)
}

/// Whether a pixel is covered, by its column and row.
type Part = fn(usize, usize) -> bool;
/// The grey level of a cover, by column, row and frame.
type Paint = fn(usize, usize, usize) -> u8;

const PARTS: [(&str, Part); 6] = [
    ("the lower third", |_, v| v >= 160),
    ("the left half", |u, _| u < 160),
    ("the right half", |u, _| u >= 160),
    ("the upper half", |_, v| v < 120),
    ("the lower half", |_, v| v >= 120),
    ("a lower corner", |u, v| u >= 200 && v >= 140),
];

const BLACK: Paint = |_, _, _| 0;
const BLACK_OF_A_VIDEO: Paint = |u, v, frame| 14 + ((u * 7 + v * 13 + frame * 5) % 5) as u8;
/// Blots of some pixels, with a level of noise.
const DIRT: Paint = |u, v, frame| {
    let blot = (u / 3).wrapping_mul(2_654_435_761) ^ (v / 3).wrapping_mul(40_503);
    60 + (blot % 97) as u8 + ((u + 3 * v + frame) % 2) as u8
};

fn painted(seen: &RgbImage, part: Part, paint: Paint, frame: usize) -> RgbImage {
    let mut picture = seen.clone();
    for v in 0..SIZE.1 {
        for (u, pixel) in picture.row_mut(v).chunks_exact_mut(3).enumerate() {
            if part(u, v) {
                pixel.fill(paint(u, v, frame));
            }
        }
    }
    picture
}

/// The shares of the covered and of the other pixels that are hidden; of those two blocks and more from the cover's edge.
fn hidden_shares(watch: &CameraWatch, part: Part) -> [f64; 2] {
    let (mut hidden, mut all) = ([0, 0], [0, 0]);
    for v in (0..SIZE.1).step_by(4) {
        for u in (0..SIZE.0).step_by(4) {
            let index = usize::from(!part(u, v));
            let far = [(16, 0), (0, 16)].iter().any(|&(x, y)| {
                part(u.saturating_sub(x), v.saturating_sub(y)) != part(u, v)
                    || part(u + x, v + y) != part(u, v)
            });
            if !far {
                all[index] += 1;
                hidden[index] += usize::from(watch.hidden().hides(u, v));
            }
        }
    }
    [0, 1].map(|index| hidden[index] as f64 / all[index] as f64)
}

#[test]
fn a_cover_is_found_where_it_is_and_forgotten_when_it_is_wiped_off() {
    let (camera, simulator) = drive("clear");
    let frames: Vec<RgbImage> = (5..75).map(|frame| simulator.frame(frame).picture).collect();
    let dirty: [(&str, Part); 3] = [PARTS[0], PARTS[5], ("a blot", |u, v| u < 90 && (130..200).contains(&v))];
    let black = PARTS.map(|part| (part, BLACK)).into_iter();
    let of_video = [(PARTS[0], BLACK_OF_A_VIDEO), (PARTS[3], BLACK_OF_A_VIDEO)];
    for ((name, part), paint) in black.chain(of_video).chain(dirty.map(|part| (part, DIRT))) {
        let mut watch = CameraWatch::new(&camera);
        for (frame, seen) in frames.iter().enumerate() {
            // It comes on the way, and goes again.
            let is_covered = (10..40).contains(&frame);
            let picture = if is_covered { painted(seen, part, paint, frame) } else { seen.clone() };
            watch.look_at(&picture);
            if frame == 9 || frame == 69 {
                assert!(watch.hidden().share() < 0.02, "{name}, frame {frame}: {}", watch.hidden().share());
            }
            if frame == 39 {
                let [covered, other] = hidden_shares(&watch, part);
                assert!(
                    covered > 0.8 && other < 0.05,
                    "{name}: {covered:.2} hidden, and {other:.2} of the rest"
                );
            }
        }
    }
}

#[test]
fn nothing_is_read_out_of_a_part_that_is_covered_from_the_start() {
    let (camera, simulator) = drive("clear");
    let place = |frame: usize| {
        let truth = simulator.truth(frame);
        (truth.x_m, truth.y_m)
    };
    for (name, part) in PARTS.into_iter().filter(|(name, _)| *name != "the lower half") {
        let mut pipeline = Pipeline::new(&Config::default(), &camera, None, None).unwrap();
        let (mut driven_m, mut seen_m) = (0.0, 0.0);
        for frame in 5..65 {
            let picture = painted(&simulator.frame(frame).picture, part, BLACK, frame);
            let sensors = Sensors { dt_s: (frame > 5).then_some(1.0 / FPS), ..Sensors::default() };
            let (output, evidence) = pipeline.step(&picture, sensors, &mut |_| {}).unwrap();
            assert_eq!(output.camera.state, CameraState::Clear, "{name}, frame {frame}");
            if frame >= 25 {
                assert!(output.why.contains("of the picture does not move"), "{name}: {}", output.why);
                assert!(
                    output.mount.is_none_or(|mount| mount.fault.is_none()),
                    "{name}, frame {frame}: {}",
                    output.why
                );
                let (after, before) = (place(frame), place(frame - 1));
                driven_m += libm::hypot(after.0 - before.0, after.1 - before.1);
                seen_m += output.motion.unwrap().previous_from_current.translation.x;
                // No pixel of the ground view that is called seen is of the cover.
                let (columns, rows) = evidence.validity.size();
                let black = (0..rows * columns).filter(|&at| {
                    evidence.validity.as_slice()[at] != 0
                        && evidence.ground.colour.as_slice()[3 * at..3 * at + 3] == [0; 3]
                });
                assert_eq!(black.count(), 0, "{name}, frame {frame}");
            }
        }
        assert!((seen_m / driven_m - 1.0).abs() < 0.05, "{name}: {seen_m:.1} of {driven_m:.1} m");
    }
}

#[test]
fn frames_whose_road_ahead_is_covered_are_passed_over_until_it_is_wiped_off() {
    let (camera, simulator) = drive("clear");
    // The first leaves the outer parts of the nearest road ahead, the others only what lies beside it.
    let parts: [(Part, CameraState); 3] = [
        (|u, v| (106..214).contains(&u) && v >= 112, CameraState::Clear),
        (|u, v| (60..260).contains(&u) && v >= 96, CameraState::NoContrast),
        (|u, v| (50..270).contains(&u) && v >= 96, CameraState::NoContrast),
    ];
    for (index, (part, state)) in parts.into_iter().enumerate() {
        let mut pipeline = Pipeline::new(&Config::default(), &camera, None, None).unwrap();
        for frame in 0..60 {
            let seen = simulator.frame(5 + frame).picture;
            let picture = if frame < 30 { painted(&seen, part, BLACK, frame) } else { seen };
            let sensors = Sensors { dt_s: (frame > 0).then_some(1.0 / FPS), ..Sensors::default() };
            let (output, evidence) = pipeline.step(&picture, sensors, &mut |_| {}).unwrap();
            if frame == 29 {
                let validity = evidence.validity.as_slice();
                let seen = validity.iter().filter(|&&seen| seen != 0).count() as f64 / validity.len() as f64;
                assert!(seen > 0.05, "{index}: {seen}");
                assert_eq!(output.camera.state, state, "{index}: {}", output.why);
            }
            if frame == 59 {
                assert_eq!(output.camera.state, CameraState::Clear, "{index}");
                assert!(output.motion.unwrap().quality > 0.3, "{index}: {:?}", output.motion);
            }
        }
    }
}

#[test]
fn on_no_kind_of_day_is_what_shows_the_scene_called_covered() {
    // Dirt on the lens is what these two days have.
    for name in Conditions::names().iter().filter(|name| !["dirty_lens", "dust"].contains(name)) {
        let (camera, simulator) = drive(name);
        let mut watch = CameraWatch::new(&camera);
        for frame in 0..40 {
            let share = watch.look_at(&simulator.frame(frame).picture).covered_share;
            assert!(share == 0.0, "{name}, frame {frame}: {share}");
        }
    }
}

#[test]
fn a_standing_vehicle_past_which_others_drive_covers_nothing() {
    let (camera, simulator) = drive("clear");
    let still = simulator.frame(5).picture;
    let mut watch = CameraWatch::new(&camera);
    for frame in 0..90 {
        // A van of a third of the picture's width, with windows and doors.
        let left = frame * 9 % 400;
        let mut picture = still.clone();
        for v in 60..200 {
            for u in left..(left + 100).min(SIZE.0) {
                let level = if ((u - left) / 9 + v / 11) % 2 == 0 { 210 } else { 70 };
                picture.row_mut(v)[3 * u..3 * u + 3].fill(level);
            }
        }
        picture.row_mut(0)[0] = frame as u8;
        let share = watch.look_at(&picture).covered_share;
        assert!(share == 0.0, "frame {frame}: {share}");
    }
}

#[test]
fn a_cover_is_hidden_to_the_edge_of_a_picture_that_blocks_do_not_fill() {
    let bottom: Part = |_, v| v >= 300;
    let right: Part = |u, _| u >= 500;
    for (width, height) in [(1241, 376), (650, 470)] {
        for (name, part) in [("the bottom", bottom), ("the right", right)] {
            let mut watch = CameraWatch::default();
            for frame in 0..24 {
                // Spots that go by.
                let mut data = Vec::with_capacity(3 * width * height);
                for (v, u) in (0..height).flat_map(|v| (0..width).map(move |u| (v, u))) {
                    let spot = ((u + 9 * frame) / 12).wrapping_mul(2_654_435_761)
                        ^ ((v + 5 * frame) / 12).wrapping_mul(40_503);
                    data.extend([if part(u, v) { 0 } else { 100 + (spot % 97) as u8 }; 3]);
                }
                watch.look_at(&RgbImage::from_vec(width, height, data).unwrap());
            }
            let hidden = watch.hidden();
            for (u, v) in [(width - 1, height - 1), (width / 8, height - 1), (width - 1, height / 8)] {
                assert_eq!(hidden.hides(u, v), part(u, v), "{name} of {width} x {height}, at {u}, {v}");
            }
        }
    }
}

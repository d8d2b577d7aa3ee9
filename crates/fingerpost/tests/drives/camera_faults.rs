//! Cameras that show nothing: faults of every kind at random moments of simulated drives are named and nothing is read out
//! of them; and on no kind of day is a camera that sees called blind.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost::camera_state::{CameraState, CameraWatch};
use fingerpost::lanes::Side;
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_geometry::Camera;
use fingerpost_map::read_route;
use fingerpost_sim::{Conditions, RoadCourse, SimConfig, Simulator, windscreen_camera};
use fingerpost_vision::picture::RgbImage;

const FPS: f64 = 10.0;

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

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    /// About normal, of standard deviation 1.
    fn normal(&mut self) -> f64 {
        (0..4).map(|_| (self.next() >> 11) as f64 / (1_u64 << 53) as f64).sum::<f64>() * 1.732 - 3.464
    }
}

/// What is wrong with a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Black,
    BlackWithNoise,
    /// A hand or a cap: dim, darker towards the edge.
    Cover,
    /// Drops or frost all over the lens.
    Fogged,
    White,
    Noise,
    Frozen,
}

const FAULTS: [Fault; 7] = [
    Fault::Black,
    Fault::BlackWithNoise,
    Fault::Cover,
    Fault::Fogged,
    Fault::White,
    Fault::Noise,
    Fault::Frozen,
];

impl Fault {
    fn state(self) -> CameraState {
        match self {
            Self::Black | Self::BlackWithNoise => CameraState::Black,
            Self::Cover | Self::Fogged | Self::White | Self::Noise => CameraState::NoContrast,
            Self::Frozen => CameraState::Frozen,
        }
    }

    /// The picture that comes in place of `seen`, behind `last`.
    fn picture(self, seen: &RgbImage, last: &RgbImage, random: &mut Random) -> RgbImage {
        let (width, height) = seen.size();
        let mut painted = |level: &dyn Fn(f64, f64) -> f64, noise: f64| {
            let mut data = Vec::with_capacity(3 * width * height);
            for y in 0..height {
                for x in 0..width {
                    let level = level(x as f64 / width as f64 - 0.5, y as f64 / height as f64 - 0.5);
                    data.extend([(level + noise * random.normal()).round().clamp(0.0, 255.0) as u8; 3]);
                }
            }
            RgbImage::from_vec(width, height, data).unwrap()
        };
        match self {
            Self::Black => painted(&|_, _| 0.0, 0.0),
            Self::BlackWithNoise => painted(&|_, _| 4.0, 3.0),
            Self::Cover => painted(&|x, y| 70.0 - 110.0 * (x * x + y * y), 2.0),
            Self::Fogged => painted(&|_, y| 190.0 - 25.0 * y, 1.0),
            Self::White => painted(&|_, _| 255.0, 1.0),
            Self::Noise => painted(&|_, _| 128.0, 60.0),
            Self::Frozen => last.clone(),
        }
    }
}

/// A drive that keeps to its lane.
fn drive_on_lane(seed: u64) -> (Camera, Simulator) {
    let (graph, route) = RoadCourse::country(seed, 600.0).roads().unwrap();
    let conditions = Conditions::named("lane_continuous").unwrap();
    let config = SimConfig { seed, conditions, cruise_speed_mps: 15.0, fps: FPS, ..SimConfig::default() };
    let camera = windscreen_camera(400, 300).unwrap();
    let simulator = Simulator::new(&graph, &route, &camera, &config).unwrap();
    (camera, simulator)
}

/// Asserts that a frame without sight says so and nothing else.
fn assert_silent(output: &FrameOutput, fault: Fault, frame: usize) {
    assert_eq!(output.camera.state, fault.state(), "{fault:?}, frame {frame}: {:?}", output.camera);
    assert_eq!(output.motion.map(|motion| motion.quality), Some(0.0), "{fault:?}, frame {frame}");
    assert!(output.lane.is_none() && output.departure.is_none(), "{fault:?}, frame {frame}");
    assert!(output.track.followed.is_none() && output.driving_line.is_empty(), "{fault:?}, frame {frame}");
    assert!(output.centreline.is_none() && output.why.starts_with("the camera "), "{}", output.why);
}

#[test]
fn a_camera_that_fails_on_the_way_is_named_and_nothing_is_read_out_of_it() {
    let mut random = Random(19);
    let (camera, simulator) = drive_on_lane(1);
    let drive: Vec<RgbImage> = (0..90).map(|frame| simulator.frame(frame).picture).collect();
    for fault in FAULTS {
        let mut pipeline = Pipeline::new(&Config::default(), &camera, None, None).unwrap();
        let mut last = RgbImage::new(400, 300);
        // Twice for 1 to 12 frames, with sight before and between.
        let mut blind = Vec::new();
        for from in [25, 55] {
            let start = from + random.below(8) as usize;
            blind.extend(start..start + 1 + random.below(12) as usize);
        }
        let mut lanes = [0, 0];
        for (frame, seen) in drive.iter().enumerate() {
            let is_blind = blind.contains(&frame);
            let picture = if is_blind { fault.picture(seen, &last, &mut random) } else { seen.clone() };
            let sensors = Sensors { dt_s: (frame > 0).then_some(1.0 / FPS), ..Sensors::default() };
            let (output, _) = pipeline.step(&picture, sensors, &mut |_| {}).unwrap();
            last = picture;
            if is_blind {
                assert_silent(output, fault, frame);
                continue;
            }
            assert_eq!(output.camera.state, CameraState::Clear, "{fault:?}, frame {frame}");
            let departure = output.departure.as_ref();
            assert!(
                departure.is_none_or(|departure| departure.warning.is_none()),
                "{fault:?}, frame {frame}"
            );
            let has_lane = output
                .lane
                .as_ref()
                .is_some_and(|lane| Side::BOTH.iter().any(|side| lane.edge(*side).is_some()));
            lanes[usize::from(frame >= 80)] += usize::from(has_lane);
        }
        assert!(lanes[0] > 20 && lanes[1] == 10, "{fault:?}: the lane comes back, {lanes:?}");
    }
}

#[test]
fn a_camera_that_is_blind_from_the_start_finds_nothing() {
    let route = read_route(include_str!("../../../fingerpost-sim/assets/town_route.geojson")).unwrap();
    for fault in FAULTS {
        let (camera, simulator) = drive_on_lane(3);
        let mut pipeline = Pipeline::new(&Config::default(), &camera, Some(&route), Some(0.0)).unwrap();
        let mut random = Random(7);
        let still = simulator.frame(0).picture;
        for frame in 0..30 {
            let picture = fault.picture(&still, &still, &mut random);
            let sensors = Sensors { dt_s: (frame > 0).then_some(1.0 / FPS), ..Sensors::default() };
            let (output, _) = pipeline.step(&picture, sensors, &mut |_| {}).unwrap();
            if frame > 0 || fault != Fault::Frozen {
                assert_silent(output, fault, frame);
            }
        }
    }
}

#[test]
fn on_no_kind_of_day_is_a_camera_that_sees_called_blind() {
    let (graph, route) = RoadCourse::country(1, 200.0).roads().unwrap();
    let camera = windscreen_camera(320, 240).unwrap();
    for name in Conditions::names() {
        let config = SimConfig { conditions: Conditions::named(name).unwrap(), ..SimConfig::default() };
        let simulator = Simulator::new(&graph, &route, &camera, &config).unwrap();
        let mut watch = CameraWatch::default();
        for frame in 10..12 {
            let evidence = watch.look_at(&simulator.frame(frame).picture);
            assert_eq!(evidence.state, CameraState::Clear, "{name}, frame {frame}: {evidence:?}");
            assert!(evidence.contrast > 1.3 * evidence.needed_contrast, "{name}: {evidence:?}");
        }
    }
}

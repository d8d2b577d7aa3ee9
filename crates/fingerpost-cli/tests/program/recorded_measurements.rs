//! `convert`: measurements of recordings whose clocks and frames are not those of the pictures.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use fingerpost_format::parse_motion_log;
use tempfile::TempDir;

use crate::program::{Called, call_line};

/// When the first picture was taken, seconds, and how many follow, ten a second.
const BEGIN_S: f64 = 1_700_000_000.0;
const PICTURES: usize = 21;

/// A message of CDR: texts and numbers in their order, each at a multiple of its size.
struct Cdr(Vec<u8>);

impl Cdr {
    /// Begins with a header.
    fn stamped(at_s: f64, frame_id: &str) -> Self {
        let seconds = at_s.floor();
        let nanoseconds = ((at_s - seconds) * 1e9) as u32;
        Self(vec![0, 1, 0, 0])
            .number((seconds as i32).to_le_bytes())
            .number(nanoseconds.to_le_bytes())
            .text(frame_id)
    }

    fn number<const N: usize>(mut self, bytes: [u8; N]) -> Self {
        self.0.resize(4 + (self.0.len() - 4).next_multiple_of(N), 0);
        self.0.extend(bytes);
        self
    }

    fn text(self, text: &str) -> Self {
        let mut with_length = self.number((text.len() as u32 + 1).to_le_bytes());
        with_length.0.extend(text.bytes().chain([0]));
        with_length
    }

    fn doubles(self, values: &[f64]) -> Self {
        values.iter().fold(self, |cdr, value| cdr.number(value.to_le_bytes()))
    }
}

fn image(at_s: f64) -> Vec<u8> {
    let (width, height) = (32_u32, 24_u32);
    let cdr = Cdr::stamped(at_s, "camera").number(height.to_le_bytes()).number(width.to_le_bytes());
    let cdr = cdr.text("rgb8").number([0]).number((3 * width).to_le_bytes());
    let mut cdr = cdr.number((3 * width * height).to_le_bytes()).0;
    cdr.resize(cdr.len() + (3 * width * height) as usize, 90);
    cdr
}

fn camera_info() -> Vec<u8> {
    let cdr = Cdr::stamped(BEGIN_S, "camera").number(24_u32.to_le_bytes()).number(32_u32.to_le_bytes());
    let cdr = cdr.text("plumb_bob").number(0_u32.to_le_bytes());
    let cdr = cdr.doubles(&[30.0, 0.0, 15.5, 0.0, 30.0, 11.5, 0.0, 0.0, 1.0]);
    cdr.doubles(&[0.0; 21]).number([0; 4]).number([0; 4]).number([0; 16]).0
}

fn twist(at_s: f64, frame_id: &str) -> Vec<u8> {
    Cdr::stamped(at_s, frame_id).doubles(&[8.0, 0.0, 0.0, 0.0, 0.0, 0.3]).0
}

fn unit(at_s: f64) -> Vec<u8> {
    let cdr = Cdr::stamped(at_s, "base_link").doubles(&[0.0; 13]).doubles(&[0.0, 0.0, -0.1]);
    cdr.doubles(&[0.0; 9]).doubles(&[0.0, 0.0, 9.8]).doubles(&[0.0; 9]).0
}

fn position(at_s: f64) -> Vec<u8> {
    Cdr::stamped(at_s, "gps").number([0]).number(1_u16.to_le_bytes()).doubles(&[47.2, 9.5, 440.0]).0
}

/// A recording with pictures, their calibration, and these messages beside: topic, schema, and each message.
fn recording(path: &Path, beside: &[(&str, &str, Vec<Vec<u8>>)]) {
    let mut writer = mcap::WriteOptions::new().create(fs::File::create(path).unwrap()).unwrap();
    let images = (0..PICTURES).map(|i| image(BEGIN_S + 0.1 * i as f64)).collect();
    let camera = [
        ("/image", "sensor_msgs/msg/Image", images),
        ("/camera_info", "sensor_msgs/msg/CameraInfo", vec![camera_info()]),
    ];
    for (topic, schema, messages) in camera.iter().chain(beside) {
        let schema_id = writer.add_schema(schema, "ros2msg", b"").unwrap();
        let channel_id = writer.add_channel(schema_id, topic, "cdr", &BTreeMap::new()).unwrap();
        for message in messages {
            let header =
                mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 1, publish_time: 1 };
            writer.write_to_known_channel(&header, message).unwrap();
        }
    }
    writer.finish().unwrap();
}

/// The drive of such a recording, and what was said.
fn converted(beside: &[(&str, &str, Vec<Vec<u8>>)]) -> (TempDir, PathBuf, Called) {
    let work = TempDir::new().unwrap();
    let (path, out) = (work.path().join("drive.mcap"), work.path().join("drive"));
    recording(&path, beside);
    let line = format!("convert mcap {} --height-m 1.5 --out {} --json", path.display(), out.display());
    let called = call_line(&line).done();
    (work, out, called)
}

fn times(count: usize, per_second: f64, off_s: f64) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| BEGIN_S + i as f64 / per_second + off_s)
}

const TWIST: &str = "geometry_msgs/msg/TwistStamped";
const IMU: &str = "sensor_msgs/msg/Imu";
const FIX: &str = "sensor_msgs/msg/NavSatFix";

/// Hours ahead and behind, as time zones and clocks that were never set are.
const OFF_S: [f64; 4] = [3600.0, -7200.0, 50_000.0, -1_699_999_000.0];

#[test]
fn positions_of_another_clock_are_said_and_not_used() {
    for off_s in OFF_S {
        let fixes = times(3, 1.0, off_s).map(position).collect();
        let (_work, out, called) = converted(&[("/fix", FIX, fixes)]);
        assert!(!out.join("gps.gpx").exists());
        for words in ["none of the 3 GPS positions of /fix", "another one"] {
            assert!(called.stderr.contains(words), "{off_s}: {}", called.stderr);
        }
    }
    let fixes = times(5, 1.0, -1.0).map(position).collect();
    let (_work, out, called) = converted(&[("/fix", FIX, fixes)]);
    assert!(
        out.join("gps.gpx").exists() && called.stdout.contains("\"gps_positions\":3"),
        "{}",
        called.stdout
    );
    assert!(called.stderr.contains("2 of the 5 GPS positions of /fix"), "{}", called.stderr);
}

#[test]
fn an_inertial_unit_of_another_clock_is_said_and_not_used() {
    let yaw_rates = |off_s: f64| {
        let twists = times(21, 10.0, 0.0).map(|at_s| twist(at_s, "base_link")).collect();
        let units = times(200, 100.0, off_s).map(unit).collect();
        let (_work, out, called) = converted(&[("/twist", TWIST, twists), ("/imu", IMU, units)]);
        let motion = parse_motion_log(&fs::read_to_string(out.join("motion.csv")).unwrap()).unwrap();
        (motion.rows.iter().map(|row| row.yaw_rate_rps).collect::<Vec<_>>(), called.stderr)
    };
    for off_s in OFF_S {
        let (rates, said) = yaw_rates(off_s);
        assert!(rates.iter().all(|rate| (rate - 0.3).abs() < 1e-9), "{off_s}: {rates:?}");
        assert!(said.contains("none of the 200 inertial measurements of /imu"), "{said}");
    }
    let (rates, said) = yaw_rates(0.0);
    assert!(rates.iter().all(|rate| (rate + 0.1).abs() < 1e-9), "{rates:?}");
    assert!(!said.contains("inertial measurements of /imu are"), "{said}");
}

#[test]
fn a_twist_of_another_clock_or_frame_is_said() {
    for off_s in OFF_S {
        let twists = times(21, 10.0, off_s).map(|at_s| twist(at_s, "base_link")).collect();
        let (_work, out, called) = converted(&[("/twist", TWIST, twists)]);
        assert!(!out.join("motion.csv").exists());
        assert!(called.stderr.contains("none of the 21 twists of /twist"), "{}", called.stderr);
    }
    let twists = times(21, 10.0, 0.0).map(|at_s| twist(at_s, "gps_antenna")).collect();
    let (_work, out, called) = converted(&[("/twist", TWIST, twists)]);
    assert!(out.join("motion.csv").exists());
    for words in ["21 messages of /twist in frame \"gps_antenna\"", "taken for the vehicle's", "/tf_static"] {
        assert!(called.stderr.contains(words), "{}", called.stderr);
    }
}

#[test]
fn names_of_frames_that_no_frame_has_cost_their_message() {
    let long = "f".repeat(256);
    let twists = times(21, 10.0, 0.0)
        .enumerate()
        .map(|(i, at_s)| twist(at_s, if i % 2 == 0 { &long } else { "base_link" }));
    let (_work, _out, called) = converted(&[("/twist", TWIST, twists.collect())]);
    assert!(called.stdout.contains("\"passed_over\":11"), "{}", called.stdout);
    assert!(
        called.stderr.contains("11 messages of ") && called.stderr.contains("256 bytes"),
        "{}",
        called.stderr
    );
}

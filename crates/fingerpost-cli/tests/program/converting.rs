//! `convert`: drives out of others' recordings.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use fingerpost_format::{camera_from_toml, parse_motion_log, parse_pose_log};
use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::program::{Called, call_line, frames};

/// A KITTI raw drive, or without `oxts` an odometry sequence, made of the pictures of the shared drive.
fn kitti(folder: &Path, pictures: &Path, is_raw: bool) -> std::path::PathBuf {
    let sequence = folder.join("2011_09_26_drive_0009_sync");
    let images = sequence.join(if is_raw { "image_02/data" } else { "image_2" });
    fs::create_dir_all(&images).unwrap();
    let mut names: Vec<_> = fs::read_dir(pictures).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    let (mut stamps, mut times) = (String::new(), String::new());
    for (i, path) in names.iter().take(5).enumerate() {
        fs::copy(path, images.join(format!("{i:010}.jpg"))).unwrap();
        stamps += &format!("2011-09-26 13:59:59.{}00000000\n", i + 5);
        times += &format!("{:e}\n", 0.1 * i as f64);
    }
    let matrix = "2.1e+02 0 1.595e+02 4.4e+01 0 2.1e+02 1.195e+02 2.1e-01 0 0 1 2.7e-03";
    if is_raw {
        fs::write(
            folder.join("calib_cam_to_cam.txt"),
            format!("S_rect_02: 6.4e+02 4.8e+02\nP_rect_02: {matrix}\n"),
        )
        .unwrap();
        fs::write(sequence.join("image_02/timestamps.txt"), &stamps).unwrap();
        let oxts = sequence.join("oxts");
        fs::create_dir_all(oxts.join("data")).unwrap();
        // The unit is 30 ms behind the camera, so that its last line is after the last picture.
        fs::write(oxts.join("timestamps.txt"), stamps.replace("00000000\n", "30000000\n")).unwrap();
        for i in 0..5 {
            let mut numbers = [0.0; 30];
            (numbers[0], numbers[1], numbers[5]) = (49.0 + 1e-5 * f64::from(i), 8.4, -1.25);
            (numbers[8], numbers[22]) = (8.0 + f64::from(i), 0.125);
            let line = numbers.map(|number| number.to_string()).join(" ");
            fs::write(oxts.join(format!("data/{i:010}.txt")), line).unwrap();
        }
    } else {
        fs::write(sequence.join("calib.txt"), format!("P0: {matrix}\nP2: {matrix}\n")).unwrap();
        fs::write(sequence.join("times.txt"), times).unwrap();
    }
    sequence
}

fn convert(line: &str, out: &Path) -> Called {
    call_line(&format!("convert {line} --out {} --json", out.display()))
}

#[test]
fn a_runs_own_recording_becomes_a_drive_again() {
    let drive = Drive::get();
    let (run, out, again) = (TempDir::new().unwrap(), TempDir::new().unwrap(), TempDir::new().unwrap());
    call_line(&drive.run_line(&drive.path(), run.path())).done();
    let recording = run.path().join("run.mcap");
    let line = format!("mcap {} --height-m 1.5", recording.display());
    convert(&line, out.path()).refused(1, &["/camera/image", "/ground_view/image", "--image-topic"]);
    let converted = convert(&format!("{line} --image-topic /camera/image"), out.path()).done();
    let facts: serde_json::Value = serde_json::from_str(&converted.stdout).unwrap();
    assert_eq!(facts["frames"], FRAMES);
    assert_eq!(facts["passed_over"], 0);

    // The pictures were packed anew, so what is found is nearly the same.
    let camera = out.path().join("camera.toml");
    call_line(&format!(
        "run {} --camera {} --no-recording --out {}",
        out.path().display(),
        camera.display(),
        again.path().display()
    ))
    .done();
    let (before, after) = (frames(run.path()), frames(again.path()));
    assert_eq!(before.len(), after.len());
    assert!(before.iter().zip(&after).all(|(a, b)| (a.t_s - b.t_s).abs() < 1e-6));
    let known = camera_from_toml(&fs::read_to_string(drive.path().join("camera.toml")).unwrap()).unwrap();
    let written = camera_from_toml(&fs::read_to_string(&camera).unwrap()).unwrap();
    assert_eq!((known.width(), known.height()), (written.width(), written.height()));
}

#[test]
fn recordings_that_cannot_be_converted_say_why() {
    let drive = Drive::get();
    let (work, out) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let nothing = work.path().join("nothing.mcap");
    fs::write(&nothing, "this is no recording, but it is long enough to be looked at").unwrap();
    convert(&format!("mcap {} --height-m 1.5", nothing.display()), out.path())
        .refused(1, &["nothing.mcap", "no MCAP recording"]);
    let bag = work.path().join("bag");
    fs::create_dir(&bag).unwrap();
    fs::write(bag.join("bag_0.db3"), "").unwrap();
    convert(&format!("bag {} --height-m 1.5", bag.display()), out.path())
        .refused(1, &["SQLite", "ros2 bag convert"]);
    call_line(&format!("convert mcap {} --out {}", nothing.display(), out.path().display()))
        .refused(2, &["--height-m"]);

    let run = TempDir::new().unwrap();
    call_line(&drive.run_line(&drive.path(), run.path())).done();
    let recording = run.path().join("run.mcap");
    let line = format!("mcap {} --image-topic /camera/image", recording.display());
    convert(&format!("{line} --height-m 1.5 --gps-topic /gps"), out.path())
        .refused(1, &["\"/gps\"", "GPS positions"]);
    let other = work.path().join("camera.toml");
    let text = fs::read_to_string(drive.path().join("camera.toml")).unwrap();
    fs::write(&other, text.replace("width = 320", "width = 300")).unwrap();
    convert(&format!("{line} --camera {}", other.display()), out.path())
        .refused(1, &["320 x 240", "300 x 240"]);

    // A recording that breaks off is converted as far as it goes.
    let bytes = fs::read(&recording).unwrap();
    let half = work.path().join("half.mcap");
    fs::write(&half, &bytes[..bytes.len() / 2]).unwrap();
    let converted =
        convert(&format!("mcap {} --image-topic /camera/image --height-m 1.5", half.display()), out.path())
            .done();
    assert!(converted.stderr.contains("ends before its end"), "{}", converted.stderr);
    let facts: serde_json::Value = serde_json::from_str(&converted.stdout).unwrap();
    assert!(facts["frames"].as_u64().is_some_and(|frames| frames > 0 && frames < FRAMES as u64));
}

#[test]
fn measurements_take_no_more_memory_than_an_input_may() {
    let work = TempDir::new().unwrap();
    let recording = work.path().join("many.mcap");
    for (schema, encoding, topic, fit) in [
        ("geometry_msgs/msg/TwistStamped", "cdr", "/twist", "3640 fit"),
        ("sensor_msgs/msg/Imu", "cdr", "/imu", "4369 fit"),
        ("sensor_msgs/msg/NavSatFix", "cdr", "/gps", "14563 fit"),
        ("foxglove.LocationFix", "protobuf", "/gps", "14563 fit"),
    ] {
        let mut writer = mcap::WriteOptions::new().create(fs::File::create(&recording).unwrap()).unwrap();
        let mut channel = |schema: &str, topic: &str, encoding: &str| {
            let schema_id = writer.add_schema(schema, "any", b"").unwrap();
            writer.add_channel(schema_id, topic, encoding, &BTreeMap::new()).unwrap()
        };
        let pictures = channel("sensor_msgs/msg/Image", "/camera", "cdr");
        let measured = channel(schema, topic, encoding);
        for (channel_id, count) in [(pictures, 1), (measured, 15_000)] {
            for time in 0..count {
                let header = mcap::records::MessageHeader {
                    channel_id,
                    sequence: 0,
                    log_time: time,
                    publish_time: time,
                };
                writer.write_to_known_channel(&header, &[0; 4]).unwrap();
            }
        }
        writer.finish().unwrap();
        let line = format!("mcap {} --height-m 1.5", recording.display());
        let out = work.path().join("out");
        convert(&format!("{line} --max-input-mib 1"), &out)
            .refused(1, &[topic, "15000 messages", fit, "--max-input-mib"]);
        // With room for them the camera is what is missing.
        convert(&line, &out).refused(1, &["no calibration"]);
    }
}

#[test]
fn kitti_sequences_become_drives() {
    let drive = Drive::get();
    for is_raw in [true, false] {
        let (work, out, run) = (TempDir::new().unwrap(), TempDir::new().unwrap(), TempDir::new().unwrap());
        let sequence = kitti(work.path(), &drive.path().join("frames"), is_raw);
        let converted = convert(&format!("kitti {}", sequence.display()), out.path()).done();
        let facts: serde_json::Value = serde_json::from_str(&converted.stdout).unwrap();
        assert_eq!(facts["frames"], 5);
        let camera = out.path().join("camera.toml");
        let text = fs::read_to_string(&camera).unwrap();
        assert!(
            text.contains("fx = 210.0") && text.contains("cx = 159.5") && text.contains("height_m = 1.65"),
            "{text}"
        );
        if is_raw {
            let motion =
                parse_motion_log(&fs::read_to_string(out.path().join("motion.csv")).unwrap()).unwrap();
            let rows: Vec<[f64; 3]> =
                motion.rows.iter().map(|row| [row.t_s, row.speed_mps, row.yaw_rate_rps]).collect();
            assert_eq!(
                rows,
                [[0.03, 8.0, 0.125], [0.13, 9.0, 0.125], [0.23, 10.0, 0.125], [0.33, 11.0, 0.125]]
            );
            let poses = parse_pose_log(&fs::read_to_string(out.path().join("poses.csv")).unwrap()).unwrap();
            assert_eq!((poses.len(), poses[2].lat, poses[2].heading_rad), (4, 49.00002, -1.25));
            let gps = fs::read_to_string(out.path().join("gps.gpx")).unwrap();
            assert!(gps.contains("lat=\"49.0000100\"") && gps.contains("1970-01-01T00:00:00.130Z"), "{gps}");
        }
        let line = format!("run {} --camera {}", out.path().display(), camera.display());
        call_line(&format!("{line} --no-recording --out {}", run.path().display())).done();
        let times: Vec<f64> = frames(run.path()).iter().map(|frame| (10.0 * frame.t_s).round()).collect();
        assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.0]);
    }
    let empty = TempDir::new().unwrap();
    let out = TempDir::new().unwrap();
    convert(&format!("kitti {} --camera 3", empty.path().display()), out.path())
        .refused(1, &["image_03/data", "image_3"]);
}

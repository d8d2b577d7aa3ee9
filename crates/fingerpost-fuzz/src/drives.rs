//! What stands in the folders of drives and runs: calibrations, times, truth, records and marks.

use fingerpost_eval::poses_from_kitti;
use fingerpost_format::{
    FrameRecord, FromJson, LoopDrive, Summary, ToJson, TruthRecord, TuSimpleRecord, TuningTrial,
    camera_from_toml, camera_from_yaml, camera_to_toml, from_json_lines, kitti_oxts, kitti_projection,
    kitti_timestamps, marks_from_json, marks_to_json, mount_from_toml, parse_motion_log, parse_pose_log,
    parse_times, to_json_line,
};
use fingerpost_geometry::{Camera, Mount, Pixel};

use crate::must;

/// What is seen by a camera that was accepted is finite, and the camera reads back where it can be written.
fn check_camera(camera: &Camera) {
    let (width, height) = (camera.width() as f64, camera.height() as f64);
    for (u, v) in [(0.0, 0.0), (0.5 * width, 0.9 * height), (width - 1.0, height - 1.0)] {
        if let Some(place) = camera.ground_of_pixel(Pixel::new(u, v)) {
            assert!(place.x.is_finite() && place.y.is_finite(), "({u}, {v}) shows {place:?}");
        }
    }
    if let Ok(text) = camera_to_toml(camera) {
        must(camera_from_toml(&text), "a camera that was written");
    }
}

pub(crate) fn camera_toml(bytes: &[u8]) -> bool {
    if let Ok(text) = str::from_utf8(bytes)
        && let Ok(camera) = camera_from_toml(text)
    {
        check_camera(&camera);
        return true;
    }
    false
}

pub(crate) fn camera_toml_seeds() -> Vec<Vec<u8>> {
    seeds(&[include_str!("../seeds/camera.toml"), include_str!("../seeds/points.toml")])
}

/// A mount that is accepted is finite.
pub(crate) fn mount_toml(bytes: &[u8]) -> bool {
    let Some(mount) = str::from_utf8(bytes).ok().and_then(|text| mount_from_toml(text).ok()) else {
        return false;
    };
    let Mount { height_m, pitch_rad, yaw_rad, roll_rad, x_m, y_m } = mount;
    assert!([height_m, pitch_rad, yaw_rad, roll_rad, x_m, y_m].iter().all(|number| number.is_finite()));
    assert!(height_m > 0.0, "a camera {height_m} m above the road");
    true
}

pub(crate) fn mount_toml_seeds() -> Vec<Vec<u8>> {
    seeds(&[
        "[mount]\nheight_m = 1.5\npitch_deg = 2.0\nyaw_deg = -0.5\nroll_deg = 0.25\nx_m = 1.5\ny_m = 0.1\n",
    ])
}

pub(crate) fn camera_yaml(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let cameras = [None, Some(Mount::level(1.5))].map(|mount| camera_from_yaml(text, mount));
    cameras.iter().flatten().for_each(|read| check_camera(&read.camera));
    cameras.iter().any(Result::is_ok)
}

pub(crate) fn camera_yaml_seeds() -> Vec<Vec<u8>> {
    seeds(&[include_str!("../seeds/ros.yaml"), include_str!("../seeds/opencv.yaml")])
}

/// Times begin at zero and do not run backwards.
pub(crate) fn times(bytes: &[u8]) -> bool {
    if let Ok(text) = str::from_utf8(bytes)
        && let Ok(times_s) = parse_times(text)
    {
        assert!(times_s.first().is_none_or(|first_s| *first_s == 0.0));
        assert!(times_s.iter().all(|t_s| t_s.is_finite()));
        assert!(times_s.is_sorted(), "times run backwards");
        return true;
    }
    false
}

pub(crate) fn times_seeds() -> Vec<Vec<u8>> {
    seeds(&["0.000000\n0.033333\n0.066667\n1.5e1\n", "1700000000.25\n\n1700000000.35\n"])
}

/// Rows are finite, and later one after the other.
pub(crate) fn motion_log(bytes: &[u8]) -> bool {
    let Ok(log) = str::from_utf8(bytes).map_err(drop).and_then(|text| parse_motion_log(text).map_err(drop))
    else {
        return false;
    };
    assert!(log.rows.len() > log.passed_over.len());
    assert!(log.rows.iter().all(|row| row.speed_mps.is_finite() && row.yaw_rate_rps.is_finite()));
    assert!(log.rows.is_sorted_by(|one, next| one.t_s < next.t_s));
    true
}

pub(crate) fn motion_log_seeds() -> Vec<Vec<u8>> {
    seeds(&["t_s,speed_mps,yaw_rate_rps\n0.0,10.0,0.0\n0.1,10.1,-0.02\n\n0.2,1.01e1,0.3\n0.2,nan,1\n"])
}

/// The same for poses.
pub(crate) fn pose_log(bytes: &[u8]) -> bool {
    let Ok(rows) = str::from_utf8(bytes).map_err(drop).and_then(|text| parse_pose_log(text).map_err(drop))
    else {
        return false;
    };
    assert!(!rows.is_empty());
    assert!(
        rows.iter().all(|row| [row.lat, row.lon, row.heading_rad].iter().all(|number| number.is_finite()))
    );
    assert!(rows.is_sorted_by(|one, next| one.t_s < next.t_s));
    true
}

pub(crate) fn pose_log_seeds() -> Vec<Vec<u8>> {
    seeds(&["t_s,lat,lon,heading_rad\n0.0,47.21785,9.539682,1.5\n0.1,47.21786,9.539683,-3.1\n"])
}

/// Records that are read can be written, and what is written reads back and is written the same.
fn check_lines<T: FromJson + ToJson>(bytes: &[u8]) -> bool {
    let Ok(records) =
        str::from_utf8(bytes).map_err(drop).and_then(|text| from_json_lines::<T>(text).map_err(drop))
    else {
        return false;
    };
    for record in records {
        let line = must(to_json_line(&record), "a record that was read");
        must(from_json_lines::<T>(&line), "a record that was written");
    }
    true
}

pub(crate) fn frames(bytes: &[u8]) -> bool {
    check_lines::<FrameRecord>(bytes)
}

pub(crate) fn frames_seeds() -> Vec<Vec<u8>> {
    seeds(&[include_str!("../seeds/frames.jsonl")])
}

pub(crate) fn truth(bytes: &[u8]) -> bool {
    check_lines::<TruthRecord>(bytes)
}

pub(crate) fn truth_seeds() -> Vec<Vec<u8>> {
    let record =
        TruthRecord { t_s: 0.5, lat: 48.5, lon: 8.25, feature_id: Some(7), ..TruthRecord::default() };
    vec![must(to_json_line(&record), "a seed").into_bytes()]
}

/// What a job is gone on with: its trials, and its closed-loop drives.
pub(crate) fn trials(bytes: &[u8]) -> bool {
    check_lines::<TuningTrial>(bytes)
}

pub(crate) fn trials_seeds() -> Vec<Vec<u8>> {
    seeds(&[
        "{\"trial\": 0, \"purpose\": \"search\", \"settings\": {}, \"scores\": null, \"ms_per_frame\": 2.5, \"error\": \"refused\"}\n",
    ])
}

pub(crate) fn closed_loop(bytes: &[u8]) -> bool {
    check_lines::<LoopDrive>(bytes)
}

pub(crate) fn closed_loop_seeds() -> Vec<Vec<u8>> {
    vec![must(to_json_line(&LoopDrive::default()), "a seed").into_bytes()]
}

/// A summary that is read can be written, and reads back.
pub(crate) fn summary(bytes: &[u8]) -> bool {
    let Some(summary) = str::from_utf8(bytes).ok().and_then(|text| Summary::from_json(text).ok()) else {
        return false;
    };
    must(
        Summary::from_json(&must(summary.to_json(), "a summary that was read")),
        "a summary that was written",
    );
    true
}

pub(crate) fn summary_seeds() -> Vec<Vec<u8>> {
    vec![must(Summary::default().to_json(), "a seed").into_bytes()]
}

/// Poses that are accepted are finite, and one a line.
pub(crate) fn kitti_poses(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let Ok(poses) = poses_from_kitti(text) else { return false };
    assert!(
        poses
            .values()
            .all(|pose| [pose.x_m, pose.y_m, pose.heading_rad].iter().all(|number| number.is_finite()))
    );
    assert_eq!(poses.len(), text.lines().filter(|line| !line.trim().is_empty()).count());
    true
}

pub(crate) fn kitti_poses_seeds() -> Vec<Vec<u8>> {
    seeds(&[
        "1 0 0 0 0 1 0 0 0 0 1 0\n9.999e-01 5e-04 -2e-03 -4.7e-02 -5e-04 1 -1e-04 -2.8e-02 2e-03 1e-04 9.999e-01 8.58e-01\n",
    ])
}

pub(crate) fn tusimple(bytes: &[u8]) -> bool {
    check_lines::<TuSimpleRecord>(bytes)
}

pub(crate) fn tusimple_seeds() -> Vec<Vec<u8>> {
    seeds(&[
        "{\"lanes\": [[-2, 300.5, 310], [500, 510, -2]], \"h_samples\": [240, 250, 260], \"raw_file\": \"a/1.jpg\"}\n",
    ])
}

/// Marks that are accepted come back as they were.
pub(crate) fn marks(bytes: &[u8]) -> bool {
    if let Ok(text) = str::from_utf8(bytes)
        && let Ok(marks) = marks_from_json(text)
    {
        let written = must(marks_to_json(&marks), "marks that were read");
        must(marks_from_json(&written), "marks that were written");
        return true;
    }
    false
}

pub(crate) fn marks_seeds() -> Vec<Vec<u8>> {
    seeds(&[include_str!("../../fingerpost-cli/tests/marks/p5h_test_small1.json")])
}

fn seeds(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

/// Numbers of an accepted file are finite, and its times can be told apart.
pub(crate) fn kitti(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let oxts = kitti_oxts(text).ok();
    if let Some(oxts) = oxts {
        assert!(oxts.heading_rad.is_finite() && oxts.speed_mps.is_finite() && oxts.yaw_rate_rps.is_finite());
    }
    let times = kitti_timestamps(text).ok().filter(|times| !times.is_empty());
    for time in times.iter().flatten() {
        assert!(times.iter().flatten().all(|other| time.since_s(*other).is_finite()));
    }
    oxts.is_some() || times.is_some() || (0..4).any(|camera| kitti_projection(text, camera).is_ok())
}

pub(crate) fn kitti_seeds() -> Vec<Vec<u8>> {
    seeds(&[
        "49.0 8.4 112.8 0.02 0.01 -1.2 0.5 8.1 8.2 0.1 0 1 0 9.8 1 0 9.8 0 0 0.1 0 0 0.1 0.05 0.01 4 11 6 6 6\n",
        "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.074343000\n",
        "P2: 7.188560e+02 0 6.071928e+02 4.5e+01 0 7.188560e+02 1.852157e+02 -1.1e-01 0 0 1 3.7e-03\n",
    ])
}

//! Junctions of recorded drives, with the recorder's satellite positions as truth: the folder named by FINGERPOST_DATA.
//! Missing data, or a missing `bzcat`, is a failure.

// A helper that fails has failed the test that calls it; figures are shown with `--nocapture`.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use fingerpost_format::{FrameRecord, TrackState, from_json_lines};
use fingerpost_map::{LatLon, Route, TangentPlane, read_route};
use nalgebra::{Isometry2, Point2, Vector2};
use tempfile::TempDir;

/// A drive of KITTI odometry past a junction.
struct Street {
    /// Its number there.
    sequence: &'static str,
    /// `[image]` and `[intrinsics]` of its camera.
    camera: &'static str,
    /// Ends of its route, latitude and longitude.
    from: &'static str,
    to: &'static str,
    /// OpenStreetMap node of the junction.
    node: i64,
}

fn data(name: &str) -> PathBuf {
    let path = PathBuf::from(env::var("FINGERPOST_DATA").unwrap()).join(name);
    assert!(path.exists(), "{} is missing", path.display());
    path
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn fingerpost(arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_fingerpost")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The camera's mount on the recorder's unit, of which the positions are: 1.08 m ahead of it and 0.32 m to its right, with the pitch
/// that the road shows.
const LEVELLED_MOUNT: &str = "[mount]\nheight_m = 1.65\npitch_deg = 0.75\nx_m = 1.08\ny_m = -0.32\n";

/// A drive's records, its route, and where the vehicle was in the map frame in each frame.
struct Driven {
    records: Vec<FrameRecord>,
    route: Route,
    map_from_vehicle: Vec<Isometry2<f64>>,
}

fn drive_with(street: &Street, mount: &str, arguments: &[&str]) -> Driven {
    let folder = TempDir::new().unwrap();
    let (camera, route, run) =
        (folder.path().join("camera.toml"), folder.path().join("route.geojson"), folder.path().join("run"));
    fs::write(&camera, format!("{}{mount}", street.camera)).unwrap();
    let map = data(&format!("osm/kitti_{}.osm", street.sequence));
    let (from, to) = (street.from, street.to);
    fingerpost(&["route", "--map", text(&map), "--from", from, "--to", to, "--out", text(&route)]);
    let input = data(&format!("kitti/frames{}", street.sequence));
    let set = ["--camera", text(&camera), "--out", text(&run)];
    let on_route = ["run", text(&input), "--route", text(&route)];
    fingerpost(&[&on_route[..], &set, arguments].concat());
    let records = from_json_lines(&fs::read_to_string(run.join("frames.jsonl")).unwrap()).unwrap();
    let route = read_route(&fs::read_to_string(&route).unwrap()).unwrap();
    let map = TangentPlane::new(route.line[0].at);
    let map_from_vehicle = positions(street.sequence)
        .into_iter()
        .map(|(at, heading_rad)| Isometry2::new(map.map_from_wgs84(at).coords, heading_rad))
        .collect();
    Driven { records, route, map_from_vehicle }
}

/// Places and headings (radians anticlockwise from east) of the recorder, one a frame.
fn positions(sequence: &str) -> Vec<(LatLon, f64)> {
    let packed = data(&format!("kitti/oxts/{sequence}.txt.bz2"));
    let output = Command::new("bzcat").arg(packed).output().unwrap();
    assert!(output.status.success(), "bzcat: {}", String::from_utf8_lossy(&output.stderr));
    let rows = String::from_utf8(output.stdout).unwrap();
    let columns = |row: &str| row.split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
    rows.lines().map(columns).map(|row| (LatLon::new(row[0], row[1]).unwrap(), row[5])).collect()
}

impl Driven {
    /// Where the map has a node, in the vehicle frame of a frame, metres.
    fn node_in_vehicle(&self, node: i64, frame: usize) -> Point2<f64> {
        let map = TangentPlane::new(self.route.line[0].at);
        let feature = self.route.features.iter().find(|feature| feature.id == node).unwrap();
        self.map_from_vehicle[frame].inverse() * map.map_from_wgs84(feature.at)
    }

    /// Checks that the junction is the first that is found, and is followed until it is arrived at. What came of it is compared with the
    /// map's place of its node, over the frames until it is passed.
    fn met(&self, node: i64) -> Met {
        let with_feature = || self.records.iter().filter(|record| record.feature.is_some());
        let first = with_feature().next().unwrap();
        assert_eq!(first.feature.as_ref().unwrap().id, node);
        let arrived = self.records.iter().find(|record| record.state == TrackState::Arrived).unwrap();
        assert_eq!(arrived.feature.as_ref().unwrap().id, node);
        let mut errors: Vec<[f64; 2]> = Vec::new();
        for record in with_feature() {
            let feature = record.feature.as_ref().filter(|feature| feature.id == node);
            let truth = self.node_in_vehicle(node, record.frame as usize);
            if let Some(feature) = feature.filter(|_| truth.x > 0.0) {
                let error_m = (Vector2::new(feature.forward_m, feature.left_m) - truth.coords).norm();
                errors.push([error_m, error_m / Vector2::from(feature.sigma_m).norm()]);
            }
        }
        Met {
            found_ahead_m: self.node_in_vehicle(node, first.frame as usize).x,
            median_error_m: median(errors.iter().map(|error| error[0])),
            error_in_sigmas: median(errors.iter().map(|error| error[1])),
        }
    }
}

fn street_00() -> Street {
    Street {
        sequence: "00",
        camera: "[image]\nwidth = 1241\nheight = 376\n\
            [intrinsics]\nfx = 718.856\nfy = 718.856\ncx = 607.1928\ncy = 185.2157\n",
        from: "48.982545,8.390366",
        to: "48.98312,8.39134",
        node: 24546162,
    }
}

fn street_06() -> Street {
    Street {
        sequence: "06",
        camera: "[image]\nwidth = 1226\nheight = 370\n\
            [intrinsics]\nfx = 707.0912\nfy = 707.0912\ncx = 601.8873\ncy = 183.1104\n",
        from: "49.05349305,8.39721999",
        to: "49.05338,8.39529",
        node: 25344948,
    }
}

/// Where the recorder was in a frame, `ahead_m` farther along its heading there.
fn place_ahead(sequence: &str, frame: usize, ahead_m: f64) -> LatLon {
    let (at, heading_rad) = positions(sequence)[frame];
    let plane = TangentPlane::new(at);
    plane.wgs84_from_map(Point2::new(ahead_m * libm::cos(heading_rad), ahead_m * libm::sin(heading_rad)))
}

/// Distances of the fix from the recorder's place, metres, from a frame on; a start `off_m` farther ahead than the true one, known to
/// about 30 m, is all that is given beside the pictures. No fix may be farther off than its bound.
fn fix_errors_m(street: &Street, off_m: f64, from: usize) -> Vec<f64> {
    let map = data(&format!("osm/kitti_{}.osm", street.sequence));
    let start = place_ahead(street.sequence, 0, off_m);
    let near = format!("{},{}", start.lat_deg, start.lon_deg);
    let driven = drive_with(street, LEVELLED_MOUNT, &["--map", text(&map), "--near", &near]);
    let true_places = positions(street.sequence);
    let mut errors_m = Vec::new();
    for record in &driven.records {
        let fix = record.fix.as_ref().unwrap();
        let plane = TangentPlane::new(true_places[record.frame as usize].0);
        let error_m = plane.map_from_wgs84(LatLon::new(fix.lat, fix.lon).unwrap()).coords.norm();
        assert!(fix.bound_m.is_none_or(|bound_m| error_m <= bound_m), "frame {}: {error_m} m", record.frame);
        errors_m.extend(Some(error_m).filter(|_| record.frame as usize >= from));
    }
    errors_m.sort_by(f64::total_cmp);
    errors_m
}

#[test]
fn the_place_on_the_map_is_corrected_by_a_junction_from_a_start_that_is_off() {
    // The vehicle has turned right at the junction by frame 115.
    for off_m in [-20.0, 0.0, 20.0] {
        let errors_m = fix_errors_m(&street_00(), off_m, 115);
        println!(
            "00, start {off_m:+} m: {:.2} m, at most {:.2} m",
            errors_m[errors_m.len() / 2],
            errors_m[errors_m.len() - 1]
        );
        assert!(errors_m[errors_m.len() / 2] <= 2.0);
    }
    // It is before the side road from frame 36 on, where that is followed.
    for off_m in [-20.0, 0.0, 20.0] {
        let errors_m = fix_errors_m(&street_06(), off_m, 40);
        println!(
            "06, start {off_m:+} m: {:.2} m, at most {:.2} m",
            errors_m[errors_m.len() / 2],
            errors_m[errors_m.len() - 1]
        );
        assert!(errors_m[errors_m.len() / 2] <= 2.0);
    }
}

/// Heights (metres) and pitches (degrees) of calibrations as users come by them: the truth is about 1.65 m and 0.75 degrees.
const HEIGHTS_M: [f64; 3] = [1.6, 1.65, 1.7];
const PITCHES_DEG: [f64; 4] = [0.0, 0.4, 0.75, 1.1];

/// What came of a street under one of the calibrations.
struct Met {
    found_ahead_m: f64,
    median_error_m: f64,
    /// Median of error / sigma.
    error_in_sigmas: f64,
}

/// Drives a street under every calibration: the junction is the first that is claimed in each, and is arrived at.
fn met_under_every_calibration(street: &Street) -> Vec<Met> {
    let mut all = Vec::new();
    for (height_m, pitch_deg) in
        HEIGHTS_M.iter().flat_map(|height_m| PITCHES_DEG.iter().map(move |pitch_deg| (height_m, pitch_deg)))
    {
        let mount =
            format!("[mount]\nheight_m = {height_m}\npitch_deg = {pitch_deg}\nx_m = 1.08\ny_m = -0.32\n");
        let met = drive_with(street, &mount, &["--start-m", "0"]).met(street.node);
        println!(
            "{}, {height_m} m, {pitch_deg} degrees: found {:.1} m ahead, {:.2} m and {:.1} sigma off",
            street.sequence, met.found_ahead_m, met.median_error_m, met.error_in_sigmas
        );
        all.push(met);
    }
    all
}

/// The middle one of the values, the upper one of two.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn a_junction_between_parked_cars_and_shadows_is_found_and_nothing_before_it() {
    // The shadow of a house hides the near half of the crossing road.
    let met = met_under_every_calibration(&street_00());
    assert!(median(met.iter().map(|met| met.median_error_m)) <= 1.0);
    assert!(met.iter().all(|met| met.median_error_m <= 3.0 && met.found_ahead_m >= 4.5));
    assert!(met.iter().filter(|met| met.error_in_sigmas > 3.0).count() <= 2);
}

#[test]
fn a_side_road_passed_in_grey() {
    let met = met_under_every_calibration(&street_06());
    assert!(median(met.iter().map(|met| met.median_error_m)) <= 1.0);
    assert!(met.iter().all(|met| met.median_error_m <= 1.5 && met.found_ahead_m >= 13.0));
    assert!(met.iter().all(|met| met.error_in_sigmas <= 3.0));
}

//! Recorded drives on their OpenStreetMap maps. `FINGERPOST_DATA` names the folder that holds both; without it these tests fail.
//!
//! Speed and yaw rate are those of the recording's inertial system with errors of cheap sensors from fixed seeds added; its place,
//! centimetres to decimetres sure, is the truth. Its WGS 84 and OpenStreetMap's agree: fitted to the roads, the shift of the drives
//! 05 and 09 is below a metre east and north.

// Functions shared by tests fail their test by unwrapping; figures are shown with `--nocapture`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

mod drives;

use std::path::PathBuf;
use std::process::Command;

use fingerpost_locate::{Fix, Locator, MotionSample, Start, Status, Traffic};
use fingerpost_map::{LatLon, OsmData, RoadGraph};
use nalgebra::Point2;

use self::drives::score::quantile;
use self::drives::{Numbers, Score, drive, line, locate, typical_faults};

/// Time between rows of the recordings, seconds: the mean of `times_00.txt`. Driven distances by speed and by place agree with it.
const ROW_S: f64 = 0.103_652;
const SEEDS: [u64; 5] = [1, 2, 3, 4, 5];
/// How well the start of `run --near` is known, standard deviation, metres.
const NEAR_SIGMA_M: f64 = 20.0;

/// A file of the data folder, decompressed where its name ends in `.bz2`.
fn bytes(name: &str) -> Vec<u8> {
    let folder =
        std::env::var("FINGERPOST_DATA").expect("set FINGERPOST_DATA to the folder of the real data");
    let path = PathBuf::from(folder).join(name);
    if !name.ends_with(".bz2") {
        return std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    let done =
        Command::new("bzip2").arg("-dc").arg(&path).output().expect("these tests need the program bzip2");
    assert!(done.status.success(), "{}: {}", path.display(), String::from_utf8_lossy(&done.stderr));
    done.stdout
}

fn osm(name: &str) -> OsmData {
    OsmData::from_bytes(&bytes(&format!("osm/{name}"))).unwrap()
}

/// A row of a recording: place and motion.
struct Recorded {
    at: LatLon,
    speed_mps: f64,
    yaw_rate_rps: f64,
}

/// Columns of `oxts/README`: latitude, longitude; ninth the forward velocity; 23rd the rate about the upward axis.
fn recording(drive: &str) -> Vec<Recorded> {
    let text = String::from_utf8(bytes(&format!("kitti/oxts/{drive}.txt.bz2"))).unwrap();
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|text| text.parse().unwrap()).collect();
        let at = LatLon::new(numbers[0], numbers[1]).unwrap();
        Recorded { at, speed_mps: numbers[8], yaw_rate_rps: numbers[22] }
    };
    text.lines().map(row).collect()
}

const MAPS: [(&str, &str); 4] =
    [("03", "comp2550_03.osm.bz2"), ("05", "kitti_05.osm"), ("06", "kitti_06.osm"), ("09", "kitti_09.osm")];

/// The fixes of a recording with errors of a seed, beside the true places; and the distance driven up to each.
fn fixes(drive: &str, map: &str, seed: u64, scale: f64) -> Vec<(Fix, Point2<f64>, f64)> {
    fixes_turning(drive, map, seed, [scale, 1.0])
}

/// The same of a gyroscope that shows `turns` times the true yaw rate.
fn fixes_turning(
    drive: &str,
    map: &str,
    seed: u64,
    [scale, turns]: [f64; 2],
) -> Vec<(Fix, Point2<f64>, f64)> {
    let graph = RoadGraph::from_osm(&osm(map)).unwrap();
    let locator = Locator::new(&graph, Traffic::Right, seed);
    driven(drive, &graph, locator, seed, [scale, turns])
}

/// The same of a vehicle that starts near the place where it truly is, as `run --near` takes it.
fn fixes_near(drive: &str, map: &str, seed: u64, turns: f64) -> Vec<(Fix, Point2<f64>, f64)> {
    let graph = RoadGraph::from_osm(&osm(map)).unwrap();
    let place_m = graph.plane().map_from_wgs84(recording(drive)[0].at);
    let start = Start { place_m, sigma_m: NEAR_SIGMA_M, heading_rad: None };
    let locator = Locator::near(&graph, Traffic::Right, seed, &start);
    driven(drive, &graph, locator, seed, [0.01, turns])
}

/// The fixes of a locator that has not moved yet.
fn driven(
    drive: &str,
    graph: &RoadGraph,
    mut locator: Locator,
    seed: u64,
    [scale, turns]: [f64; 2],
) -> Vec<(Fix, Point2<f64>, f64)> {
    let mut numbers = Numbers(seed);
    let mut sign = || if numbers.unit() < 0.5 { -1.0 } else { 1.0 };
    let (scale, bias_rps) = (1.0 + sign() * scale, sign() * 0.05_f64.to_radians());
    let mut before: Option<Point2<f64>> = None;
    let mut driven_m = 0.0;
    let located = recording(drive).into_iter().enumerate().map(|(index, row)| {
        let sample = MotionSample {
            t_s: index as f64 * ROW_S,
            speed_mps: row.speed_mps * scale + numbers.normal(0.1),
            yaw_rate_rps: row.yaw_rate_rps * turns + bias_rps + numbers.normal(0.1_f64.to_radians()),
        };
        let truth = graph.plane().map_from_wgs84(row.at);
        driven_m += before.map_or(0.0, |before| (truth - before).norm());
        before = Some(truth);
        (locator.step(sample).unwrap().unwrap(), truth, driven_m)
    });
    located.collect()
}

/// What became of a drive.
#[derive(Debug)]
struct Outcome {
    converged_m: Option<f64>,
    /// Of every row from the first converged one on.
    errors_m: Vec<f64>,
    levels_m: Vec<f64>,
    violations: usize,
}

fn outcome(fixes: &[(Fix, Point2<f64>, f64)]) -> Outcome {
    let first = fixes.iter().position(|(fix, ..)| fix.status == Status::Converged);
    let error_m = |(fix, truth, _): &(Fix, Point2<f64>, f64)| (fix.place_m - truth).norm();
    let converged: Vec<_> = fixes.iter().filter(|(fix, ..)| fix.status == Status::Converged).collect();
    Outcome {
        converged_m: first.map(|first| fixes[first].2),
        errors_m: first.map_or(Vec::new(), |first| fixes[first..].iter().map(error_m).collect()),
        levels_m: converged.iter().filter_map(|(fix, ..)| fix.level_m).collect(),
        violations: converged.iter().filter(|row| row.0.level_m.unwrap() < error_m(row)).count(),
    }
}

fn shown(drive: &str, seed: u64, outcome: &Outcome) -> String {
    let Outcome { converged_m, errors_m, levels_m, violations } = outcome;
    let [p50, p95] = [0.5, 0.95].map(|share| quantile(errors_m, share));
    format!(
        "{drive}, seed {seed}: converged after {converged_m:.0?} m, error {p50:.2} m, p95 {p95:.2} m, level {:.1} m, {violations} of {} outside",
        quantile(levels_m, 0.5),
        levels_m.len()
    )
}

#[test]
fn drives_05_and_09_converge_within_500_metres_to_3_metres() {
    for (drive, map) in [("05", "kitti_05.osm"), ("09", "kitti_09.osm")] {
        for seed in SEEDS {
            let outcome = outcome(&fixes(drive, map, seed, 0.01));
            println!("{}", shown(drive, seed, &outcome));
            assert!(outcome.converged_m.is_some_and(|driven_m| driven_m <= 500.0));
            assert!(quantile(&outcome.errors_m, 0.5) <= 3.0);
            assert!(quantile(&outcome.errors_m, 0.95) <= 10.0);
            assert_eq!(outcome.violations, 0);
        }
    }
}

/// Drive 06 goes up and down a dual carriageway whose two turning places look alike, and 03 is short and on a map that is metres
/// off: they need not converge, and claim nothing false.
#[test]
fn drives_03_and_06_claim_nothing_false() {
    for (drive, map) in [("03", "comp2550_03.osm.bz2"), ("06", "kitti_06.osm")] {
        for seed in SEEDS {
            let outcome = outcome(&fixes(drive, map, seed, 0.01));
            println!("{}", shown(drive, seed, &outcome));
            assert_eq!(outcome.violations, 0);
        }
    }
}

/// A drive on the map of another, kilometres away: some road there fits for a while, but no better than roads fit at random. Nothing
/// false is claimed for more than three seconds. (The map of 06 has the roads of 05 as well.)
#[test]
fn a_drive_that_was_never_on_the_map_is_not_found_there() {
    for (drive, own) in MAPS {
        for map in MAPS.map(|(_, map)| map).into_iter().chain(["kitti_00.osm"]).filter(|map| *map != own) {
            let (mut run, mut longest) = (0, 0);
            for (fix, truth, _) in fixes(drive, map, 1, 0.01) {
                let is_false = fix.level_m.is_some_and(|level_m| level_m < (fix.place_m - truth).norm());
                run = if fix.status == Status::Converged && is_false { run + 1 } else { 0 };
                longest = longest.max(run);
            }
            println!("{drive} on {map}: falsely converged for {longest} rows");
            assert!(longest as f64 * ROW_S <= 3.0);
        }
    }
}

#[test]
fn a_speed_that_is_off_by_a_tenth_converges_as_well() {
    for (drive, map) in [("05", "kitti_05.osm"), ("09", "kitti_09.osm")] {
        for seed in SEEDS {
            let outcome = outcome(&fixes(drive, map, seed, 0.1));
            println!("{}", shown(drive, seed, &outcome));
            assert!(outcome.converged_m.is_some());
            assert!(quantile(&outcome.errors_m, 0.5) <= 5.0);
        }
    }
}

/// The scales of consumer gyroscopes are up to 3 % off.
#[test]
fn a_gyroscope_whose_scale_is_off_keeps_its_protection_levels() {
    for (drive, map) in [("05", "kitti_05.osm"), ("09", "kitti_09.osm")] {
        for turns in [0.97, 0.98, 0.99, 1.01, 1.02, 1.03] {
            let outcome = outcome(&fixes_turning(drive, map, 1, [0.01, turns]));
            println!("{turns}: {}", shown(drive, 1, &outcome));
            assert!(outcome.converged_m.is_some());
            assert!(quantile(&outcome.errors_m, 0.5) <= 4.0);
            assert_eq!(outcome.violations, 0);
        }
    }
}

/// Error of a place in units of its standard deviation in its least sure direction, which is `sigma_m` of a run's fix.
fn in_sigmas((fix, truth, _): &(Fix, Point2<f64>, f64)) -> f64 {
    (fix.place_m - truth).norm() / fix.covariance_m2.symmetric_eigenvalues().max().sqrt()
}

/// The eastern turning place of 06 is drawn 11 m beside where the drive turned; of a vehicle that does not know yet how wrong its speed is
/// it makes one that is surely in a wrong place.
#[test]
fn a_start_that_is_given_exactly_leaves_a_sigma_that_counts_the_rivals() {
    for (drive, map, most_over) in [
        ("00", "kitti_00.osm", 0.0),
        ("05", "kitti_05.osm", 0.0),
        ("06", "kitti_06.osm", 0.18),
        ("09", "kitti_09.osm", 0.04),
    ] {
        for turns in [0.97, 1.0, 1.03] {
            let fixes = fixes_near(drive, map, 1, turns);
            let outcome = outcome(&fixes);
            let (last, most) = (fixes.last().unwrap(), fixes.iter().map(in_sigmas).fold(0.0, f64::max));
            let over = fixes.iter().filter(|row| in_sigmas(row) > 3.0).count() as f64 / fixes.len() as f64;
            println!(
                "{turns}: {}; ends {:.1} m and {:.1} sigmas off, {:?}; {:.2} % of all rows over 3 sigmas, at most {most:.1}",
                shown(drive, 1, &outcome),
                (last.0.place_m - last.1).norm(),
                in_sigmas(last),
                last.0.status,
                100.0 * over
            );
            assert!(over <= most_over);
            assert!(drive == "06" || outcome.violations == 0);
            assert!(last.0.status != Status::Ambiguous || in_sigmas(last) <= 3.0);
        }
    }
}

#[test]
fn fifty_made_up_drives_keep_their_protection_levels() {
    let mut all = Score::default();
    for seed in 0..50 {
        let osm = osm(["kitti_00.osm", "kitti_05.osm", "kitti_06.osm", "kitti_09.osm"][seed as usize % 4]);
        let roads = RoadGraph::from_osm(&osm).unwrap();
        let mut numbers = Numbers(1000 + seed);
        let road = std::iter::repeat_with(|| line(&roads, 1500.0, &mut numbers)).flatten().next().unwrap();
        let rows = drive(&road, typical_faults(&mut numbers), &mut numbers);
        all.add(&locate(&osm, &rows, &mut numbers));
    }
    println!("{all}");
    assert!(all.never_converged <= 5);
    assert!(all.violations_part() <= 1e-3);
    assert!(quantile(&all.levels_m, 0.5) <= 4.0 * all.median_error_m());
}

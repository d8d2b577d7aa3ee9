//! Made-up drives on the roads of the built-in town: sensors with errors, and a map that was drawn a metre or two beside the roads.

use fingerpost_geometry::Polyline;
use fingerpost_locate::{Locator, MotionSample, Status, Traffic};
use fingerpost_map::{OsmData, RoadGraph};
use nalgebra::{Point2, Vector2};

use crate::drives::{Faults, Numbers, Pose, Road, Score, drive, line, locate, typical_faults};

const TOWN: &[u8] = include_bytes!("../../../fingerpost-sim/assets/town.osm");

fn town() -> OsmData {
    OsmData::from_bytes(TOWN).unwrap()
}

fn roads() -> RoadGraph {
    RoadGraph::from_osm(&town()).unwrap()
}

/// The first drive of that length that a seed gives.
fn line_of(graph: &RoadGraph, length_m: f64, numbers: &mut Numbers) -> Road {
    std::iter::repeat_with(|| line(graph, length_m, numbers)).flatten().next().unwrap()
}

#[test]
fn drives_in_the_town_are_located_and_keep_their_protection_levels() {
    let mut all = Score::default();
    for seed in 0..12 {
        let mut numbers = Numbers(seed);
        let road = line_of(&roads(), 1500.0, &mut numbers);
        let rows = drive(&road, typical_faults(&mut numbers), &mut numbers);
        all.add(&locate(&town(), &rows, &mut numbers));
    }
    println!("{all}");
    assert_eq!(all.never_converged, 0);
    assert!(all.violations_part() <= 1e-3);
    assert!(all.median_error_m() < 2.5);
    // Errors keep for about 100 m: some 150 independent ones, of which 2 + 1.96 x 2 / sqrt(150) is the upper end of the 95 % interval.
    assert!(all.nees() < 2.32, "{}", all.nees());
}

#[test]
fn the_same_log_gives_the_same_fixes() {
    let mut numbers = Numbers(3);
    let road = line_of(&roads(), 300.0, &mut numbers);
    let rows = drive(&road, Faults { scale: 0.01, bias_rps: 1e-3 }, &mut numbers);
    let fixes = || {
        let mut locator = Locator::new(&roads(), Traffic::Right, 7);
        rows.iter().map(|(row, _)| locator.step(*row).unwrap().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(fixes(), fixes());
}

/// Rows of one drive and then of another, with times that go on.
fn after(rows: Vec<(MotionSample, Pose)>, more: Vec<(MotionSample, Pose)>) -> Vec<(MotionSample, Pose)> {
    let last_s = rows.last().map_or(0.0, |(row, _)| row.t_s);
    let later =
        more.into_iter().map(|(row, pose)| (MotionSample { t_s: row.t_s + last_s + 0.1, ..row }, pose));
    rows.into_iter().chain(later).collect()
}

/// A vehicle that is carried elsewhere while its sensors see nothing: what was converged must be given up within a few turns,
/// and the vehicle be found again. Five of the six are converged when they are carried off; the first one coasts, where the map is
/// metres off.
#[test]
fn a_kidnapped_vehicle_is_noticed_and_found_again() {
    let mut converged = 0;
    for seed in 1..=6 {
        let mut numbers = Numbers(100 + seed);
        let faults = typical_faults(&mut numbers);
        let first = drive(&line_of(&roads(), 1000.0, &mut numbers), faults, &mut numbers);
        let second = drive(&line_of(&roads(), 2000.0, &mut numbers), faults, &mut numbers);
        let kidnapped = first.len();
        let rows = after(first, second);
        let fixes = crate::drives::fixes(&town(), &rows, &mut numbers);
        let noticed =
            fixes.iter().skip(kidnapped).position(|(fix, _)| fix.status != Status::Converged).unwrap();
        let driven_m = |i: usize| rows[kidnapped + i].1.driven_m;
        println!("noticed after {:.0} m", driven_m(noticed));
        converged += usize::from(fixes[kidnapped - 1].0.status == Status::Converged);
        assert!(driven_m(noticed) < 500.0, "{}", driven_m(noticed));
        let (last, truth) = fixes.last().unwrap();
        assert_eq!(last.status, Status::Converged);
        assert!((last.place_m - truth).norm() < last.level_m.unwrap());
        // Between, no other place is claimed for more than three seconds.
        let false_claims = fixes.iter().skip(kidnapped + noticed).map(|(fix, truth)| {
            fix.status == Status::Converged && (fix.place_m - truth).norm() > fix.level_m.unwrap()
        });
        assert!(longest_run(false_claims) <= 30);
    }
    assert_eq!(converged, 5);
}

/// The longest run of claims, rows.
pub(crate) fn longest_run(claims: impl Iterator<Item = bool>) -> usize {
    let mut longest = 0;
    let mut run = 0;
    for claim in claims {
        run = if claim { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    longest
}

/// Circles in a yard beside the road, which the map does not have: no road is claimed there, and afterwards the vehicle is found.
#[test]
fn a_yard_is_no_road_and_the_road_is_found_again_behind_it() {
    for seed in [5, 6, 7] {
        let mut numbers = Numbers(seed);
        let Road { line: road, .. } = line_of(&roads(), 2600.0, &mut numbers);
        let (leaves_m, radius_m) = (1000.0, 14.0);
        let (gate, ahead) = road.at(leaves_m);
        let left = Vector2::new(-ahead.y, ahead.x);
        let circle = (0..80)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 40.0)
            .map(|angle| gate + (ahead * libm::sin(angle) + left * (1.0 - libm::cos(angle))) * radius_m);
        let on = |from_m: f64, to_m: f64| road.part(from_m, to_m).unwrap().points().to_vec();
        let points: Vec<Point2<f64>> =
            on(0.0, leaves_m).into_iter().chain(circle).chain(on(leaves_m, road.length_m())).collect();
        let line = Polyline::new(points).unwrap();
        let rows = drive(&Road { line, lanes: Vec::new() }, typical_faults(&mut numbers), &mut numbers);
        let fixes = crate::drives::fixes(&town(), &rows, &mut numbers);
        let at = |from_m: f64, to_m: f64| {
            let inside = move |pose: &Pose| (from_m..to_m).contains(&pose.driven_m);
            rows.iter().zip(&fixes).filter(move |((_, pose), _)| inside(pose)).map(|(_, fix)| fix)
        };
        let yard_m = 2.0 * std::f64::consts::TAU * radius_m;
        let claims =
            at(leaves_m + 60.0, leaves_m + yard_m - 5.0).map(|(fix, _)| fix.status == Status::Converged);
        let longest = longest_run(claims);
        let lost =
            at(leaves_m, leaves_m + yard_m + 50.0).filter(|(fix, _)| fix.status == Status::Lost).count();
        println!("claimed in the yard for {longest} rows, lost in {lost}");
        assert!(longest <= 30 && lost > 0);
        let (last, truth) = fixes.last().unwrap();
        assert_eq!(last.status, Status::Converged);
        assert!((last.place_m - truth).norm() < last.level_m.unwrap());
    }
}

#[test]
fn rows_that_are_no_numbers_are_refused_and_late_ones_change_nothing() {
    let mut locator = Locator::new(&roads(), Traffic::Right, 1);
    let row = MotionSample { t_s: 1.0, speed_mps: 5.0, yaw_rate_rps: 0.0 };
    let first = locator.step(row).unwrap().unwrap();
    assert!(locator.step(MotionSample { speed_mps: f64::NAN, ..row }).is_err());
    let late = locator.step(MotionSample { t_s: 0.5, speed_mps: 50.0, ..row }).unwrap().unwrap();
    assert_eq!(late.place_m, first.place_m);
    assert_eq!(first.status, Status::Ambiguous);
}

//! Made-up drives in the built-in town with a GPS receiver that errs, jumps, falls silent and lies. Nothing of this may put the
//! vehicle outside its protection level, and it is found at least as soon as without GPS.

use fingerpost_locate::GpsEvidence;
use fingerpost_map::{OsmData, RoadGraph};
use nalgebra::{Point2, Vector2};

use crate::drives::{Drive, Numbers, Score, drive, line, score, typical_faults};

const TOWN: &[u8] = include_bytes!("../../../fingerpost-sim/assets/town.osm");
/// Time between two fixes of GPS, in rows of motion.
const ROWS: usize = 10;

/// Some drives with GPS that is off by `error` (metres, by the time in seconds), if it says anything, with 5 m of noise.
fn located(error: impl Fn(f64) -> Option<Vector2<f64>>) -> (Score, Vec<(f64, GpsEvidence)>) {
    located_by(|t_s, truths, noise| Some(truths.last()? + error(t_s)? + noise))
}

/// The same with the place that GPS gives, by the time (seconds), the true places up to then, one a row, and 5 m of noise.
fn located_by(
    place: impl Fn(f64, &[Point2<f64>], Vector2<f64>) -> Option<Point2<f64>>,
) -> (Score, Vec<(f64, GpsEvidence)>) {
    let osm = OsmData::from_bytes(TOWN).unwrap();
    let roads = RoadGraph::from_osm(&osm).unwrap();
    let mut all = Score::default();
    let mut evidence = Vec::new();
    for seed in 0..6 {
        let mut numbers = Numbers(200 + seed);
        let road = std::iter::repeat_with(|| line(&roads, 1200.0, &mut numbers)).flatten().next().unwrap();
        let rows = drive(&road, typical_faults(&mut numbers), &mut numbers);
        let mut located = Drive::of(&osm, &mut numbers);
        let (mut fixes, mut truths) = (Vec::new(), Vec::new());
        for (index, (row, pose)) in rows.iter().enumerate() {
            let truth = located.in_map(pose);
            truths.push(truth);
            let fix = located.locator.step(*row).unwrap().unwrap();
            fixes.push((fix, truth));
            let noise = Vector2::new(numbers.normal(5.0), numbers.normal(5.0));
            if let Some(place) = place(row.t_s, &truths, noise).filter(|_| index % ROWS == 0) {
                evidence.extend(located.locator.gps(place).map(|evidence| (row.t_s, evidence)));
            }
        }
        all.add(&score(&fixes, &rows));
    }
    println!("{all}");
    (all, evidence)
}

fn silent(_: f64) -> Option<Vector2<f64>> {
    None
}

fn exact(_: f64) -> Option<Vector2<f64>> {
    Some(Vector2::zeros())
}

/// Every drive converges, no sooner lost than without GPS, and keeps its level.
fn check(with: &Score) {
    let (without, _) = located(silent);
    assert_eq!((with.never_converged, with.violations), (0, 0));
    assert!(with.median_error_m() < without.median_error_m() + 0.5);
    assert!(with.converged_m.iter().sum::<f64>() <= without.converged_m.iter().sum::<f64>());
}

#[test]
fn noise_of_five_metres_helps() {
    check(&located(exact).0);
}

#[test]
fn a_constant_error_of_fifteen_metres_does_no_harm() {
    check(&located(|_| Some(Vector2::new(9.0, -12.0))).0);
}

#[test]
fn a_jump_of_a_hundred_metres_is_not_believed() {
    let jumps = |t_s: f64| {
        Some(if (60.0..90.0).contains(&t_s) { Vector2::new(80.0, 60.0) } else { Vector2::zeros() })
    };
    let (score, evidence) = located(jumps);
    check(&score);
    let during = evidence.iter().filter(|(t_s, _)| (60.0..90.0).contains(t_s));
    assert!(during.clone().count() > 100 && during.clone().all(|(_, evidence)| !evidence.believed));
    let outside = evidence.iter().filter(|(t_s, _)| *t_s > 90.0);
    assert!(outside.clone().all(|(_, evidence)| evidence.believed));
}

#[test]
fn a_minute_of_silence_does_no_harm() {
    check(&located(|t_s| (!(40.0..100.0).contains(&t_s)).then(Vector2::zeros)).0);
}

#[test]
fn a_drift_of_a_metre_a_second_is_given_up() {
    let (score, evidence) =
        located(|t_s| Some(Vector2::new((t_s - 30.0).max(0.0) * 0.8, (t_s - 30.0).max(0.0) * 0.6)));
    check(&score);
    assert!(evidence.iter().filter(|(t_s, _)| *t_s > 100.0).all(|(_, evidence)| !evidence.believed));
}

/// A receiver that has lost its sky and repeats its last place for ever, to the digit: it is believed no more but where a drive comes
/// by that place again, and moves nothing.
#[test]
fn a_place_that_is_repeated_for_ever_is_given_up() {
    let (score, evidence) =
        located_by(
            |t_s, truths, noise| {
                if t_s < 40.0 { Some(truths.last()? + noise) } else { truths.get(400).copied() }
            },
        );
    check(&score);
    let later: Vec<bool> =
        evidence.iter().filter(|(t_s, _)| *t_s > 70.0).map(|(_, evidence)| evidence.believed).collect();
    let believed = later.iter().filter(|believed| **believed).count();
    println!("{believed} of {} believed", later.len());
    assert!(later.len() > 100 && believed * 5 < later.len());
}

/// Places that come two seconds late lie up to 26 m behind the vehicle. They still tell the street, and the level is kept.
#[test]
fn places_that_are_two_seconds_late_do_no_harm() {
    check(&located_by(|_, truths, noise| Some(truths[truths.len().saturating_sub(21)] + noise)).0);
}

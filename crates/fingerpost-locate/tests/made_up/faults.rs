//! Motion logs that stop, repeat, run late, jump and lie, on made-up drives in the built-in town. A false place is one that is
//! farther from the truth than the alert limit, as on another road.

use fingerpost_locate::{ALERT_LIMIT_M, Fix, MotionSample, Status};
use fingerpost_map::{OsmData, RoadGraph};
use nalgebra::Point2;

use crate::drives::{Drive, Numbers, Pose, drive, line, typical_faults};
use crate::simulated::longest_run;

const TOWN: &[u8] = include_bytes!("../../../fingerpost-sim/assets/town.osm");
const SEEDS: u64 = 4;
/// Rows of three seconds.
const THREE_S: usize = 30;
/// What goes wrong begins at this row, a minute after the start, when most drives are converged.
const BEGINS: usize = 600;

/// What became of a drive.
struct Located {
    /// The fix after each row that was taken in, and the true place.
    fixes: Vec<(Fix, Point2<f64>)>,
    refused: usize,
}

impl Located {
    /// The longest false claim from a row on, rows.
    fn longest_false_claim(&self, from: usize) -> usize {
        longest_run(self.fixes.iter().skip(from).map(|(fix, truth)| {
            fix.status == Status::Converged && (fix.place_m - truth).norm() > ALERT_LIMIT_M
        }))
    }

    fn ends_converged(&self) -> bool {
        self.fixes.last().is_some_and(|(fix, _)| fix.status == Status::Converged)
    }
}

/// Drives of 2 km, of which a fault changes the rows.
fn located(fault: impl Fn(&mut Vec<(MotionSample, Pose)>)) -> Vec<Located> {
    let town = OsmData::from_bytes(TOWN).unwrap();
    let roads = RoadGraph::from_osm(&town).unwrap();
    let drives = (0..SEEDS).map(|seed| {
        let mut numbers = Numbers(400 + seed);
        let road = std::iter::repeat_with(|| line(&roads, 2000.0, &mut numbers)).flatten().next().unwrap();
        let mut rows = drive(&road, typical_faults(&mut numbers), &mut numbers);
        fault(&mut rows);
        let mut drive = Drive::of(&town, &mut numbers);
        let mut located = Located { fixes: Vec::new(), refused: 0 };
        for (row, pose) in &rows {
            match drive.locator.step(*row) {
                Ok(fix) => located.fixes.push((fix.unwrap(), drive.in_map(pose))),
                Err(_) => located.refused += 1,
            }
        }
        println!(
            "seed {seed}: falsely converged for {} rows, {} refused, at the end {:?}",
            located.longest_false_claim(0),
            located.refused,
            located.fixes.last().map(|(fix, _)| fix.status)
        );
        located
    });
    drives.collect()
}

/// No drive claims anything false for more than three seconds; gives how many are converged at their end.
fn check(drives: &[Located]) -> usize {
    assert!(drives.iter().all(|drive| drive.longest_false_claim(0) <= THREE_S));
    drives.iter().filter(|drive| drive.ends_converged()).count()
}

/// Nothing is measured for ten seconds, in which the vehicle drives a hundred metres and may turn: not converged in the row behind
/// the gap, and found again.
#[test]
fn a_gap_of_ten_seconds_is_known_and_mended() {
    let drives = located(|rows| drop(rows.drain(BEGINS..BEGINS + 100)));
    assert_eq!(check(&drives), drives.len());
    assert!(drives.iter().all(|drive| drive.fixes[BEGINS].0.status != Status::Converged));
}

/// After two minutes of silence the vehicle may be anywhere: all begins anew.
#[test]
fn a_gap_of_two_minutes_begins_anew() {
    let drives = located(|rows| {
        rows.iter_mut().skip(BEGINS).for_each(|(row, _)| row.t_s += 120.0);
    });
    check(&drives);
    assert!(drives.iter().all(|drive| drive.fixes[BEGINS].0.mass < 0.1));
}

/// Rows that come twice, and rows that come a second late, change nothing: all other fixes are as without them.
#[test]
fn rows_that_come_twice_or_late_change_nothing() {
    let clean = located(|_| ());
    let disturbed = located(|rows| {
        for index in (BEGINS..rows.len()).step_by(7).rev() {
            rows.insert(index + 1, rows[index]);
            rows.insert(index + 1, rows[index - 10]);
        }
    });
    for (clean, disturbed) in clean.iter().zip(&disturbed) {
        let last = |located: &Located| located.fixes.last().map(|(fix, _)| fix.clone());
        assert_eq!(last(clean), last(disturbed));
    }
}

/// One row in ten holds no number or a motion that no car makes: those are refused, and the vehicle stays found.
#[test]
fn rows_that_no_car_drives_are_refused() {
    let drives = located(|rows| {
        for (index, (row, _)) in rows.iter_mut().enumerate().filter(|(index, _)| index % 10 == 3) {
            match index % 4 {
                0 => row.speed_mps = f64::NAN,
                1 => row.speed_mps = 1e300,
                2 => row.yaw_rate_rps = -40.0,
                _ => row.yaw_rate_rps = f64::INFINITY,
            }
        }
    });
    assert_eq!(check(&drives), drives.len());
    assert!(drives.iter().all(|drive| drive.refused > drive.fixes.len() / 11));
}

/// The speed sticks at its value for twenty seconds: values that repeat to the last digit are not those of a sensor that lives, and the
/// vehicle goes on at any speed until they change. Nothing is converged meanwhile, and all are found again.
#[test]
fn a_speed_that_sticks_is_noticed_and_mended() {
    let drives = located(|rows| {
        let stuck_mps = rows[BEGINS].0.speed_mps;
        rows.iter_mut().skip(BEGINS).take(200).for_each(|(row, _)| row.speed_mps = stuck_mps);
    });
    assert_eq!(check(&drives), drives.len());
    let mut while_stuck = drives.iter().flat_map(|drive| &drive.fixes[BEGINS + 5..BEGINS + 200]);
    assert!(while_stuck.all(|(fix, _)| fix.status != Status::Converged));
}

/// The yaw rate is cut off at 0.15 rad/s, half of what a corner takes, from some moment on.
#[test]
fn a_yaw_rate_that_is_cut_off_is_contradicted_by_the_roads() {
    let drives = located(|rows| {
        for (row, _) in rows.iter_mut().skip(BEGINS) {
            row.yaw_rate_rps = row.yaw_rate_rps.clamp(-0.15, 0.15);
        }
    });
    check(&drives);
}

/// Consumer gyroscopes' scales are up to 3 % off: all converge, and no more of their rows are outside their level than of others'.
#[test]
fn a_yaw_rate_of_another_scale_keeps_the_protection_levels() {
    for scale in [1.03, 0.97] {
        let drives = located(|rows| rows.iter_mut().for_each(|(row, _)| row.yaw_rate_rps *= scale));
        assert_eq!(check(&drives), drives.len(), "{scale}");
        let claims = drives.iter().flat_map(|drive| &drive.fixes);
        let claims: Vec<_> = claims.filter(|(fix, _)| fix.status == Status::Converged).collect();
        let outside =
            claims.iter().filter(|(fix, truth)| (fix.place_m - truth).norm() > fix.level_m.unwrap());
        let part = outside.count() as f64 / claims.len() as f64;
        println!("scale {scale}: {part:.5} of {} rows are outside", claims.len());
        assert!(part <= 1e-3, "{scale}: {part}");
    }
}

/// The speed drops to zero for five seconds while the vehicle drives on: no tyres brake like that. Nothing is converged meanwhile, and
/// all are found again.
#[test]
fn a_speed_that_drops_to_zero_is_noticed_and_mended() {
    let drives = located(|rows| {
        rows.iter_mut().skip(BEGINS).take(50).for_each(|(row, _)| row.speed_mps = 0.0);
    });
    assert_eq!(check(&drives), drives.len());
    let mut at_zero = drives.iter().flat_map(|drive| &drive.fixes[BEGINS..BEGINS + 50]);
    assert!(at_zero.all(|(fix, _)| fix.status != Status::Converged));
}

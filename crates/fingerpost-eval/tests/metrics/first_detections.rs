//! First detections against dead reckoning, of hand-made runs.

use crate::made_by_hand::{drive_north, moved, record, seen};
use fingerpost_eval::{FirstDetection, evaluate_junctions, first_detections};
use fingerpost_format::FrameRecord;
use fingerpost_format::TrackState::{Searching, Tracking};

/// Node 3 is on the map alone; the map has node 1 half a metre too far.
const ROUTE: [(i64, f64); 3] = [(1, 10.5), (3, 20.0), (2, 30.0)];

/// A run that believes to be `ahead_m` farther than it is until frame 4.
fn run(ahead_m: f64) -> Vec<FrameRecord> {
    let believed = |frame: u64, record: FrameRecord| FrameRecord {
        route_m: Some(frame as f64 + ahead_m),
        ..moved(record, 1.0, 0.0)
    };
    (0..41)
        .map(|frame| {
            let seen = match frame {
                4 => seen(frame, Tracking, 1, 7.0, 0.0),
                5..=7 => seen(frame, Tracking, 1, 10.0 - frame as f64, 0.0),
                12 => seen(frame, Tracking, 3, 8.0, 0.0),
                _ => record(frame, Searching),
            };
            believed(frame, seen)
        })
        .collect()
}

fn assert_near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-9, "{found} is not {wanted}");
}

#[test]
fn the_first_frame_of_a_feature_is_held_against_the_frame_before() {
    let found = first_detections(&run(2.0), &drive_north(41), &ROUTE).unwrap();
    let [FirstDetection { detected_off_m, expected_off_m }] = found[..] else { panic!("{found:?}") };
    // It is 6 m ahead and seen at 7 m; expected it was at 10.5 m less 5 m that are believed and 1 m of motion.
    assert_near(detected_off_m, 1.0);
    assert_near(expected_off_m, 1.5);
}

#[test]
fn without_a_believed_place_nothing_was_expected() {
    let mut lost = run(2.0);
    lost[3].route_m = None;
    assert_eq!(first_detections(&lost, &drive_north(41), &ROUTE).unwrap(), []);
}

#[test]
fn a_feature_that_only_the_map_has_is_found_falsely_and_counts_as_no_other() {
    let ids: Vec<i64> = ROUTE.iter().map(|(id, _)| *id).collect();
    let evaluation = evaluate_junctions(&run(0.0), &drive_north(41), &ids).unwrap();
    assert_eq!((evaluation.summary.features_total, evaluation.summary.features_detected), (2, 1));
    assert_eq!(evaluation.summary.false_detections, 1);
    let of_missing: Vec<_> = evaluation.claims.iter().filter(|claim| claim.place == Some(1)).collect();
    assert!(of_missing.len() == 1 && of_missing[0].error.is_none(), "{of_missing:?}");
    let first = evaluation.claims[0].error.unwrap();
    assert_near(first.distance_m, 1.0);
    assert_near(first.per_sigma[0], 10.0);
}

//! Junction metrics of hand-made runs, computed by hand.

use crate::made_by_hand::{drive_north, moved, record, seen};
use fingerpost_eval::{EvalError, FeatureIdentity, evaluate_junctions, feature_summaries};
use fingerpost_format::TrackState::{Arrived, Lost, Searching, Tracking};
use fingerpost_format::{ErrorQuantiles, FixRecord, FrameRecord, TruthRecord};

const ROUTE: [i64; 2] = [1, 2];

/// Node 1 tracked in frames 2 to 4 (0.1, 0.2 and 0.5 m off), arrived in 5 to 9 (1 m off to the left); then nothing.
fn first_feature_found(frames: u64) -> Vec<FrameRecord> {
    (0..frames)
        .map(|frame| {
            let ahead_m = 10.0 - frame as f64;
            match frame {
                2 => seen(frame, Tracking, 1, ahead_m + 0.1, 0.0),
                3 => seen(frame, Tracking, 1, ahead_m, 0.2),
                4 => seen(frame, Tracking, 1, ahead_m - 0.3, -0.4),
                5..=9 => seen(frame, Arrived, 1, ahead_m, 1.0),
                _ => record(frame, Searching),
            }
        })
        .collect()
}

fn assert_near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-9, "{found} is not {wanted}");
}

fn assert_quantiles(found: Option<ErrorQuantiles>, wanted: [f64; 3]) {
    let found = found.unwrap();
    for (found, wanted) in [found.p50, found.p95, found.max].into_iter().zip(wanted) {
        assert_near(found, wanted);
    }
}

#[test]
fn detection_arrival_and_errors_by_hand() {
    let evaluation = evaluate_junctions(&first_feature_found(41), &drive_north(41), &ROUTE).unwrap();
    let summary = evaluation.summary;
    assert_eq!((summary.features_total, summary.features_detected), (2, 1));
    assert_eq!((summary.false_detections, summary.arrivals), (0, 1));
    assert_quantiles(summary.position_error_m, [0.2, 0.5, 0.5]);
    assert_quantiles(evaluation.arrived_position_error_m, [1.0, 1.0, 1.0]);
    assert_eq!((summary.motion_error_pct, summary.fix_error_m, summary.bound_violations), (None, None, None));
}

#[test]
fn fixes_are_measured_from_the_true_place_and_against_their_bound() {
    // At 60 degrees north, half as far to the east as to the north.
    let truth: Vec<_> =
        drive_north(4).into_iter().map(|truth| TruthRecord { lat: 60.0, lon: 10.0, ..truth }).collect();
    let fix = |north_deg: f64, east_deg: f64, bound_m: Option<f64>| FixRecord {
        lat: 60.0 + north_deg,
        lon: 10.0 + east_deg,
        heading_rad: 0.0,
        sigma_m: 1.0,
        bound_m,
        status: None,
        measurements: Vec::new(),
    };
    let fixes =
        [Some(fix(1e-4, 0.0, Some(11.0))), Some(fix(0.0, 1e-4, Some(11.0))), Some(fix(0.0, 0.0, None)), None];
    let run: Vec<_> = fixes
        .into_iter()
        .zip(0..)
        .map(|(fix, frame)| FrameRecord { fix, ..record(frame, Searching) })
        .collect();
    let summary = evaluate_junctions(&run, &truth, &[]).unwrap().summary;
    let error_m = summary.fix_error_m.unwrap();
    assert!((error_m.max - 11.12).abs() < 0.01 && (error_m.p50 - 5.56).abs() < 0.01, "{error_m:?}");
    assert_eq!(summary.bound_violations, Some(1));
}

#[test]
fn a_feature_that_stays_far_ahead_does_not_count() {
    let run =
        |frames: u64| evaluate_junctions(&first_feature_found(frames), &drive_north(41), &ROUTE).unwrap();
    assert_eq!(run(20).summary.features_total, 1, "the second is 11 m ahead at the end");
    assert_eq!(run(22).summary.features_total, 2, "9 m ahead");
}

#[test]
fn a_detection_at_the_wrong_place_is_false_and_detects_nothing() {
    let mut run: Vec<FrameRecord> = (0..41).map(|frame| record(frame, Searching)).collect();
    run[2] = seen(2, Tracking, 1, 11.2, 0.0);
    run[3] = seen(3, Tracking, 1, 7.0, 0.0);
    let summary = evaluate_junctions(&run, &drive_north(41), &ROUTE).unwrap().summary;
    assert_eq!((summary.false_detections, summary.features_detected), (1, 0));
    assert_quantiles(summary.position_error_m, [0.0, 3.2, 3.2]);
    run[2] = seen(2, Tracking, 1, 10.9, 0.0);
    let summary = evaluate_junctions(&run, &drive_north(41), &ROUTE).unwrap().summary;
    assert_eq!((summary.false_detections, summary.features_detected), (0, 1), "2.9 m off");
}

#[test]
fn a_detection_anew_after_a_loss_is_judged_anew() {
    let mut run = first_feature_found(41);
    run[3] = record(3, Lost);
    run[4] = seen(4, Tracking, 1, 10.0, 0.0);
    let summary = evaluate_junctions(&run, &drive_north(41), &ROUTE).unwrap().summary;
    assert_eq!((summary.false_detections, summary.features_detected), (1, 1));
}

#[test]
fn a_feature_that_was_passed_is_a_false_detection_however_near() {
    let mut run: Vec<FrameRecord> = (0..41).map(|frame| record(frame, Searching)).collect();
    run[12] = seen(12, Tracking, 1, -2.0, 0.0);
    let summary = evaluate_junctions(&run, &drive_north(41), &ROUTE).unwrap().summary;
    assert_eq!((summary.false_detections, summary.features_detected), (1, 0));
}

#[test]
fn the_feature_after_the_next_has_a_true_place_too() {
    // Node 2 is tracked while node 1, at which the run has arrived, is still the truth's next.
    let mut run = first_feature_found(41);
    run[9] = seen(9, Tracking, 2, 21.5, 0.0);
    let summary = evaluate_junctions(&run, &drive_north(41), &ROUTE).unwrap().summary;
    assert_eq!((summary.false_detections, summary.features_detected), (0, 2));
    assert_quantiles(summary.position_error_m, [0.2, 0.5, 0.5]);
}

#[test]
fn a_broken_frame_does_not_end_a_detection() {
    let mut run = first_feature_found(41);
    run[3] = FrameRecord { error: Some("torn".to_owned()), ..record(3, Tracking) };
    run[4] = seen(4, Tracking, 1, 16.0, 0.0);
    let summary = evaluate_junctions(&run, &drive_north(41), &ROUTE).unwrap().summary;
    assert_eq!(summary.false_detections, 0, "frame 4 goes on with the detection of frame 2");
}

#[test]
fn motion_is_compared_in_percent() {
    let run: Vec<FrameRecord> = (0..11).map(|frame| moved(record(frame, Searching), 0.9, 0.0)).collect();
    let summary = evaluate_junctions(&run, &drive_north(11), &ROUTE).unwrap().summary;
    assert_near(summary.motion_error_pct.unwrap(), 10.0);
}

#[test]
fn a_route_may_pass_a_node_twice() {
    let features = [7, 8, 7].map(|id| FeatureIdentity {
        id,
        name: String::new(),
        kind: "junction".to_owned(),
        at_m: 0.0,
    });
    let run = [
        seen(0, Tracking, 7, 5.0, 0.0),
        seen(1, Arrived, 7, 1.0, 0.0),
        seen(2, Tracking, 8, 6.0, 0.0),
        seen(3, Arrived, 8, 1.0, 0.0),
        record(4, Searching),
        seen(5, Tracking, 7, 9.0, 0.0),
    ];
    let summaries = feature_summaries(&run, &features);
    let detected: Vec<_> = summaries.iter().map(|s| (s.detected_frame, s.arrived_frame)).collect();
    assert_eq!(detected, [(Some(0), Some(1)), (Some(2), Some(3)), (Some(5), None)]);
    assert_eq!(summaries[2].detected_forward_m, Some(9.0));
    assert_eq!(summaries[2].max_p, Some(0.9));
}

#[test]
fn a_run_without_a_route_has_nothing_to_find() {
    let run: Vec<FrameRecord> = (0..5).map(|frame| record(frame, Searching)).collect();
    let summary = evaluate_junctions(&run, &drive_north(5), &[]).unwrap().summary;
    assert_eq!((summary.features_total, summary.position_error_m), (0, None));
}

#[test]
fn what_does_not_belong_together_is_refused_with_numbers() {
    let (run, truth) = (first_feature_found(41), drive_north(41));
    assert_eq!(evaluate_junctions(&[], &truth, &ROUTE), Err(EvalError::NoFrames));
    assert_eq!(
        evaluate_junctions(&run, &truth[..40], &ROUTE),
        Err(EvalError::NoTruth { frame: 40, truths: 40, first: 0, last: 39 })
    );
    assert_eq!(
        evaluate_junctions(&run, &truth, &[2]),
        Err(EvalError::OtherRoute { frame: 0, id: 1, features: 1 })
    );
    let mut shuffled = run;
    shuffled.swap(3, 4);
    assert_eq!(
        evaluate_junctions(&shuffled, &truth, &ROUTE),
        Err(EvalError::NotAscending { what: "run", frame: 3, before: 4 })
    );
}

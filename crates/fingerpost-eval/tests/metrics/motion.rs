//! Motion metrics of hand-made runs, computed by hand.

use std::f64::consts::FRAC_PI_2;

use crate::made_by_hand::{drive_north, moved, record};
use fingerpost_eval::{EvalError, PosesError, evaluate_motion, poses_from_kitti, poses_from_truth};
use fingerpost_format::TrackState::NoRoute;
use fingerpost_format::{FrameRecord, MotionRecord};

fn assert_near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-9, "{found} is not {wanted}");
}

#[test]
fn distance_heading_and_steps_by_hand() {
    let mut run: Vec<FrameRecord> = (0..11).map(|frame| moved(record(frame, NoRoute), 1.1, 0.01)).collect();
    run[0].motion = None;
    let evaluation = evaluate_motion(&run, &poses_from_truth(&drive_north(11))).unwrap();
    assert_eq!(evaluation.steps, 10);
    assert_near(evaluation.distance_m, 11.0);
    assert_near(evaluation.true_distance_m, 10.0);
    assert_near(evaluation.motion_error_pct, 10.0);
    assert_near(evaluation.end_heading_error_deg, 0.1_f64.to_degrees());
    assert_near(evaluation.forward_error_m.unwrap().max, 0.1);
    assert_near(evaluation.left_error_m.unwrap().max, 0.0);
    assert_near(evaluation.yaw_error_deg.unwrap().p50, 0.01_f64.to_degrees());
}

#[test]
fn a_step_over_a_broken_frame_is_compared_as_one() {
    let mut run: Vec<FrameRecord> = (0..4).map(|frame| moved(record(frame, NoRoute), 1.0, 0.0)).collect();
    run[2] = FrameRecord { error: Some("torn".to_owned()), ..record(2, NoRoute) };
    run[3] = moved(record(3, NoRoute), 2.0, 0.0);
    let evaluation = evaluate_motion(&run, &poses_from_truth(&drive_north(4))).unwrap();
    assert_eq!(evaluation.steps, 2);
    assert_near(evaluation.motion_error_pct, 0.0);
}

#[test]
fn kitti_poses_turn_left_about_a_falling_y_axis() {
    // One metre forward, then a left turn on the spot: the camera's z axis goes to the first camera's negative x.
    let text = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n0 0 -1 -0.5 0 1 0 0 1 0 0 1\n";
    let poses = poses_from_kitti(text).unwrap();
    assert_near(poses[&1].x_m, 1.0);
    assert_near(poses[&1].heading_rad, 0.0);
    assert_near(poses[&2].y_m, 0.5);
    assert_near(poses[&2].heading_rad, FRAC_PI_2);
    let mut run = vec![
        record(0, NoRoute),
        moved(record(1, NoRoute), 1.0, 0.0),
        moved(record(2, NoRoute), 0.0, FRAC_PI_2),
    ];
    run[2].motion = run[2].motion.map(|motion| MotionRecord { left_m: 0.5, ..motion });
    let evaluation = evaluate_motion(&run, &poses).unwrap();
    assert_near(evaluation.motion_error_pct, 0.0);
    assert_near(evaluation.end_heading_error_deg, 0.0);
    assert_near(evaluation.left_error_m.unwrap().max, 0.0);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let run: Vec<FrameRecord> = (0..3).map(|frame| record(frame, NoRoute)).collect();
    assert_eq!(evaluate_motion(&run, &poses_from_truth(&drive_north(3))), Err(EvalError::NoMotion));
    let run: Vec<FrameRecord> = (0..3).map(|frame| moved(record(frame, NoRoute), 0.0, 0.0)).collect();
    let standing: Vec<_> = drive_north(3)
        .into_iter()
        .map(|mut truth| {
            truth.y_m = 0.0;
            truth
        })
        .collect();
    assert_eq!(evaluate_motion(&run, &poses_from_truth(&standing)), Err(EvalError::Standing));
    assert_eq!(
        poses_from_kitti("1 0 0 0 0 1 0 0 0 0 1 0\n\n1 2 x\n"),
        Err(PosesError::Line { line: 3, found: 2 })
    );
    // Twelve numbers with another word between them are no pose.
    assert_eq!(poses_from_kitti("1 0 0 0 0 1 x 0 0 0 0 1 0\n"), Err(PosesError::Line { line: 1, found: 12 }));
    assert_eq!(poses_from_kitti("nan 0 0 0 0 1 0 0 0 0 1 0\n"), Err(PosesError::Line { line: 1, found: 11 }));
}

//! The papers' motion beside the method's on simulated drives, where every step is known.
//!
//! `cargo test -p fingerpost-papers --test motion -- --nocapture` prints the table.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "../../fingerpost/tests/simulated/mod.rs"]
mod simulated;

use fingerpost::motion::{
    DirectMotion, DirectMotionConfig, FarnebackMotionConfig, FlowModel, MotionEstimator, MotionMethod,
};
use fingerpost::{Config, Pipeline};
use fingerpost_papers::FarnebackMotion;
use nalgebra::Vector3;
use simulated::{camera, is_measured_in_other_views, motions, rms, turns};

fn farneback(model: FlowModel) -> FarnebackMotion {
    FarnebackMotion::new(&FarnebackMotionConfig { model, ..FarnebackMotionConfig::default() }).unwrap()
}

#[test]
fn direct_alignment_is_more_accurate_than_flow() {
    println!("{:<9} {:<7} {:>9} {:>9} {:>9}", "drive", "method", "fwd cm", "left cm", "yaw mrad");
    for drive in turns() {
        let name = drive.name;
        let errors = |method: &str, estimator: &mut dyn MotionEstimator| {
            let rms = rms(&drive, &motions(&drive, estimator));
            let shown = rms.component_mul(&Vector3::new(100.0, 100.0, 1000.0));
            println!("{name:<9} {method:<7} {:>9.2} {:>9.2} {:>9.2}", shown.x, shown.y, shown.z);
            rms
        };
        let direct = errors("direct", &mut DirectMotion::new(&DirectMotionConfig::default()));
        let mean = errors("mean", &mut farneback(FlowModel::Mean));
        let rigid = errors("rigid", &mut farneback(FlowModel::Rigid));
        assert!(
            (0..3).all(|axis| direct[axis] < 0.5 * mean[axis]),
            "{name}: half of what the mean flow errs"
        );
        assert!(
            name == "rough" || (0..3).all(|axis| direct[axis] < rigid[axis]),
            "{name}: better than the rigid fit to the flow"
        );
    }
}

#[test]
fn another_ground_view_starts_anew() {
    let measured = is_measured_in_other_views(&mut farneback(FlowModel::Rigid));
    assert_eq!(measured, [false, true, false, true]);
}

#[test]
fn flow_that_is_asked_for_and_not_given_is_refused_with_what_to_do() {
    let mut config = Config::default();
    config.motion.estimator = MotionMethod::Farneback;
    let refused = Pipeline::new(&config, &camera(), None, None).err().unwrap().to_string();
    for words in ["motion.estimator = \"farneback\"", "fingerpost_papers::parts", "\"direct\""] {
        assert!(refused.contains(words), "{refused}");
    }
    let parts = fingerpost_papers::parts(&config).unwrap();
    assert!(Pipeline::with_parts(&config, &camera(), None, None, parts).is_ok());
}

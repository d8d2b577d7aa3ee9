//! What a frame says decided it must have decided it: value and bound of every test, on drives that pass and fail them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use std::collections::BTreeMap;

use crate::painted::{Junction, Place, World, camera, route};
use fingerpost::track::{Decision, Lack, TrackEvidence};
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_map::FeatureKind;
use nalgebra::{Isometry2, Vector2};

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const NORTH: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];
/// Leaves 14 m north of where the map has it.
const LATE_EAST: &[Place] = &[(0.0, 14.0), (60.0, 14.0)];

/// Asserts that what decided a frame lies on the side of its bound that the decision tells, and names the decision.
fn held(config: &Config, output: &FrameOutput, evidence: &TrackEvidence) -> &'static str {
    let text = &output.why;
    let says = |number: f64| assert!(text.contains(&format!("{number:.2}")), "{number} is not in: {text}");
    let lacks = |lack: &Lack| match *lack {
        Lack::Presence { present, needed } => {
            assert!(present < needed, "{text}");
            [present, needed].into_iter().for_each(says);
        }
        Lack::Place { present, sigma_m, most_m } => {
            assert!(sigma_m > most_m, "{text}");
            [present, sigma_m, most_m].into_iter().for_each(says);
        }
    };
    let is_there = |least: f64| {
        let followed = output.track.followed.as_ref().expect("what is there is followed");
        assert!(followed.present >= least, "{least}: {text}");
        says(followed.present);
        followed.covariance.fixed_view::<2, 2>(0, 0).trace().sqrt()
    };
    match &evidence.decision {
        Decision::NotInReach { ahead_m, .. } => {
            let far_m = config.ground_view.far_m;
            assert!(!(0.5 * far_m..far_m).contains(ahead_m), "{text}");
            assert!(text.contains(&format!("{:.0} m", ahead_m.abs())), "{ahead_m} is not in: {text}");
            "not in reach"
        }
        Decision::NotFound { places, .. } => {
            assert!(evidence.places.is_empty() && evidence.sought.is_none(), "{text}");
            assert!(*places > 0 && text.contains(&format!("{places} places")), "{text}");
            "not found"
        }
        Decision::NotSure { lack, .. } => {
            lacks(lack);
            "not sure"
        }
        Decision::NoLongerSure { lack, .. } => {
            lacks(lack);
            "no longer sure"
        }
        Decision::NextUnknown { likeliest, rival } => {
            assert!(likeliest.1 >= rival.1, "{text}");
            [likeliest.1, rival.1].into_iter().for_each(says);
            "next unknown"
        }
        Decision::Detected => {
            assert!(is_there(config.track.detect_present) <= config.track.detect_sigma_m, "{text}");
            "detected"
        }
        Decision::Confirmed => {
            is_there(config.track.lost_present);
            "confirmed"
        }
        Decision::Arrived => "arrived",
        Decision::Passing => "passing",
        _ => "another",
    }
}

/// How often each decision came over these roads, with a start and without.
fn decisions_on(roads: &[(&[Place], f64)]) -> BTreeMap<&'static str, usize> {
    let (camera, world, kind) = (camera(), World::new(roads), FeatureKind::Junction);
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: 5.5 };
    let (route, _) = route(&junction);
    let config = Config::default();
    let mut pipelines =
        [None, Some(20.0)].map(|start_m| Pipeline::new(&config, &camera, Some(&route), start_m).unwrap());
    let mut seen = BTreeMap::new();
    for i in 0..50 {
        let y = -38.0 + 0.7 * f64::from(i);
        let map_from_vehicle = Isometry2::new(Vector2::new(0.2, y), std::f64::consts::FRAC_PI_2);
        let frame = world.picture(&camera, &map_from_vehicle);
        for pipeline in &mut pipelines {
            let (output, evidence) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
            *seen.entry(held(&config, output, evidence.track)).or_default() += 1;
            for absurd in ["-0.00", "-0 ", "NaN", "inf", " 1 frames"] {
                assert!(!output.why.contains(absurd), "{roads:?}: {}", output.why);
            }
        }
    }
    seen
}

#[test]
fn every_decision_is_what_its_numbers_say() {
    let worlds: [&[(&[Place], f64)]; 6] = [
        &[(SOUTH, 5.5), (EAST, 5.5), (WEST, 5.5)],
        &[(SOUTH, 5.5), (NORTH, 5.5)],
        &[(SOUTH, 5.5), (NORTH, 5.5), (LATE_EAST, 5.5)],
        &[(SOUTH, 9.0), (NORTH, 9.0), (EAST, 9.0)],
        &[(SOUTH, 3.0), (NORTH, 3.0), (WEST, 4.0)],
        &[(SOUTH, 30.0), (NORTH, 30.0)],
    ];
    // A drive has one thread.
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    std::thread::scope(|scope| {
        let drives = worlds.map(|roads| scope.spawn(move || decisions_on(roads)));
        for (decision, times) in drives.into_iter().flat_map(|drive| drive.join().unwrap()) {
            *seen.entry(decision).or_default() += times;
        }
    });
    for decision in ["not in reach", "not sure", "detected", "confirmed"] {
        assert!(seen.contains_key(decision), "{decision} never came: {seen:?}");
    }
    assert!(seen.len() >= 6, "too few kinds of decisions: {seen:?}");
}

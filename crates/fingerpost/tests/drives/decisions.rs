//! What a frame says decided it must have decided it: value and bound of every test, on drives that pass and fail them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use std::collections::BTreeMap;

use crate::painted::{Junction, Place, World, camera, route};
use fingerpost::track::{Decision, Missing, TrackEvidence};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_map::FeatureKind;
use nalgebra::{Isometry2, Vector2};

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const NORTH: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];
/// Leaves 14 m north of where the map has it.
const LATE_EAST: &[Place] = &[(0.0, 14.0), (60.0, 14.0)];

/// Asserts that what decided a frame lies on the side of its bound that the decision tells, and names the decision.
fn held(evidence: &TrackEvidence, text: &str) -> &'static str {
    let says = |number: f64| assert!(text.contains(&format!("{number:.2}")), "{number} is not in: {text}");
    match &evidence.decision {
        Decision::NotFound { .. } => {
            if let Some(p) = evidence.sought.as_ref().and_then(|sought| sought.matched.p) {
                let needed_p = evidence.needed_p.expect("a search has a bound");
                // Scores come from sums in single precision.
                assert!(p < needed_p + 1e-4, "{p} against {needed_p}: {text}");
                says(needed_p);
            }
            "not found"
        }
        Decision::EdgesDisagree { aligned_p, needed_p, .. } => {
            assert!(aligned_p < needed_p, "{text}");
            says(*aligned_p);
            says(*needed_p);
            "edges disagree"
        }
        Decision::NoVergeInView { p, needed_p, .. } => {
            assert!(p < needed_p, "{text}");
            says(*needed_p);
            "no verge in view"
        }
        Decision::NotExpected { surprise, most, .. } => {
            assert!(surprise >= most, "{text}");
            says(*surprise);
            "not expected"
        }
        Decision::OffApproach { beside_m, most_m, .. } => {
            assert!(beside_m > most_m, "{text}");
            "off the approach"
        }
        Decision::Dropped { frames, most_frames, .. } => {
            assert!(frames > most_frames, "{text}");
            "dropped"
        }
        Decision::Candidate { frames, missing, .. } => {
            match missing {
                Missing::Frames { needed } => assert!(frames < needed, "{text}"),
                Missing::Contrast { sum, needed } => assert!(sum < needed, "{text}"),
                Missing::Distance { sigma_m, most_m } => assert!(sigma_m > most_m, "{text}"),
            }
            "candidate"
        }
        Decision::Confirmed => {
            if let Some((p, needed_p)) = evidence.predicted_p.zip(evidence.needed_p) {
                assert!(p >= needed_p, "{text}");
                says(needed_p);
            }
            "confirmed"
        }
        Decision::NotConfirmed { .. } | Decision::Lost { .. } => {
            let (p, needed_p) = evidence.predicted_p.zip(evidence.needed_p).expect("both are known");
            assert!(p < needed_p, "{text}");
            "not confirmed"
        }
        Decision::Detected => "detected",
        _ => "another",
    }
}

/// How often each decision came over these roads, with a start and without.
fn decisions_on(roads: &[(&[Place], f64)]) -> BTreeMap<&'static str, usize> {
    let (camera, world, kind) = (camera(), World::new(roads), FeatureKind::Junction);
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: 5.5 };
    let (route, _) = route(&junction);
    let mut pipelines = [None, Some(20.0)]
        .map(|start_m| Pipeline::new(&Config::default(), &camera, Some(&route), start_m).unwrap());
    let mut seen = BTreeMap::new();
    for i in 0..50 {
        let y = -38.0 + 0.7 * f64::from(i);
        let map_from_vehicle = Isometry2::new(Vector2::new(0.2, y), std::f64::consts::FRAC_PI_2);
        let frame = world.picture(&camera, &map_from_vehicle);
        for pipeline in &mut pipelines {
            let (output, evidence) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
            *seen.entry(held(evidence.track, &output.why)).or_default() += 1;
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
    for decision in ["not found", "candidate", "detected", "confirmed"] {
        assert!(seen.contains_key(decision), "{decision} never came: {seen:?}");
    }
    assert!(seen.len() >= 6, "too few kinds of decisions: {seen:?}");
}

use super::*;
use crate::centreline::{WayKind, Ways};
use crate::lanes::departure::Silence;
use crate::mount::{MountAngle, MountContradiction};
use crate::track::Lack;
use crate::vehicle_signals::Disagreement;

#[test]
fn the_lanes_edges_are_seen_kept_or_none() {
    let words = |kept_frames, followed| LaneWords { kept_frames, followed }.to_string();
    assert_eq!(words([Some(0), Some(0)], [true, true]), "both edges of the lane are seen");
    assert_eq!(words([None, None], [false, false]), "no edge of a lane is seen");
    assert_eq!(
        words([Some(0), Some(4)], [true, true]),
        "the lane's left edge is seen, its right edge has not been seen for 4 frames and is kept"
    );
    assert_eq!(
        words([None, None], [true, false]),
        "the lane's left edge is not sure yet, its right edge is not seen"
    );
}

#[test]
fn what_decided_where_road_is_is_said() {
    let words = |by_colours| RoadWords { by_colours }.to_string();
    assert_eq!(words(0.0), "the network decided what is road");
    let joined = "the network decided what is road, in 7 % of the places the colours of this drive";
    assert_eq!(words(0.068), joined);
}

#[test]
fn a_departure_is_warned_of_or_its_silence_explained() {
    let words = |warning, silence| {
        let departure = DepartureOutput { warning, silence, ..DepartureOutput::default() };
        DepartureWords(&departure).to_string()
    };
    assert_eq!(words(None, None), "");
    assert_eq!(words(Some(Side::Right), None), "; warning: the vehicle leaves the lane to the right");
    assert_eq!(
        words(None, Some(Silence::TurnSignal)),
        "; a wheel is at an edge, no warning because the driver signals"
    );
}

#[test]
fn what_does_not_agree_is_said_with_both_values_and_the_bound() {
    let between = |bus, camera| Some(Disagreement { bus, camera, allowed_share: 0.12 });
    let words = |evidence: SignalsEvidence| SignalsWords(&evidence).to_string();
    assert_eq!(words(SignalsEvidence::default()), "");
    let speed = words(SignalsEvidence { speed_disagreement: between(163.2, 124.8), ..Default::default() });
    let yaw_rate = words(SignalsEvidence { yaw_rate_disagreement: between(-1.0, 1.0), ..Default::default() });
    let said = |text: &str, words: &[&str]| assert!(words.iter().all(|word| text.contains(word)), "{text}");
    said(&speed, &["163 m against 125 m", "at most 12 %", "can.speed_unit", "height"]);
    said(&yaw_rate, &["-57 degrees against 57", "at most 12 %", "can.yaw_rate_positive"]);
    let contradiction = MountContradiction { angle: MountAngle::Pitch, by_rad: -0.2, most_rad: 0.08 };
    let pitch = MountContradictionWords(&contradiction).to_string();
    said(&pitch, &["pitch", "-11.5 degrees off", "at most 4.6", "anew"]);
}

#[test]
fn a_place_on_the_map_is_said_with_what_was_measured_of_it() {
    use fingerpost_locate::{GpsEvidence, PoseInnovation, SightingEvidence, Verdict};
    let words = |evidence| FixWords { evidence: &evidence, stops: &[] }.to_string();
    assert_eq!(words(FixEvidence::default()), "");
    let innovation = PoseInnovation { off: [-3.21, 0.4, 0.01], sigma: [4.0, 2.0, 0.1] };
    let seen =
        |verdict, innovation| Some(SightingEvidence { landmark: 0, innovation, present: 0.97, verdict });
    let accepted =
        words(FixEvidence { feature: seen(Verdict::Accepted, Some(innovation)), ..FixEvidence::default() });
    assert!(accepted.contains("3.2 m back and 0.4 m to the left"), "{accepted}");
    let refused = words(FixEvidence { feature: seen(Verdict::Disagrees, None), ..FixEvidence::default() });
    assert!(refused.contains("does not count: no possible place"), "{refused}");
    let gps = |believed| Some(GpsEvidence { innovation_m: [60.0, 80.0], believed });
    let jump = words(FixEvidence { gps: gps(false), ..FixEvidence::default() });
    assert_eq!(jump, "; GPS 100.0 m off and not believed");
    assert_eq!(words(FixEvidence { gps: gps(true), ..FixEvidence::default() }), "; GPS 100.0 m off");
}

#[test]
fn a_driving_line_that_is_too_tight_is_said_with_both_radii() {
    let words = TooTightWords { tightest_radius_m: 8.49, turning_radius_m: 9.0 }.to_string();
    assert_eq!(words, "the driving line turns at 8.49 m, the vehicle at no less than 9.00 m");
}

fn feature_words(decision: Decision) -> String {
    let track = TrackOutput::default();
    let evidence = TrackEvidence { decision, ..TrackEvidence::default() };
    let why = Why {
        motion_doubt: None,
        camera: &CameraEvidence::default(),
        track: &track,
        evidence: &evidence,
        stops: &[],
        mount: None,
        signals: None,
        lane: None,
        turns_through: false,
        centreline: &CentrelineEvidence::default(),
        by_colours: None,
        departure: None,
        fix: None,
    };
    why.to_string()
}

/// Numbers of every size that a decision may hold.
const NUMBERS: [f64; 9] = [0.0, 1e-9, 0.004, 0.25, 0.5, 0.999, 1.0, 37.25, 3_523_697.8];

#[test]
fn what_a_feature_lacks_is_said_with_its_value_and_the_bound_that_it_missed() {
    let (index, present) = (0, 0.875);
    for value in NUMBERS {
        for bound in NUMBERS {
            let presence = Lack::Presence { present: value, needed: bound };
            let place = Lack::Place { present, sigma_m: value, most_m: bound };
            for (lack, words) in [
                (presence, [format!("probability {value:.2}"), format!("{bound:.2} is needed")]),
                (place, [format!("known to {value:.2} m"), format!("{bound:.2} m is needed")]),
            ] {
                for decision in [Decision::NotSure { index, lack }, Decision::NoLongerSure { index, lack }] {
                    let text = feature_words(decision);
                    assert!(words.iter().all(|words| text.contains(words)), "{words:?} in {text}");
                    assert!(!text.contains('-'), "{text}");
                }
            }
        }
    }
}

#[test]
fn what_lies_behind_is_not_said_to_be_ahead() {
    for ahead_m in [-3_523_697.8, -12.0, -0.6, -1e-9, 0.0, 0.4, 7.0, 440.0] {
        let text = feature_words(Decision::NotInReach { index: 0, ahead_m });
        let side = if ahead_m < 0.0 { "behind" } else { "ahead" };
        assert!(text.contains(&format!("{:.0} m {side}", ahead_m.abs())), "{text}");
        assert!(!text.contains('-'), "{text}");
    }
}

#[test]
fn a_road_that_forks_is_said_with_its_ways() {
    let ways = Ways { probability: [0.52, 0.0, 0.48], kind: WayKind::Left, ..Ways::default() };
    let words = WaysWords(&ways).to_string();
    assert_eq!(words, "the road ahead is ambiguous: to the left 0.52, to the right 0.48");
}

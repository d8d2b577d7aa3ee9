//! Rule texts that a person got wrong, and one of their own.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost_control::{
    ControlError, ControllerName, DEFAULT_RULES, FuzzyError, RuleBase, Situation, Steersman, VehicleLimits,
    arc,
};

const OWN: &str = "
    input offset_deg -30 30
      right -30 -30 0
      left    0 30 30
    output turn_deg -60 60
      to_right -60 -30 0
      to_left    0 30 60
    rule if offset_deg is left then turn_deg is to_right
    rule if offset_deg is right then turn_deg is to_left";

fn error(text: &str) -> FuzzyError {
    Steersman::new(ControllerName::Fuzzy, VehicleLimits::default(), text).unwrap_err()
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    for (from, to, line, words) in [
        (
            "rule if",
            "rule when",
            "line 8",
            "\"when offset_deg is left then turn_deg is to_right\" is not understood",
        ),
        ("is left then", "is lefft then", "line 8", "there is no term \"lefft\"; there are right, left"),
        ("if offset_deg", "if ofset_deg", "line 8", "there is no input \"ofset_deg\"; there are offset_deg"),
        ("right -30 -30 0", "right -30 0 -30", "line 3", "give three or four corners in ascending order"),
        ("left    0 30 30", "left 0 thirty 30", "line 4", "\"thirty\" cannot be used; give a number"),
        ("left    0 30 30", "right 0 30 30", "line 4", "\"right\" is there already"),
        ("-60 60\n", "60 -60\n", "line 5", "a least value below the greatest"),
        ("input", "entry", "line 2", "is not understood; write \"input NAME FROM TO\""),
    ] {
        assert!(OWN.contains(from), "{from}");
        let error = error(&OWN.replacen(from, to, 1)).to_string();
        assert!(error.starts_with(line) && error.contains(words), "{error}");
    }
}

#[test]
fn what_means_nothing_to_the_controller_is_named() {
    let error_of = |from: &str, to: &str| error(&OWN.replace(from, to)).to_string();
    assert!(
        error_of("offset_deg", "wind_mps")
            .contains("input \"wind_mps\", which means nothing here; there are offset_deg")
    );
    assert!(error_of("turn_deg", "horn").contains("output \"horn\""));
    assert!(error("").to_string().contains("no input"));
}

#[test]
fn every_shipped_rule_can_be_read_back() {
    let base = RuleBase::parse(DEFAULT_RULES).unwrap();
    let again =
        DEFAULT_RULES.lines().filter(|line| line.starts_with("rule ")).map(|line| &line["rule ".len()..]);
    assert!(base.rules().eq(again) && base.rules().len() == 32);
}

#[test]
fn rules_of_ones_own_fire_and_where_none_does_the_vehicle_is_not_steered() {
    let mut steersman = Steersman::new(ControllerName::Fuzzy, VehicleLimits::default(), OWN).unwrap();
    let mut path = Vec::new();
    let mut steer = |left_m: f64| {
        arc(left_m, 0.0, 0.0, [20.0, 0.5], &mut path);
        let situation = Situation {
            path: &path,
            speed_mps: 5.0,
            steer_rad: 0.0,
            lateral_sigma_m: 0.05,
            room_m: 1.0,
            present: 1.0,
            seen_ahead_m: 20.0,
            turn_ahead: None,
        };
        let command = steersman.steer(&situation, None);
        (command, steersman.evidence().rules.iter().map(|rule| rule.number).collect::<Vec<_>>())
    };
    let (command, fired) = steer(-1.0);
    assert!(command.unwrap().steer_rad < -0.1 && fired == [1]);
    let (command, fired) = steer(1.0);
    assert!(command.unwrap().steer_rad > 0.1 && fired == [2]);
    let (command, fired) = steer(0.0);
    assert_eq!((command, fired), (Err(ControlError::NoRule { output: "turn_deg" }), Vec::new()));
}

//! Whatever the situation, a command is one that the vehicle can follow.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost_control::{
    ControlError, ControllerName, DEFAULT_RULES, Moving, Situation, Steersman, VehicleLimits, arc,
};
use proptest::prelude::*;

/// Limits of vehicles from a robot to a lorry.
fn vehicles() -> impl Strategy<Value = VehicleLimits> {
    (0.3_f64..8.0, 0.5_f64..30.0, 0.05_f64..3.0, 0.5_f64..4.0, 0.5_f64..5.0).prop_map(
        |(wheelbase_m, turning_radius_m, rate, lateral, brakes)| VehicleLimits {
            wheelbase_m,
            turning_radius_m,
            steering_rate_radps: rate,
            lateral_acceleration_mps2: lateral,
            deceleration_mps2: brakes,
            ..VehicleLimits::default()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None,
        rng_seed: prop::test_runner::RngSeed::Fixed(24), ..ProptestConfig::default() })]

    #[test]
    fn a_command_can_be_followed(
        limits in vehicles(),
        (left_m, heading_rad, curvature_per_m, length_m) in (-6.0_f64..6.0, -3.0_f64..3.0, -0.5_f64..0.5, 0.5_f64..40.0),
        (speed_mps, asked_share, lateral_sigma_m, present, seen_ahead_m) in
            (0.0_f64..30.0, -1.0_f64..1.0, 0.0_f64..3.0, 0.0_f64..1.0, 0.0_f64..60.0),
        dt_s in 0.0_f64..0.5,
    ) {
        let mut path = Vec::new();
        arc(left_m, heading_rad, curvature_per_m, [length_m, 0.5], &mut path);
        let steer_rad = asked_share * limits.steer_max_rad();
        let situation =
            Situation { path: &path, speed_mps, steer_rad, lateral_sigma_m, room_m: 1.0, present, seen_ahead_m, turn_ahead: None };
        for name in ControllerName::ALL {
            let mut steersman = Steersman::new(name, limits, DEFAULT_RULES).unwrap();
            let command = steersman.steer(&situation, Some(dt_s)).unwrap();
            prop_assert!(command.steer_rad.abs() <= limits.steer_max_rad() + 1e-9);
            prop_assert!((command.steer_rad - steer_rad).abs() <= limits.steering_rate_radps * dt_s + 1e-9);
            prop_assert!(command.speed_mps >= 0.0 && command.speed_mps <= limits.speed_max_mps);
            let v = command.speed_mps;
            let to_side = v * v * limits.curvature_per_m(command.steer_rad).abs();
            prop_assert!(to_side <= limits.lateral_acceleration_mps2 + 1e-9);
            // It stops within what it sees.
            let stops_m = v * v / (2.0 * limits.deceleration_mps2) + v * limits.reaction_s;
            prop_assert!(stops_m <= seen_ahead_m + 1e-9);
            // The plan says why it goes no faster, where neither rules nor the turn that is wanted do.
            let is_planned = (v - steersman.speed_plan().speed_mps).abs() < 1e-9;
            prop_assert!(name == ControllerName::Fuzzy || steersman.evidence().limited.speed || is_planned);
            // The same situation is steered the same again, by the same steersman and by another.
            prop_assert_eq!(steersman.steer(&situation, Some(dt_s)), Ok(command));
        }
    }

    #[test]
    fn what_is_no_number_is_refused(which in 0_usize..6, number in prop::sample::select(vec![f64::NAN, f64::INFINITY])) {
        let mut path = Vec::new();
        arc(0.5, 0.1, 0.0, [20.0, 0.5], &mut path);
        if which == 5 {
            path[3].y_m = number;
        }
        let of = |i: usize, good: f64| if i == which { number } else { good };
        let situation = Situation {
            path: &path,
            speed_mps: of(0, 5.0),
            steer_rad: of(1, 0.0),
            lateral_sigma_m: of(2, 0.1),
            room_m: 1.0,
            present: of(3, 1.0),
            seen_ahead_m: of(4, 20.0),
            turn_ahead: None,
        };
        for name in ControllerName::ALL {
            let mut steersman = Steersman::new(name, VehicleLimits::default(), DEFAULT_RULES).unwrap();
            let refused = matches!(steersman.steer(&situation, Some(0.1)), Err(ControlError::NotFinite { .. }));
            prop_assert!(refused, "{name:?}");
        }
    }
}

#[test]
fn a_path_without_length_leads_nowhere() {
    for points in 0..2 {
        let path = vec![fingerpost_control::PathPoint::default(); points];
        let situation = Situation {
            path: &path,
            speed_mps: 5.0,
            steer_rad: 0.0,
            lateral_sigma_m: 0.1,
            room_m: 1.0,
            present: 1.0,
            seen_ahead_m: 20.0,
            turn_ahead: None,
        };
        let mut steersman =
            Steersman::new(ControllerName::Stanley, VehicleLimits::default(), DEFAULT_RULES).unwrap();
        assert_eq!(steersman.steer(&situation, None), Err(ControlError::NoPath { points }));
    }
}

#[test]
fn a_quarter_of_a_circle_is_driven_to_its_end() {
    let limits = VehicleLimits::default();
    let steer_rad = limits.steer_rad(-0.1);
    let end = limits.driven(Moving { steer_rad, speed_mps: 5.0 }, std::f64::consts::PI);
    assert!((end.translation.x - 10.0).abs() < 1e-9 && (end.translation.y + 10.0).abs() < 1e-9);
    assert!((end.rotation.angle() + 0.5 * std::f64::consts::PI).abs() < 1e-9);
}

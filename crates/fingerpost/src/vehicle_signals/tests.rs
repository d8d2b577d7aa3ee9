use nalgebra::{Isometry2, Matrix3, Vector2};

use super::*;

const DT_S: f64 = 0.1;

fn sample<T>(value: T) -> Option<Sample<T>> {
    Some(Sample { value, age_s: 0.02 })
}

fn samples(speed_mps: f64, yaw_rate_rps: f64) -> Option<VehicleSamples> {
    Some(VehicleSamples {
        speed_mps: sample(speed_mps),
        yaw_rate_rps: sample(yaw_rate_rps),
        turn_signal: sample(TurnSignal::Left),
    })
}

/// The camera's motion in a frame, of a quality.
fn seen(speed_mps: f64, yaw_rate_rps: f64, quality: f64) -> Motion {
    Motion {
        previous_from_current: Isometry2::new(Vector2::new(speed_mps * DT_S, 0.0), yaw_rate_rps * DT_S),
        covariance: Matrix3::identity(),
        quality,
    }
}

fn step(
    signals: &mut VehicleSignals,
    samples: Option<VehicleSamples>,
    motion: Option<&Motion>,
) -> (VehicleState, SignalsEvidence) {
    signals.step(SignalsInput { samples, motion, dt_s: Some(DT_S) })
}

fn is_near(value: Option<f64>, expected: f64) -> bool {
    value.is_some_and(|value| (value - expected).abs() < 1e-9)
}

#[test]
fn the_bus_goes_before_the_camera() {
    let mut signals = VehicleSignals::new(&CanConfig::default());
    let (state, evidence) = step(&mut signals, samples(10.0, 0.1), Some(&seen(9.0, 0.12, 0.9)));
    assert!(is_near(state.speed_mps, 10.0) && is_near(state.yaw_rate_rps, 0.1));
    assert_eq!(state.turn_signal, TurnSignal::Left);
    assert_eq!(evidence.speed, SignalUse { source: SignalSource::Can, not_used: None });
    assert_eq!(evidence.turn_signal.source, SignalSource::Can);
}

#[test]
fn what_is_missing_late_or_impossible_comes_from_the_camera() {
    let motion = seen(9.0, 0.12, 0.9);
    let late = Some(Sample { value: 10.0, age_s: 0.7 });
    for (speed_mps, why) in [
        (None, NotUsed::Missing),
        (late, NotUsed::Late { age_s: 0.7 }),
        (sample(f64::NAN), NotUsed::OutOfRange),
        (sample(-400.0), NotUsed::OutOfRange),
    ] {
        let mut signals = VehicleSignals::new(&CanConfig::default());
        let given = Some(VehicleSamples { speed_mps, ..samples(0.0, 0.1).unwrap_or_default() });
        let (state, evidence) = step(&mut signals, given, Some(&motion));
        assert!(is_near(state.speed_mps, 9.0), "{why:?}");
        assert_eq!(evidence.speed, SignalUse { source: SignalSource::Camera, not_used: Some(why) });
        assert_eq!(evidence.yaw_rate.source, SignalSource::Can, "the other signals stand");

        let (state, evidence) = step(&mut signals, given, Some(&seen(9.0, 0.1, 0.1)));
        assert_eq!(state.speed_mps, None, "a camera that does not believe itself says nothing");
        assert_eq!(evidence.speed.source, SignalSource::Nowhere);
    }
    let mut signals = VehicleSignals::new(&CanConfig::default());
    let (state, evidence) = signals.step(SignalsInput::default());
    assert_eq!(state, VehicleState::default());
    assert_eq!(evidence.turn_signal.not_used, Some(NotUsed::Missing));
}

#[test]
fn turn_signals_may_come_seldom_and_must_be_known() {
    let mut signals = VehicleSignals::new(&CanConfig::default());
    let mut with = |value, age_s| {
        let turn_signal = Some(Sample { value, age_s });
        let (state, evidence) =
            step(&mut signals, Some(VehicleSamples { turn_signal, ..VehicleSamples::default() }), None);
        (state.turn_signal, evidence.turn_signal.not_used)
    };
    assert_eq!(with(TurnSignal::Right, 8.0), (TurnSignal::Right, None));
    assert_eq!(with(TurnSignal::Right, 12.0), (TurnSignal::Unknown, Some(NotUsed::Late { age_s: 12.0 })));
    assert_eq!(with(TurnSignal::Unknown, 0.1), (TurnSignal::Unknown, Some(NotUsed::OutOfRange)));
}

#[test]
fn a_spike_is_passed_over_and_a_lasting_change_believed() {
    let mut signals = VehicleSignals::new(&CanConfig::default());
    assert!(is_near(step(&mut signals, samples(20.0, 0.0), None).0.speed_mps, 20.0));
    let (state, evidence) = step(&mut signals, samples(40.0, 0.0), None);
    assert_eq!((state.speed_mps, evidence.speed.not_used), (None, Some(NotUsed::Jump)));
    assert!(is_near(step(&mut signals, samples(20.5, 0.0), None).0.speed_mps, 20.5));
    // Twenty metres a second more take a second at the fastest change that is believed.
    let frames = (0..100).position(|_| step(&mut signals, samples(40.5, 0.0), None).0.speed_mps.is_some());
    assert_eq!(frames, Some(9));
    let (state, _) = step(&mut signals, samples(39.0, 0.0), None);
    assert!(is_near(state.speed_mps, 39.0), "hard braking is no jump");
}

#[test]
fn a_signal_that_contradicts_the_camera_for_long_is_not_believed() {
    let mut signals = VehicleSignals::new(&CanConfig::default());
    let wrong_for = |signals: &mut VehicleSignals, frames: usize| {
        let motion = seen(10.0, 0.0, 0.9);
        (0..frames)
            .map(|_| step(signals, samples(16.0, 0.0), Some(&motion)).1.speed.not_used)
            .last()
            .flatten()
    };
    assert_eq!(wrong_for(&mut signals, 19), None, "for a moment the camera may be wrong");
    assert_eq!(wrong_for(&mut signals, 2), Some(NotUsed::ContradictsCamera));
    let (state, evidence) = step(&mut signals, samples(16.0, 0.0), Some(&seen(10.0, 0.0, 0.9)));
    assert!(is_near(state.speed_mps, 10.0) && evidence.speed.source == SignalSource::Camera);
    let right = seen(16.2, 0.0, 0.9);
    let believed = (0..100).position(|_| {
        step(&mut signals, samples(16.0, 0.0), Some(&right)).1.speed.source == SignalSource::Can
    });
    assert!(matches!(believed, Some(18..=21)), "{believed:?}");
}

//! Departure warnings on simulated drives: noise as a camera has it, truth known to the millisecond.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

mod road;

use fingerpost_control::vehicle::VehicleConfig;
use fingerpost_control::{TurnSignal, VehicleState};
use fingerpost_lanes::Side;
use fingerpost_lanes::departure::{DepartureConfig, DepartureOutput, DepartureWarning, Silence};
use fingerpost_lanes::geometry::{EdgeOnRoad, LaneOnRoad};

use crate::road::{Camera, Driver, Place, Random, Road};

/// What happened on a drive.
#[derive(Default)]
struct Drive {
    /// When a warning began, and on which side.
    warnings: Vec<(f64, Side)>,
    /// When the first wheel crossed an edge of the first lane.
    crossed: Option<(f64, Side)>,
}

/// What the driver does after a while of keeping to the lane.
#[derive(Clone, Copy)]
enum Plan {
    Keep,
    /// Drifts and comes back.
    DriftAndReturn {
        lateral_mps: f64,
    },
    /// Drifts and stays in the next lane.
    ChangeLane {
        lateral_mps: f64,
        signal: bool,
    },
}

/// How the road bends.
#[derive(Clone, Copy)]
enum Bends {
    /// Alike all along.
    Alike,
    /// From straight to its curvature and back again and again, each within so many seconds.
    Ease { for_s: f64 },
}

impl Bends {
    /// Share of the road's curvature at a time.
    fn share(self, t_s: f64) -> f64 {
        match self {
            Self::Alike => 1.0,
            // Half of each period is eased, the rest straight and bent in turns.
            Self::Ease { for_s } => {
                let phase = (t_s / for_s).rem_euclid(4.0);
                (phase - 1.0).clamp(0.0, 1.0) - (phase - 3.0).clamp(0.0, 1.0)
            }
        }
    }
}

const SUBSTEPS: usize = 20;

fn drive(seed: u64, length_s: f64, wander_m: f64, plan: Plan, bends: Bends) -> Drive {
    let mut random = Random::new(seed);
    let fps = [10.0, 20.0, 25.0, 30.0][(seed % 4) as usize];
    let dt_s = 1.0 / fps;
    let speed_mps = random.between(13.0, 33.0);
    let whole = Road {
        lane_width_m: random.between(3.0, 3.6),
        curvature_per_m: random.sign() * random.between(0.0, 1.0 / 500.0),
    };
    let (mut camera, driver) = (Camera::new(&mut random), Driver::new(&mut random, wander_m));
    let (begin_s, overshoot_m) = (random.between(15.0, 25.0), random.between(0.15, 0.6));
    let yaw_bias_rps = 0.005 * random.normal();
    let signal_s = begin_s - random.between(0.5, 2.0);
    let config = DepartureConfig::default();
    let vehicle = VehicleConfig { width_m: road::WIDTH_M, ..VehicleConfig::default() };
    let (mut warning, mut before) = (DepartureWarning::default(), None);
    let (mut place, mut over, mut drive) = (Place::default(), false, Drive::default());
    let mut t_s = 0.0;
    while t_s < length_s {
        let heading_rad = place.heading_rad(speed_mps);
        let road = Road { curvature_per_m: bends.share(t_s) * whole.curvature_per_m, ..whole };
        for _ in 0..SUBSTEPS {
            let least_m = place.clearance_m(&road, speed_mps).into_iter().fold(f64::INFINITY, f64::min);
            let keep = |middle_m: f64| driver.keeping_mps(t_s, &place, middle_m);
            let wish_mps = match plan {
                Plan::DriftAndReturn { lateral_mps } if t_s > begin_s && !over => {
                    over = least_m < -overshoot_m;
                    lateral_mps
                }
                Plan::ChangeLane { lateral_mps, .. } if t_s > begin_s && !over => {
                    over = place.left_m.abs() > 0.8 * road.lane_width_m;
                    lateral_mps
                }
                Plan::ChangeLane { lateral_mps, .. } if over => {
                    keep(road.lane_width_m * lateral_mps.signum())
                }
                Plan::Keep | Plan::DriftAndReturn { .. } | Plan::ChangeLane { .. } => keep(0.0),
            };
            driver.steer(&mut place, wish_mps, dt_s / SUBSTEPS as f64);
            t_s += dt_s / SUBSTEPS as f64;
            let crossed =
                place.clearance_m(&road, speed_mps).iter().position(|clearance_m| *clearance_m < 0.0);
            if let (None, Some(side)) = (drive.crossed, crossed) {
                drive.crossed = Some((t_s, Side::BOTH[side]));
            }
        }
        let turn_signal = match plan {
            Plan::ChangeLane { lateral_mps, signal: true } if t_s > signal_s && !over => {
                if lateral_mps > 0.0 { TurnSignal::Left } else { TurnSignal::Right }
            }
            _ => TurnSignal::Off,
        };
        // A gyroscope with a bias and steps of a quarter of a degree a second, as production vehicles have.
        let turned_rad = place.heading_rad(speed_mps) - heading_rad;
        let true_rps = road.curvature_per_m * speed_mps + turned_rad / dt_s;
        let yaw_rps = ((true_rps + yaw_bias_rps + 0.002 * random.normal()) / 0.0043).round() * 0.0043;
        let lane = camera.see(&mut random, &road, &place, speed_mps, dt_s);
        let state = VehicleState {
            speed_mps: Some(speed_mps * (1.0 + 0.01 * random.normal())),
            yaw_rate_rps: Some(yaw_rps),
            turn_signal,
        };
        let (output, _) = warning.step(&config, &vehicle, &lane, &state, dt_s);
        if let (Some(side), true) = (output.warning, output.warning != before) {
            drive.warnings.push((t_s, side));
        }
        before = output.warning;
    }
    drive
}

/// How long after the crossing each drift was warned of, seconds; one that was not, or twice, or on the wrong side, is a
/// failure.
fn delays_s(drifts: std::ops::Range<u64>, bends: Bends, plan: impl Fn(f64) -> Plan) -> Vec<f64> {
    drifts
        .map(|seed| {
            let mut random = Random::new(1000 + seed);
            let lateral_mps = random.sign() * random.between(0.15, 1.0);
            let Drive { warnings, crossed } = drive(seed, 50.0, 0.1, plan(lateral_mps), bends);
            let (crossed_s, crossed_side) = crossed.unwrap();
            assert!(
                matches!(warnings[..], [(_, side)] if side == crossed_side),
                "drift {seed} at {lateral_mps:.2} m/s crossed at {crossed_s:.2} s: {warnings:?}"
            );
            warnings[0].0 - crossed_s
        })
        .collect()
}

/// Three hundredths of a second from the middle, and all but one in two hundred within 0.3 s: the slowest drifts, 0.15 m/s,
/// cover 5 cm in that time, which is what a camera's edges are off themselves.
fn assert_in_time(delays_s: &[f64]) {
    let mean_s = delays_s.iter().sum::<f64>() / delays_s.len() as f64;
    assert!(mean_s.abs() < 0.03, "{mean_s}");
    let late = delays_s.iter().filter(|delay_s| delay_s.abs() > 0.3).count();
    assert!(late * 200 <= delays_s.len(), "{late} of {}", delays_s.len());
    assert!(delays_s.iter().all(|delay_s| delay_s.abs() < 0.5), "{delays_s:?}");
}

#[test]
fn drifts_are_warned_of_as_the_wheel_crosses_the_edge() {
    assert_in_time(&delays_s(0..400, Bends::Alike, |lateral_mps| Plan::DriftAndReturn { lateral_mps }));
}

#[test]
fn drifts_where_bends_begin_and_end_are_warned_of_as_well() {
    let bends = Bends::Ease { for_s: 2.0 };
    let delays_s = delays_s(600..800, bends, |lateral_mps| Plan::DriftAndReturn { lateral_mps });
    let late = delays_s.iter().filter(|delay_s| delay_s.abs() > 0.3).count();
    assert!(late * 25 <= delays_s.len(), "{late} of {}: {delays_s:?}", delays_s.len());
    for seed in 0..10 {
        let Drive { warnings, .. } = drive(6000 + seed, 60.0, 0.2, Plan::Keep, bends);
        assert!(warnings.is_empty(), "drive {seed}: {warnings:?}");
    }
}

#[test]
fn a_lane_change_without_a_signal_is_warned_of_once() {
    assert_in_time(&delays_s(400..600, Bends::Alike, |lateral_mps| Plan::ChangeLane {
        lateral_mps,
        signal: false,
    }));
}

#[test]
fn thirty_minutes_of_keeping_to_the_lane_are_silent() {
    for seed in 0..30 {
        let Drive { warnings, .. } = drive(5000 + seed, 60.0, 0.2, Plan::Keep, Bends::Alike);
        assert!(warnings.is_empty(), "drive {seed}: {warnings:?}");
    }
}

#[test]
fn a_signal_silences_the_lane_change() {
    for seed in 0..200 {
        let mut random = Random::new(2000 + seed);
        let lateral_mps = random.sign() * random.between(0.15, 1.0);
        let Drive { warnings, crossed } =
            drive(seed, 50.0, 0.1, Plan::ChangeLane { lateral_mps, signal: true }, Bends::Alike);
        assert!(warnings.is_empty() && crossed.is_some(), "change {seed}: {warnings:?}");
    }
}

/// What is said when the vehicle of this state moves to the left at 0.5 m/s from the middle of its lane, frame by frame.
fn exact_drift(state: VehicleState) -> Vec<DepartureOutput> {
    let (config, vehicle) = (DepartureConfig::default(), VehicleConfig::default());
    let mut warning = DepartureWarning::default();
    let frame = |frame: u32| {
        let moved_m = 0.05 * f64::from(frame.saturating_sub(30));
        let heading_rad = if frame > 30 {
            -0.5 / state.speed_mps.filter(|mps| mps.is_finite()).unwrap_or(20.0)
        } else {
            0.0
        };
        let edge = |offset_m: f64| {
            Some(EdgeOnRoad { offset_m: offset_m - moved_m, heading_rad, ..EdgeOnRoad::default() })
        };
        let lane = LaneOnRoad { left: edge(1.7), right: edge(-1.7) };
        warning.step(&config, &vehicle, &lane, &state, 0.1).0
    };
    (0..60).map(frame).collect()
}

fn silences(outputs: &[DepartureOutput]) -> Vec<Silence> {
    assert!(outputs.iter().all(|output| output.warning.is_none()));
    let mut silences: Vec<Silence> = outputs.iter().filter_map(|output| output.silence).collect();
    silences.dedup();
    silences
}

#[test]
fn silence_has_a_reason() {
    let driving = VehicleState { speed_mps: Some(20.0), ..VehicleState::default() };
    let warned = exact_drift(driving);
    let first = warned.iter().position(|output| output.warning.is_some()).unwrap();
    assert_eq!(warned[first].warning, Some(Side::Left));
    assert!(
        (45..49).contains(&first),
        "{first}: 0.8 m to the edge, some of it turned away by the front axle"
    );
    assert!((warned[40].time_to_crossing_s.unwrap() - 0.1 * (first - 40) as f64).abs() < 0.2);
    assert!((warned[44].lateral_speed_mps.unwrap() - 0.5).abs() < 0.1);
    assert_eq!(warned[10].time_to_crossing_s, None, "straight on");

    let to = |turn_signal| VehicleState { turn_signal, ..driving };
    assert_eq!(silences(&exact_drift(to(TurnSignal::Left)))[0], Silence::TurnSignal);
    assert!(exact_drift(to(TurnSignal::Right)).iter().any(|output| output.warning == Some(Side::Left)));
    let at = |speed_mps| exact_drift(VehicleState { speed_mps, ..driving });
    assert_eq!(silences(&at(Some(9.0))), [Silence::Slow]);
    // A speed that is not known silences nothing: the edges' own drift is enough for a warning.
    for speed_mps in [None, Some(f64::NAN)] {
        let late = at(speed_mps).iter().position(|output| output.warning == Some(Side::Left)).unwrap();
        assert!(late.abs_diff(first) <= 3, "{speed_mps:?}: frame {late} in place of {first}");
    }
}

#[test]
fn nothing_is_said_without_edges_and_nonsense_does_no_harm() {
    let (config, vehicle) = (DepartureConfig::default(), VehicleConfig::default());
    let mut warning = DepartureWarning::default();
    let state = VehicleState { speed_mps: Some(20.0), ..VehicleState::default() };
    let mut step = |edge: Option<EdgeOnRoad>, dt_s: f64| {
        warning.step(&config, &vehicle, &LaneOnRoad { left: edge, right: None }, &state, dt_s).0
    };
    assert_eq!(step(None, 0.1), DepartureOutput::default());
    for nonsense in [f64::NAN, f64::INFINITY] {
        let edge = EdgeOnRoad { offset_m: nonsense, ..EdgeOnRoad::default() };
        assert_eq!(step(Some(edge), 0.1), DepartureOutput::default());
    }
    let edge = EdgeOnRoad { offset_m: 1.7, ..EdgeOnRoad::default() };
    for dt_s in [0.1, 0.0, -1.0, f64::NAN, 1e9, 0.1] {
        let output = step(Some(edge), dt_s);
        assert!(output.warning.is_none() && output.lateral_speed_mps.is_some_and(f64::is_finite), "{dt_s}");
    }
    assert!((0..30).any(|_| step(None, 0.1).lateral_speed_mps.is_none()), "an edge is forgotten");
}

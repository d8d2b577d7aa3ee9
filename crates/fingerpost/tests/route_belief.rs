//! The belief of the route on painted drives past three side roads: a start that is wrong and pauses in the pictures.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

mod painted;

use std::collections::BTreeMap;

use fingerpost::track::TrackMethod;
use fingerpost::vehicle_signals::{Sample, VehicleSamples};
use fingerpost::{Config, Pipeline, Sensors};
use nalgebra::{Isometry2, Point2, Vector2};
use painted::{Place, World, camera, route_past};

const WIDTH_M: f64 = 5.5;
/// Metres north of the nodes, and where the side roads lead.
const SIDES: [(f64, Place); 3] = [(30.0, (-60.0, 0.0)), (75.0, (60.0, 0.0)), (112.0, (-60.0, 10.0))];
const ENDS: [f64; 2] = [-20.0, 160.0];
const SPEED_MPS: f64 = 8.0;
const DT_S: f64 = 0.1;
/// A feature that is said to be there and is this far off is false, metres.
const FALSE_M: f64 = 3.0;

/// What a drive is like.
#[derive(Default)]
struct Drive {
    /// How far the start is given too far along, metres.
    start_off_m: f64,
    /// From how far north on, and for how many seconds, there are no pictures.
    pause: Option<(f64, f64)>,
    /// Whether the vehicle's bus says the speed.
    bus: Option<f64>,
}

/// What came of a drive.
#[derive(Debug)]
struct Outcome {
    /// How far off the best claim of each side road was, metres.
    found: BTreeMap<usize, f64>,
    /// How far off the last progress along the route was, metres.
    route_off_m: f64,
}

/// Drives past all side roads.
fn drive(drive: &Drive) -> Outcome {
    let roads: Vec<[Place; 2]> =
        SIDES.iter().map(|&(north, (x, y))| [(0.0, north), (x, north + y)]).collect();
    let mut painted: Vec<(&[Place], f64)> = vec![(&[(0.0, -60.0), (0.0, 200.0)], WIDTH_M)];
    painted.extend(roads.iter().map(|road| (road.as_slice(), WIDTH_M)));
    let (world, camera, route) = (World::new(&painted), camera(), route_past(&SIDES, ENDS, WIDTH_M));
    let mut config = Config::default();
    config.track.method = TrackMethod::Belief;
    let first = 0.0;
    let start_m = first - ENDS[0] + drive.start_off_m;
    let mut pipeline = Pipeline::new(&config, &camera, Some(&route), Some(start_m)).unwrap();
    let (mut t_s, mut last_s) = (0.0, None);
    let mut outcome = Outcome { found: BTreeMap::new(), route_off_m: f64::INFINITY };
    while first + SPEED_MPS * t_s < SIDES[2].0 + 2.0 {
        let north = first + SPEED_MPS * t_s;
        let map_from_vehicle = Isometry2::new(Vector2::new(0.3, north), std::f64::consts::FRAC_PI_2);
        let signals = drive.bus.map(|speed_mps| VehicleSamples {
            speed_mps: Some(Sample { value: speed_mps, age_s: 0.0 }),
            ..VehicleSamples::default()
        });
        let sensors = Sensors { dt_s: last_s.map(|last_s: f64| t_s - last_s), signals, ..Sensors::default() };
        let frame = world.picture(&camera, &map_from_vehicle);
        let (output, _) = pipeline.step(&frame, sensors, &mut |_| {}).unwrap();
        if let Some(followed) = &output.track.followed {
            let node = map_from_vehicle.inverse() * Point2::new(0.0, SIDES[followed.index].0);
            let off_m = (followed.vehicle_from_feature.translation.vector - node.coords).norm();
            let present = followed.present.unwrap();
            assert!(off_m < FALSE_M || present < 0.5, "{north}: {off_m} m off at {present}: {}", output.why);
            let nearest = outcome.found.entry(followed.index).or_insert(f64::INFINITY);
            *nearest = off_m.min(*nearest);
        }
        outcome.route_off_m = output.track.route_m.map_or(f64::INFINITY, |m| (m - (north - ENDS[0])).abs());
        last_s = Some(t_s);
        let is_before_pause = |&(from, _): &(f64, f64)| north < from && north + SPEED_MPS * DT_S >= from;
        t_s += drive.pause.filter(is_before_pause).map_or(DT_S, |(_, for_s)| for_s);
    }
    outcome
}

#[test]
fn features_are_found_from_a_start_that_is_right() {
    let outcome = drive(&Drive::default());
    assert_eq!(outcome.found.len(), 3, "{outcome:?}");
    assert!(outcome.found.values().all(|off_m| *off_m < 0.5), "{outcome:?}");
}

#[test]
fn a_start_that_is_off_is_mended_or_claims_nothing_false() {
    // What is false fails in the drive.
    for (start_off_m, is_mended) in [(-8.0, true), (8.0, true), (-30.0, false), (30.0, false)] {
        let outcome = drive(&Drive { start_off_m, ..Drive::default() });
        assert!(!is_mended || outcome.route_off_m < 1.5, "{start_off_m}: {outcome:?}");
    }
}

#[test]
fn a_pause_in_the_pictures_claims_nothing_and_is_mended() {
    for (for_s, bus) in [(1.2, None), (2.5, None), (5.0, None), (5.0, Some(SPEED_MPS))] {
        let outcome = drive(&Drive { pause: Some((12.0, for_s)), bus, ..Drive::default() });
        let last_off_m = outcome.found.get(&2);
        assert!(last_off_m.is_some_and(|off_m| *off_m < 0.5), "{for_s} s, bus {bus:?}: {outcome:?}");
    }
}

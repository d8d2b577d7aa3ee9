//! Directions without a start, on a painted road past six side roads of which any may come first: nothing false is claimed, and
//! from the second or third that comes on, or from the first where the drive begins at the beginning, all are found.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use std::collections::BTreeSet;

use crate::painted::{Place, World, camera_of_width, route_past};
use fingerpost::track::{Decision, State};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_map::{LatLon, TangentPlane};
use nalgebra::{Isometry2, Point2, Vector2};

const WIDTH_M: f64 = 5.5;
const WEST: Place = (-60.0, 0.0);
const EAST: Place = (60.0, 0.0);
/// Metres north of the nodes, and where the side roads lead: to the left and right in turns, so that every third looks alike.
const SIDES: [(f64, Place); 6] =
    [(30.0, WEST), (70.0, EAST), (118.0, WEST), (152.0, EAST), (210.0, WEST), (262.0, EAST)];
/// The route's ends, metres north.
const ENDS: [f64; 2] = [-20.0, 300.0];
/// Metres from picture to picture.
const STEP_M: f64 = 0.8;
/// A feature that is followed so far off is false, metres.
const FALSE_M: f64 = 3.0;

/// What came of a drive.
struct Outcome {
    found: BTreeSet<usize>,
    /// Index, place of the vehicle (metres north) and how far off, of everything followed that is not there.
    false_claims: Vec<(usize, f64, f64)>,
    /// Frames before the first claim in which the evidence names two features and their probabilities.
    doubts: Vec<[f64; 2]>,
}

/// Whether positions by GPS are given.
#[derive(Clone, Copy)]
enum Gps {
    None,
    Right,
}

/// Drives from `from_m` to `to_m` north, without a start.
fn drive([from_m, to_m]: [f64; 2], gps: Gps) -> Outcome {
    let (camera, route) = (camera_of_width(320), route_past(&SIDES, ENDS, WIDTH_M));
    let roads = SIDES.map(|(north, (x, _))| [(0.0, north), (x, north)]);
    let mut painted: Vec<(&[Place], f64)> = vec![(&[(0.0, -80.0), (0.0, 360.0)], WIDTH_M)];
    painted.extend(roads.iter().map(|road| (road.as_slice(), WIDTH_M)));
    let world = World::new(&painted);
    let mut config = Config::default();
    config.ground_view.metres_per_pixel = 0.1;
    // The painted roads meet at sharp corners.
    config.track.kerb_radius_m = 0.0;
    let mut pipeline = Pipeline::new(&config, &camera, Some(&route), None).unwrap();
    let plane = TangentPlane::new(LatLon { lat_deg: 47.1, lon_deg: 9.5 });
    let mut outcome = Outcome { found: BTreeSet::new(), false_claims: Vec::new(), doubts: Vec::new() };
    for index in 0..((to_m - from_m) / STEP_M) as usize {
        let north = from_m + STEP_M * index as f64;
        let map_from_vehicle = Isometry2::new(Vector2::new(0.0, north), std::f64::consts::FRAC_PI_2);
        let picture = world.picture(&camera, &map_from_vehicle);
        let gps = matches!(gps, Gps::Right).then(|| plane.wgs84_from_map(Point2::new(0.0, north)));
        let sensors = Sensors { dt_s: (index > 0).then_some(0.1), gps, ..Sensors::default() };
        let (output, evidence) = pipeline.step(&picture, sensors, &mut |_| {}).unwrap();
        if let Decision::NextUnknown { likeliest, rival } = evidence.track.decision {
            assert_eq!((output.track.state, output.track.route_m), (State::Searching, None));
            assert!(output.why.contains("not sure yet"), "{}", output.why);
            outcome.doubts.push([likeliest.1, rival.1]);
        }
        let Some(followed) = &output.track.followed else { continue };
        let node = map_from_vehicle.inverse() * Point2::new(0.0, SIDES[followed.index].0);
        let off_m = (followed.vehicle_from_feature.translation.vector - node.coords).norm();
        if off_m > FALSE_M {
            outcome.false_claims.push((followed.index, north, off_m));
        } else {
            outcome.found.insert(followed.index);
        }
    }
    outcome
}

#[test]
fn a_vehicle_that_begins_in_mid_route_is_not_taken_to_be_at_its_beginning() {
    // Before the third, which looks like the first; before the second; before the fourth.
    for (from_m, surely) in [(88.0, 4..6), (48.0, 3..6), (128.0, 5..6)] {
        let outcome = drive([from_m, 275.0], Gps::None);
        assert!(outcome.false_claims.is_empty(), "{from_m}: {:?}", outcome.false_claims);
        let missing: Vec<usize> = surely.filter(|index| !outcome.found.contains(index)).collect();
        assert!(missing.is_empty(), "{from_m}: {missing:?} not among {:?}", outcome.found);
        assert!(outcome.doubts.iter().all(|[likeliest, rival]| likeliest >= rival && *likeliest < 0.9));
    }
}

#[test]
fn one_that_begins_at_the_beginning_finds_all_that_come() {
    let outcome = drive([ENDS[0], 225.0], Gps::None);
    assert!(outcome.false_claims.is_empty(), "{:?}", outcome.false_claims);
    assert!((0..5).all(|index| outcome.found.contains(&index)), "{:?}", outcome.found);
}

/// The third lies as far ahead as the first from the route's beginning, and looks like it.
#[test]
fn one_that_looks_like_the_beginning_is_mended_by_what_follows() {
    let outcome = drive([68.0, 275.0], Gps::None);
    let mended = |&(index, north, _): &(usize, f64, f64)| index == 0 && north < SIDES[2].0 + 5.0;
    assert!(outcome.false_claims.iter().all(mended), "{:?}", outcome.false_claims);
    assert!((4..6).all(|index| outcome.found.contains(&index)), "{:?}", outcome.found);
}

#[test]
fn a_position_ends_all_doubt() {
    let outcome = drive([88.0, 170.0], Gps::Right);
    assert!(outcome.false_claims.is_empty(), "{:?}", outcome.false_claims);
    assert!((2..4).all(|index| outcome.found.contains(&index)), "{:?}", outcome.found);
    assert!(outcome.doubts.len() <= 1);
}

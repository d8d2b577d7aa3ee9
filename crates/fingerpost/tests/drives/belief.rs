//! The belief on painted drives, where every place is known: what is there is found, and what is not is not claimed.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, World, camera, route};
use fingerpost::track::{Decision, Lack, State};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_map::FeatureKind;
use nalgebra::{Isometry2, Point2, Vector2};

const WIDTH_M: f64 = 5.5;
const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const NORTH: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];

/// Nearer than this a feature is placed for a driving line, metres.
const NEAR_M: f64 = 9.0;

/// What was said of the feature in a frame, and where it is.
struct Seen {
    state: State,
    why: String,
    present: Option<f64>,
    sigma_m: Option<f64>,
    off_m: Option<f64>,
    before_m: f64,
}

/// Drives north towards a node at the origin, which the route has `start_off_m` too near.
fn drive(roads: &[(&[Place], f64)], junction: &Junction<'_>, start_off_m: f64) -> Vec<Seen> {
    drive_with(&crate::painted::config(), roads, junction, start_off_m)
}

/// The same with other settings.
fn drive_with(
    config: &Config,
    roads: &[(&[Place], f64)],
    junction: &Junction<'_>,
    start_off_m: f64,
) -> Vec<Seen> {
    let (world, camera) = (World::new(roads), camera());
    let (route, _) = route(junction);
    let node_m = route.features[0].route_m;
    let start_m = node_m - 28.0 + start_off_m;
    let mut pipeline = Pipeline::new(config, &camera, Some(&route), Some(start_m)).unwrap();
    let mut seen = Vec::new();
    for i in 0..48 {
        let y = -28.0 + 0.5 * f64::from(i);
        let map_from_vehicle = Isometry2::new(Vector2::new(0.2, y), std::f64::consts::FRAC_PI_2);
        let frame = world.picture(&camera, &map_from_vehicle);
        let (output, evidence) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
        check_decision(evidence.track, &output.why);
        let node = map_from_vehicle.inverse() * Point2::origin();
        let followed = output.track.followed.as_ref();
        seen.push(Seen {
            state: output.track.state,
            why: output.why.clone(),
            present: followed.map(|followed| followed.present),
            sigma_m: followed.map(|f| f.covariance.fixed_view::<2, 2>(0, 0).trace().sqrt()),
            off_m: followed.map(|f| (f.vehicle_from_feature.translation.vector - node.coords).norm()),
            before_m: node.x,
        });
    }
    seen
}

/// What decided the frame lies on its side of the bound, and is said.
fn check_decision(evidence: &fingerpost::track::TrackEvidence, why: &str) {
    let weights: f64 = evidence.places.iter().map(|place| place.weight).sum();
    assert!(weights <= 1.0 + 1e-9, "{weights}: {why}");
    let (Decision::NotSure { lack, .. } | Decision::NoLongerSure { lack, .. }) = &evidence.decision else {
        return;
    };
    let said = match lack {
        Lack::Presence { present, needed } => {
            assert!(present < needed, "{why}");
            needed
        }
        Lack::Place { sigma_m, most_m, .. } => {
            assert!(sigma_m > most_m, "{why}");
            most_m
        }
    };
    assert!(why.contains(&format!("{said:.2}")), "{said} is not in: {why}");
}

fn t_junction(start_off_m: f64) -> Vec<Seen> {
    let roads = [(SOUTH, WIDTH_M), (EAST, WIDTH_M), (WEST, WIDTH_M)];
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    drive(&roads, &junction, start_off_m)
}

#[test]
fn a_junction_is_found_wherever_the_start_is_believed_to_be() {
    for start_off_m in [-8.0, 0.0, 6.0] {
        let seen = t_junction(start_off_m);
        let first = seen.iter().position(|s| s.state == State::Tracking).expect("it is found");
        assert!(seen[first].before_m > 7.0, "start {start_off_m}: found at {} m", seen[first].before_m);
        for seen in &seen[first..] {
            let (Some(off_m), Some(sigma_m)) = (seen.off_m, seen.sigma_m) else { continue };
            let most_m = if seen.before_m < NEAR_M { 0.8_f64.min(3.0 * sigma_m) } else { 3.0 * sigma_m };
            assert!(off_m < most_m, "start {start_off_m}: {off_m} of {sigma_m}: {}", seen.why);
            assert!(seen.present.is_some_and(|present| present >= 0.5), "{}", seen.why);
        }
        assert!(seen.iter().any(|s| s.state == State::Arrived), "start {start_off_m}: never arrived");
    }
}

#[test]
fn a_road_without_the_junction_is_none() {
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    // Nor where a place may be known half as well.
    let mut config = crate::painted::config();
    config.track.detect_sigma_m *= 2.0;
    for roads in [[(SOUTH, WIDTH_M), (NORTH, WIDTH_M)], [(SOUTH, 90.0), (NORTH, 90.0)]] {
        let claimed =
            drive_with(&config, &roads, &junction, 0.0).into_iter().find(|seen| seen.off_m.is_some());
        assert!(claimed.is_none(), "{:?}", claimed.map(|seen| seen.why));
    }
}

#[test]
fn a_side_road_is_found_on_its_own_side_alone() {
    let roads = [(SOUTH, WIDTH_M), (NORTH, WIDTH_M), (WEST, WIDTH_M)];
    let kind = FeatureKind::SideRoad;
    for (sides, is_there) in [([WEST], true), ([EAST], false)] {
        let junction = Junction { kind, approach: SOUTH, exit: NORTH, sides: &sides, width_m: WIDTH_M };
        let found = drive(&roads, &junction, 0.0).iter().any(|seen| seen.off_m.is_some());
        assert_eq!(found, is_there, "{sides:?}");
    }
}

#[test]
fn that_the_road_bends_is_no_evidence_of_a_side_road() {
    // By 35 degrees to the left.
    const BENT: &[Place] = &[(0.0, 0.0), (-34.4, 49.1)];
    let bend = [(SOUTH, WIDTH_M), (BENT, WIDTH_M)];
    let with_side_road = [(SOUTH, WIDTH_M), (BENT, WIDTH_M), (EAST, WIDTH_M)];
    for (roads, sides, is_there) in
        [(&with_side_road[..], [EAST], true), (&bend[..], [EAST], false), (&bend[..], [WEST], false)]
    {
        let kind = FeatureKind::SideRoad;
        let junction = Junction { kind, approach: SOUTH, exit: BENT, sides: &sides, width_m: WIDTH_M };
        let found = drive(roads, &junction, 0.0).into_iter().find(|seen| seen.off_m.is_some());
        assert_eq!(found.is_some(), is_there, "{sides:?}: {:?}", found.map(|seen| seen.why));
    }
}

#[test]
fn a_standing_vehicle_grows_no_surer() {
    let (camera, kind) = (camera(), FeatureKind::Junction);
    let world = World::new(&[(SOUTH, WIDTH_M), (EAST, WIDTH_M), (WEST, WIDTH_M)]);
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    let (route, _) = route(&junction);
    let start_m = route.features[0].route_m - 20.0;
    let mut pipeline =
        Pipeline::new(&crate::painted::config(), &camera, Some(&route), Some(start_m)).unwrap();
    let mut places = Vec::new();
    for i in 0..60 {
        // Up to 10 m before the node, where the vehicle stays.
        let y = (-20.0 + 0.5 * f64::from(i)).min(-10.0);
        let map_from_vehicle = Isometry2::new(Vector2::new(0.2, y), std::f64::consts::FRAC_PI_2);
        let mut frame = world.picture(&camera, &map_from_vehicle);
        frame.as_mut_slice().iter_mut().skip(i as usize % 7).step_by(7).for_each(|level| *level ^= 1);
        let (_, evidence) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
        places.push(evidence.track.places.first().map(|place| place.covariance[(0, 0)].sqrt()));
    }
    let (Some(before_m), Some(after_m)) = (places[25], places[59]) else { panic!("no place: {places:?}") };
    assert!(after_m > 0.9 * before_m, "{before_m} to {after_m}");
}

#[test]
fn what_was_doubtful_when_the_curve_began_stays_so() {
    // A yard's entrance where the map has a side road.
    const ENTRANCE: &[Place] = &[(0.0, 0.0), (-6.0, 0.0)];
    let roads = [(SOUTH, WIDTH_M), (NORTH, WIDTH_M), (ENTRANCE, 4.0)];
    let kind = FeatureKind::SideRoad;
    let junction = Junction { kind, approach: SOUTH, exit: NORTH, sides: &[WEST], width_m: WIDTH_M };
    let mut config = crate::painted::config();
    (config.track.detect_present, config.track.lost_present) = (0.5, 0.5);
    let seen = drive_with(&config, &roads, &junction, 0.0);
    let arrived: Vec<f64> =
        seen.iter().filter(|s| s.state == State::Arrived).filter_map(|s| s.present).collect();
    assert!(arrived.len() >= 6, "{}", arrived.len());
    assert!(arrived.iter().all(|present| (0.5..0.9).contains(present)), "{arrived:?}");
}

#[test]
fn two_side_roads_near_each_other_are_not_taken_for_each_other() {
    const FIRST_M: f64 = 20.0;
    const APART_M: f64 = 11.0;
    let sides = [(FIRST_M, (-60.0, 0.0)), (FIRST_M + APART_M, (-60.0, 0.0))];
    let route = crate::painted::route_past(&sides, [-60.0, 100.0], WIDTH_M);
    let roads: [&[Place]; 3] = [
        &[(0.0, -60.0), (0.0, 100.0)],
        &[(0.0, FIRST_M), (-60.0, FIRST_M)],
        &[(0.0, FIRST_M + APART_M), (-60.0, FIRST_M + APART_M)],
    ];
    let (world, camera) = (World::new(&roads.map(|road| (road, WIDTH_M))), camera());
    for start_off_m in [-8.0, -4.0, 0.0, 4.0, 8.0] {
        let start_m = 60.0 - 10.0 + start_off_m;
        let config = crate::painted::config();
        let mut pipeline = Pipeline::new(&config, &camera, Some(&route), Some(start_m)).unwrap();
        let mut found = [false; 2];
        for i in 0..80 {
            let y = -10.0 + 0.5 * f64::from(i);
            let map_from_vehicle = Isometry2::new(Vector2::new(0.2, y), std::f64::consts::FRAC_PI_2);
            let frame = world.picture(&camera, &map_from_vehicle);
            let (output, _) = pipeline.step(&frame, Sensors::default(), &mut |_| {}).unwrap();
            let Some(followed) = &output.track.followed else { continue };
            let node = Point2::new(0.0, sides[followed.index].0);
            let off_m = ((followed.vehicle_from_feature * Point2::origin())
                - map_from_vehicle.inverse() * node)
                .norm();
            assert!(off_m < 2.0, "start {start_off_m}, {y}: {off_m} m off: {}", output.why);
            found[followed.index] = true;
        }
        assert_eq!(found, [true; 2], "start {start_off_m}");
    }
}

use std::f64::consts::FRAC_PI_2;

use fingerpost_locate::Verdict;
use fingerpost_map::{OsmData, OsmNode, OsmWay};
use nalgebra::{Matrix3, Point2, Vector3};

use super::*;
use crate::matching::Match;

const DT_S: f64 = 0.1;
const SPEED_MPS: f64 = 8.0;

fn plane() -> TangentPlane {
    TangentPlane::new(LatLon { lat_deg: 47.0, lon_deg: 9.0 })
}

/// A road of 200 m to the east, with a street to the north at 90 m and one to the south at 150 m.
fn roads() -> RoadGraph {
    let places = [(0.0, 0.0), (90.0, 0.0), (150.0, 0.0), (200.0, 0.0), (90.0, 120.0), (150.0, -120.0)];
    let nodes = places
        .iter()
        .zip(1..)
        .map(|((east, north), id)| OsmNode { id, at: plane().wgs84_from_map(Point2::new(*east, *north)) });
    let way = |id: i64, nodes: &[i64]| {
        let tags = [("highway".to_owned(), "residential".to_owned())].into();
        OsmWay { id, nodes: nodes.to_vec(), tags }
    };
    let ways = vec![way(1, &[1, 2, 3, 4]), way(2, &[2, 5]), way(3, &[3, 6])];
    RoadGraph::from_osm(&OsmData { nodes: nodes.collect(), ways, ..OsmData::default() }).unwrap()
}

/// Along the road to the east from 10 m on, then into a street with an arc of 6 m; the vehicle's true places and fixes.
fn drive(corner_m: f64, left: f64, off_m: f64) -> Vec<(Point2<f64>, f64, MapFix)> {
    let near = plane().wgs84_from_map(Point2::new(10.0 + off_m, 0.0));
    let near = NearPlace { at: near, sigma_m: 20.0 };
    let mut stage = FixStage::new(&roads(), Traffic::Centre, Some(near));
    let radius_m = 6.0;
    let (mut place, mut heading) = (Point2::new(10.0, 0.0), 0.0_f64);
    let mut fixes = Vec::new();
    for _ in 0..(corner_m + 70.0) as usize {
        let turns = place.x > corner_m - radius_m && heading.abs() < FRAC_PI_2 - 1e-3;
        let yaw_rate_rps = if turns { left * SPEED_MPS / radius_m } else { 0.0 };
        let middle = heading + 0.5 * yaw_rate_rps * DT_S;
        place += SPEED_MPS * DT_S * nalgebra::Vector2::new(libm::cos(middle), libm::sin(middle));
        heading = (heading + yaw_rate_rps * DT_S).clamp(-FRAC_PI_2, FRAC_PI_2);
        let vehicle = VehicleState {
            speed_mps: Some(SPEED_MPS),
            yaw_rate_rps: Some(yaw_rate_rps),
            ..VehicleState::default()
        };
        fixes.extend(
            stage.step(Some(DT_S), &vehicle, None, FixInput::default()).0.map(|fix| (place, heading, fix)),
        );
    }
    fixes
}

#[test]
fn a_corner_to_either_side_tells_where_the_vehicle_is() {
    for (corner_m, left, off_m) in [(90.0, 1.0, 15.0), (150.0, -1.0, -15.0)] {
        let fixes = drive(corner_m, left, off_m);
        let error_m =
            |(place, _, fix): &(Point2<f64>, f64, MapFix)| (plane().map_from_wgs84(fix.at) - place).norm();
        let first = &fixes[0];
        assert!(first.2.status != Status::Converged, "a place known to 20 m is none yet");
        let last = fixes.last().unwrap();
        assert!(error_m(last) < 4.0, "corner at {corner_m} m: {} m off", error_m(last));
        assert!((last.2.heading_rad - last.1).abs() < 0.1, "corner at {corner_m} m");
        assert!(last.2.sigma_m < 5.0 && last.2.sigma_m < 0.7 * first.2.sigma_m);
    }
}

/// GPS along a drive of 190 m to the east, and what must come of it: the fix is never farther to the side than its bound, and its
/// error at the end is hardly more than without GPS. `gps` says by the second where the receiver puts a vehicle that is `at` metres along.
fn with_gps(gps: impl Fn(f64, f64) -> Option<[f64; 2]>) -> (Vec<FixEvidence>, f64) {
    let near = NearPlace { at: plane().wgs84_from_map(Point2::new(5.0, 0.0)), sigma_m: 10.0 };
    let mut stage = FixStage::new(&roads(), Traffic::Centre, Some(near));
    let vehicle = VehicleState { speed_mps: Some(5.0), yaw_rate_rps: Some(0.0), ..VehicleState::default() };
    let (mut evidence, mut error_m) = (Vec::new(), 0.0);
    for step in 1..=360 {
        let time_s = f64::from(step) * DT_S;
        let at_m = 5.0 + 5.0 * time_s;
        let said = gps(time_s, at_m).filter(|_| step % 10 == 0);
        let gps = said.map(|[east_m, north_m]| plane().wgs84_from_map(Point2::new(east_m, north_m)));
        let (fix, of_step) = stage.step(Some(DT_S), &vehicle, None, FixInput { gps, followed: None });
        let fix = fix.unwrap();
        let off = plane().map_from_wgs84(fix.at) - Point2::new(at_m, 0.0);
        assert!(fix.bound_m.is_none_or(|bound_m| off.norm() <= bound_m), "{time_s} s: {off:?}, {fix:?}");
        evidence.extend(of_step.gps.map(|_| of_step));
        error_m = off.norm();
    }
    (evidence, error_m)
}

#[test]
fn a_receiver_that_errs_jumps_or_lies_harms_nothing() {
    let (none, alone_m) = with_gps(|_, _| None);
    assert!(none.is_empty());
    let believed = |evidence: &[FixEvidence]| {
        evidence.iter().filter(|of_step| of_step.gps.is_some_and(|gps| gps.believed)).count()
    };
    // True places: all believed, and no worse than without.
    let (evidence, error_m) = with_gps(|_, at_m| Some([at_m, 0.0]));
    assert_eq!((evidence.len(), believed(&evidence)), (36, 36));
    assert!(error_m <= alone_m + 0.5, "{error_m} {alone_m}");
    // A hundred metres off for ten seconds: none of those believed, and nothing comes of them.
    let (evidence, error_m) =
        with_gps(|t_s, at_m| Some([at_m, if (10.0..20.0).contains(&t_s) { 100.0 } else { 0.0 }]));
    assert_eq!(believed(&evidence), 26);
    assert!(error_m <= alone_m + 0.5, "{error_m} {alone_m}");
    // Silent from ten seconds on, and repeating its last place from there on.
    let (evidence, error_m) = with_gps(|t_s, at_m| (t_s < 10.0).then_some([at_m, 0.0]));
    assert!(evidence.len() == 9 && error_m <= alone_m + 0.5, "{error_m} {alone_m}");
    let (_, error_m) = with_gps(|t_s, at_m| Some([if t_s < 10.0 { at_m } else { 54.0 }, 0.0]));
    assert!(error_m <= alone_m + 15.0, "{error_m} {alone_m}");
    // Two seconds late, which is ten metres; fifteen metres to the side all along; a drift of a metre a second to the side.
    for (lie, most_m) in [([-10.0, 0.0], 10.0), ([0.0, 15.0], 3.0)] {
        let (_, error_m) = with_gps(|_, at_m| Some([at_m + lie[0], lie[1]]));
        assert!(error_m <= alone_m + most_m, "{lie:?}: {error_m} {alone_m}");
    }
    let (_, error_m) = with_gps(|t_s, at_m| Some([at_m, t_s]));
    assert!(error_m <= alone_m + 3.0, "{error_m} {alone_m}");
}

/// The vehicle's bus and camera say nothing for four seconds, in which the driver brakes from 10 to 4 m/s. Expected: the place goes on at
/// the last speed, 12 m too far in the end, and its standard deviation says so; once the speed is known again it does not grow on.
#[test]
fn a_speed_that_stops_is_an_error_that_the_fix_knows_of() {
    let near = NearPlace { at: plane().wgs84_from_map(Point2::new(20.0, 0.0)), sigma_m: 3.0 };
    let mut stage = FixStage::new(&roads(), Traffic::Centre, Some(near));
    let known = |speed_mps| VehicleState {
        speed_mps: Some(speed_mps),
        yaw_rate_rps: Some(0.0),
        ..VehicleState::default()
    };
    let mut at_m = 20.0;
    let mut sigmas_m = Vec::new();
    for step in 0..100 {
        let t_s = f64::from(step) * DT_S;
        let speed_mps = 10.0 - 1.5 * (t_s - 3.0).clamp(0.0, 4.0);
        at_m += speed_mps * DT_S;
        let unseen = (3.0..7.0).contains(&t_s);
        let vehicle = if unseen { VehicleState { speed_mps: None, ..known(0.0) } } else { known(speed_mps) };
        let fix = stage.step(Some(DT_S), &vehicle, None, FixInput::default()).0.unwrap();
        let off_m = (plane().map_from_wgs84(fix.at) - Point2::new(at_m, 0.0)).norm();
        // By then the other direction, in which the road ends, is ruled out.
        assert!(t_s < 3.0 || off_m <= 3.0 * fix.sigma_m, "{t_s} s: {off_m} m, {fix:?}");
        assert!(fix.bound_m.is_none_or(|bound_m| off_m <= bound_m), "{t_s} s: {off_m} m, {fix:?}");
        sigmas_m.push(fix.sigma_m);
    }
    assert!(sigmas_m[69] > 10.0 && sigmas_m[69] > 2.0 * sigmas_m[29], "{sigmas_m:?}");
    assert!(sigmas_m[99] < 1.2 * sigmas_m[70], "{sigmas_m:?}");
}

#[test]
fn a_feature_that_is_followed_corrects_a_start_that_is_off() {
    for off_m in [-20.0, 20.0] {
        let near = NearPlace { at: plane().wgs84_from_map(Point2::new(40.0 + off_m, 0.0)), sigma_m: 20.0 };
        let mut stage = FixStage::new(&roads(), Traffic::Centre, Some(near));
        let node = stage.plane.map_from_wgs84(plane().wgs84_from_map(Point2::new(90.0, 0.0)));
        stage.map_from_feature = vec![Isometry2::new(node.coords, 0.0)];
        let vehicle =
            VehicleState { speed_mps: Some(SPEED_MPS), yaw_rate_rps: Some(0.0), ..VehicleState::default() };
        let mut last = None;
        let mut made = Vec::new();
        for step in 1..=60 {
            let at_m = 40.0 + SPEED_MPS * DT_S * f64::from(step);
            // It is seen from 15 m before it on, a metre to the left of the vehicle.
            let seen = Followed {
                index: 0,
                vehicle_from_feature: Isometry2::translation(90.0 - at_m, 1.0),
                covariance: Matrix3::from_diagonal(&Vector3::new(0.09, 0.09, 0.01)),
                present: 0.5,
                present_by_sight: 0.99,
                matched: Match::default(),
            };
            let followed = Some(&seen).filter(|_| at_m > 75.0);
            let input = FixInput { gps: None, followed };
            let (fix, evidence) = stage.step(Some(DT_S), &vehicle, None, input);
            last = fix.map(|fix| (at_m, fix));
            made.extend(evidence.feature);
        }
        let (at_m, fix) = last.unwrap();
        let off = plane().map_from_wgs84(fix.at) - Point2::new(at_m, -1.0);
        assert!(off.norm() < 2.0, "{off_m}: {off}");
        assert!(made.len() >= 3 && made.iter().all(|made| made.verdict == Verdict::Accepted), "{made:?}");
        // Believed too far on, the feature puts it back; too far back, ahead. A metre to its left, it puts it to the right.
        let [forward_m, left_m, _] = made[0].innovation.unwrap().off;
        assert!(forward_m * off_m < 0.0 && left_m < 0.0, "{off_m}: {forward_m} {left_m}");
    }
}

#[test]
fn frames_without_times_move_nothing_and_unseen_ones_go_on() {
    let mut stage = FixStage::new(&roads(), Traffic::Right, None);
    let vehicle =
        VehicleState { speed_mps: Some(SPEED_MPS), yaw_rate_rps: Some(0.0), ..VehicleState::default() };
    let first = stage.step(None, &vehicle, None, FixInput::default()).0.unwrap();
    assert_eq!(stage.step(None, &vehicle, None, FixInput::default()).0, Some(first));
    let near = NearPlace { at: plane().wgs84_from_map(Point2::new(10.0, 0.0)), sigma_m: 3.0 };
    let mut stage = FixStage::new(&roads(), Traffic::Right, Some(near));
    let place = |fix: MapFix| plane().map_from_wgs84(fix.at);
    let before = place(stage.step(Some(DT_S), &vehicle, None, FixInput::default()).0.unwrap());
    let after = (0..4)
        .filter_map(|_| stage.step(Some(DT_S), &VehicleState::default(), None, FixInput::default()).0)
        .last()
        .unwrap();
    assert!(((place(after) - before).norm() - 4.0 * SPEED_MPS * DT_S).abs() < 0.5);
}

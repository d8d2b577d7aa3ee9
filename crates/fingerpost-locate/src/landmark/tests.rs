use fingerpost_map::{LatLon, OsmData, OsmNode, OsmWay, RoadGraph, TangentPlane};
use nalgebra::Point2;

use super::*;
use crate::{Fix, Locator, MotionInterval, Start, Traffic};

fn sighting(ahead_m: f64, left_m: f64, heading_rad: f64) -> Sighting {
    Sighting {
        landmark: 0,
        map_from_landmark: Isometry2::new(Vector2::new(200.0, 0.0), 0.0),
        vehicle_from_landmark: Isometry2::new(Vector2::new(ahead_m, left_m), heading_rad),
        covariance: Matrix3::from_diagonal(&Vector3::new(0.09, 0.09, 0.0025)),
        present: 0.99,
    }
}

#[test]
fn a_landmark_ahead_puts_the_vehicle_behind_it() {
    let pose = |ahead_m, left_m, heading_rad| sighting(ahead_m, left_m, heading_rad).pose();
    assert!((pose(10.0, 0.0, 0.0) - Vector3::new(190.0, 0.0, 0.0)).norm() < 1e-9);
    assert!(
        (pose(10.0, 2.0, 0.0) - Vector3::new(190.0, -2.0, 0.0)).norm() < 1e-9,
        "seen left, it is to the right"
    );
    // The approach leads to the right in the vehicle frame: the vehicle heads north and has the landmark straight ahead.
    let north = pose(10.0, 0.0, -FRAC_PI_2);
    assert!((north - Vector3::new(200.0, -10.0, FRAC_PI_2)).norm() < 1e-9, "{north}");
}

#[test]
fn the_derivative_of_the_pose_is_that_of_differences() {
    let at = [11.0, -2.0, 0.4];
    let turned = |mut at: [f64; 3], number: usize, by: f64| {
        at[number] += by;
        let mut seen = sighting(at[0], at[1], at[2]);
        seen.map_from_landmark = Isometry2::new(Vector2::new(200.0, 30.0), 0.9);
        seen
    };
    let derivative = turned(at, 0, 0.0).pose_by_sighting();
    for number in 0..3 {
        let numeric = (turned(at, number, 1e-5).pose() - turned(at, number, -1e-5).pose()) / 2e-5;
        assert!((numeric - derivative.column(number)).norm() < 1e-6, "{number}: {numeric}");
    }
}

/// A road of 400 m to the east with a street to the north at 200 m.
fn roads() -> RoadGraph {
    let plane = TangentPlane::new(LatLon { lat_deg: 47.0, lon_deg: 9.0 });
    let places = [(0.0, 0.0), (200.0, 0.0), (400.0, 0.0), (200.0, 150.0)];
    let nodes = places
        .iter()
        .zip(1..)
        .map(|((east, north), id)| OsmNode { id, at: plane.wgs84_from_map(Point2::new(*east, *north)) });
    let way = |id: i64, nodes: &[i64]| {
        let tags = [("highway".to_owned(), "residential".to_owned())].into();
        OsmWay { id, nodes: nodes.to_vec(), tags }
    };
    RoadGraph::from_osm(&OsmData {
        nodes: nodes.collect(),
        ways: vec![way(1, &[1, 2, 3]), way(2, &[2, 4])],
        ..OsmData::default()
    })
    .unwrap()
}

/// What comes of a drive, step by step: where the vehicle is, the fix, and what was made of the landmark.
type Driven = Vec<(Point2<f64>, Fix, Option<SightingEvidence>)>;

/// A drive to the east from 140 m on for 20 m, that is believed to begin `start_off_m` farther on. The landmark is seen `seen_off_m`
/// farther ahead and to the left than the map has it, in every step.
fn drive(start_off_m: f64, seen_off_m: [f64; 2], present: f64) -> Driven {
    drive_seeing(start_off_m, |_| Some((seen_off_m, present)))
}

/// The same with a landmark that is not seen in every step, nor always there.
fn drive_seeing(start_off_m: f64, seen_off: impl Fn(u32) -> Option<([f64; 2], f64)>) -> Driven {
    let graph = roads();
    let corner = graph.plane().map_from_wgs84(
        TangentPlane::new(LatLon { lat_deg: 47.0, lon_deg: 9.0 }).wgs84_from_map(Point2::new(200.0, 0.0)),
    );
    let place = |east_m: f64| corner + Vector2::new(east_m - 200.0, 0.0);
    let start = Start { place_m: place(140.0 + start_off_m), sigma_m: 20.0, heading_rad: Some([0.0, 0.05]) };
    let mut locator = Locator::near(&graph, Traffic::Centre, 1, &start);
    (1..=20_u32)
        .map(|step| {
            let true_m = place(140.0 + f64::from(step));
            let motion = MotionInterval {
                time_s: 0.1,
                speed_mps: 10.0,
                yaw_rate_rps: 0.0,
                turn_variance_rad2: 2.7e-8,
                distance_variance_m2: 0.0,
            };
            locator.go_on(&motion);
            let evidence = seen_off(step).and_then(|([farther_m, left_m], present)| {
                locator.sight(&Sighting {
                    map_from_landmark: Isometry2::new(corner.coords, 0.0),
                    present,
                    ..sighting(corner.x - true_m.x + farther_m, left_m, 0.0)
                })
            });
            (true_m, locator.now().unwrap(), evidence)
        })
        .collect()
}

#[test]
fn a_junction_seen_ahead_corrects_a_start_that_is_off() {
    for start_off_m in [-20.0, 20.0] {
        let fixes = drive(start_off_m, [0.0, 0.0], 0.99);
        let (_, _, first) = fixes.iter().find(|(.., evidence)| evidence.is_some()).unwrap();
        let innovation = first.unwrap().innovation.unwrap();
        assert!(
            (innovation.off[0] + start_off_m).abs() < 10.0,
            "it is moved back by about as much: {innovation:?}"
        );
        let (true_m, fix, _) = fixes.last().unwrap();
        assert!((fix.place_m - true_m).norm() < 2.0, "{start_off_m}: {}", fix.place_m - true_m);
    }
}

#[test]
fn a_landmark_counts_once_however_often_it_is_seen() {
    let fixes = drive(0.0, [0.0, 0.0], 1.0);
    let sigmas_m: Vec<f64> = fixes
        .iter()
        .filter(|(.., evidence)| evidence.is_some_and(|evidence| evidence.verdict == Verdict::Accepted))
        .map(|(_, fix, _)| fix.covariance_m2[(0, 0)].sqrt())
        .collect();
    assert!(sigmas_m.len() >= 6, "{}", sigmas_m.len());
    assert!(sigmas_m.iter().all(|sigma_m| *sigma_m > 0.9 * PLACE_SIGMA_M), "{sigmas_m:?}");
    assert!(sigmas_m.iter().all(|sigma_m| *sigma_m < 1.2 * PLACE_SIGMA_M), "{sigmas_m:?}");
}

#[test]
fn what_is_seen_where_no_vehicle_can_be_counts_little() {
    // Fifty metres to the side of every road.
    let fixes = drive(0.0, [0.0, 50.0], 0.99);
    let evidence: Vec<SightingEvidence> = fixes.iter().filter_map(|(.., evidence)| *evidence).collect();
    assert!(!evidence.is_empty());
    assert!(evidence.iter().all(|evidence| evidence.verdict == Verdict::Disagrees), "{evidence:?}");
    let (_, unmoved, _) = drive(0.0, [0.0, 0.0], 0.0).pop().unwrap();
    let (_, fix, _) = fixes.last().unwrap();
    assert!((fix.place_m - unmoved.place_m).norm() < 0.5);
}

#[test]
fn what_was_taken_for_a_landmark_before_it_does_not_keep_it_from_counting() {
    // Something else is taken for the junction 25 m before it and counts; then it is seen itself.
    let seen = |step| match step {
        1..=4 => Some(([-25.0, 0.0], 0.9)),
        12.. => Some(([0.0, 0.0], 0.99)),
        _ => None,
    };
    let fixes = drive_seeing(0.0, seen);
    let mut verdicts = fixes.iter().filter_map(|(.., evidence)| evidence.map(|evidence| evidence.verdict));
    assert_eq!(verdicts.next(), Some(Verdict::Accepted));
    assert_eq!(verdicts.next_back(), Some(Verdict::Accepted));
    let (true_m, fix, _) = fixes.last().unwrap();
    assert!((fix.place_m - true_m).norm() < 2.0, "{}", fix.place_m - true_m);
}

#[test]
fn a_landmark_is_in_sight_until_another_is_or_the_vehicle_has_driven_on() {
    let mut landmarks = Landmarks::default();
    let (one, other) = (sighting(10.0, 0.0, 0.0), Sighting { landmark: 1, ..sighting(30.0, 0.0, 0.0) });
    assert!(landmarks.see(&one).is_none() && landmarks.see(&one).is_none());
    assert!(landmarks.see(&other).is_some_and(|seen| seen.landmark == 0));
    let mut motion = Motion::default();
    motion.go_on(8.0, 0.0, 1.0);
    assert!(landmarks.go(&motion).is_some_and(|seen| seen.landmark == 1));
    assert!(landmarks.in_sight.is_none());
    assert!(!Sighting { present: f64::NAN, ..one }.is_sound());
}

#[test]
fn a_landmark_that_comes_into_sight_again_makes_nothing_surer() {
    let seen = |step| (!(8..=14).contains(&step)).then_some(([0.0, 0.0], 0.99));
    let fixes = drive_seeing(0.0, seen);
    let (_, fix, evidence) = fixes.iter().rfind(|(.., evidence)| evidence.is_some()).unwrap();
    assert_eq!(evidence.unwrap().verdict, Verdict::Counted);
    assert!(fix.covariance_m2[(0, 0)].sqrt() > 0.9 * PLACE_SIGMA_M);
}

/// Starts, sightings and places beside the road drawn from what is believed of them: the squared error is what the covariance says.
#[test]
fn errors_are_as_large_as_the_covariance_says() {
    let mut draws = crate::random::Random::new(7);
    let mut normal = || (0..12).map(|_| draws.unit()).sum::<f64>() - 6.0;
    let drives = 40;
    let mean: f64 = (0..drives)
        .map(|_| {
            let (start_off_m, seen_off_m) = (20.0 * normal(), [1.63 * normal(), 1.63 * normal()]);
            let (true_m, fix, _) = drive(start_off_m, seen_off_m, 1.0).pop().unwrap();
            let off = fix.place_m - true_m;
            off.x * off.x / fix.covariance_m2[(0, 0)]
        })
        .sum::<f64>()
        / f64::from(drives);
    // Mean of 40 squares of a standard normal number: within 0.61 and 1.48 in 95 % of draws (chi-squared over its degrees of freedom).
    assert!((0.61..=1.48).contains(&mean), "{mean}");
}

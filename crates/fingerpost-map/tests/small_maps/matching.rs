//! Matching noisy tracks: parallel roads, noise, outliers, and tracks that leave the map.

use fingerpost_map::{FeatureOptions, LatLon, RoadGraph, Route, RouteError, match_track};

use crate::town::{Town, at};

/// Two parallel streets 15 m apart, joined by cross streets every 100 m; the lower has nodes 1, 2, ... and the upper
/// 101, 102, ..., six of each.
fn parallel_streets() -> RoadGraph {
    let mut town = Town::default();
    let lower: Vec<i64> = (1..=6).collect();
    let upper: Vec<i64> = (101..=106).collect();
    for step in 0..6_i64 {
        let x = 100.0 * step as f64;
        town = town.node(step + 1, x, 0.0).node(step + 101, x, 15.0);
        town = town.way(200 + step, &[step + 1, step + 101], &["highway=residential"]);
    }
    town.way(10, &lower, &["highway=residential"]).way(11, &upper, &["highway=residential"]).graph()
}

/// A sequence of numbers with a standard normal distribution: sums of twelve uniform ones from a fixed generator.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// A track along corners (metres), a point every 8 m, with noise of a standard deviation in metres.
fn track(corners: &[(f64, f64)], sigma_m: f64, seed: u64) -> Vec<LatLon> {
    let mut normal = noise(seed);
    let mut points = Vec::new();
    for ends in corners.windows(2) {
        let (dx, dy) = (ends[1].0 - ends[0].0, ends[1].1 - ends[0].1);
        let steps = (libm::hypot(dx, dy) / 8.0).ceil();
        let mut step = 0.0;
        while step <= steps {
            let share = step / steps;
            let x = ends[0].0 + dx * share + sigma_m * normal();
            points.push(at(x, ends[0].1 + dy * share + sigma_m * normal()));
            step += 1.0;
        }
    }
    points
}

fn nodes(route: &Route) -> Vec<i64> {
    route.line.iter().filter_map(|point| point.node).collect()
}

fn matched(track: &[LatLon]) -> Result<Route, RouteError> {
    match_track(&parallel_streets(), track, &FeatureOptions::default())
}

#[test]
fn five_metres_of_noise_do_not_change_the_street() {
    for seed in 0..20 {
        let lower = matched(&track(&[(20.0, 0.0), (470.0, 0.0)], 5.0, seed)).unwrap();
        assert_eq!(nodes(&lower), [2, 3, 4, 5], "seed {seed}");
        let upper = matched(&track(&[(470.0, 15.0), (20.0, 15.0)], 5.0, seed)).unwrap();
        assert_eq!(nodes(&upper), [105, 104, 103, 102], "seed {seed}");
    }
}

#[test]
fn a_real_change_of_street_is_followed() {
    let corners = [(20.0, 0.0), (200.0, 0.0), (200.0, 15.0), (470.0, 15.0)];
    let route = matched(&track(&corners, 1.0, 7)).unwrap();
    assert_eq!(nodes(&route), [2, 3, 103, 104, 105]);
    let there_and_back = [(250.0, 0.0), (200.0, 0.0), (200.0, 15.0), (250.0, 15.0)];
    assert_eq!(nodes(&matched(&track(&there_and_back, 1.0, 3)).unwrap()), [3, 103]);
}

#[test]
fn standing_still_moves_nothing() {
    let mut points = track(&[(20.0, 0.0), (150.0, 0.0)], 1.0, 1);
    let mut normal = noise(9);
    points.extend((0..200).map(|_| at(150.0 + 3.0 * normal(), 3.0 * normal())));
    points.extend(track(&[(150.0, 0.0), (290.0, 0.0)], 1.0, 2));
    assert_eq!(nodes(&matched(&points).unwrap()), [2, 3]);
}

#[test]
fn single_outliers_are_passed_over() {
    let mut points = track(&[(20.0, 0.0), (470.0, 0.0)], 2.0, 5);
    points[20] = at(160.0, 80.0);
    points[40] = at(340.0, -400.0);
    assert_eq!(nodes(&matched(&points).unwrap()), [2, 3, 4, 5]);
}

#[test]
fn a_one_way_street_is_not_driven_backwards() {
    let graph = Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 300.0, 0.0)
        .way(10, &[1, 2], &["highway=residential", "oneway=yes"])
        .graph();
    let against =
        match_track(&graph, &track(&[(280.0, 0.0), (20.0, 0.0)], 1.0, 1), &FeatureOptions::default());
    assert!(matches!(against, Err(RouteError::TrackBroken { .. })), "{against:?}");
}

#[test]
fn why_a_track_has_no_route() {
    assert!(matches!(matched(&[]), Err(RouteError::TrackTooShort { found: 0, .. })));
    assert!(matches!(matched(&[at(5.0, 0.0)]), Err(RouteError::TrackTooShort { found: 1, .. })));
    let leaves = track(&[(300.0, 0.0), (300.0, -600.0)], 1.0, 4);
    let error = matched(&leaves).unwrap_err();
    let RouteError::TrackOffRoad { point, .. } = error else { panic!("{error}") };
    assert!((6..=9).contains(&point), "fifty metres out, at 8 m a point: {point}");
    assert!(error.to_string().contains("leaves the map at its point"));
    let far_away = track(&[(9000.0, 0.0), (9500.0, 0.0)], 1.0, 4);
    assert!(matches!(matched(&far_away), Err(RouteError::TrackOffRoad { point: 1, .. })));
}

//! Barriers on nodes: which let cars through, and that routes keep to it.

use fingerpost_map::{FeatureOptions, LatLon, RouteError, plan};

use crate::town::{Town, at};

/// A road of 300 m with a barrier in its middle, and a way round it that is 200 m longer.
fn road(barrier: &[&str]) -> Town {
    Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 100.0, 0.0)
        .node(3, 150.0, 0.0)
        .node(4, 200.0, 0.0)
        .node(5, 300.0, 0.0)
        .node(6, 100.0, 100.0)
        .node(7, 200.0, 100.0)
        .way(10, &[1, 2, 3, 4, 5], &["highway=residential"])
        .way(11, &[2, 6, 7, 4], &["highway=residential"])
        .barrier(3, barrier)
}

fn length_m(town: Town, stops: &[(f64, f64)]) -> Result<f64, RouteError> {
    let stops: Vec<LatLon> = stops.iter().map(|&(x, y)| at(x, y)).collect();
    let route = plan(&town.graph(), &stops, &FeatureOptions::default())?;
    Ok(route.polyline().unwrap().length_m())
}

fn is_passed(barrier: &[&str]) -> bool {
    let length_m = length_m(road(barrier), &[(0.0, 0.0), (300.0, 0.0)]).unwrap();
    assert!(
        [300.0, 500.0].iter().any(|known_m| (known_m - length_m).abs() < 1e-3),
        "{barrier:?}: {length_m}"
    );
    length_m < 400.0
}

#[test]
fn the_kind_of_a_barrier_says_whether_cars_pass() {
    for kind in [
        "gate",
        "lift_gate",
        "swing_gate",
        "cattle_grid",
        "toll_booth",
        "border_control",
        "entrance",
        "kerb",
        "no",
    ] {
        assert!(is_passed(&[&format!("barrier={kind}")]), "{kind}");
    }
    for kind in [
        "bollard",
        "block",
        "jersey_barrier",
        "cycle_barrier",
        "chain",
        "stile",
        "kissing_gate",
        "bus_trap",
        "yes",
        "what",
    ] {
        assert!(!is_passed(&[&format!("barrier={kind}")]), "{kind}");
    }
}

#[test]
fn access_tags_and_locks_are_more_than_the_kind() {
    for (kind, tag, passes) in [
        ("gate", "access=no", false),
        ("gate", "access=private", true),
        ("gate", "motor_vehicle=no", false),
        ("gate", "locked=yes", false),
        ("gate", "locked=Yes", false),
        ("gate", "locked=true", false),
        ("gate", "locked=1", false),
        ("gate", "locked=no", true),
        ("gate", "locked=night", true),
        ("gate", "access:conditional=no @ (22:00-06:00)", true),
        ("lift_gate", "vehicle=no", false),
        ("bollard", "motorcar=yes", true),
        ("bollard", "vehicle=yes", true),
        ("bollard", "access=yes", true),
        ("bollard", "bicycle=yes", false),
        ("gate", "foot=no", true),
    ] {
        assert_eq!(is_passed(&[&format!("barrier={kind}"), tag]), passes, "{kind}, {tag}");
    }
    assert!(
        is_passed(&["barrier=bollard", "access=no", "motor_vehicle=yes"]),
        "the most special one decides"
    );
    assert!(is_passed(&["access=no"]), "no barrier");
}

#[test]
fn places_on_both_sides_of_a_barrier_are_reached_from_their_side() {
    let between = |stops: &[(f64, f64)]| length_m(road(&["barrier=bollard"]), stops).unwrap();
    assert!((between(&[(120.0, 0.0), (140.0, 0.0)]) - 20.0).abs() < 1e-3);
    assert!((between(&[(140.0, 0.0), (160.0, 0.0)]) - 380.0).abs() < 1e-3, "round it");
    // A stop at the barrier is left by where it was come from.
    let stopped_m = between(&[(0.0, 0.0), (150.0, 0.0), (300.0, 0.0)]);
    assert!((stopped_m - 600.0).abs() < 1e-3, "{stopped_m}");
    let no_way_round = Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 50.0, 0.0)
        .node(3, 100.0, 0.0)
        .way(10, &[1, 2], &["highway=residential"])
        .way(11, &[2, 3], &["highway=residential"])
        .barrier(2, &["barrier=bollard"]);
    let refused = length_m(no_way_round, &[(0.0, 0.0), (100.0, 0.0)]).unwrap_err();
    assert!(refused.to_string().contains("barriers"), "{refused}");
}

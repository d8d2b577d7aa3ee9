//! What a route's junctions, side roads and bends are, with their arms.

use std::f64::consts::{FRAC_PI_2, PI};

use fingerpost_map::{
    Arm, ArmRole, FeatureKind, FeatureOptions, LatLon, RoadClass, RoadGraph, RouteFeature, TangentPlane, plan,
};
use nalgebra::Point2;

use crate::town::{Town, at};

/// A crossroads at the origin (node 1), roads of 100 m named after where they lead; the northern one is cut into two ways
/// and bends right at (0, 20); the western one starts with a kink of 2 m.
fn crossroads() -> RoadGraph {
    Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 100.0, 0.0)
        .node(3, 0.0, 20.0)
        .node(4, 30.0, 60.0)
        .node(5, -1.0, 1.0)
        .node(6, -100.0, 0.0)
        .node(7, 0.0, -100.0)
        .node(8, 60.0, 100.0)
        .way(20, &[1, 2], &["highway=residential", "name=East", "surface=gravel", "width=4"])
        .way(21, &[1, 3], &["highway=secondary", "name=North"])
        .way(22, &[3, 4, 8], &["highway=secondary", "name=North"])
        .way(23, &[6, 5, 1], &["highway=track"])
        .way(24, &[7, 1], &["highway=secondary", "name=South"])
        .way(25, &[1, 8], &["highway=footway"])
        .graph()
}

fn features(
    graph: &RoadGraph,
    from: (f64, f64),
    to: (f64, f64),
    options: &FeatureOptions,
) -> Vec<RouteFeature> {
    plan(graph, &[at(from.0, from.1), at(to.0, to.1)], options).unwrap().features
}

fn degrees(angle_rad: f64) -> f64 {
    angle_rad.to_degrees()
}

fn ends_m(arm: &Arm, origin: LatLon) -> Point2<f64> {
    TangentPlane::new(origin).map_from_wgs84(*arm.points.last().unwrap())
}

#[test]
fn a_right_turn_at_a_crossroads() {
    let graph = crossroads();
    let features = features(&graph, (0.0, -80.0), (90.0, 0.0), &FeatureOptions::default());
    assert_eq!(features.len(), 1);
    let junction = &features[0];
    assert_eq!((junction.id, junction.kind), (1, FeatureKind::Junction));
    assert_eq!(junction.name, "South x East x North", "the route's roads first; the track has no name");
    assert!(
        (junction.turn_rad + FRAC_PI_2).abs() < 1e-3,
        "right is negative: {}",
        degrees(junction.turn_rad)
    );
    assert!((junction.route_m - 80.0).abs() < 1e-3);
    let roles: Vec<ArmRole> = junction.arms.iter().map(|arm| arm.role).collect();
    assert_eq!(roles, [ArmRole::Approach, ArmRole::Exit, ArmRole::Side, ArmRole::Side]);
    // Leaving the node: south, east, then anticlockwise from the exit north and west.
    for (arm, expected_rad) in junction.arms.iter().zip([-FRAC_PI_2, 0.0, FRAC_PI_2, PI]) {
        let off_rad = libm::sin(arm.bearing_rad - expected_rad).abs();
        assert!(
            off_rad < 0.15 && libm::cos(arm.bearing_rad - expected_rad) > 0.9,
            "{}",
            degrees(arm.bearing_rad)
        );
    }
    let widths_m: Vec<f64> = junction.arms.iter().map(|arm| arm.width_m).collect();
    assert_eq!(widths_m, [6.5, 4.0, 6.5, 3.0]);
    assert_eq!(junction.arms[1].surface.as_deref(), Some("gravel"));
    assert_eq!(junction.arms[0].surface, None);
}

#[test]
fn arms_follow_their_roads_past_the_first_node() {
    let graph = crossroads();
    let junction = features(&graph, (0.0, -80.0), (90.0, 0.0), &FeatureOptions::default()).remove(0);
    assert!(junction.arms.iter().all(|arm| arm.points[0] == junction.at));
    // North goes on into its second way, as far as 45 m are full; the approach reaches past the route's start.
    let north = ends_m(&junction.arms[2], junction.at);
    assert!((north - Point2::new(30.0, 60.0)).norm() < 0.01, "{north}");
    let south = ends_m(&junction.arms[0], junction.at);
    assert!((south - Point2::new(0.0, -100.0)).norm() < 0.01, "{south}");
    // The western arm's direction is that of its first 8 m, not of the kink.
    assert!(degrees(junction.arms[3].bearing_rad) > 170.0, "{}", degrees(junction.arms[3].bearing_rad));
}

#[test]
fn straight_over_a_crossroads_is_a_junction_and_a_left_turn_is_positive() {
    let graph = crossroads();
    let straight = features(&graph, (0.0, -80.0), (0.0, 15.0), &FeatureOptions::default()).remove(0);
    assert_eq!(straight.kind, FeatureKind::Junction);
    assert!(straight.turn_rad.abs() < 1e-3);
    let left = features(&graph, (0.0, -80.0), (-90.0, 0.1), &FeatureOptions::default()).remove(0);
    assert!((degrees(left.turn_rad) - 90.0).abs() < 8.0, "{}", degrees(left.turn_rad));
}

#[test]
fn excluded_classes_are_no_arms_unless_the_route_takes_them() {
    let graph = crossroads();
    let options = FeatureOptions { excluded: vec![RoadClass::Track], ..FeatureOptions::default() };
    let past = features(&graph, (0.0, -80.0), (0.0, 15.0), &options).remove(0);
    assert_eq!((past.kind, past.arms.len()), (FeatureKind::SideRoad, 3));
    let onto = features(&graph, (0.0, -80.0), (-90.0, 0.1), &options).remove(0);
    assert_eq!((onto.kind, onto.arms.len()), (FeatureKind::Junction, 4));
}

/// A straight road from west to east with a side road to the north at x = 50, and another way from x = 100 on.
fn side_road(joint: (f64, f64)) -> RoadGraph {
    Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 50.0, 0.0)
        .node(3, joint.0, joint.1)
        .node(4, 200.0, 0.0)
        .node(5, 60.0, 70.0)
        .way(30, &[1, 2, 3], &["highway=tertiary", "name=Main"])
        .way(31, &[3, 4], &["highway=tertiary", "name=Main"])
        .way(32, &[5, 2], &["highway=residential", "name=Lane"])
        .graph()
}

#[test]
fn a_side_road_on_the_left_and_on_the_right() {
    let graph = side_road((100.0, 0.0));
    let eastwards = features(&graph, (5.0, 0.0), (190.0, 0.0), &FeatureOptions::default());
    assert_eq!(eastwards.len(), 1, "one road cut into two ways is no junction");
    assert_eq!((eastwards[0].id, eastwards[0].kind), (2, FeatureKind::SideRoad));
    assert_eq!(eastwards[0].name, "Main x Lane");
    let left_of_exit_rad =
        |feature: &RouteFeature| libm::sin(feature.arms[2].bearing_rad - feature.arms[1].bearing_rad);
    assert!(left_of_exit_rad(&eastwards[0]) > 0.9);
    let westwards = features(&graph, (190.0, 0.0), (5.0, 0.0), &FeatureOptions::default());
    assert!(left_of_exit_rad(&westwards[0]) < -0.9);
    let turning = features(&graph, (5.0, 0.0), (60.0, 69.0), &FeatureOptions::default());
    assert_eq!(turning[0].kind, FeatureKind::Junction);
}

#[test]
fn a_bend_is_sharp_or_nothing() {
    let bend = |joint| features(&side_road(joint), (60.0, 0.0), (195.0, 0.0), &FeatureOptions::default());
    // At (125, 75) the road turns by a right angle to the right; at (125, 10) by 16 degrees.
    let sharp = bend((125.0, 75.0));
    assert_eq!(sharp.len(), 1);
    assert_eq!((sharp[0].id, sharp[0].kind, sharp[0].arms.len()), (3, FeatureKind::Bend, 2));
    assert!((degrees(sharp[0].turn_rad) + 90.0).abs() < 0.1, "{}", degrees(sharp[0].turn_rad));
    assert_eq!(bend((125.0, 10.0)), []);
}

#[test]
fn a_rounded_corner_is_one_bend_in_its_middle() {
    // A quarter circle of radius 10 m about (100, 10), a node every 11.25 degrees.
    let mut town = Town::default().node(1, 0.0, 0.0);
    let mut nodes = vec![1];
    for step in 0..=8_i32 {
        let (sin, cos) = libm::sincos(f64::from(step) * PI / 16.0);
        town = town.node(i64::from(step) + 10, 100.0 + 10.0 * sin, 10.0 - 10.0 * cos);
        nodes.push(i64::from(step) + 10);
    }
    nodes.push(2);
    let graph = town.node(2, 110.0, 100.0).way(40, &nodes, &["highway=residential"]).graph();
    let features = features(&graph, (1.0, 0.0), (110.0, 99.0), &FeatureOptions::default());
    assert_eq!(features.len(), 1);
    assert!((13..=15).contains(&features[0].id), "near the middle: {}", features[0].id);
    assert_eq!(features[0].name, "unnamed residential");
    assert!(features[0].turn_rad > 35_f64.to_radians());
}

#[test]
fn a_bend_next_to_a_junction_is_part_of_it() {
    let near_bend = |x: f64| {
        let graph = Town::default()
            .node(1, 0.0, 0.0)
            .node(2, 100.0, 0.0)
            .node(3, x, 0.0)
            .node(4, x, 90.0)
            .node(5, 100.0, -80.0)
            .way(50, &[1, 2, 3, 4], &["highway=residential"])
            .way(51, &[2, 5], &["highway=residential"])
            .graph();
        let features = features(&graph, (1.0, 0.0), (x, 85.0), &FeatureOptions::default());
        features.into_iter().map(|feature| (feature.id, feature.kind)).collect::<Vec<_>>()
    };
    assert_eq!(near_bend(111.0), [(2, FeatureKind::SideRoad)], "the exit arm's course holds the bend");
    assert_eq!(near_bend(130.0), [(2, FeatureKind::SideRoad), (3, FeatureKind::Bend)]);
}

#[test]
fn what_lies_beside_an_arm_is_seen_from_its_node() {
    // A road east with a pavement on the left of its way, drawn from its far end; one north drawn from the node.
    let graph = Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 80.0, 0.0)
        .node(3, 0.0, 80.0)
        .node(4, -80.0, 0.0)
        .way(10, &[2, 1], &["highway=residential", "sidewalk=left"])
        .way(11, &[1, 3], &["highway=residential", "sidewalk:left=yes"])
        .way(12, &[4, 1], &["highway=residential"])
        .graph();
    let features = features(&graph, (-70.0, 0.0), (70.0, 0.0), &FeatureOptions::default());
    let pavements = |role: ArmRole| {
        let arm = features[0].arms.iter().find(|arm| arm.role == role).unwrap();
        arm.beside.map(|side| side.pavement)
    };
    assert_eq!(pavements(ArmRole::Exit), [Some(false), Some(true)]);
    assert_eq!(pavements(ArmRole::Side), [Some(true), None]);
    assert_eq!(pavements(ArmRole::Approach), [None, None]);
}

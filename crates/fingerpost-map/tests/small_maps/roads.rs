//! Which ways are roads, their widths and directions, and the graph made of them.

use crate::town::{Town, at};
use fingerpost_map::{Direction, RoadAttributes, RoadClass, Travel, parse_width_m};
use nalgebra::Point2;

fn attributes(tags: &[&str]) -> Option<RoadAttributes> {
    RoadAttributes::from_tags(&Town::default().way(1, &[], tags).data().ways[0].tags)
}

fn width_m(tags: &[&str]) -> f64 {
    attributes(tags).unwrap().width_m
}

#[test]
fn every_class_goes_by_its_own_name() {
    for highway in [
        "motorway",
        "trunk",
        "primary",
        "secondary",
        "tertiary",
        "unclassified",
        "residential",
        "living_street",
        "service",
        "track",
    ] {
        assert_eq!(RoadClass::from_highway(highway).unwrap().as_str(), highway);
    }
    assert_eq!(RoadClass::from_highway("road"), Some(RoadClass::Unclassified));
    assert_eq!(RoadClass::from_highway("secondary_link"), Some(RoadClass::Link));
    assert_eq!(RoadClass::Link.as_str(), "link");
    for highway in ["footway", "cycleway", "path", "steps", "pedestrian", "construction", "link", "foo_link"]
    {
        assert_eq!(RoadClass::from_highway(highway), None, "{highway}");
    }
}

#[test]
fn private_roads_are_kept_and_closed_ones_are_not() {
    assert!(attributes(&["highway=service", "access=private"]).is_some());
    assert!(attributes(&["highway=track", "motor_vehicle=agricultural"]).is_some());
    assert!(attributes(&["highway=residential", "access=no"]).is_none());
    assert!(attributes(&["highway=residential", "motor_vehicle=no"]).is_none());
    assert!(attributes(&["highway=residential", "access=no", "motor_vehicle=yes"]).is_some());
    assert!(attributes(&["highway=residential", "motor_vehicle=emergency"]).is_none());
    assert!(attributes(&["highway=residential", "access=no;destination"]).is_some());
    assert!(attributes(&["highway=service", "area=yes"]).is_none());
    assert!(attributes(&["building=yes"]).is_none());
}

#[test]
fn widths_are_read_in_every_usual_spelling() {
    for (text, expected_m) in [
        ("5.5", 5.5),
        ("5,5 m", 5.5),
        (" 7 ", 7.0),
        ("~6m", 6.0),
        ("16'", 4.8768),
        ("16'6\"", 5.0292),
        ("16 ft", 4.8768),
        ("3.5m", 3.5),
        ("3.5\u{a0}m", 3.5),
        ("~3,5", 3.5),
        ("~ 3.5 metres", 3.5),
        ("250 cm", 2.5),
        ("250cm", 2.5),
        ("2500 mm", 2.5),
        ("0.003 km", 3.0),
        ("0.003 mi", 4.828_032),
        ("4 yd", 3.6576),
        ("10'6\"", 3.2004),
        ("10' 6\"", 3.2004),
        ("10'6", 3.2004),
        ("10\u{2032}6\u{2033}", 3.2004),
        ("10\u{2019}6\u{201d}", 3.2004),
        ("10'6''", 3.2004),
        ("10 ft 6 in", 3.2004),
        ("10ft 6in", 3.2004),
        ("10 feet 6 inches", 3.2004),
        ("10 Ft", 3.048),
        ("120 in", 3.048),
        ("120\"", 3.048),
        ("16.5'", 5.0292),
    ] {
        let seen_m = parse_width_m(text).unwrap();
        assert!((seen_m - expected_m).abs() < 1e-9, "{text}: {seen_m}");
    }
    let unclear = [
        "", "wide", "3 km", "5500", "0", "-4", "NaN", "inf", "5;6", "3-4", "<3", ">3", "about 3", "3 4",
        "3 m 4",
    ];
    for text in unclear.into_iter().chain([
        "6 in 10 ft",
        "10 ft 6 ft",
        "10 ft 6 in 3",
        "3 lanes",
        "3..5",
        ",",
        "m",
        "'",
        "1e1",
    ]) {
        assert_eq!(parse_width_m(text), None, "{text}");
    }
}

#[test]
fn width_goes_from_tag_to_lanes_to_class() {
    let close = |seen: f64, expected: f64| assert!((seen - expected).abs() < 1e-9, "{seen}, not {expected}");
    close(width_m(&["highway=residential", "width=4.2", "lanes=3"]), 4.2);
    close(width_m(&["highway=residential", "width=nonsense", "lanes=3"]), 8.25);
    close(width_m(&["highway=residential", "lanes=0"]), 5.5);
    close(width_m(&["highway=residential", "width=9", "width:carriageway=6"]), 6.0);
    close(width_m(&["highway=residential", "est_width=5", "width=nonsense"]), 5.0);
    // `lanes` leaves out lanes for bicycles and parked cars.
    close(width_m(&["highway=residential", "lanes=2", "parking:right=lane", "cycleway:both=lane"]), 10.5);
    close(width_m(&["highway=residential", "lanes=2", "parking:both=half_on_kerb"]), 7.5);
    close(width_m(&["highway=secondary"]), 6.5);
    close(width_m(&["highway=secondary", "oneway=yes"]), 3.5);
    close(width_m(&["highway=track", "oneway=yes"]), 3.0);
    close(width_m(&["highway=motorway"]), 7.5);
}

#[test]
fn one_way_tags() {
    let travel = |tags: &[&str]| attributes(tags).unwrap().travel;
    assert_eq!(travel(&["highway=residential"]), Travel::Both);
    assert_eq!(travel(&["highway=residential", "oneway=yes"]), Travel::Forward);
    assert_eq!(travel(&["highway=residential", "oneway=true"]), Travel::Forward);
    assert_eq!(travel(&["highway=residential", "oneway=-1"]), Travel::Backward);
    assert_eq!(travel(&["highway=tertiary", "junction=roundabout"]), Travel::Forward);
    assert_eq!(travel(&["highway=motorway"]), Travel::Forward);
    assert_eq!(travel(&["highway=motorway", "oneway=no"]), Travel::Both);
    for oneway in ["reversible", "maybe", "yes;no", "", "forward"] {
        assert_eq!(travel(&["highway=residential", &format!("oneway={oneway}")]), Travel::Unsure, "{oneway}");
    }
    assert_eq!(travel(&["highway=residential", "oneway=alternating"]), Travel::Both);
    // A tag for cars alone is more special.
    assert_eq!(travel(&["highway=residential", "oneway=yes", "oneway:motor_vehicle=no"]), Travel::Both);
    assert_eq!(travel(&["highway=residential", "motor_vehicle:backward=no"]), Travel::Forward);
    assert_eq!(travel(&["highway=residential", "access:forward=no"]), Travel::Backward);
    assert_eq!(attributes(&["highway=residential", "oneway=yes", "vehicle:forward=no"]), None);
}

#[test]
fn a_way_that_leaves_the_extract_is_cut_there() {
    let graph = Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 10.0, 0.0)
        .node(4, 50.0, 0.0)
        .node(5, 60.0, 0.0)
        .way(7, &[1, 2, 3, 4, 4, 5], &["highway=track", "ref=F 9"])
        .graph();
    let ids: Vec<i64> = graph.ways().iter().map(|way| way.id).collect();
    assert_eq!(ids, [7, 7]);
    assert_eq!(graph.segments().len(), 2, "nothing bridges the gap, and a node given twice is one");
    assert_eq!(graph.ways()[0].attributes.name.as_deref(), Some("F 9"));
    assert!((graph.way_line(&graph.ways()[1])[0] - Point2::new(50.0, 0.0)).norm() < 1e-6);
}

#[test]
fn the_nearest_place_of_a_road() {
    let graph = Town::default()
        .node(1, 0.0, 0.0)
        .node(2, 100.0, 0.0)
        .node(3, 100.0, 80.0)
        .way(7, &[1, 2, 3], &["highway=residential", "oneway=yes"])
        .graph();
    let snap = graph.nearest(Point2::new(30.0, 4.0), 10.0).unwrap();
    assert_eq!(snap.segment, 0);
    assert!((snap.along_m - 30.0).abs() < 1e-6 && (snap.distance_m - 4.0).abs() < 1e-6);
    assert!((snap.p_in_map - Point2::new(30.0, 0.0)).norm() < 1e-6);
    assert!(graph.nearest(Point2::new(30.0, 4.0), 3.9).is_none());
    assert!(graph.nearest(Point2::new(f64::NAN, 0.0), 10.0).is_none());
    let near_corner = graph.within(Point2::new(97.0, 2.0), 5.0);
    assert_eq!(near_corner.iter().map(|snap| snap.segment).collect::<Vec<_>>(), [0, 1]);
    assert!(graph.permits(0, Direction::Forward) && !graph.permits(0, Direction::Backward));
    assert_eq!(graph.node_index(3), Some(2));
    assert_eq!(graph.node_index(9), None);
    assert!((graph.nodes()[1].at.lat_deg - at(100.0, 0.0).lat_deg).abs() < 1e-12);
}

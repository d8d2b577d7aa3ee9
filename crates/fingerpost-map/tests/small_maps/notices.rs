//! What of a map's tags is not understood is counted, with its first place.

use fingerpost_map::{MapNotice, MapNoticeKind, OsmData, RoadGraph};

use crate::town::Town;

/// The notices of a map of a good road and one road more for each of these tags.
fn notices(tags: &[&str]) -> Vec<MapNotice> {
    let road = Town::default().node(1, 0.0, 0.0).node(2, 100.0, 0.0).node(3, 50.0, 0.0);
    let road = road.way(1, &[1, 3, 2], &["highway=residential", "width=5"]);
    let roads = (5..).zip(tags).fold(road, |town, (id, tag)| {
        let class: &[&str] = if tag.starts_with("highway=") { &[] } else { &["highway=residential"] };
        town.way(id, &[1, 2], &[class, &[tag]].concat())
    });
    roads.graph().notices().to_vec()
}

#[test]
fn every_tag_that_decides_and_is_not_understood_is_said() {
    for (kind, tag) in [
        (MapNoticeKind::Highway, "highway=residental"),
        (MapNoticeKind::Highway, "highway=foo_link"),
        (MapNoticeKind::Access, "access=maybe"),
        (MapNoticeKind::Access, "motor_vehicle=yes;perhaps"),
        (MapNoticeKind::Access, "vehicle:forward=perhaps"),
        (MapNoticeKind::Oneway, "oneway=reversible"),
        (MapNoticeKind::Oneway, "oneway=maybe"),
        (MapNoticeKind::Alternating, "oneway=alternating"),
        (MapNoticeKind::Conditional, "oneway:conditional=yes @ (07:00-09:00)"),
        (MapNoticeKind::Conditional, "motor_vehicle:backward:conditional=no @ winter"),
        (MapNoticeKind::Width, "width=wide"),
        (MapNoticeKind::Width, "est_width=5;6"),
        (MapNoticeKind::Lanes, "lanes=two"),
        (MapNoticeKind::Lanes, "lanes=0"),
        (MapNoticeKind::Roadside, "sidewalk=maybe"),
        (MapNoticeKind::Roadside, "kerb:left=maybe"),
        (MapNoticeKind::Roadside, "parking:both=maybe"),
        (MapNoticeKind::Roadside, "parking:lane:right=maybe"),
        (MapNoticeKind::Roadside, "cycleway=maybe"),
    ] {
        let said = notices(&[tag, "maxspeed=50", tag, tag]);
        let [notice] = said.as_slice() else { panic!("{tag}: {said:?}") };
        assert_eq!((notice.kind, notice.count), (kind, 3), "{tag}");
        let (key, value) = tag.split_once('=').unwrap();
        let value = value.rsplit(';').next().filter(|_| kind == MapNoticeKind::Access).unwrap_or(value);
        assert_eq!(notice.first, format!("way 5, {key}={value}"));
        assert!(notice.to_string().contains(&format!("3, first: way 5, {key}")), "{notice}");
    }
}

#[test]
fn what_is_understood_or_decides_nothing_is_not() {
    let silent = [
        "highway=footway",
        "highway=construction",
        "access=private",
        "access=agricultural;forestry",
        "access=no",
        "oneway=-1",
        "oneway:bicycle=whatever",
        "hgv:conditional=no @ (weight>7.5)",
        "width=10'6\"",
        "lanes=2",
        "sidewalk=separate",
        "cycleway=shared",
        "parking:left=yes",
        "surface=whatever",
    ];
    assert_eq!(notices(&silent), []);
    let footway = Town::default().node(1, 0.0, 0.0).node(2, 9.0, 0.0);
    let footway =
        footway.way(1, &[1, 2], &["highway=track"]).way(2, &[1, 2], &["highway=footway", "width=wide"]);
    assert_eq!(footway.graph().notices(), []);
    // The carriageway's width is read, and no other is asked for.
    let road = Town::default().node(1, 0.0, 0.0).node(2, 9.0, 0.0);
    let road = road.way(1, &[1, 2], &["highway=track", "width:carriageway=4", "width=wide", "lanes=two"]);
    assert_eq!(road.graph().notices(), []);
}

#[test]
fn barriers_are_said_where_they_are_on_roads() {
    let road = || {
        let town = Town::default().node(1, 0.0, 0.0).node(2, 50.0, 0.0).node(3, 100.0, 0.0).node(4, 9.0, 9.0);
        town.way(1, &[1, 2, 3], &["highway=track"]).barrier(4, &["barrier=what"])
    };
    assert_eq!(road().graph().notices(), []);
    let said = road().barrier(2, &["barrier=what"]).barrier(3, &["barrier=gate", "access=maybe"]).graph();
    let firsts: Vec<&str> = said.notices().iter().map(|notice| notice.first.as_str()).collect();
    assert_eq!(firsts, ["node 3, access=maybe", "node 2, barrier=what"]);
}

#[test]
fn locks_and_times_of_barriers_are_said() {
    for (kind, tag) in [
        (Some(MapNoticeKind::Locked), "locked=night"),
        (Some(MapNoticeKind::Locked), "locked=maybe"),
        (Some(MapNoticeKind::Conditional), "access:conditional=no @ (22:00-06:00)"),
        (Some(MapNoticeKind::Conditional), "motor_vehicle:conditional=no @ winter"),
        (Some(MapNoticeKind::Conditional), "locked:conditional=yes @ (22:00-06:00)"),
        (None, "locked=Yes"),
        (None, "locked=no"),
        (None, "bicycle:conditional=no @ winter"),
    ] {
        // The map is read from a file: what speaks of barriers is all that is kept of a node.
        let (key, value) = tag.split_once('=').unwrap();
        let text = format!(
            r#"<osm><node id="1" lat="47" lon="9"/><node id="3" lat="47" lon="9.001"/>
            <node id="2" lat="47" lon="9.0005"><tag k="barrier" v="gate"/><tag k="{key}" v="{value}"/></node>
            <way id="1"><nd ref="1"/><nd ref="2"/><nd ref="3"/><tag k="highway" v="track"/></way></osm>"#
        );
        let osm = OsmData::from_bytes(text.as_bytes()).unwrap();
        let graph = RoadGraph::from_osm(&osm).unwrap();
        let said: Vec<_> = graph.notices().iter().map(|notice| (notice.kind, notice.first.clone())).collect();
        let expected: Vec<_> = kind.map(|kind| (kind, format!("node 2, {tag}"))).into_iter().collect();
        assert_eq!(said, expected, "{tag}");
    }
}

#[test]
fn what_a_map_says_cannot_steer_a_terminal() {
    let said = notices(&["width=\u{1b}[31mwide\n\u{202e}"]);
    assert_eq!(said[0].first, "way 5, width=[31mwide");
}

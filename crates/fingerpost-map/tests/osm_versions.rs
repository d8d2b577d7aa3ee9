//! Histories, maps that were put together, deleted elements and places on ways: in XML and in PBF the same data.

// Functions shared by tests fail their test by panicking.
#![allow(clippy::unwrap_used, clippy::panic)]

mod pbf_bytes;

use std::fmt::Write;

use fingerpost_map::{MapNoticeKind, OsmData, OsmError};
use pbf_bytes::{blob, field, map_of, number_field, packed, varint};

/// An element of a file.
#[derive(Clone, Copy, Debug)]
enum Element {
    /// Number, version, and latitude in degrees; none for a deleted one.
    Node(i64, i64, Option<i64>),
    /// Number, version, and class; none for a deleted one.
    Way(i64, i64, Option<&'static str>),
}
use Element::{Node, Way};

fn xml(elements: &[Element]) -> Vec<u8> {
    let mut text = String::from("<osm>");
    for element in elements {
        match *element {
            Node(id, version, Some(lat)) => {
                write!(text, "<node id='{id}' version='{version}' visible='true' lat='{lat}' lon='9'/>")
                    .unwrap();
            }
            Node(id, version, None) => {
                write!(text, "<node id='{id}' version='{version}' visible='false'/>").unwrap()
            }
            Way(id, version, Some(class)) => {
                let key = if class == "house" { "building" } else { "highway" };
                write!(text, "<way id='{id}' version='{version}'><nd ref='1'/><nd ref='2'/><tag k='{key}' v='{class}'/></way>")
                    .unwrap();
            }
            Way(id, version, None) => {
                write!(text, "<way id='{id}' version='{version}' visible='false'/>").unwrap()
            }
        }
    }
    text.push_str("</osm>");
    text.into_bytes()
}

/// As a block with a group an element: nodes alone where `is_dense` is not said, else as columns of one.
fn pbf(elements: &[Element], is_dense: bool) -> Vec<u8> {
    let texts = ["", "highway", "building", "track", "service", "house"];
    let table: Vec<u8> = texts.iter().flat_map(|text| field(1, text.as_bytes())).collect();
    let text = |wanted: &str| texts.iter().position(|text| *text == wanted).unwrap() as u8;
    let info = |version: i64, is_there: bool| {
        [number_field(1, version as u64), number_field(6, u64::from(is_there))].concat()
    };
    let units = |degrees: i64| degrees * 10_000_000;
    let group = |element: &Element| match *element {
        Node(id, version, lat) => {
            // What a deleted node has for a place is none.
            let at = lat.map_or(i64::from(i32::MAX), units);
            if is_dense {
                let info = [field(1, &varint(version as u64)), field(6, &[u8::from(lat.is_some())])].concat();
                let columns = [packed(&[id]), info, packed(&[at]), packed(&[units(9)])];
                let fields =
                    [1, 5, 8, 9].iter().zip(columns).flat_map(|(number, column)| field(*number, &column));
                field(2, &fields.collect::<Vec<u8>>())
            } else {
                let signed = |value: i64| u64::from_le_bytes(((value << 1) ^ (value >> 63)).to_le_bytes());
                let fields = [
                    number_field(1, signed(id)),
                    field(4, &info(version, lat.is_some())),
                    number_field(8, signed(at)),
                    number_field(9, signed(units(9))),
                ];
                field(1, &fields.concat())
            }
        }
        Way(id, version, class) => {
            let key = if class == Some("house") { "building" } else { "highway" };
            let tags = class.map(|class| [field(2, &[text(key)]), field(3, &[text(class)])].concat());
            let fields = [
                number_field(1, id as u64),
                tags.unwrap_or_default(),
                field(4, &info(version, class.is_some())),
                field(8, &packed(&[1, 1])),
            ];
            field(3, &fields.concat())
        }
    };
    let groups: Vec<u8> = elements.iter().flat_map(|element| field(2, &group(element))).collect();
    map_of(&[field(1, &table), groups].concat())
}

/// Latitudes of the nodes and classes of the ways, by number, and how many stood there again.
type Read = (Vec<(i64, i64)>, Vec<(i64, String)>, usize);

/// What is read of these elements, by every format.
fn read(elements: &[Element]) -> Read {
    let of = |bytes: &[u8]| {
        let data = OsmData::from_bytes(bytes).unwrap();
        let nodes = data.nodes.iter().map(|node| (node.id, node.at.lat_deg.round() as i64)).collect();
        let ways = data.ways.iter().map(|way| (way.id, way.tags["highway"].clone())).collect();
        let again = data.notices.iter().filter(|notice| notice.kind == MapNoticeKind::RepeatedElement);
        (nodes, ways, again.map(|notice| notice.count).sum())
    };
    let read: Read = of(&xml(elements));
    for is_dense in [false, true] {
        assert_eq!(of(&pbf(elements, is_dense)), read, "{elements:?}, dense: {is_dense}");
    }
    read
}

#[test]
fn the_newest_version_counts_in_whatever_order() {
    let history = [
        Node(1, 1, Some(10)),
        Node(1, 2, Some(20)),
        Node(1, 3, Some(30)),
        Node(2, 1, Some(40)),
        Node(2, 2, None),
        Node(3, 1, None),
        Node(3, 2, Some(50)),
        Way(7, 1, Some("track")),
        Way(7, 2, None),
        Way(8, 1, Some("track")),
        Way(8, 2, Some("service")),
        Way(9, 1, Some("track")),
        Way(9, 2, Some("house")),
        Way(10, 1, Some("house")),
        Way(10, 2, Some("track")),
    ];
    let expected = (vec![(1, 30), (3, 50)], vec![(8, "service".to_owned()), (10, "track".to_owned())], 7);
    for turn in 0..history.len() {
        for step in [1, 2, 4, 7, 8, 11, 13, 14] {
            let order: Vec<Element> =
                (0..history.len()).map(|place| history[(turn + place * step) % history.len()]).collect();
            assert_eq!(read(&order), expected, "{order:?}");
        }
    }
}

#[test]
fn copies_are_one_and_deleted_elements_alone_are_none() {
    let one = [Node(1, 4, Some(10)), Node(2, 1, Some(20)), Way(7, 2, Some("track"))];
    let (nodes, ways, again) = read(&[one, one].concat());
    assert_eq!((nodes.len(), ways.len(), again), (2, 1, 3));
    assert_eq!(read(&one).2, 0, "nothing stands there again");
    assert_eq!(read(&[Node(1, 0, Some(10)), Node(1, 0, Some(20))]).0, [(1, 10)], "the first of copies");
    assert_eq!(read(&[Node(1, 2, None), Node(5, 1, Some(3)), Way(9, 2, None)]), (vec![(5, 3)], vec![], 0));
    // Numbers of editors, which descend.
    let made =
        [Node(-1, 1, Some(10)), Node(-2, 1, Some(20)), Way(-7, 1, Some("track")), Way(-8, 1, Some("track"))];
    let (nodes, ways, again) = read(&made);
    assert_eq!((nodes.len(), ways.len(), again), (2, 2, 0));
}

#[test]
fn a_barrier_is_that_of_the_version_that_counts() {
    let map = |old: &str, new: &str| {
        format!(
            "<osm><node id='1' version='1' lat='1' lon='2'>{old}</node><node id='1' version='2' lat='1' lon='2'>{new}</node></osm>"
        )
    };
    let tag = "<tag k='barrier' v='gate'/><tag k='name' v='x'/>";
    for (text, count) in [(map(tag, ""), 0), (map("", tag), 1), (map(tag, tag), 1)] {
        let data = OsmData::from_bytes(text.as_bytes()).unwrap();
        assert_eq!(data.barriers.len(), count, "{text}");
        assert!(data.barriers.iter().all(|barrier| barrier.node == 1 && barrier.tags.len() == 1));
    }
}

#[test]
fn barriers_of_pbf_are_those_of_xml() {
    let texts = ["", "barrier", "bollard", "name", "Pier", "motor_vehicle", "no"];
    let table: Vec<u8> = texts.iter().flat_map(|text| field(1, text.as_bytes())).collect();
    let plain =
        [vec![1 << 3, 2], field(2, &[3, 1, 5]), field(3, &[4, 2, 6]), vec![8 << 3, 0, 9 << 3, 0]].concat();
    let dense = [
        field(1, &packed(&[1, 1, 1])),
        field(8, &packed(&[0, 0, 0])),
        field(9, &packed(&[0, 0, 0])),
        // Of the first node none, of the second a name and a barrier, of the third a name.
        field(10, &[0, 3, 4, 1, 2, 5, 6, 0, 3, 4, 0]),
    ];
    let (plain, dense) = (field(1, &plain), field(2, &dense.concat()));
    for group in [plain, dense] {
        let data = OsmData::from_bytes(&map_of(&[field(1, &table), field(2, &group)].concat())).unwrap();
        let [barrier] = data.barriers.as_slice() else { panic!("{data:?}") };
        assert_eq!((barrier.node, barrier.tags.len()), (if data.nodes.len() == 3 { 2 } else { 1 }, 2));
        assert_eq!(
            (barrier.tags["barrier"].as_str(), barrier.tags["motor_vehicle"].as_str()),
            ("bollard", "no")
        );
    }
}

#[test]
fn places_on_ways_are_places_of_nodes() {
    let text = "<osm><way id='1'><nd ref='4' lat='47' lon='9'/><nd ref='2' lat='48' lon='9'/><nd ref='3'/>\
                <tag k='highway' v='track'/></way><way id='2'><nd ref='2' lat='48' lon='9'/><nd ref='9' lat='1' lon='1'/></way></osm>";
    let data = OsmData::from_bytes(text.as_bytes()).unwrap();
    let places: Vec<(i64, f64)> = data.nodes.iter().map(|node| (node.id, node.at.lat_deg)).collect();
    assert_eq!(places[..2], [(2, 48.0), (4, 47.0)]);
    // The same in PBF, with a node that stands on its own as well, which is moved by nothing.
    let way = [
        vec![1 << 3, 1],
        field(2, &[1]),
        field(3, &[1]),
        field(8, &packed(&[4, -2])),
        field(9, &packed(&[470_000_000, 10_000_000])),
        field(10, &packed(&[90_000_000, 0])),
    ];
    let node =
        [vec![1 << 3, 4, 8 << 3], varint(2 * 480_000_000), vec![9 << 3], varint(2 * 90_000_000)].concat();
    let table = [field(1, &[]), field(1, b"highway")].concat();
    let groups = [field(2, &field(1, &node)), field(2, &field(3, &way.concat()))].concat();
    let pbf = OsmData::from_bytes(&map_of(&[field(1, &table), groups].concat())).unwrap();
    let places: Vec<(i64, f64, f64)> =
        pbf.nodes.iter().map(|node| (node.id, node.at.lat_deg, node.at.lon_deg)).collect();
    assert_eq!(places, [(2, 48.0, 9.0), (4, 47.0, 9.0)]);
}

#[test]
fn features_that_a_reader_must_have_are_known_or_refused_by_name() {
    let map = |features: &[&str]| {
        let header: Vec<u8> = features.iter().flat_map(|feature| field(4, feature.as_bytes())).collect();
        blob("OSMHeader", &field(1, &header))
    };
    assert!(OsmData::from_bytes(&map(&["OsmSchema-V0.6", "DenseNodes", "HistoricalInformation"])).is_ok());
    let refused = OsmData::from_bytes(&map(&["OsmSchema-V0.6", "Curves"])).unwrap_err();
    assert_eq!(refused, OsmError::Feature { feature: "Curves".to_owned() });
    assert!(refused.to_string().contains("osmium cat"), "{refused}");
}

#[test]
fn what_a_server_says_of_a_map_is_kept() {
    let words = "runtime error: Query timed out in \"query\" at line 3";
    for inner in [
        format!("<remark> {words} after 25 seconds. </remark>"),
        format!("<remark> {} after 25 seconds. </remark>", words.replace('"', "&quot;")),
        format!("<remark><![CDATA[ {words} after 25 seconds. ]]></remark>"),
    ] {
        let data =
            OsmData::from_bytes(format!("<osm><note>free</note><meta/>{inner}</osm>").as_bytes()).unwrap();
        let [remark] = data.notices.as_slice() else { panic!("{:?}", data.notices) };
        assert_eq!((remark.kind, remark.count), (MapNoticeKind::Remark, 1));
        assert_eq!(remark.first, format!("{words} after 25 seconds."), "{inner}");
    }
    let text = "<osm><action type='modify'><new><node id='1' lat='1' lon='1'/></new></action><action/></osm>";
    let data = OsmData::from_bytes(text.as_bytes()).unwrap();
    assert_eq!(
        data.notices[0].to_string(),
        "elements not understood: 2, first: <action> at byte 5; they are passed over"
    );
    let refused = OsmData::from_bytes(b" {\"version\": 0.6, \"elements\": []}").unwrap_err();
    assert_eq!(refused, OsmError::Json);
}

#[test]
fn a_deletion_is_newer_than_an_element_of_its_version() {
    for version in [0, 1, 7] {
        let both = [
            [Node(1, version, Some(10)), Node(1, version, None)],
            [Way(7, version, Some("track")), Way(7, version, None)],
        ];
        for [there, deleted] in both {
            for order in [vec![there, deleted], vec![deleted, there], vec![there, deleted, there]] {
                let (nodes, ways, _) = read(&order);
                assert!(nodes.is_empty() && ways.is_empty(), "{order:?}");
            }
            // One that was made again has a version of its own.
            let again = match there {
                Node(id, _, lat) => Node(id, version + 1, lat),
                Way(id, _, class) => Way(id, version + 1, class),
            };
            for order in [[there, deleted, again], [again, deleted, there], [deleted, again, there]] {
                let (nodes, ways, _) = read(&order);
                assert_eq!(nodes.len() + ways.len(), 1, "{order:?}");
            }
        }
    }
    // As editors write it.
    let text = "<osm><node id='1' version='3' lat='1' lon='2'/><node id='1' version='3' action='delete' lat='1' lon='2'/></osm>";
    assert!(OsmData::from_bytes(text.as_bytes()).unwrap().nodes.is_empty());
}

/// The remark of a map with this inside.
fn remark(inner: &str) -> String {
    let data = OsmData::from_bytes(format!("<osm><remark>{inner}</remark></osm>").as_bytes()).unwrap();
    let [remark] = data.notices.as_slice() else { panic!("{:?}", data.notices) };
    remark.first.clone()
}

#[test]
fn references_in_a_remark_are_what_they_stand_for() {
    for (inner, expected) in [
        ("a &amp; b &lt;c&gt; &quot;d&quot; &apos;e&apos;", "a & b <c> \"d\" 'e'"),
        ("&#x27;out of memory&#39; &#228;&#x1F697;", "'out of memory' ä🚗"),
        ("&amp;quot; stays", "&quot; stays"),
        ("&nbsp;&unknown; &#xD800; &#99999999;", "&nbsp;&unknown; &#xD800; &#99999999;"),
        ("a&#10;fingerpost: b&#27;[2J", "a fingerpost: b[2J"),
    ] {
        assert_eq!(remark(inner), expected, "{inner}");
    }
}

#[test]
fn a_remark_that_is_too_long_ends_in_an_ellipsis() {
    for inner in [
        "long ".repeat(1000),
        "ö".repeat(501),
        "&quot;".repeat(1001),
        format!("{}&amp;{}", "x".repeat(999), "y".repeat(5)),
        format!("begins{}ends", " ".repeat(2000)),
        format!("{}<b/>{}", "x ".repeat(600), "y".repeat(5)),
    ] {
        let shown = remark(&inner);
        assert!(shown.ends_with('…') && shown.chars().count() <= 200, "{shown}");
        assert!(shown.starts_with(['l', 'ö', '"', 'x', 'b']), "{shown}");
    }
    assert_eq!(remark(&"x".repeat(200)), "x".repeat(200));
}

#[test]
fn a_map_is_read_in_every_encoding_that_a_track_is() {
    let name = "Straße 東京 🚗";
    let text = format!(
        "<?xml version='1.0'?><osm><node id='1' lat='1' lon='2'/><node id='2' lat='1' lon='3'/>\
         <way id='7'><nd ref='1'/><nd ref='2'/><tag k='highway' v='track'/><tag k='name' v='{name}'/></way></osm>"
    );
    let expected = OsmData::from_bytes(text.as_bytes()).unwrap();
    assert_eq!((expected.ways[0].tags["name"].as_str(), expected.notices.len()), (name, 0));
    let units = || text.encode_utf16();
    for mark in [None, Some(0xFEFF)] {
        let little: Vec<u8> = mark.into_iter().chain(units()).flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = mark.into_iter().chain(units()).flat_map(u16::to_be_bytes).collect();
        let marked = [mark.map_or(&b""[..], |_| b"\xef\xbb\xbf"), text.as_bytes()].concat();
        for bytes in [little, big, marked] {
            assert_eq!(OsmData::from_bytes(&bytes).unwrap(), expected);
            // What it takes in UTF-8 counts where it is copied.
            assert!(matches!(OsmData::from_bytes_within(&bytes, 100), Err(OsmError::TooLarge { .. })));
            assert!(matches!(OsmData::from_bytes(&bytes[..bytes.len() / 2]), Err(OsmError::Xml { .. })));
        }
    }
    // Latin-1: the letters that are none are counted.
    let latin: Vec<u8> = text
        .replace(name, "Stra\u{df}e \u{e9}")
        .chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap())
        .collect();
    let read = OsmData::from_bytes(&latin).unwrap();
    assert_eq!(read.ways[0].tags["name"], "Stra\u{fffd}e \u{fffd}");
    let [letters] = read.notices.as_slice() else { panic!("{:?}", read.notices) };
    assert_eq!((letters.kind, letters.count), (MapNoticeKind::Letter, 2));
    let at: usize = letters.first.strip_prefix("byte ").unwrap().parse().unwrap();
    assert_eq!(latin[at], 0xDF);
    let json: Vec<u8> = "{\"elements\": []}".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(OsmData::from_bytes(&json), Err(OsmError::Json));
}

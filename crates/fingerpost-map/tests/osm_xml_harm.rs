//! OSM XML and GPX that were made to do harm: attributes, elements and texts without end.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used)]

use fingerpost_map::{OsmData, OsmError, parse_gpx_within};

/// Memory that the inputs may take, bytes.
const LIMIT_BYTES: usize = 4_000_000;
/// Times that something is repeated: in bytes of the file more than the limit.
const MANY: usize = 400_000;

/// What is taken at once, bytes, while something is read.
fn measured<T>(read: impl FnOnce() -> T) -> (u64, T) {
    let mut result = None;
    let taken = allocation_counter::measure(|| result = Some(read()));
    (taken.bytes_max, result.unwrap())
}

#[test]
fn attributes_and_elements_within_each_other_have_a_bound() {
    let attributes = |count: usize| (0..count).map(|i| format!(" a{i}=''")).collect::<String>();
    for (count, is_read) in [(0, true), (60, true), (61, true), (62, false), (1000, false), (MANY, false)] {
        let text = format!("<osm><node id='1' lat='1' lon='2'{}/></osm>", attributes(count));
        let (taken, read) = measured(|| OsmData::from_bytes_within(text.as_bytes(), LIMIT_BYTES));
        assert_eq!(read.is_ok(), is_read, "{count}");
        assert!(read.err().is_none_or(|error| error.to_string().contains("more than 64 attributes")));
        assert!(taken < LIMIT_BYTES as u64, "{count}: {taken} bytes");
        let text = format!("<gpx><wpt lat='1' lon='2'{}/></gpx>", attributes(count + 1));
        let (taken, read) = measured(|| parse_gpx_within(&text, LIMIT_BYTES));
        assert_eq!(read.is_ok(), is_read, "{count}");
        assert!(taken < LIMIT_BYTES as u64, "{count}: {taken} bytes");
    }
    for (depth, is_read) in [(1, true), (63, true), (64, false), (MANY, false)] {
        let text = format!("<osm>{}{}</osm>", "<a>".repeat(depth), "</a>".repeat(depth));
        let (taken, read) = measured(|| OsmData::from_bytes_within(text.as_bytes(), LIMIT_BYTES));
        assert_eq!(read.is_ok(), is_read, "{depth}");
        assert!(taken < LIMIT_BYTES as u64, "{depth}: {taken} bytes");
    }
}

#[test]
fn what_a_way_or_node_holds_is_counted_while_it_is_read() {
    let tags: String = (0..MANY).map(|i| format!("<tag k='{i}' v=''/>")).collect();
    let texts = [
        format!("<osm><way id='1'>{tags}</way></osm>"),
        format!("<osm><way id='1'>{tags}<tag k='highway' v='x'/></way></osm>"),
        format!("<osm><way id='1'>{}</way></osm>", "<nd ref='1'/>".repeat(MANY)),
        format!("<osm><way id='1'>{}</way></osm>", "<nd ref='1' lat='1' lon='1'/>".repeat(MANY)),
    ];
    for text in texts {
        let (taken, read) = measured(|| OsmData::from_bytes_within(text.as_bytes(), LIMIT_BYTES));
        assert!(matches!(read, Err(OsmError::TooLarge { .. })), "{} ...: {read:?}", &text[..60]);
        assert!(taken < LIMIT_BYTES as u64 + 100_000, "{} ...: {taken} bytes", &text[..60]);
    }
    // What is no highway, or speaks of no barrier, is given back.
    let houses = "<way id='1'><nd ref='1'/><tag k='building' v='yes'/></way>".repeat(MANY / 4);
    let nodes = format!(
        "<osm><node id='1' lat='1' lon='1'>{tags}</node><node id='2' lat='1' lon='1'><tag k='access' v='no'/></node></osm>"
    );
    for text in [format!("<osm>{houses}</osm>"), nodes] {
        let (taken, read) = measured(|| OsmData::from_bytes_within(text.as_bytes(), LIMIT_BYTES));
        assert!(read.is_ok(), "{} ...: {read:?}", &text[..60]);
        assert!(taken < LIMIT_BYTES as u64, "{} ...: {taken} bytes", &text[..60]);
    }
}

#[test]
fn texts_are_kept_no_longer_than_they_may_be() {
    let long = "x".repeat(10 * LIMIT_BYTES);
    let remark = format!("<osm><remark>cut</remark><remark>{long}</remark></osm>");
    let (taken, read) = measured(|| OsmData::from_bytes_within(remark.as_bytes(), LIMIT_BYTES));
    assert_eq!(read.unwrap().notices[0].count, 2);
    assert!(taken < 100_000, "{taken} bytes");
    let track = format!("<gpx>{long}<wpt lat='1' lon='2'><desc>{long}</desc></wpt></gpx>");
    let (taken, read) = measured(|| parse_gpx_within(&track, LIMIT_BYTES));
    assert_eq!(read.unwrap().points.len(), 1);
    assert!(taken < 100_000, "{taken} bytes");
}

#[test]
fn versions_are_within_the_limit_too() {
    let node = |version: usize| format!("<node id='1' version='{version}' lat='1' lon='2'/>");
    for (versions, is_read) in [(1000, true), (MANY / 4, false)] {
        let text = format!("<osm>{}</osm>", (1..=versions).map(node).collect::<String>());
        let (taken, read) = measured(|| OsmData::from_bytes_within(text.as_bytes(), LIMIT_BYTES));
        assert_eq!(read.is_ok(), is_read, "{versions}");
        assert!(taken < LIMIT_BYTES as u64 + 100_000, "{versions}: {taken} bytes");
    }
}

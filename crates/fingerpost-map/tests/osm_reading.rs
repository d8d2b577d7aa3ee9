//! Reading OpenStreetMap data: the same from XML and PBF, and what broken data says.

use fingerpost_map::{GraphError, OsmData, OsmError, RoadGraph};
use proptest::prelude::*;

const XML: &[u8] = include_bytes!("data/tiny.osm");
/// The same data, converted by osmium-tool.
const PBF: &[u8] = include_bytes!("data/tiny.osm.pbf");

#[test]
fn xml_and_pbf_hold_the_same() {
    let data = OsmData::from_bytes(XML).unwrap();
    assert_eq!(data, OsmData::from_bytes(PBF).unwrap());
    let ids: Vec<i64> = data.nodes.iter().map(|node| node.id).collect();
    assert_eq!(ids, [-4, 1, 2, 3]);
    assert!((data.nodes[0].at.lat_deg + 33.9123457).abs() < 1e-12, "south of the equator");
    let way_ids: Vec<i64> = data.ways.iter().map(|way| way.id).collect();
    assert_eq!(way_ids, [10, 20], "only highways, ascending");
    assert_eq!(data.ways[0].tags["name"], "Hof & Gasse ß");
    assert_eq!(data.ways[0].nodes, [1, 2]);
}

#[test]
fn an_editors_deleted_elements_are_left_out() {
    let text = r#"<osm><node id="1" lat="1" lon="2"/><node id="2" action="delete"/><node id="3" visible="false"/>
        <way id="1" action="delete"><nd ref="1"/><tag k="highway" v="track"/></way></osm>"#;
    let data = OsmData::from_bytes(text.as_bytes()).unwrap();
    assert_eq!((data.nodes.len(), data.ways.len()), (1, 0));
}

#[test]
fn broken_data_says_what_and_what_next() {
    let message = |bytes: &[u8]| OsmData::from_bytes(bytes).unwrap_err().to_string();
    assert_eq!(OsmData::from_bytes(b""), Err(OsmError::Empty));
    assert!(message(b"BZh91AY&SY").contains("bunzip2"));
    assert!(message(b"\x1f\x8b\x08\x00").contains("gunzip"));
    assert!(message(b"lat,lon\n1,2\n").contains("lat,lon"), "shows how the file starts");
    assert!(message(b"<gpx></gpx>").contains("not <osm>"));
    assert!(message(b"<osm><node id=\"1\" lat=\"91\" lon=\"0\"/></osm>").contains("no place"));
    assert!(message(b"<osm><node id=\"1\" lon=\"0\"/></osm>").contains("lacks the attribute lat"));
    assert!(message(b"<osm><way id=\"x\"/></osm>").contains("no number"));
}

#[test]
fn data_cut_short_is_refused_wherever_it_is_cut() {
    let end = XML.windows(6).position(|bytes| bytes == b"</osm>").unwrap();
    for length in [5, 60, 150, 400, end, end + 3] {
        let error = OsmData::from_bytes(&XML[..length]).unwrap_err();
        assert!(matches!(error, OsmError::Xml { .. }), "{length} bytes: {error}");
    }
    for length in [20, PBF.len() / 2, PBF.len() - 1] {
        let error = OsmData::from_bytes(&PBF[..length]).unwrap_err();
        assert!(matches!(error, OsmError::Pbf { .. }), "{length} bytes: {error}");
    }
}

#[test]
fn a_map_without_roads_is_no_graph() {
    let text = r#"<osm><node id="1" lat="1" lon="2"/><node id="2" lat="1" lon="2.001"/>
        <way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="footway"/></way>
        <way id="2"><nd ref="1"/><nd ref="99"/><tag k="highway" v="residential"/></way></osm>"#;
    let error = RoadGraph::from_osm(&OsmData::from_bytes(text.as_bytes()).unwrap()).unwrap_err();
    assert_eq!(error, GraphError::NoRoads { highways: 2, notices: Vec::new() });
    assert!(error.to_string().ends_with("export an area with roads, with the nodes of its ways"));
}

#[test]
fn why_a_map_may_have_no_roads_is_said_with_the_refusal() {
    let refusal = |inner: &str| {
        let text =
            format!(r#"<osm><node id="1" lat="1" lon="2"/><node id="2" lat="1" lon="2.001"/>{inner}</osm>"#);
        RoadGraph::from_osm(&OsmData::from_bytes(text.as_bytes()).unwrap()).unwrap_err().to_string()
    };
    let timed_out = refusal("<remark>runtime error: Query timed out after 25 seconds</remark>");
    assert!(timed_out.contains("first: runtime error: Query timed out after 25 seconds"), "{timed_out}");
    let unknown = refusal(r#"<way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="foo"/></way>"#);
    assert!(unknown.contains("values of highway not understood: 1, first: way 1, highway=foo"), "{unknown}");
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: prop::test_runner::RngSeed::Fixed(11), ..ProptestConfig::default() })]

    #[test]
    fn damaged_bytes_never_panic(at in 0usize..500, byte: u8) {
        for bytes in [XML, PBF] {
            let mut bytes = bytes.to_vec();
            let at = at % bytes.len();
            bytes[at] = byte;
            // Either it is still data or it is an error; both are an answer.
            drop(OsmData::from_bytes(&bytes));
        }
    }
}

#[test]
fn a_map_is_read_whole_within_its_memory_or_refused() {
    for bytes in [XML, PBF] {
        let whole = OsmData::from_bytes(bytes).unwrap();
        let mut was_read = false;
        for memory_bytes in (0..3000).step_by(10) {
            match OsmData::from_bytes_within(bytes, memory_bytes) {
                Ok(data) => {
                    assert_eq!(data, whole, "{memory_bytes} bytes");
                    was_read = true;
                }
                Err(error) => {
                    assert!(matches!(error, OsmError::TooLarge { .. }), "{memory_bytes} bytes: {error}");
                    assert!(!was_read, "{memory_bytes} bytes are less than enough");
                }
            }
        }
        assert!(was_read);
    }
}

#[test]
fn blocks_that_are_packed_in_another_way_say_how_to_pack_them() {
    // A blob's field 3 is its contents packed with zlib; 4 is LZMA, 5 bzip2, 6 LZ4, 7 zstd, all of them bytes.
    let header = PBF.windows(9).position(|bytes| bytes == b"OSMHeader").unwrap() + 9;
    let zlib_field = PBF[header..].iter().position(|byte| *byte == 0x1a).unwrap() + header;
    for (field, packing, next) in [
        (0x22, "LZMA", "download"),
        (0x2a, "bzip2", "download"),
        (0x32, "LZ4", "osmium cat"),
        (0x3a, "zstd", "download"),
    ] {
        let mut bytes = PBF.to_vec();
        bytes[zlib_field] = field;
        let error = OsmData::from_bytes(&bytes).unwrap_err();
        assert_eq!(error, OsmError::PackedBlocks { packing });
        let message = error.to_string();
        assert!(message.contains(packing) && message.contains(next), "{message}");
    }
}

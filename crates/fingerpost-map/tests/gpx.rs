//! GPX: which points are read, and what broken tracks say.

use fingerpost_map::{GpxError, parse_gpx, parse_gpx_within};

const TRACK: &str = r#"<?xml version="1.0"?>
<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1" xmlns:x="urn:x">
  <metadata><time>1999-01-01T00:00:00Z</time></metadata>
  <wpt lat="1" lon="2"/>
  <trk><name>A &amp; B</name><trkseg>
    <trkpt lat="48.5" lon="8.25"><ele>110.5</ele><time>2011-10-03T12:55:34Z</time></trkpt>
    <trkpt lon="-8.5" lat="-48.75"><extensions><x:time>nonsense</x:time></extensions></trkpt>
  </trkseg><trkseg><trkpt lat="3" lon="4"/></trkseg></trk>
</gpx>"#;

#[test]
fn track_points_of_all_segments_in_their_order() {
    let points = parse_gpx(TRACK).unwrap().points;
    let places: Vec<(f64, f64)> = points.iter().map(|point| (point.at.lat_deg, point.at.lon_deg)).collect();
    assert_eq!(places, [(48.5, 8.25), (-48.75, -8.5), (3.0, 4.0)]);
    assert_eq!(points[0].time_s, Some(1_317_646_534.0));
    assert_eq!(points[1].time_s, None, "an extension's time is not the point's");
}

#[test]
fn route_points_then_waypoints_where_there_is_no_track() {
    let routed = r#"<gpx><wpt lat="1" lon="2"/><rte><rtept lat="5" lon="6"/></rte></gpx>"#;
    assert!((parse_gpx(routed).unwrap().points[0].at.lat_deg - 5.0).abs() < 1e-12);
    let marked = r#"<gpx><wpt lat="1" lon="2"/><wpt lat="1" lon="3"/></gpx>"#;
    assert_eq!(parse_gpx(marked).unwrap().points.len(), 2);
}

#[test]
fn broken_tracks_say_what_and_what_next() {
    let message = |text: &str| parse_gpx(text).unwrap_err().to_string();
    assert_eq!(parse_gpx("<gpx></gpx>"), Err(GpxError::NoPoints));
    assert!(message("").contains("no <gpx>"));
    assert!(message("<kml/>").contains("not <gpx>"));
    assert!(message("<gpx><trkpt lat=\"1\"/></gpx>").contains("lacks the attribute lon"));
    assert!(message("<gpx><trkpt lat=\"north\" lon=\"1\"/></gpx>").contains("no number"));
    assert!(message("<gpx><trkpt lat=\"91\" lon=\"1\"/></gpx>").contains("no place"));
    for length in [30, 120, 300, TRACK.len() - 8] {
        assert!(message(&TRACK[..length]).contains("broken at byte"), "{length}");
    }
}

#[test]
fn a_bad_point_or_time_costs_itself() {
    let good = "<trkpt lat=\"1\" lon=\"1\"><time>2011-10-03T12:55:34Z</time></trkpt>";
    for (bad, is_point, said) in [
        ("<trkpt lat=\"1\" lon=\"1\"><time>noon</time></trkpt>", true, "\"noon\" is not ISO 8601"),
        ("<trkpt lat=\"1\" lon=\"1\"><time></time></trkpt>", true, "\"\" is not ISO 8601"),
        ("<trkpt lat=\"1\" lon=\"1\"><time/></trkpt>", true, "\"\" is not ISO 8601"),
        ("<trkpt lat=\"91\" lon=\"1\"><time>2011-10-03T12:55:34Z</time></trkpt>", false, "no place"),
        ("<trkpt lat=\"\" lon=\"1\"/>", false, "is no number"),
        ("<trkpt lon=\"1\"/>", false, "lacks the attribute lat"),
    ] {
        let track = parse_gpx(&format!("<gpx>\n{good}\n{good}\n{bad}\n{good}\n{bad}\n</gpx>")).unwrap();
        assert_eq!(track.points.len(), if is_point { 5 } else { 3 }, "{bad}");
        assert_eq!(track.points.iter().filter(|point| point.time_s.is_some()).count(), 3, "{bad}");
        let first = track.passed_over.first.unwrap();
        assert_eq!((track.passed_over.count, first.line), (2, 4), "{bad}");
        assert!(first.cause.contains(said), "{bad}: {first}");
    }
}

#[test]
fn elements_within_each_other_and_points_have_a_bound() {
    for depth in [1, 10, 62, 63, 64, 1000, 300_000] {
        let text =
            format!("<gpx><wpt lat=\"1\" lon=\"2\"/>{}{}</gpx>", "<a>".repeat(depth), "</a>".repeat(depth));
        let read = parse_gpx(&text);
        assert_eq!(read.is_ok(), depth < 64, "{depth}: {read:?}");
    }
    for points in [1, 10, 1000, 20_000] {
        let text = format!("<gpx>{}</gpx>", "<wpt lat=\"1\" lon=\"2\"/>".repeat(points));
        for memory_bytes in [0, 50, 1000, 100_000, 10_000_000] {
            let mut read = Ok(0);
            let taken = allocation_counter::measure(|| {
                read = parse_gpx_within(&text, memory_bytes).map(|track| track.points.len());
            });
            assert!(
                read == Ok(points) || matches!(read, Err(GpxError::TooLarge { .. })),
                "{points}: {read:?}"
            );
            assert!(taken.bytes_max < memory_bytes as u64 + 4096, "{points}: {} bytes", taken.bytes_max);
        }
    }
}

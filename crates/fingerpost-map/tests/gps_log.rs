//! Logs of GPS receivers: which positions are read, and what is said of those that give none.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost_map::{GpsClock, GpsLogError, parse_gps_log_within};

const MEMORY: usize = 10_000_000;

/// A sentence with its checksum: the exclusive or of what stands between "$" and "*" (NMEA 0183).
fn sentence(body: &str) -> String {
    format!("${body}*{:02X}\r\n", body.bytes().fold(0, |sum, byte| sum ^ byte))
}

fn rmc(clock: &str, status: char, north: &str, date: &str) -> String {
    sentence(&format!("GNRMC,{clock},{status},{north},N,00932.00000,W,1.0,90.0,{date},,,A"))
}

#[test]
fn sentences_with_dates_give_positions_south_and_west_negative() {
    // `date -u -d 2011-10-03T12:55:34Z +%s` is 1317646534.
    let mut log = rmc("125534.25", 'A', "4830.00000", "031011");
    log += &sentence("GPRMC,125535.00,A,3315.00000,S,15130.00000,E,1.0,90.0,031011,,,A");
    let read = parse_gps_log_within(log.as_bytes(), MEMORY).unwrap();
    let seen: Vec<[f64; 2]> = read.points.iter().map(|point| [point.at.lat_deg, point.at.lon_deg]).collect();
    for (seen, expected) in seen.iter().zip([[48.5, -(9.0 + 32.0 / 60.0)], [-33.25, 151.5]]) {
        assert!((seen[0] - expected[0]).abs() < 1e-9 && (seen[1] - expected[1]).abs() < 1e-9, "{seen:?}");
    }
    assert_eq!(
        read.points.iter().map(|point| point.time_s).collect::<Vec<_>>(),
        [Some(1_317_646_534.25), Some(1_317_646_535.0)]
    );
}

#[test]
fn a_time_of_day_goes_on_after_midnight() {
    let at = |clock: &str| sentence(&format!("GPGGA,{clock},4830.0,N,00815.0,E,1,8,1.0,400.0,M,48.0,M,,"));
    let log = at("235959.00") + &at("000000.00") + &at("000001.50");
    let read = parse_gps_log_within(log.as_bytes(), MEMORY).unwrap();
    let times: Vec<_> = read.points.iter().map(|point| point.time_s.unwrap()).collect();
    assert_eq!(times, [86_399.0, 86_400.0, 86_401.5]);
    assert_eq!(read.clock, GpsClock::Midnight);
    let dated = log + &rmc("125534.00", 'A', "4830.00000", "031011");
    assert_eq!(parse_gps_log_within(dated.as_bytes(), MEMORY).unwrap().clock, GpsClock::Utc);
}

#[test]
fn what_has_no_fix_is_none_and_what_is_damaged_is_counted() {
    let good = rmc("125534.00", 'A', "4830.00000", "031011");
    let no_fix = rmc("125533.00", 'V', "4830.00000", "031011");
    let cut = &good[..good.len() - 9];
    let wrong = good.replace("4830", "4831");
    let log =
        format!("# a comment\n{no_fix}{cut}\n{wrong}1317646534.1 {good}$GPGSV,1,1,00*79\n\u{fffd}binary\n");
    let read = parse_gps_log_within(log.as_bytes(), MEMORY).unwrap();
    assert_eq!((read.points.len(), read.damaged.count, read.unchecked), (1, 2, 0));
    assert_eq!(read.damaged.first.unwrap().line, 3);
    assert!((read.points[0].at.lat_deg - 48.5).abs() < 1e-9);

    let error = parse_gps_log_within((no_fix + &wrong).as_bytes(), MEMORY).unwrap_err();
    assert!(matches!(error, GpsLogError::Damaged { damaged: 1, without_fix: 1, .. }), "{error}");
    let unlit = rmc("125533.00", 'V', "4830.00000", "031011");
    let error = parse_gps_log_within(unlit.as_bytes(), MEMORY);
    assert_eq!(error, Err(GpsLogError::NoFix { without_fix: 1 }));
    assert_eq!(parse_gps_log_within(b"nothing of the kind", MEMORY), Err(GpsLogError::NoLog));
    assert!(matches!(parse_gps_log_within(b"<kml/>", MEMORY), Err(GpsLogError::Gpx(_))));
    let many = rmc("125534.00", 'A', "4830.00000", "031011").repeat(100);
    assert!(matches!(parse_gps_log_within(many.as_bytes(), 1000), Err(GpsLogError::TooLarge { .. })));
}

/// Expected: sentences without checksums are those with, as long as they are whole and the log has no others.
#[test]
fn a_log_without_checksums_is_read_and_counted() {
    let bare = |sentence: String| sentence.split('*').next().unwrap_or_default().to_owned() + "\r\n";
    let rmc = |clock: &str| rmc(clock, 'A', "4830.00000", "031011");
    let gga = sentence("GPGGA,125534.00,4830.0,N,00815.0,E,1,8,1.0,400.0,M,48.0,M,,");
    let checked = parse_gps_log_within((rmc("125534.00") + &rmc("125535.00")).as_bytes(), MEMORY).unwrap();
    let unchecked = bare(rmc("125534.00")) + &bare(rmc("125535.00"));
    let read = parse_gps_log_within(unchecked.as_bytes(), MEMORY).unwrap();
    assert_eq!((read.points, read.damaged.count, read.unchecked), (checked.points, 0, 2));
    assert_eq!(parse_gps_log_within(bare(gga).as_bytes(), MEMORY).unwrap().points.len(), 1);
    let mixed = parse_gps_log_within((unchecked.clone() + &rmc("125536.00")).as_bytes(), MEMORY).unwrap();
    assert_eq!((mixed.points.len(), mixed.damaged.count, mixed.unchecked), (1, 2, 0));
    for end in [40, 30, 20] {
        let cut = parse_gps_log_within(&unchecked.as_bytes()[..end], MEMORY);
        assert!(matches!(cut, Err(GpsLogError::Damaged { .. })), "{end}: {cut:?}");
    }
}

#[test]
fn every_encoding_gives_the_same_positions() {
    let track = "<?xml version=\"1.0\" encoding=\"UTF-16\"?>\n<gpx><name>B\u{e4}r</name><trkpt lat=\"48.5\" lon=\"8.25\"/></gpx>";
    let sentences = rmc("125534.00", 'A', "4830.00000", "031011");
    for text in [track, sentences.as_str()] {
        let plain = parse_gps_log_within(text.as_bytes(), MEMORY).unwrap();
        let units = || std::iter::once(0xFEFF).chain(text.encode_utf16());
        let latin_1: Vec<u8> = text.chars().map(|letter| letter as u8).collect();
        for bytes in [
            units().flat_map(u16::to_le_bytes).collect(),
            units().flat_map(u16::to_be_bytes).collect(),
            units().skip(1).flat_map(u16::to_le_bytes).collect(),
            ["\u{feff}", text].concat().into_bytes(),
            latin_1,
        ] {
            assert_eq!(parse_gps_log_within(&bytes, MEMORY).as_ref(), Ok(&plain));
        }
    }
}

#[test]
fn reports_of_gpsd_go_before_sentences() {
    let log = [
        r#"{"class":"VERSION","release":"3.22"}"#,
        r#"{"class":"TPV","device":"/dev/ttyS0","mode":1}"#,
        r#"{"class":"TPV","mode":3,"time":"2011-10-03T12:55:34.500Z","lat":48.5,"lon":8.25,"altHAE":110.0}"#,
        r#"{"class":"TPV","mode":2,"lat":48.6,"lon":8.2"#,
        r#"{"class":"SKY","satellites":[]}"#,
    ];
    let log = rmc("125534.00", 'A', "4700.00000", "031011") + &log.join("\n");
    let read = parse_gps_log_within(log.as_bytes(), MEMORY).unwrap();
    assert_eq!((read.points.len(), read.damaged.count), (1, 1));
    assert_eq!(read.points[0].time_s, Some(1_317_646_534.5));
    assert!((read.points[0].at.lon_deg - 8.25).abs() < 1e-12);
}

#[test]
fn reports_of_gpsd_whose_time_is_bad_or_missing_are_counted() {
    let report = |time: &str| format!(r#"{{"class":"TPV","mode":3,{time}"lat":48.5,"lon":8.25}}"#);
    let good = report(r#""time":"2011-10-03T12:55:34.500Z","#);
    for (time, cause) in
        [("", "has no time"), (r#""time":"yesterday","#, "time \"yesterday\" is not ISO 8601")]
    {
        let log = [good.clone(), report(time), report(time)].join("\n");
        let read = parse_gps_log_within(log.as_bytes(), MEMORY).unwrap();
        let timed = read.points.iter().filter(|point| point.time_s.is_some()).count();
        assert_eq!((read.points.len(), timed, read.damaged.count), (3, 1, 2));
        let first = read.damaged.first.unwrap();
        assert!(first.line == 2 && first.cause.contains(cause), "{first}");
    }
}

#[test]
fn logs_of_receivers_are_read_whole() {
    let real = |name: &str| {
        let path = format!("{}/tests/data/nmea/{name}", env!("CARGO_MANIFEST_DIR"));
        parse_gps_log_within(&std::fs::read(path).unwrap(), MEMORY).unwrap()
    };
    let trimble = real("nmea-rtk.log");
    assert_eq!((trimble.damaged.count, trimble.unchecked), (0, 0));
    let first = trimble.points[0];
    // Its first sentence has 4134.49795459 N, 09345.03431408 W on 18 March 2020, 13:28:19.60.
    assert!((first.at.lat_deg - 41.574_965_909_8).abs() < 1e-9);
    assert!((first.at.lon_deg + 93.750_571_901_3).abs() < 1e-9);
    assert!((first.time_s.unwrap() - 1_584_538_099.6).abs() < 1e-3);
    assert!(trimble.points.windows(2).all(|pair| pair[1].time_s > pair[0].time_s));
}
